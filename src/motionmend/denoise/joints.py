"""Joint angles as channels: degrees without jumps, the root relative to the travelling frame."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Bools, Floats, Ints
from ..bodies.motion import Motion
from ..bodies.skeleton import ROTATION, TRANSLATION, Skeleton
from .branches import nearest_triple, nearest_turn, steady_triple
from .travel import Travel, travel

DEGREES, CENTIMETRES = 180.0 / np.pi, 100.0


@dataclass(frozen=True, eq=False)
class JointChannels:
    """A motion as channels, and what it takes to come back. Column c stands for the file's channel c.

    Attributes
    ----------
    values : (T, D) degrees and centimetres, NaN = missing.
    travel : the travelling frame, None where the root has no three rotations.
    """

    values: Floats
    travel: Travel | None


def joint_channels(motion: Motion, centre: Floats | None) -> JointChannels:
    """Channels of a motion.

    The root's place and orientation are written in the travelling frame: its three translations become the
    offset from the smooth path in the frame's axes, its three rotations the rotation vector from the smooth
    heading. Every other angle stays the file's own, brought to the turn nearest `centre`; of the two triples
    that mean the same rotation of a three-DOF joint those are taken that stay about `centre` without flipping.

    Parameters
    ----------
    motion : any skeleton.
    centre : (D,) degrees, what each angle is near to; None takes each angle's own robust middle.
    """
    skeleton = motion.skeleton
    values = motion.q * unit(skeleton)
    if centre is None:
        centre = middle(values, skeleton)
    turns, moves = root_rows(skeleton)
    angles = np.flatnonzero(skeleton.dof_kind == ROTATION)
    values[:, angles] = nearest_turn(values[:, angles], centre[angles])
    for triple in triples(skeleton):
        values[:, triple] = steady_triple(values[:, triple], centre[triple], motion.fps)
    if len(turns) != 3:
        return JointChannels(values, None)
    up = skeleton.up
    rotation = root_rotation(skeleton, turns, motion.q)
    place = (
        skeleton.offsets[0] + motion.q[:, moves] @ skeleton.dof_axis[moves]
        if len(moves) == 3
        else np.zeros((motion.frames, 3))
    )
    frame = travel(place, heading(rotation, up), motion.fps, up)
    back = frame.rotations().transpose(0, 2, 1)
    known = np.isfinite(rotation).all(axis=(1, 2))
    relative = np.full((motion.frames, 3), np.nan)
    relative[known] = Rotation.from_matrix(back[known] @ rotation[known]).as_rotvec(degrees=True)
    values[:, turns] = relative
    if len(moves) == 3:
        values[:, moves] = CENTIMETRES * np.einsum("tij,tj->ti", back, place - frame.place)
    return JointChannels(values, frame)


def motion_of(channels: JointChannels, repaired: Floats, trusted: Bools, motion: Motion) -> Motion:
    """The motion that has the repaired channels, in the file's own angles and turns.

    Parameters
    ----------
    channels : of `motion`.
    repaired : (T, D) degrees and centimetres, NaN = left open.
    trusted : (T, D) True where the file's own sample says which turn is meant.
    motion : the input.
    """
    skeleton = motion.skeleton
    file_values = motion.q * unit(skeleton)
    result = repaired.copy()
    turns, moves = root_rows(skeleton)
    if channels.travel is not None:
        frame = channels.travel.rotations()
        known = np.isfinite(repaired[:, turns]).all(axis=1)
        relative = Rotation.from_rotvec(repaired[known][:, turns], degrees=True).as_matrix()
        angles = np.full((len(repaired), 3), np.nan)
        angles[known] = root_angles(skeleton, turns, frame[known] @ relative)
        result[:, turns] = angles
        if len(moves) == 3:
            offset = np.einsum("tij,tj->ti", frame, repaired[:, moves] / CENTIMETRES)
            along = channels.travel.place + offset - skeleton.offsets[0]
            result[:, moves] = CENTIMETRES * along @ np.linalg.inv(skeleton.dof_axis[moves])
    meant = _branch_reference(file_values, trusted)
    rotations = np.flatnonzero(skeleton.dof_kind == ROTATION)
    for triple in [*triples(skeleton), *([turns] if channels.travel is not None else [])]:
        known = np.isfinite(file_values[:, triple])
        sure = trusted[:, triple] & known
        # The twins lie half a turn apart in the outer two angles. What is believed of these tells them apart; else even
        # rejected ones do better than a line across a place where the file itself may flip.
        told = sure[:, ::2].any(axis=1, keepdims=True)
        raw = ~told & known.all(axis=1, keepdims=True)
        like = np.where(raw, file_values[:, triple], meant[:, triple])
        result[:, triple] = nearest_triple(result[:, triple], like, sure | ~told)
    result[:, rotations] = nearest_turn(result[:, rotations], meant[:, rotations])
    return motion.with_q(result / unit(skeleton))


def unit(skeleton: Skeleton) -> Floats:
    """(D,) channel units per radian or metre."""
    return np.where(skeleton.dof_kind == ROTATION, DEGREES, CENTIMETRES)


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


def middle(values: Floats, skeleton: Skeleton) -> Floats:
    """(D,) robust middle of each channel: the circular median direction for angles, the median else."""
    centre = np.zeros(values.shape[1])
    for d in range(values.shape[1]):
        known = values[np.isfinite(values[:, d]), d]
        if known.size == 0:
            continue
        if skeleton.dof_kind[d] == ROTATION:
            mean = np.exp(1j * known / DEGREES).mean()
            start = np.angle(mean) * DEGREES if abs(mean) > 1e-6 else 0.0
            centre[d] = np.median(nearest_turn(known, np.full(known.shape, start)))
        else:
            centre[d] = np.median(known)
    return centre


def root_rotation(skeleton: Skeleton, turns: Ints, q: Floats) -> Floats:
    """(T, 3, 3) rotation of the root from its three rotation rows, NaN where one is missing."""
    known = np.isfinite(q[:, turns]).all(axis=1)
    total = Rotation.identity(int(known.sum()))
    for row in turns:
        total = total * Rotation.from_rotvec(q[known][:, row, None] * skeleton.dof_axis[row])
    matrices = np.full((len(q), 3, 3), np.nan)
    matrices[known] = total.as_matrix()
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
