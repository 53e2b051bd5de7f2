"""A library of poses in the order of their clips, to be searched by joint angles (section 3.5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Ints, frozen, runs
from ..bodies.motion import Motion
from ..bodies.performer import DOFS, Performer, Pose, Poses
from ..errors import MismatchError
from ..numerics.neighbors import Neighbors

EVERYWHERE = frozen(np.ones(DOFS - 6))  # every joint coordinate counts
FPS = 30.0  # of a depth sensor: what follows a pose follows at its pace


@final
@dataclass(frozen=True, eq=False)
class PoseDatabase:
    """N poses of the 34-DOF performer without their roots.

    Attributes
    ----------
    joints : (N, 28) rad, clip after clip, at 30 Hz.
    last : (N,) index of the last pose of each pose's clip, or of the part of it without a gap.
    """

    joints: Floats
    last: Ints

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(np.asarray(self.joints, np.float32)))  # as files hold them
        object.__setattr__(self, "last", frozen(self.last, np.int64))
        if self.joints.ndim != 2 or self.last.shape != self.joints.shape[:1]:
            raise MismatchError(f"poses (N, n) and last (N,) were wanted, came {self.joints.shape}, {self.last.shape}")

    def __len__(self) -> int:
        return len(self.joints)

    @cached_property
    def search(self) -> Neighbors:
        """The poses, to be searched."""
        return Neighbors(self.joints.astype(np.float32))

    def following(self, index: Ints, count: int) -> Ints:
        """(K, count) indices of the poses that follow each of K, the clip's last one repeated at its end."""
        ahead = index[:, None] + np.arange(1, count + 1)
        return np.asarray(np.minimum(ahead, self.last[index][:, None]))


def whole_poses(q: Floats) -> Bools:
    """(T,) in which frames of joint coordinates (T, D), rad and m, no channel is missing."""
    return np.asarray(np.isfinite(q).all(axis=1))


def database_of(clips: Sequence[Motion]) -> tuple[PoseDatabase, Poses, list[Performer]]:
    """The poses of clips on any skeleton that `templates` maps onto the performer, thinned to 30 Hz.

    Returns
    -------
    The library, the same poses with their roots in camera axes (y down), and each skeleton's performer once.
    """
    from ..bodies.templates import performer_of, poses_of

    kept: list[Poses] = []
    performers: dict[int, Performer] = {}
    for clip in clips:
        if id(clip.skeleton) not in performers:
            performers[id(clip.skeleton)] = performer_of(clip.skeleton)
        performer = performers[id(clip.skeleton)]
        step = max(1, round(clip.fps / FPS))
        q, up = clip.q[::step], _upright(clip.skeleton.up)
        for begin, stop in runs(whole_poses(q)):  # what comes after a gap does not follow what was before it
            part = Motion(clip.skeleton, q[begin:stop], clip.fps / step)
            kept.append(poses_of(part, performer).poses.moved(up, np.zeros(3)))
    if not kept:
        return PoseDatabase(np.empty((0, 28)), np.empty(0, np.int64)), _joined([]), []
    ends = np.cumsum([len(poses) for poses in kept]) - 1
    last = np.repeat(ends, [len(poses) for poses in kept])
    poses = _joined(kept)
    return PoseDatabase(poses.joints, last.astype(np.int64)), poses, list(performers.values())


def _joined(parts: Sequence[Poses]) -> Poses:
    if not parts:
        return Poses(np.empty((0, 3)), np.empty((0, 3, 3)), np.empty((0, 28)))
    return Poses(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("translation", "root", "joints")))


def _upright(up: Floats) -> Floats:
    """(3, 3) a rotation that brings `up` to the camera's -y."""
    from ..bodies.performer import rotation

    y, wanted = up / np.linalg.norm(up), np.array([0.0, -1.0, 0.0])
    axis = np.cross(y, wanted)
    sine, cosine = float(np.linalg.norm(axis)), float(y @ wanted)
    if sine < 1e-9:
        return np.eye(3) if cosine > 0 else np.diag((1.0, -1.0, -1.0))
    return rotation(axis / sine * np.arctan2(sine, cosine))


def strange(search: Neighbors, pose: Pose, trust: Floats, counted: Floats = EVERYWHERE) -> float:
    """rad, root mean square of how far what is seen of a pose is from the library's nearest.

    Parameters
    ----------
    search : poses of the library. pose : to be judged.
    trust : (28,) how well each joint coordinate is seen, 0 to 1. counted : (28,) how much each counts, 0 to 1.
    """
    weights = np.maximum(trust, 0.02) * counted
    _, distance = search.nearest(pose.joints, 5, weights)
    return float(np.sqrt((distance**2).mean() / weights.sum()))
