"""The order in which a joint turns about its axes: angles of one order written as those of another."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Floats
from ...bodies.motion import Motion
from ...bodies.skeleton import Skeleton, turned_in_other_order
from .joints import DEGREES, root_rows, triples


@dataclass(frozen=True)
class Reordered:
    """A joint whose three rotations, about axes at right angles, follow each other otherwise than in clips.

    Only of such is every triple of angles in one order one in the other.

    Attributes
    ----------
    joint : its name.
    root : whether it is the root.
    names : of its channels, in its own order.
    axes : unit vectors, in its own order.
    in_clips : which of them comes first, second and third in the clips.
    """

    joint: str
    root: bool
    names: tuple[str, ...]
    axes: tuple[tuple[float, ...], ...]
    in_clips: tuple[int, ...]


def reordered(skeleton: Skeleton, names: Sequence[str]) -> tuple[Reordered, ...]:
    """The joints that are so.

    Parameters
    ----------
    skeleton : of a recording.
    names : of the clips' channels, in their order.
    """
    turns, _ = root_rows(skeleton)
    otherwise = set(turned_in_other_order(skeleton, names).tolist())
    place = {name: k for k, name in enumerate(names)}
    found = []
    for rows in (turns, *triples(skeleton)):
        own = tuple(skeleton.dof_names[row] for row in rows)
        joint = int(skeleton.dof_joint[rows[0]]) if len(rows) else -1
        if joint in otherwise and all(name in place for name in own):
            axes = tuple(tuple(axis) for axis in skeleton.dof_axis[rows].tolist())
            in_clips = tuple(np.argsort([place[name] for name in own]).tolist())
            found.append(Reordered(skeleton.names[joint], joint == 0, own, axes, in_clips))
    return tuple(found)


def in_order(angles: Floats, axes: Floats, wanted: Floats) -> Floats:
    """Angles about one order's axes as angles about the other's.

    Parameters
    ----------
    angles : (N, 3) degrees, intrinsic; a row with NaN has no answer.
    axes, wanted : (3, 3) unit vectors at right angles, the same in two orders, as rows.

    Returns
    -------
    (N, 3) degrees within half a turn, the second within a quarter; NaN where one of the three is.
    """
    known = np.isfinite(angles).all(axis=1)
    turns = Rotation.identity(int(known.sum()))
    for k in range(3):
        turns = turns * Rotation.from_rotvec(angles[known, k : k + 1] / DEGREES * axes[k])
    written = np.full(angles.shape, np.nan)
    if known.any():
        written[known] = turns.as_davenport(wanted, "intrinsic", degrees=True, suppress_warnings=True)
    return written


def in_order_of(motion: Motion, names: Sequence[str]) -> Motion:
    """The motion with its `reordered` joints turning in another order.

    Parameters
    ----------
    motion : q in rad; where one of a joint's three is missing all three are then.
    names : channels in that order.

    Returns
    -------
    The same rotations. Which of the angles that mean them are taken may change from frame to frame.
    """
    joints = reordered(motion.skeleton, names)
    if not joints:
        return motion
    skeleton, q = motion.skeleton, motion.q.copy()
    dof_names, axes, limits = list(skeleton.dof_names), skeleton.dof_axis.copy(), skeleton.limits.copy()
    for joint in joints:
        rows = np.array([skeleton.dof_names.index(name) for name in joint.names])
        wanted = rows[list(joint.in_clips)]
        q[:, rows] = in_order(q[:, rows] * DEGREES, skeleton.dof_axis[rows], skeleton.dof_axis[wanted]) / DEGREES
        axes[rows], limits[rows] = skeleton.dof_axis[wanted], skeleton.limits[wanted]
        for row, other in zip(rows, wanted, strict=True):
            dof_names[row] = skeleton.dof_names[other]
    turned = replace(skeleton, dof_names=tuple(dof_names), dof_axis=axes, limits=limits)
    return replace(motion, skeleton=turned, q=q)
