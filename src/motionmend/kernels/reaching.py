"""Points of one body brought to places by Levenberg's and Marquardt's steps, none longer than an arc is straight."""

import numpy as np

from ..arrays import Bools, Floats, Ints
from . import articulated
from .articulated import missed, normal_equations
from .body import Chain, Posed
from .compile import compiled
from .dense import factor_and_solve
from .putting import put, put_matrix

LONGEST = 0.5  # rad or m in one step: beyond it the straight continuation of an arc is no longer it

_frames, _twists, _points = articulated.frames, articulated.twists, articulated.points
_advance = articulated.advance


@compiled
def reach_within(
    chain: Chain,
    moves: Bools,
    bones: Ints,
    local: Floats,
    wanted: Floats,
    weights: Floats,
    stiffness: Floats,
    limits: Floats,
    rounds: int,
    pose: Posed,
) -> None:
    """Bring points to wanted places; the pose is changed in place.

    Minimises the sum of weights² · |point - wanted|² plus stiffness² · (coordinate - start)².

    Parameters
    ----------
    moves : (B, D) which degrees of freedom move which bone; one that moves none stays.
    bones, local, wanted, weights : (N,), (N, 3) m, (N, 3) m, (N,), the points; those of weight 0 do not count.
    stiffness : (D,) m/rad, 0 for the root. limits : (D, 2) of the joint coordinates.
    rounds : most steps.
    """
    bodies, count, dofs = chain.parents.shape[0], bones.shape[0], 6 + chain.axes.shape[0]
    placed, moving, world = np.empty((bodies, 4, 4)), np.empty((dofs, 6)), np.empty((count, 3))
    begun, away, step = pose.joints.copy(), np.zeros(dofs), np.empty(dofs)
    # What moves nothing stays: the systems are of the others only.
    loose, free = np.empty(dofs, np.int64), 0
    for d in range(dofs):
        for b in range(bodies):
            if moves[b, d]:
                loose[free] = d
                free += 1
                break
    hessian, gradient = np.empty((dofs, dofs)), np.empty(dofs)
    lifted, taken = np.empty((free, free)), np.empty(free)
    step[:] = 0.0
    tried = Posed(pose.translation.copy(), pose.root.copy(), pose.joints.copy())
    angles = tried.joints
    _frames(chain, pose, placed)
    _points(placed, bones, local, world)
    cost, damping = missed(world, wanted, weights), 1e-4
    for _ in range(rounds):
        _twists(chain, pose.joints, placed, moving)
        normal_equations(moves, moving, bones, world, wanted, weights, stiffness, away, hessian, gradient)
        better, now = False, cost
        for _attempt in range(6):
            for i in range(free):
                for k in range(i + 1):
                    lifted[i, k] = hessian[loose[i], loose[k]]
                lifted[i, i] += damping
                taken[i] = gradient[loose[i]]
            if not factor_and_solve(lifted, taken):
                taken[:] = 0.0
            size = 0.0
            for i in range(free):
                size = max(size, abs(taken[i]))
            for i in range(free):
                step[loose[i]] = -taken[i] * min(1.0, LONGEST / max(size, 1e-12))
            _put(tried, pose)
            _advance(tried, step)
            now = 0.0
            for j in range(dofs - 6):
                angles[j] = min(max(angles[j], limits[6 + j, 0]), limits[6 + j, 1])
                away[6 + j] = angles[j] - begun[j]
                now += (stiffness[6 + j] * away[6 + j]) ** 2
            _frames(chain, tried, placed)
            _points(placed, bones, local, world)
            now += missed(world, wanted, weights)
            if now < cost:
                better = True
                break
            damping *= 8.0
        if not better:
            break
        _put(pose, tried)
        gained, cost, damping = cost - now, now, damping / 4.0
        if gained < 1e-5 * cost + 1e-9:
            break


@compiled
def _put(into: Posed, pose: Posed) -> None:
    put(into.translation, pose.translation)
    put_matrix(into.root, pose.root)
    put(into.joints, pose.joints)
