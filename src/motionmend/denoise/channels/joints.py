"""Joint angles as channels: degrees without jumps, the root relative to the travelling frame."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ...bodies.skeleton import ROTATION, TRANSLATION, Skeleton
from .branches import nearest_triple, nearest_turn, steady_triple, steady_turn
from .pieces import pieces
from .travel import Travel, travel, turn

DEGREES, CENTIMETRES = 180.0 / np.pi, 100.0


@dataclass(frozen=True, eq=False)
class JointChannels:
    """What it takes to come back from channels to a motion.

    Attributes
    ----------
    travel : the travelling frame, None where the root has no three rotations.
    columns : (U,) the file's channels that a model does not know.
    values : (T, U) degrees and centimetres of them, as `joint_channels` has them.
    """

    travel: Travel | None
    columns: Ints
    values: Floats


def joint_channels(motion: Motion, centre: Floats) -> tuple[Floats, Travel | None]:
    """Channels of a motion.

    The root's place and orientation are written in the travelling frame: its three translations become the
    offset from the smooth path in the frame's axes, its three rotations the rotation vector from the smooth
    heading. Every other angle stays the file's own, shifted by whole turns to stay about `centre`; of the two
    triples that mean the same rotation of a three-DOF joint those are taken that stay about it without flipping.

    Parameters
    ----------
    motion : any skeleton.
    centre : (D,) degrees, what each angle is near to.

    Returns
    -------
    values : (T, D) degrees and centimetres, NaN = missing; column c stands for the file's channel c.
    travel : the travelling frame, None where the root has no three rotations.
    """
    skeleton, q = motion.skeleton, motion.q
    turns, moves = root_rows(skeleton)
    angles = np.flatnonzero(skeleton.dof_kind == ROTATION)
    values = q * unit(skeleton)
    balls = triples(skeleton)
    for triple in balls:
        values[:, triple] = steady_triple(values[:, triple], centre[triple], motion.fps)
    for row in np.setdiff1d(angles, np.concatenate([turns, *balls])):
        values[:, row] = steady_turn(values[:, row], float(centre[row]), motion.fps)
    if len(turns) != 3:
        return values, None
    up = skeleton.up
    place = root_place(motion, moves)
    frame = travel(place, root_heading(motion, turns), motion.fps, up)
    for some in pieces(motion.frames):
        back = turn(frame.heading[some], up).transpose(0, 2, 1)
        rotation = joint_rotation(skeleton, turns, q[some])
        known = np.isfinite(rotation).all(axis=(1, 2))
        relative = np.full((len(rotation), 3), np.nan)
        relative[known] = Rotation.from_matrix(back[known] @ rotation[known]).as_rotvec(degrees=True)
        values[some, turns] = relative
        if len(moves) == 3:
            values[some, moves] = CENTIMETRES * np.einsum("tij,tj->ti", back, place[some] - frame.place[some])
    return values, frame


def into_angles(values: Floats, frame: Travel | None, trusted: Bools, motion: Motion) -> None:
    """Turn repaired channels into the file's own angles and turns, in place.

    Parameters
    ----------
    values : (T, D) degrees and centimetres, NaN = left open; becomes radians and metres.
    frame : the travelling frame of `joint_channels`.
    trusted : (T, D) True where the file's own sample is there and says which turn is meant.
    motion : the input.
    """
    skeleton, q, scale = motion.skeleton, motion.q, unit(motion.skeleton)
    turns, _ = root_rows(skeleton)
    if frame is not None:
        for some in pieces(motion.frames):
            _root_into_angles(values[some], frame.part(some), skeleton)
    for triple in [*triples(skeleton), *([turns] if frame is not None else [])]:
        file_values, sure = q[:, triple] * scale[triple], trusted[:, triple]
        known = np.isfinite(file_values)
        # The twins lie half a turn apart in the outer two angles. What is believed of these tells them apart; else even
        # rejected ones do better than a line across a place where the file itself may flip.
        told: Bools = np.asarray(sure[:, ::2].any(axis=1, keepdims=True))
        raw = ~told & known.all(axis=1, keepdims=True)
        like = np.where(raw, file_values, _branch_reference(file_values, sure))
        for some in pieces(motion.frames):
            values[some, triple] = nearest_triple(values[some, triple], like[some], sure[some] | ~told[some])
    for d in np.flatnonzero(skeleton.dof_kind == ROTATION):
        meant = _branch_reference(q[:, d : d + 1] * scale[d], trusted[:, d : d + 1])
        values[:, d : d + 1] = nearest_turn(values[:, d : d + 1], meant)
    values /= scale


def _root_into_angles(values: Floats, frame: Travel, skeleton: Skeleton) -> None:
    """The root's rotation vectors and offsets in the travelling frame as its own angles and translations, in place."""
    turns, moves = root_rows(skeleton)
    rotations = frame.rotations()
    known = np.isfinite(values[:, turns]).all(axis=1)
    relative = Rotation.from_rotvec(values[known][:, turns], degrees=True).as_matrix()
    angles = np.full((len(values), 3), np.nan)
    angles[known] = root_angles(skeleton, turns, rotations[known] @ relative)
    values[:, turns] = angles
    if len(moves) == 3:
        offset = np.einsum("tij,tj->ti", rotations, values[:, moves] / CENTIMETRES)
        along = frame.place + offset - skeleton.offsets[0]
        values[:, moves] = CENTIMETRES * along @ np.linalg.inv(skeleton.dof_axis[moves])


def root_place(motion: Motion, moves: Ints) -> Floats:
    """(T, 3) m of the root, NaN = missing; where it has no three translations it stands."""
    skeleton = motion.skeleton
    if len(moves) != 3:
        return np.zeros((motion.frames, 3))
    return np.asarray(skeleton.offsets[0] + motion.q[:, moves] @ skeleton.dof_axis[moves])


def root_heading(motion: Motion, turns: Ints) -> Floats:
    """(T,) rad about up, NaN = missing."""
    skeleton = motion.skeleton
    found = [heading(joint_rotation(skeleton, turns, motion.q[some]), skeleton.up) for some in pieces(motion.frames)]
    return np.concatenate(found)


def unit(skeleton: Skeleton) -> Floats:
    """(D,) channel units per radian or metre."""
    return np.where(skeleton.dof_kind == ROTATION, DEGREES, CENTIMETRES)


def joints_of(skeleton: Skeleton, columns: Ints) -> Ints:
    """(C,) a number for the joint of each channel's rotations, others for its translations; apart what is of none.

    Parameters
    ----------
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.
    """
    kind = 2 * skeleton.dof_joint[columns] + (skeleton.dof_kind[columns] == TRANSLATION)
    return np.where(columns >= 0, kind, -1 - np.arange(len(columns)))


def root_rows(skeleton: Skeleton) -> tuple[Ints, Ints]:
    """Rows of the root's three rotations and three translations, in chain order; empty where it has others.

    The translations count only when they come before the rotations, as they do in every format read.
    """
    rows = skeleton.dofs_of(0)
    turns = rows[skeleton.dof_kind[rows] == ROTATION]
    moves = rows[skeleton.dof_kind[rows] == TRANSLATION]
    none = np.empty(0, dtype=np.int64)
    if len(turns) != 3 or not _orthogonal(skeleton.dof_axis[turns]):
        return none, none
    if len(moves) != 3 or moves.max() > turns.min() or abs(np.linalg.det(skeleton.dof_axis[moves])) < 1e-6:
        return turns, none
    return turns, moves


def triples(skeleton: Skeleton) -> list[Ints]:
    """Rows of every joint but the root that turns about three axes at right angles."""
    found = []
    for joint in range(1, len(skeleton.names)):
        rows = skeleton.dofs_of(joint)
        rows = rows[skeleton.dof_kind[rows] == ROTATION]
        if len(rows) == 3 and _orthogonal(skeleton.dof_axis[rows]):
            found.append(rows)
    return found


def middle(values: Floats, angular: Bools) -> Floats:
    """(C,) robust middle of channels (T, C): the median, of those that are `angular` (C,) degrees about their mean."""
    return np.array([_middle(values[:, c], bool(angle)) for c, angle in enumerate(angular)])


def own_middle(motion: Motion, rows: Ints | None = None) -> Floats:
    """(D,) the same of a motion's channels, degrees and centimetres; of these rows only, the others 0, if given."""
    angular, scale = motion.skeleton.dof_kind == ROTATION, unit(motion.skeleton)
    centre = np.zeros(len(scale))
    for d in np.arange(len(scale)) if rows is None else rows:
        centre[d] = _middle(motion.q[:, d] * scale[d], bool(angular[d]))
    return centre


def _middle(channel: Floats, angular: bool) -> float:
    known = channel[np.isfinite(channel)]
    if known.size == 0:
        return 0.0
    if not angular:
        return float(np.median(known))
    mean = np.exp(1j * known / DEGREES).mean()
    start = np.angle(mean) * DEGREES if abs(mean) > 1e-6 else 0.0
    return float(np.median(nearest_turn(known, np.full(known.shape, start))))


def joint_rotation(skeleton: Skeleton, turns: Ints, q: Floats) -> Floats:
    """(T, 3, 3) rotation of a joint from its rotation rows and q (T, D) rad, NaN where one is missing."""
    known = np.isfinite(q[:, turns]).all(axis=1)
    total = np.broadcast_to(np.eye(3), (int(known.sum()), 3, 3))
    for row in turns:
        total = total @ turn(q[known, row], skeleton.dof_axis[row])
    matrices = np.full((len(q), 3, 3), np.nan)
    matrices[known] = total
    return matrices


def root_angles(skeleton: Skeleton, turns: Ints, rotation: Floats) -> Floats:
    """(T, 3) degrees about the root's three axes, in chain order, that make `rotation` (T, 3, 3)."""
    axes = skeleton.dof_axis[turns]
    hand = np.sign(np.linalg.det(axes))
    # in the basis of the axes themselves the turns are about x, y and z
    basis = axes.T * np.array([1.0, 1.0, hand])
    inside = Rotation.from_matrix(basis.T @ rotation @ basis)
    return np.asarray(_euler(inside) * np.array([1.0, 1.0, hand]))


def _euler(rotation: Rotation) -> Floats:
    """Intrinsic x-y-z angles in degrees; at the pole, where many answers are equal, the last angle is 0."""
    m = rotation.as_matrix()
    b = np.arcsin(np.clip(m[:, 0, 2], -1.0, 1.0))
    pole = np.abs(m[:, 0, 2]) > 1.0 - 1e-12
    a = np.where(pole, np.arctan2(m[:, 2, 1], m[:, 1, 1]), np.arctan2(-m[:, 1, 2], m[:, 2, 2]))
    c = np.where(pole, 0.0, np.arctan2(-m[:, 0, 1], m[:, 0, 0]))
    return np.stack([a, b, c], axis=1) * DEGREES


def heading(rotation: Floats, up: Floats) -> Floats:
    """(T,) rad: the part of each rotation (T, 3, 3) that turns about `up` (swing-twist), NaN where missing."""
    known = np.isfinite(rotation).all(axis=(1, 2))
    quaternion = Rotation.from_matrix(rotation[known]).as_quat()
    angle = np.full(len(rotation), np.nan)
    angle[known] = 2.0 * np.arctan2(quaternion[:, :3] @ up, quaternion[:, 3])
    return angle


def _branch_reference(file_values: Floats, trusted: Bools) -> Floats:
    """The file's own angles where trusted, and between trusted frames the straight line from one to the next."""
    meant = file_values.copy()
    frames = np.arange(len(meant))
    for d in range(meant.shape[1]):
        known = trusted[:, d] & np.isfinite(file_values[:, d])
        if known.any():
            meant[:, d] = np.interp(frames, frames[known], file_values[known, d])
    return meant


def _orthogonal(axes: Floats) -> bool:
    return bool(np.allclose(axes @ axes.T, np.eye(3), atol=1e-6))
