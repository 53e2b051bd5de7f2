"""A library of poses in the order of their clips, to be searched by joint angles (section 3.5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ..arrays import Floats, Ints, frozen
from ..bodies.motion import Motion
from ..errors import MismatchError
from ..numerics.neighbors import Neighbors

FPS = 30.0  # of a depth sensor: what follows a pose follows at its pace


@final
@dataclass(frozen=True, eq=False)
class PoseDatabase:
    """N poses of the 34-DOF performer without their roots.

    Attributes
    ----------
    joints : (N, 28) rad, clip after clip, at 30 Hz.
    last : (N,) index of the last pose of each pose's clip.
    """

    joints: Floats
    last: Ints

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(self.joints))
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


def database_of(clips: Sequence[Motion]) -> PoseDatabase:
    """The poses of clips on any skeleton that `templates` maps onto the performer, thinned to 30 Hz."""
    from ..bodies.templates import performer_of, poses_of

    joints: list[Floats] = []
    for clip in clips:
        poses, _ = poses_of(clip, performer_of(clip.skeleton))
        step = max(1, round(clip.fps / FPS))
        kept = poses.joints[::step]
        joints.append(kept[np.isfinite(kept).all(axis=1)])
    ends = np.cumsum([len(clip) for clip in joints]) - 1
    stacked = np.concatenate(joints) if joints else np.empty((0, 28))
    return PoseDatabase(stacked, np.repeat(ends, [len(clip) for clip in joints]).astype(np.int64))
