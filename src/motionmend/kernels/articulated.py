"""Frames and twists down a tree of bones that turn by rotation vectors.

Throughout: a chain of B bones with J joint coordinates has D = 6 + J degrees of freedom: 3 of the root's place, 3 of
its rotation, then the J coordinates.
"""

from math import cos, sin, sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints
from .body import Chain, Posed
from .compile import compiled
from .dense import factor_and_solve
from .putting import put, put_matrix

_SMALL = 1e-4  # rad; below, series to the fourth order are exact to rounding


@compiled
def quadratic(w: Floats, a: float, b: float, out: Floats) -> None:
    """I + a [w] + b [w]^2 into `out` (3, 3), [w] being the cross product with w (3,): exp(w) and its slope are such."""
    x, y, z = w[0], w[1], w[2]
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[0, 1] = b * x * y - a * z
    out[0, 2] = b * x * z + a * y
    out[1, 0] = b * x * y + a * z
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[1, 2] = b * y * z - a * x
    out[2, 0] = b * x * z - a * y
    out[2, 1] = b * y * z + a * x
    out[2, 2] = 1.0 - b * (x * x + y * y)


@compiled
def exponential(w: Floats, rotation: Floats) -> None:
    """The rotation (3, 3) about the vector w (3,) by its length in rad."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    angle = sqrt(square)
    if angle < _SMALL:
        a, b = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        a, b = sin(angle) / angle, (1.0 - cos(angle)) / square
    quadratic(w, a, b, rotation)


@compiled
def left_jacobian(w: Floats, slope: Floats) -> None:
    """The (3, 3) that turns a change of the rotation vector w into the angular velocity of exp(w), in fixed axes."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    angle = sqrt(square)
    if angle < _SMALL:
        a, b = 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    else:
        a, b = (1.0 - cos(angle)) / square, (angle - sin(angle)) / (square * angle)
    quadratic(w, a, b, slope)


@compiled
def frames(chain: Chain, pose: Posed, placed: Floats) -> None:
    """One pose to `placed` (B, 4, 4), world from bone."""
    for i in range(3):
        placed[0, i, 3] = pose.translation[i]
        placed[0, 3, i] = 0.0
        for k in range(3):
            placed[0, i, k] = pose.root[i, k]
    placed[0, 3, 3] = 1.0
    turn, rested = np.empty((3, 3)), np.empty((3, 3))
    for b in range(1, chain.parents.shape[0]):
        frame(b, chain, pose.joints, turn, rested, placed)


@compiled
def frame(b: int, chain: Chain, joints: Floats, turn: Floats, rested: Floats, placed: Floats) -> None:
    """The same of one bone b that has a parent, which is placed already; `turn` and `rested` (3, 3) are overwritten."""
    parents, offsets, rests, first, axes = chain
    p = parents[b]
    for i in range(3):
        placed[b, 3, i] = 0.0
        placed[b, i, 3] = placed[p, i, 3]
        for k in range(3):
            placed[b, i, 3] += placed[p, i, k] * offsets[b, k]
    placed[b, 3, 3] = 1.0
    vector = rested[0]
    for i in range(3):
        vector[i] = 0.0
        for c in range(first[b], first[b + 1]):
            vector[i] += axes[c, i] * joints[c]
    exponential(vector, turn)
    for i in range(3):
        for k in range(3):
            rested[i, k] = (
                placed[p, i, 0] * rests[b, 0, k] + placed[p, i, 1] * rests[b, 1, k] + placed[p, i, 2] * rests[b, 2, k]
            )
    for i in range(3):
        for k in range(3):
            placed[b, i, k] = rested[i, 0] * turn[0, k] + rested[i, 1] * turn[1, k] + rested[i, 2] * turn[2, k]


@compiled
def twists(chain: Chain, joints: Floats, placed: Floats, moving: Floats) -> None:
    """Rows [angular velocity, velocity of the origin] (D, 6) of every degree of freedom, in world axes.

    A point x carried by the row d moves at cross(moving[d, :3], x) + moving[d, 3:]. The root turns about its own
    place in world axes (an increment from the left); `placed` is what `frames` gives for the same pose.
    """
    parents, _, rests, first, axes = chain
    moving[:6] = 0.0
    for i in range(3):
        moving[i, 3 + i] = 1.0
        moving[3 + i, i] = 1.0
        _about(placed[0], moving[3 + i])
    vector, slope, local = np.empty(3), np.empty((3, 3)), np.empty((2, 3))
    for b in range(1, parents.shape[0]):
        p = parents[b]
        vector[:] = 0.0
        for c in range(first[b], first[b + 1]):
            for i in range(3):
                vector[i] += axes[c, i] * joints[c]
        left_jacobian(vector, slope)
        for c in range(first[b], first[b + 1]):
            for i in range(3):
                local[0, i] = slope[i, 0] * axes[c, 0] + slope[i, 1] * axes[c, 1] + slope[i, 2] * axes[c, 2]
            for i in range(3):
                local[1, i] = rests[b, i, 0] * local[0, 0] + rests[b, i, 1] * local[0, 1] + rests[b, i, 2] * local[0, 2]
            for i in range(3):
                moving[6 + c, i] = (
                    placed[p, i, 0] * local[1, 0] + placed[p, i, 1] * local[1, 1] + placed[p, i, 2] * local[1, 2]
                )
            _about(placed[b], moving[6 + c])


@compiled
def _about(placed: Floats, row: Floats) -> None:
    """Fill the second half of a twist that turns about the origin of `placed` (4, 4): place x angular velocity."""
    x, y, z = placed[0, 3], placed[1, 3], placed[2, 3]
    row[3] = y * row[2] - z * row[1]
    row[4] = z * row[0] - x * row[2]
    row[5] = x * row[1] - y * row[0]


@compiled
def points(placed: Floats, bones: Ints, local: Floats, world: Floats) -> None:
    """Points (N, 3) in m fixed to bones, `local` (N, 3) in the frame of bone `bones` (N,), to `world` (N, 3)."""
    for n in range(bones.shape[0]):
        b = bones[n]
        for i in range(3):
            world[n, i] = (
                placed[b, i, 0] * local[n, 0]
                + placed[b, i, 1] * local[n, 1]
                + placed[b, i, 2] * local[n, 2]
                + placed[b, i, 3]
            )


@compiled
def upright(chain: Chain, joints: Floats, bones: Ints, local: Floats, world: Floats) -> None:
    """`points` of many poses, `joints` (P, J), with the root at 0 and not turned, to `world` (P, N, 3)."""
    placed, place, straight = np.empty((chain.parents.shape[0], 4, 4)), np.zeros(3), np.eye(3)
    for p in range(joints.shape[0]):
        frames(chain, Posed(place, straight, joints[p]), placed)
        points(placed, bones, local, world[p])


@compiled
def advance(pose: Posed, delta: Floats) -> None:
    """Add `delta` (D,) to a pose in place: the root's rotation is turned from the left, all else is added to."""
    translation, root, joints = pose
    turn, before = np.empty((3, 3)), root.copy()
    exponential(delta[3:6], turn)
    for i in range(3):
        translation[i] += delta[i]
        for k in range(3):
            root[i, k] = turn[i, 0] * before[0, k] + turn[i, 1] * before[1, k] + turn[i, 2] * before[2, k]
    _orthonormal(root)
    for c in range(joints.shape[0]):
        joints[c] += delta[6 + c]


@compiled
def _orthonormal(rotation: Floats) -> None:
    """One Newton step towards the nearest rotation, in place: rounding never adds up over many increments."""
    before = rotation.copy()
    for i in range(3):
        for k in range(3):
            gram = 0.0
            for j in range(3):
                for n in range(3):
                    gram += before[i, j] * before[n, j] * before[n, k]
            rotation[i, k] = 1.5 * before[i, k] - 0.5 * gram


@compiled
def reach(
    chain: Chain,
    moves: Bools,
    bones: Ints,
    local: Floats,
    wanted: Floats,
    weights: Floats,
    rest_weights: Floats,
    limits: Floats,
    iterations: int,
    pose: Posed,
) -> float:
    """Bring points of one body to wanted places by damped Gauss-Newton; the pose is changed in place.

    Minimises the sum of weights² · |point - wanted|² plus rest_weights² · (coordinate - start)².

    Parameters
    ----------
    moves : (B, D) which degrees of freedom move which bone.
    bones, local : (N,), (N, 3) m, the points.
    wanted : (N, 3) m; weights : (N,) 1 where it counts, 0 where the place is not known (may be NaN then).
    rest_weights : (D,) m/rad and m/m, what holds each degree of freedom where it starts.
    limits : (D, 2) of the joint coordinates; the root's rows are not looked at.
    iterations : at most so many.

    Returns
    -------
    float : the cost, m².
    """
    bodies, count, dofs = chain.parents.shape[0], bones.shape[0], 6 + chain.axes.shape[0]
    joints = pose.joints
    placed, moving, world = np.empty((bodies, 4, 4)), np.empty((dofs, 6)), np.empty((count, 3))
    # Ever since the start: the increments of the root, and how far each joint coordinate has gone.
    away, held_away, change = np.zeros(dofs), np.zeros(dofs), np.zeros(dofs)
    held_pose = Posed(np.empty(3), np.empty((3, 3)), np.empty(dofs - 6))
    hessian, lifted, gradient = np.empty((dofs, dofs)), np.empty((dofs, dofs)), np.empty(dofs)
    held, downhill = np.zeros(dofs, dtype=np.bool_), np.empty(dofs)
    damping, cost = 1e-4, np.inf
    for step in range(iterations + 1):
        frames(chain, pose, placed)
        points(placed, bones, local, world)
        now = missed(world, wanted, weights) + _missed_start(away, rest_weights)
        if now < cost:
            saved = cost - now
            cost = now
            _keep(pose, away, held_pose, held_away)
            damping = max(damping * 0.1, 1e-9)
            if step == iterations or saved < 1e-7 * cost + 1e-14:
                break
            twists(chain, joints, placed, moving)
            normal_equations(moves, moving, bones, world, wanted, weights, rest_weights, away, hessian, gradient)
        else:
            _keep(held_pose, held_away, pose, away)
            if step == iterations or damping > 1e6:
                break
            damping *= 10.0
        for d in range(dofs):
            # A coordinate that its limit keeps from going where the cost falls is left out of the step.
            at_low = d >= 6 and joints[d - 6] <= limits[d, 0] + 1e-9
            at_high = d >= 6 and joints[d - 6] >= limits[d, 1] - 1e-9
            held[d] = (at_low and gradient[d] > 0.0) or (at_high and gradient[d] < 0.0)
            downhill[d] = 0.0 if held[d] else gradient[d]
            for e in range(d + 1):
                lifted[d, e] = 0.0 if held[d] or held[e] else hessian[d, e]
            lifted[d, d] += damping * (1e-3 + hessian[d, d]) + (1.0 if held[d] else 0.0)
        put(change, downhill)
        if not factor_and_solve(lifted, change):
            change[:] = 0.0
        size = 0.0
        for d in range(dofs):
            size += change[d] * change[d]
        size = max(sqrt(size), 1.0)  # a radian at most
        for d in range(dofs):
            change[d] /= -size
            if d >= 6:  # a coordinate at its limit stays there
                low, high = limits[d, 0] - joints[d - 6], limits[d, 1] - joints[d - 6]
                change[d] = min(max(change[d], low), high)
            away[d] += change[d]
        advance(pose, change)
    _keep(held_pose, held_away, pose, away)
    return cost


@compiled
def missed(world: Floats, wanted: Floats, weights: Floats) -> float:
    """Sum of the squares of what each point that counts misses."""
    total = 0.0
    for n in range(world.shape[0]):
        if weights[n] > 0.0:
            for i in range(3):
                total += (weights[n] * (world[n, i] - wanted[n, i])) ** 2
    return total


@compiled
def _missed_start(away: Floats, rest_weights: Floats) -> float:
    total = 0.0
    for d in range(away.shape[0]):
        total += (rest_weights[d] * away[d]) ** 2
    return total


@compiled
def _keep(pose: Posed, away: Floats, kept: Posed, kept_away: Floats) -> None:
    """Copy a pose and how far it has gone."""
    put(kept.translation, pose.translation)
    put_matrix(kept.root, pose.root)
    put(kept.joints, pose.joints)
    put(kept_away, away)


@compiled
def normal_equations(
    moves: Bools,
    moving: Floats,
    bones: Ints,
    world: Floats,
    wanted: Floats,
    weights: Floats,
    rest_weights: Floats,
    away: Floats,
    hessian: Floats,
    gradient: Floats,
) -> None:
    """Lower half of the Gauss-Newton matrix (D, D) and the gradient (D,) of what `reach` minimises, halved."""
    dofs = moving.shape[0]
    slope = np.empty((dofs, 3))
    for d in range(dofs):
        gradient[d] = rest_weights[d] ** 2 * away[d]
        for e in range(d):
            hessian[d, e] = 0.0
        hessian[d, d] = rest_weights[d] ** 2
    for n in range(bones.shape[0]):
        if weights[n] <= 0.0:
            continue
        square = weights[n] * weights[n]
        x, y, z = world[n, 0], world[n, 1], world[n, 2]
        carried = moves[bones[n]]
        for d in range(dofs):
            if not carried[d]:
                continue
            slope[d, 0] = moving[d, 1] * z - moving[d, 2] * y + moving[d, 3]
            slope[d, 1] = moving[d, 2] * x - moving[d, 0] * z + moving[d, 4]
            slope[d, 2] = moving[d, 0] * y - moving[d, 1] * x + moving[d, 5]
            for i in range(3):
                gradient[d] += square * slope[d, i] * (world[n, i] - wanted[n, i])
            for e in range(d + 1):
                if carried[e]:
                    for i in range(3):
                        hessian[d, e] += square * slope[d, i] * slope[e, i]
