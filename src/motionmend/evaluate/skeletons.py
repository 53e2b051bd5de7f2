"""How close joint angles come to the truth where channels have other names: by what both skeletons have in common."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.motion import Motion
from ..bodies.performer import LANDMARKS
from ..bodies.postures import Postures
from ..bodies.rig import motion_landmarks
from ..bodies.skeleton import ROTATION, Skeleton, forward, rest_positions
from ..errors import MismatchError
from .joints import JointComparison, compare_joints
from .metrics import RATE_TOLERANCE, body_channels

SAME_REST = np.cos(np.radians(1.0))  # of the angle between a bone at rest in one skeleton and in the other


@dataclass(frozen=True, eq=False)
class SkeletonComparison:
    """What `compare_skeletons` found.

    Attributes
    ----------
    joints : of the positions of joints that both have.
    rms_deg : RMS over the body's joints and frames of the angle by which a joint is turned otherwise against the one it
        hangs from, degrees; None where the skeletons rest otherwise, rates differ, or joints are matched by role.
    rms_deg_by_joint : the same of each joint, hands and toes too; by the truth's names.
    """

    joints: JointComparison
    rms_deg: float | None
    rms_deg_by_joint: dict[str, float | None] | None

    def to_json(self) -> dict[str, Any]:
        """The fields of `joints` and the others, each under its own name, ready for `json.dumps`."""
        return {**self.joints.to_json(), "rms_deg": self.rms_deg, "rms_deg_by_joint": self.rms_deg_by_joint}


def compare_skeletons(truth: Motion, other: Motion) -> SkeletonComparison:
    """Compare joint angles whose channels cannot be matched by name, as an .amc and the .bvh made of it.

    Or whose channels mean another thing, because joints turn in another order.

    Where more than half of the joints have the same names, these are compared, else the joints of `LANDMARKS`, found
    by names and by the shape of the skeleton.

    Parameters
    ----------
    truth, other : of any rates; joint positions are compared in time where they differ.

    Raises
    ------
    MismatchError : not even those joints are found, or no time is common.
    """
    ours, theirs = _same_names(truth.skeleton, other.skeleton)
    if 2 * len(ours) <= min(len(truth.skeleton.names), len(other.skeleton.names)):
        try:
            both = [_postures(one, LANDMARKS, motion_landmarks(one)) for one in (truth, other)]
        except MismatchError as error:
            raise MismatchError(f"a comparison needs the same channels or joints in both, or bodies: {error}") from None
        found = compare_joints(both[0], both[1], align=None)
        said = f"channels and joints have other names: {len(LANDMARKS)} joints are compared by their roles"
        return SkeletonComparison(_noting(found, said, "rms_deg is null: joints have other names"), None, None)
    (true_at, true_turn), (other_at, other_turn) = (forward(one.skeleton, one.q) for one in (truth, other))
    names = tuple(truth.skeleton.names[j] for j in ours)
    found = compare_joints(
        _postures(truth, names, true_at[:, ours]), _postures(other, names, other_at[:, theirs]), align=None
    )
    same = sorted(truth.channels) == sorted(other.channels)
    why = "joints turn in another order" if same else "channels have other names"
    said = f"{why}: joints of the same name are compared, {len(ours)} of {len(true_at[0])}"
    if truth.frames != other.frames or abs(truth.fps - other.fps) > RATE_TOLERANCE * truth.fps:
        return SkeletonComparison(_noting(found, said, "rms_deg is null: frames or rates differ"), None, None)
    if not _rest_alike(truth.skeleton, other.skeleton, ours, theirs):
        return SkeletonComparison(
            _noting(found, said, "rms_deg is null: the skeletons rest in other poses"), None, None
        )
    turned = {
        names[k]: _apart(_local(true_turn, ours[k], above), _local(other_turn, theirs[k], over))
        for k, above, over in _turning(truth.skeleton, other.skeleton, ours, theirs)
    }
    body = [angles for name, angles in turned.items() if body_channels([f"{name}.turn"])[0]]
    return SkeletonComparison(
        _noting(found, said, "rms_deg is of the angles by which whole joints are turned, not of channels"),
        _rms_deg(np.array(body)),
        {name: _rms_deg(angles) for name, angles in turned.items()},
    )


def _same_names(truth: Skeleton, other: Skeleton) -> tuple[Ints, Ints]:
    """(N,) joints of the truth and those of the other with the same names, whatever case and subject's prefix."""
    known: dict[str, int] = {}
    for joint, name in enumerate(other.names):
        known.setdefault(_bare(name), joint)
    pairs = [(joint, known.pop(_bare(name))) for joint, name in enumerate(truth.names) if _bare(name) in known]
    both = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return both[:, 0], both[:, 1]


def _bare(name: str) -> str:
    return name.rpartition(":")[2].strip().lower()


def _postures(motion: Motion, names: tuple[str, ...], positions: Floats) -> Postures:
    return Postures(names, positions, np.arange(motion.frames) / motion.fps)


def _rest_alike(truth: Skeleton, other: Skeleton, ours: Ints, theirs: Ints) -> bool:
    """Whether bones between joints that both have point the same way at rest."""
    rests = [rest_positions(one)[joints] for one, joints in ((truth, ours), (other, theirs))]
    place = {int(joint): k for k, joint in enumerate(ours)}
    for k, joint in enumerate(ours):
        above = place.get(int(truth.parents[joint]))
        if above is not None:
            bones = [rest[k] - rest[above] for rest in rests]
            lengths = [float(np.linalg.norm(bone)) for bone in bones]
            if min(lengths) > 1e-3 and bones[0] @ bones[1] < SAME_REST * lengths[0] * lengths[1]:
                return False
    return True


def _turning(truth: Skeleton, other: Skeleton, ours: Ints, theirs: Ints) -> list[tuple[int, int, int]]:
    """Of the pairs that turn in the truth and hang from a pair: their number, and that they hang from in each."""
    pairs = set(zip(ours.tolist(), theirs.tolist(), strict=True))
    found = []
    for k, (one, its) in enumerate(zip(ours, theirs, strict=True)):
        above, over = int(truth.parents[one]), int(other.parents[its])
        if (above, over) in pairs and (truth.dof_kind[truth.dofs_of(int(one))] == ROTATION).any():
            found.append((k, above, over))
    return found


def _local(turns: Floats, joint: int, above: int) -> Floats:
    """(T, 3, 3) how a joint is turned against the one it hangs from."""
    return np.asarray(np.swapaxes(turns[:, above], 1, 2) @ turns[:, joint])


def _apart(one: Floats, other: Floats) -> Floats:
    """(T,) rad between rotations (T, 3, 3), also where it is next to nothing; NaN where one is missing."""
    between = np.swapaxes(one, 1, 2) @ other
    skew = between - np.swapaxes(between, 1, 2)
    sine = np.sqrt(np.sum(skew**2, axis=(1, 2)) / 8.0)
    return np.asarray(np.arctan2(sine, (np.trace(between, axis1=1, axis2=2) - 1.0) / 2.0))


def _rms_deg(angles: Floats) -> float | None:
    there = angles[np.isfinite(angles)]
    return float(np.degrees(np.sqrt(np.mean(there**2)))) if there.size else None


def _noting(found: JointComparison, first: str, last: str) -> JointComparison:
    return replace(found, notes=(first, *found.notes, last))
