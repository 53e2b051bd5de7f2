"""Any motion as a Biovision one (.bvh)."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.motion import Motion
from ..bodies.skeleton import TRANSLATION, Skeleton, forward
from ..errors import MismatchError
from .hierarchy import BvhSource, parse_hierarchy, replaces, skeleton_of

CENTIMETRE = 0.01
TOGETHER = 1 << 13  # frames of which all joints are posed at a time
POSITIONS = ("Xposition", "Yposition", "Zposition")
ROTATIONS = ("Zrotation", "Xrotation", "Yrotation")


def bvh_of(motion: Motion) -> Motion:
    """The same movement on a skeleton a .bvh can hold.

    Every joint gets the channels Zrotation Xrotation Yrotation, the root and each joint that moves along an axis
    Xposition Yposition Zposition before them; a leaf `<joint>_end` becomes an End Site. Joints, offsets and world
    positions stay. Euler angles of a joint need all its turns: where one is missing, all three are.

    Parameters
    ----------
    motion : any, of one or several roots.

    Returns
    -------
    Motion whose `source` is a `BvhSource` in centimetres.

    Raises
    ------
    MismatchError : when a joint's name cannot stand in a .bvh.
    """
    skeleton = motion.skeleton
    order, header = _header(skeleton)
    hierarchy = parse_hierarchy(header, Path("skeleton.bvh"))
    target, columns = skeleton_of(hierarchy, CENTIMETRE, skeleton.up)
    q = np.zeros((motion.frames, len(target.dof_names)))
    own = [(target.dofs_of(place), joint) for place, joint in enumerate(order)]
    own = [(rows, joint) for rows, joint in own if joint >= 0 and len(rows)]
    for start in range(0, motion.frames, TOGETHER):
        some = slice(start, start + TOGETHER)
        moved, turned = _local(skeleton, motion.q[some])
        for rows, joint in own:
            q[some, rows[-3:]] = _euler(turned[:, joint])
            q[some, rows[:-3]] = moved[:, joint][:, : len(rows) - 3]
    for rows, _ in own:
        _make_continuous(q, rows[-3:])
    shift = np.zeros(len(target.dof_names))
    for joint in np.flatnonzero(target.parents >= 0).tolist():
        rows = target.dofs_of(joint)[:-3]
        offset = target.offsets[joint]
        if len(rows) and replaces(q[:, rows] + offset, offset):  # as most programs have it, if a reader can tell
            shift[rows] = offset
    source = BvhSource(
        before=f"{header}MOTION\nFrames: ",
        between="\nFrame Time: ",
        frame_time=repr(1 / motion.fps),
        fps=motion.fps,
        dof_names=target.dof_names,
        columns=columns,
        metres=CENTIMETRE,
        shift=shift,
    )
    return Motion(target, q, motion.fps, source, motion.guesses)


def _header(skeleton: Skeleton) -> tuple[list[int], str]:
    """The HIERARCHY text, and the skeleton's joint at each place of it, -1 for an End Site put in."""
    lines = ["HIERARCHY"]
    order: list[int] = []
    moves = set(skeleton.dof_joint[skeleton.dof_kind == TRANSLATION].tolist())

    def add(joint: int, indent: str) -> None:
        name = skeleton.names[joint]
        if not name or re.search(r"[{}\n\r]|^\s|\s$|\s\s", name):
            raise MismatchError(f"joint name {name!r} cannot stand in a .bvh: no braces, no stray spaces; rename it")
        root = skeleton.parents[joint] < 0
        channels = (*(POSITIONS if root or joint in moves else ()), *ROTATIONS)
        order.append(joint)
        lines.extend(
            (
                f"{indent}{'ROOT' if root else 'JOINT'} {name}",
                f"{indent}{{",
                f"{indent}  OFFSET {_numbers(skeleton.offsets[joint])}",
                f"{indent}  CHANNELS {len(channels)} {' '.join(channels)}",
            )
        )
        children = np.flatnonzero(skeleton.parents == joint).tolist()
        if not children:
            end(-1, np.zeros(3), indent + "  ")
        elif len(children) == 1 and _is_end(skeleton, joint, children[0]):
            end(children[0], skeleton.offsets[children[0]], indent + "  ")
        else:
            for child in children:
                add(child, indent + "  ")
        lines.append(f"{indent}}}")

    def end(joint: int, offset: Floats, indent: str) -> None:
        order.append(joint)
        lines.extend((f"{indent}End Site", f"{indent}{{", f"{indent}  OFFSET {_numbers(offset)}", f"{indent}}}"))

    for root in np.flatnonzero(skeleton.parents < 0).tolist():
        add(root, "")
    return order, "\n".join(lines) + "\n"


def _is_end(skeleton: Skeleton, joint: int, child: int) -> bool:
    return (
        skeleton.names[child] == f"{skeleton.names[joint]}_end"
        and not len(skeleton.dofs_of(child))
        and not np.any(skeleton.parents == child)
    )


def _local(skeleton: Skeleton, q: Floats) -> tuple[Floats, Floats]:
    """Each joint's move (T, J, 3) m and turn (T, J, 3, 3) against its parent, from its own degrees of freedom only."""
    joints = len(skeleton.names)
    apart = replace(skeleton, parents=np.full(joints, -1), offsets=np.zeros((joints, 3)))
    moved, turned = forward(apart, q)
    for joint in range(joints):
        rows = skeleton.dofs_of(joint)
        kinds = skeleton.dof_kind[rows]
        if np.all(np.diff(kinds.astype(int)) <= 0):  # moves before it turns: a missing x leaves y and z
            axes = skeleton.dof_axis[rows] * (kinds == TRANSLATION)[:, None]
            moved[:, joint] = np.where(axes == 0, 0.0, q[:, rows, None] * axes).sum(axis=1)
    return moved, turned


def _euler(turned: Floats) -> Floats:
    """Angles (T, 3) rad about z, x and y, the first outermost; NaN where `turned` is."""
    from scipy.spatial.transform import Rotation

    angles = np.full((len(turned), 3), np.nan)
    known = np.isfinite(turned).all(axis=(1, 2))
    if known.any():
        with warnings.catch_warnings():  # at 90° about x two of the angles are one freedom; any choice will do
            warnings.filterwarnings("ignore", message="Gimbal lock")
            angles[known] = Rotation.from_matrix(turned[known]).as_euler("ZXY")
    return angles


def _make_continuous(q: Floats, rows: Ints) -> None:
    """Shift angles by whole turns so that none jumps from one known frame to the next, in place."""
    known = np.flatnonzero(np.isfinite(q[:, rows]).all(axis=1))
    for row in rows:
        q[known, row] = np.unwrap(q[known, row])


def _numbers(offset: Floats) -> str:
    return " ".join(repr(float(value)) for value in offset / CENTIMETRE)
