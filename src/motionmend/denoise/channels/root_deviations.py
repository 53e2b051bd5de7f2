"""How unsure the root is in the file's own channels: the travelling frame has others, and errs itself."""

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ...bodies.skeleton import Skeleton
from ...kernels.articulated import left_jacobian
from .joints import joint_rotation, root_heading, root_place, root_rows
from .pieces import pieces
from .travel import Travel, noise_followed

ANY_ANGLE = np.pi / np.sqrt(3.0)  # rad, deviation of an angle of which nothing is known
POLE = 1e-3  # sine of how far the first and last axis are apart at least: there the linear law ends


def root_deviations(
    std: Floats, noise: Floats, frame: Travel, motion: Motion, repaired: Floats, at_home: Bools
) -> Floats:
    """Deviations of the root's own channels, of those in the travelling frame and of what that is unsure of.

    Parameters
    ----------
    std : (T, D) rad and m; of the root's place along the frame's axes, of its turns those of the rotation vector.
    noise : (D,) of the samples, likewise; NaN = unknown.
    frame : of `joint_channels`.
    motion : what it was made of.
    repaired : (T, D) rad and m, the angles of which deviations are asked.
    at_home : (D,) True for channels that do not follow what the frame made of noise: they are still, or a library knows
        where they lie.

    Returns
    -------
    (T, D) rad and m. Where an angle's axes nearly meet (at a pole of its order) it may be anything.
    """
    skeleton, found = motion.skeleton, std.copy()
    turns, moves = root_rows(skeleton)
    place, share = root_place(motion, moves), np.square(np.nan_to_num(noise)) * at_home
    by_place, by_heading = noise_followed(frame, place, root_heading(motion, turns), motion.fps)
    by_heading = by_heading * float(np.square(skeleton.up) @ share[turns])
    for some in pieces(motion.frames):
        to_angles, of_heading = _slopes(skeleton, turns, repaired[some], frame.part(some))
        spread = np.einsum("tij,tj->ti", np.square(to_angles), np.square(found[some, turns]))
        spread += np.square(of_heading) * by_heading[some, None]
        own = np.minimum(np.sqrt(spread), ANY_ANGLE)
        found[some, turns] = np.where(np.isfinite(own), own, found[some, turns])
        if len(moves) == 3:
            way = np.square(np.linalg.inv(skeleton.dof_axis[moves]).T @ frame.part(some).rotations())
            spread = np.einsum("tij,tj->ti", way, np.square(found[some, moves]) + by_place[some, None] * share[moves])
            found[some, moves] = np.where(np.isfinite(spread), np.sqrt(spread), found[some, moves])
    return found


def _slopes(skeleton: Skeleton, turns: Ints, q: Floats, frame: Travel) -> tuple[Floats, Floats]:
    """(T, 3, 3) and (T, 3): how the root's angles change with its rotation vector in a frame, and with its heading.

    NaN where an angle is missing.

    Source
    ------
    The axes about which each angle turns at its place in the chain are a basis, and angles go by its dual one; how a
    rotation turns with its vector is the left Jacobian (Barfoot, State estimation for robotics, 2017, section 7.1).
    """
    axes, known = skeleton.dof_axis[turns], np.isfinite(q[:, turns]).all(axis=1)
    to_angles, of_heading = np.full((len(q), 3, 3), np.nan), np.full((len(q), 3), np.nan)
    if not known.any():
        return to_angles, of_heading
    first = Rotation.from_rotvec(q[known, turns[0], None] * axes[0])
    second = first * Rotation.from_rotvec(q[known, turns[1], None] * axes[1])
    basis = np.stack([np.broadcast_to(axes[0], (len(first), 3)), first.apply(axes[1]), second.apply(axes[2])], axis=1)
    across = np.cross(basis[:, [1, 2, 0]], basis[:, [2, 0, 1]])
    volume = np.einsum("ti,ti->t", basis[:, 0], across[:, 0])
    dual = across / (np.where(volume < 0.0, -1.0, 1.0) * np.maximum(np.abs(volume), POLE))[:, None, None]
    heads = frame.rotations()[known]
    vector = Rotation.from_matrix(heads.transpose(0, 2, 1) @ joint_rotation(skeleton, turns, q)[known]).as_rotvec()
    slopes = np.empty((len(vector), 3, 3))
    for one, slope in zip(vector, slopes, strict=True):
        left_jacobian(one, slope)
    to_angles[known], of_heading[known] = dual @ heads @ slopes, dual @ skeleton.up
    return to_angles, of_heading
