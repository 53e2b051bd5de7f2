"""Poses that bring joints to given places: damped least squares within the joints' limits."""

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.performer import (
    DOFS,
    FACING,
    LANDMARKS,
    MOVES,
    Performer,
    Pose,
    landmarks,
    rotation,
    standing,
)
from ...errors import MismatchError

TORSO = np.array(
    [LANDMARKS.index(name) for name in ("pelvis", "chest", "neck", "l_shoulder", "r_shoulder", "l_hip", "r_hip")]
)


def reach(
    performer: Performer,
    pose: Pose,
    targets: Floats,
    weights: Floats | None = None,
    free: Bools | None = None,
    stiffness: float = 0.03,
    rounds: int = 30,
) -> tuple[Pose, float]:
    """The pose near `pose` whose joints are at `targets` (section 3.3.2, an inverse kinematics problem).

    Minimises the sum of weights |x_j - target_j|^2 + stiffness^2 |joints - those of `pose`|^2 by Levenberg-Marquardt,
    joint angles held within their limits. What no target speaks for stays as it was.

    Parameters
    ----------
    performer : whose joints.
    pose : where to begin.
    targets : (16, 3) m, NaN = no target.
    weights : (16,) of each target; 1 unless given.
    free : (34,) which degrees of freedom may change; all unless given.
    stiffness : m per rad.
    rounds : most steps.

    Returns
    -------
    The pose, and the weighted root mean square distance left, in m (0 without targets).

    Raises
    ------
    MismatchError : targets that are not (16, 3).
    """
    from ...kernels import reaching

    targets = np.asarray(targets, dtype=np.float64)
    if targets.shape != (len(LANDMARKS), 3):
        raise MismatchError(f"targets must be ({len(LANDMARKS)}, 3), came {targets.shape}")
    weight = np.ones(len(LANDMARKS)) if weights is None else np.asarray(weights, dtype=np.float64)
    weight = np.where(np.isfinite(targets).all(axis=1), weight, 0.0)
    wanted = np.where(weight[:, None] > 0, targets, 0.0)
    if not weight.any():
        return pose, 0.0
    loose = np.ones(DOFS, bool) if free is None else np.asarray(free)
    posed = pose.arrays
    stiff = np.full(DOFS, stiffness)
    stiff[:6] = 0.0
    limits = np.where(loose[:, None], performer.limits, (-np.inf, np.inf))  # what may not change stays, wherever it is
    reaching.reach_within(
        performer.chain,
        MOVES & loose,
        *performer.marks,
        wanted,
        np.sqrt(weight),
        stiff,
        limits,
        rounds,
        posed,
    )
    found = Pose(*posed)
    distance = ((wanted - landmarks(performer, found)) ** 2).sum(axis=1)
    return found, float(np.sqrt(weight @ distance / weight.sum()))


def placed(performer: Performer, joints: Floats, targets: Floats, weights: Floats) -> Pose:
    """The pose with these joint angles, turned and moved as a whole to bring its joints closest to `targets`.

    Parameters
    ----------
    joints : (28,) rad.
    targets, weights : (16, 3) m and (16,), of joints with a weight of 0 nothing is asked.
    """
    upright = Pose(np.zeros(3), np.eye(3), joints)
    turn, shift, _ = fitted(landmarks(performer, upright)[None], targets, weights)
    return Pose(shift[0], turn[0], joints)


def fitted(bodies: Floats, targets: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotation and shift that bring each of N bodies' joints closest to the targets (Kabsch 1976).

    Parameters
    ----------
    bodies : (N, 16, 3) m.
    targets : (16, 3) m; where the weight is 0 anything.
    weights : (16,) not negative.

    Returns
    -------
    turns : (N, 3, 3). shifts : (N, 3) m. left : (N,) weighted root mean square distance, m.
    """
    share = weights / weights.sum()
    wanted = np.where(weights[:, None] > 0, targets, 0.0)
    goal, center = share @ wanted, np.einsum("j,njk->nk", share, bodies)
    product = np.einsum("j,njk,jl->nkl", share, bodies - center[:, None], wanted - goal)
    left, _, right = np.linalg.svd(product)
    sign = np.where(np.linalg.det(left @ right) < 0, -1.0, 1.0)
    left[:, :, 2] *= sign[:, None]
    turns = np.swapaxes(left @ right, 1, 2)
    shifts = goal - np.einsum("nkl,nl->nk", turns, center)
    moved = np.einsum("nkl,njl->njk", turns, bodies) + shifts[:, None]
    return turns, shifts, np.sqrt(np.einsum("j,njk->n", share, (moved - wanted) ** 2))


def standing_at(targets: Floats, weights: Floats, heading: float, performer: Performer) -> Pose:
    """Upright before a level camera, the mean of the given joints in place; heading 0 faces the camera, rad."""
    pose = standing((0.0, 0.0, 0.0), rotation(np.array([0.0, heading, 0.0])) @ FACING)
    share = weights / weights.sum()
    goal = share @ np.where(weights[:, None] > 0, targets, 0.0)
    return Pose(goal - share @ landmarks(performer, pose), pose.root, pose.joints)
