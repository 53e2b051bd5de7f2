"""Inverse kinematics: the joint angles that put some joints where they should be."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import Bools, Floats, Ints, frozen
from ..errors import MismatchError
from .skeleton import ROTATION, Skeleton

# The gradient of the cost (m² per radian) below which nothing is left to gain.
GRADIENT_TOLERANCE = 1e-12
# The pull towards the start is slackened in stages: (times rest_weight, share of the cost that a round must still save,
# share of the rounds). Under a weak pull alone the least change lies along a narrow curved valley that takes hundreds.
STAGES = ((100.0, 1e-2, 0.25), (10.0, 1e-2, 0.25), (1.0, 1e-7, 0.5))
# Targets met within this distance (m) can be reached: what is left is the pull towards the start, and is removed.
# By less than SMALL_TURN (rad or m) of any DOF, that is: where only a wild turn would do, the miss is the lesser evil.
REACHABLE, SMALL_TURN = 1e-3, 0.05
MET = 1e-6
# A pose whose pull on every joint is nil while a target is this far away (m) sits on a saddle or out of reach.
STUCK = 1e-4
# How far (rad) such a pose is bent off its saddle: enough to leave it, too little to reach another posture.
NUDGE = 0.1
# Damping as a share of the stiffest direction's curvature. It is the same for all directions: scaled by each
# direction's own curvature, legs near full extension crawl.
FIRST_DAMPING, LEAST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-12, 1e9


@dataclass(frozen=True, eq=False)
class IkResult:
    """What `solve` found.

    Attributes
    ----------
    q : (T, D) rad and m, or (D,) when one pose was given; DOFs outside `movable` are those of the start.
    residual : (T, P) or (P,) m, distance of each joint from its target; NaN where there was none.
    iterations : rounds until the last frame stopped.
    converged : (T,) or (1,) whether the targets are met, or no small change of the pose lowers the cost any more.
    """

    q: Floats
    residual: Floats
    iterations: int
    converged: Bools

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen(self.q))
        object.__setattr__(self, "residual", frozen(self.residual))
        object.__setattr__(self, "converged", frozen(self.converged, np.bool_))


def solve(
    skeleton: Skeleton,
    q0: ArrayLike,
    joints: Sequence[int] | Ints,
    targets: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    rest_weight: ArrayLike = 1e-3,
    movable: Sequence[int] | Ints | None = None,
    max_iterations: int = 200,
) -> IkResult:
    """Move joints to targets by damped least squares within the joint limits, staying near the start.

    Minimises, for each frame by itself,
    sum_p w_p |x_p(q) - target_p|² + sum_d (rest_weight_d (q_d - q0_d))²  over the movable q_d within limits.
    A limit that the start already breaks is widened to the start: a recorded pose is never pushed about
    because its file's limits are narrower than the person. All frames are solved side by side.

    Parameters
    ----------
    skeleton : the body, D degrees of freedom.
    q0 : (D,) or (T, D) rad and m, the start and the pose to stay near.
    joints : (P,) indices of the joints to place.
    targets : (P, 3) or (T, P, 3) m; a target with NaN is left out.
    weights : (P,) or (T, P), not negative; 1 when not given.
    rest_weight : a number or (D,), not negative: the metres of miss that weigh as much as one radian (or metre) of
        change. It decides what the targets leave open; targets that can be reached are reached whatever it is.
    movable : indices of the DOFs that may change; all when not given.
    max_iterations : rounds after which the frames that still improve are returned as they are.

    Returns
    -------
    IkResult : a frame whose start holds NaN above a joint to place, or that has no target at all, keeps its start
        and is reported as not converged when it had a target.

    Raises
    ------
    MismatchError : shapes that do not fit the skeleton or each other, or indices it does not have.

    Source
    ------
    Levenberg 1944 and Marquardt 1963 for the damping; limits by projection and an active set as in
    Kanzow, Yamashita and Fukushima 2004, "Levenberg-Marquardt methods with strong local convergence properties".
    """
    start = np.array(q0, dtype=np.float64, ndmin=2)
    frames, dofs = start.shape
    if dofs != len(skeleton.dof_names) or np.ndim(q0) > 2:
        raise MismatchError(f"a start pose needs {len(skeleton.dof_names)} values a frame, came {np.shape(q0)}")
    placed = _indices("joints", joints, len(skeleton.names))
    allowed = np.arange(dofs) if movable is None else np.unique(_indices("movable", movable, dofs))
    moved = np.intersect1d(allowed, _above(skeleton, placed))
    wanted = _spread("targets", targets, (frames, len(placed), 3))
    scale = _spread("weights", 1.0 if weights is None else weights, (frames, len(placed)))
    rest = _spread("rest_weight", rest_weight, (dofs,))[moved]

    problem = _Problem(
        chain=_Chain(skeleton, placed, moved),
        start=start,
        wanted=np.nan_to_num(wanted),
        root_weights=np.sqrt(np.where(np.isfinite(wanted).all(axis=2), scale, 0.0)),
        rest=rest,
        lower=np.minimum(skeleton.limits[moved, 0], start[:, moved]),
        upper=np.maximum(skeleton.limits[moved, 1], start[:, moved]),
    )
    usable = np.isfinite(start[:, _above(skeleton, placed)]).all(axis=1) & (problem.root_weights > 0).any(axis=1)
    rows = np.flatnonzero(usable)
    q = start.copy()
    converged: Bools = np.array(~(problem.root_weights > 0).any(axis=1))
    iterations = 0
    if len(rows) and len(moved):
        for slack, tolerance, share in STAGES:
            stage = replace(problem, rest=problem.rest * slack)
            most = max(1, round(share * max_iterations))
            q[rows], converged[rows], rounds = _descend(stage, rows, q[rows], most, tolerance)
            iterations += rounds
        stuck = rows[converged[rows] & (_misses(problem, rows, q[rows]) > STUCK)]
        if len(stuck):
            iterations += _leave_saddles(problem, stuck, q, converged, most)
        q[rows] = _settle(problem, rows, q[rows])
        converged[rows] |= _misses(problem, rows, q[rows]) < MET
    residual = np.linalg.norm(problem.chain.positions(q) - wanted, axis=2)
    if np.ndim(q0) == 1:
        return IkResult(q[0], residual[0], iterations, converged)
    return IkResult(q, residual, iterations, converged)


@dataclass(frozen=True, eq=False)
class _Problem:
    """T independent problems over the same joints P and movable DOFs m."""

    chain: "_Chain"
    start: Floats  # (T, D)
    wanted: Floats  # (T, P, 3)
    root_weights: Floats  # (T, P)
    rest: Floats  # (m,)
    lower: Floats  # (T, m)
    upper: Floats  # (T, m)


def _descend(problem: _Problem, rows: Ints, begin: Floats, most: int, tolerance: float) -> tuple[Floats, Bools, int]:
    """Levenberg-Marquardt on the frames `rows` from `begin` (n, D): poses, which converged, rounds needed."""
    moved = problem.chain.moved
    best = begin.copy()
    found = np.zeros(len(rows), dtype=bool)
    damping = np.full(len(rows), FIRST_DAMPING)
    active = np.arange(len(rows))
    residual, jacobian = _linearise(problem, rows, best)
    cost = _cost(problem, rows, residual, best)
    for iteration in range(most):
        at = rows[active]
        x = best[np.ix_(active, moved)]
        pull = problem.rest**2
        gradient = np.einsum("nri,nr->ni", jacobian, residual) + pull * (x - problem.start[at][:, moved])
        hessian = jacobian.transpose(0, 2, 1) @ jacobian
        hessian[:, range(len(moved)), range(len(moved))] += pull
        held = ((x <= problem.lower[at]) & (gradient > 0)) | ((x >= problem.upper[at]) & (gradient < 0))
        gradient[held] = 0.0
        flat = np.abs(gradient).max(axis=1) <= GRADIENT_TOLERANCE
        found[active[flat]] = True
        keep = ~flat & (damping[active] < LARGEST_DAMPING)
        active, at, x, held = active[keep], at[keep], x[keep], held[keep]
        residual, jacobian = residual[keep], jacobian[keep]
        if not len(active):
            return best, found, iteration
        step = _step(hessian[keep], gradient[keep], held, damping[active])
        trial = best[active]
        trial[:, moved] = np.clip(x + step, problem.lower[at], problem.upper[at])
        new_residual, new_jacobian = _linearise(problem, at, trial)
        new_cost = _cost(problem, at, new_residual, trial)
        saved = cost[active] - new_cost
        better = saved > 0
        best[active[better]] = trial[better]
        cost[active[better]] = new_cost[better]
        residual[better], jacobian[better] = new_residual[better], new_jacobian[better]
        # A step that saves nothing measurable, or none that rounding can tell from standing still, ends the frame.
        done = np.where(better, saved <= tolerance * new_cost, np.abs(step).max(axis=1) < 1e-9)
        found[active[done]] = True
        damping[active] = np.maximum(damping[active] * np.where(better, 0.1, 10.0), LEAST_DAMPING)
        active, residual, jacobian = active[~done], residual[~done], jacobian[~done]
        if not len(active):
            return best, found, iteration + 1
    return best, found, most


def _step(hessian: Floats, gradient: Floats, held: Bools, damping: Floats) -> Floats:
    """The damped Gauss-Newton step (n, m) with the DOFs `held` at their limits left where they are."""
    free = ~held
    hessian = hessian * (free[:, :, None] & free[:, None, :])
    stiffest = np.einsum("nii->ni", hessian).max(axis=1, keepdims=True)
    lift = damping[:, None] * np.maximum(stiffest, 1e-12) + held
    size = hessian.shape[1]
    hessian[:, range(size), range(size)] += lift
    return np.asarray(-np.linalg.solve(hessian, gradient[:, :, None])[:, :, 0])


def _leave_saddles(problem: _Problem, stuck: Ints, q: Floats, converged: Bools, most: int) -> int:
    """Bend stuck frames and try again; keep what is clearly better (a straight leg told to shorten)."""
    moved = problem.chain.moved
    turning = problem.chain.skeleton.dof_kind[moved] == ROTATION
    lower, upper = problem.lower[stuck], problem.upper[stuck]
    x = q[np.ix_(stuck, moved)]
    room_up, room_down = upper - x, x - lower
    bent = x + NUDGE * turning * np.where(room_up >= room_down, 1.0, -1.0)
    begin = q[stuck]
    begin[:, moved] = np.clip(bent, lower, upper)
    again, found, iterations = _descend(problem, stuck, begin, most, STAGES[-1][1])
    better = _total(problem, stuck, again) < (1 - 1e-6) * _total(problem, stuck, q[stuck])
    q[stuck[better]] = again[better]
    converged[stuck[better]] = found[better]
    return iterations


def _settle(problem: _Problem, rows: Ints, q: Floats) -> Floats:
    """Bring poses (n, D) whose targets can be reached exactly onto them by the smallest changes that do."""
    moved = problem.chain.moved
    near = np.flatnonzero(_misses(problem, rows, q) < REACHABLE)
    settled = q.copy()
    held = np.zeros((len(near), len(moved)), dtype=bool)
    for _ in range(10):
        if not len(near):
            break
        at = rows[near]
        residual, jacobian = _linearise(problem, at, settled[near])
        jacobian = jacobian * ~held[:, None, :]
        x = settled[np.ix_(near, moved)]
        free = x - (np.linalg.pinv(jacobian, rcond=1e-4) @ residual[:, :, None])[:, :, 0]
        trial = settled[near]
        trial[:, moved] = np.clip(free, problem.lower[at], problem.upper[at])
        newly = (trial[:, moved] != free) & ~held
        before, after = (residual**2).sum(axis=1), (_linearise(problem, at, trial)[0] ** 2).sum(axis=1)
        turned = np.abs(trial[:, moved] - q[np.ix_(near, moved)]).max(axis=1)
        better = (after < before - 1e-24) & (turned < SMALL_TURN)
        settled[near[better]] = trial[better]
        keep = better | newly.any(axis=1)
        near, held = near[keep], (held | newly)[keep]
    return settled


def _linearise(problem: _Problem, rows: Ints, q: Floats) -> tuple[Floats, Floats]:
    """Weighted residuals (n, 3P) and their derivatives (n, 3P, m)."""
    at, slope = problem.chain.positions_and_jacobian(q)
    scale = problem.root_weights[rows][:, :, None]
    residual = ((at - problem.wanted[rows]) * scale).reshape(len(rows), -1)
    return residual, (slope * scale[..., None]).reshape(len(rows), residual.shape[1], -1)


def _cost(problem: _Problem, rows: Ints, residual: Floats, q: Floats) -> Floats:
    moved = problem.chain.moved
    away = problem.rest * (q[:, moved] - problem.start[rows][:, moved])
    return np.asarray((residual**2).sum(axis=1) + (away**2).sum(axis=1))


def _total(problem: _Problem, rows: Ints, q: Floats) -> Floats:
    return _cost(problem, rows, _linearise(problem, rows, q)[0], q)


def _misses(problem: _Problem, rows: Ints, q: Floats) -> Floats:
    """(n,) m, the largest distance from a target that counts."""
    away = np.linalg.norm(problem.chain.positions(q) - problem.wanted[rows], axis=2)
    return np.asarray(np.where(problem.root_weights[rows] > 0, away, 0.0).max(axis=1))


class _Chain:
    """The joints above those to place, split into those that stay and those that the movable DOFs move."""

    def __init__(self, skeleton: Skeleton, placed: Ints, moved: Ints) -> None:
        self.skeleton = skeleton
        self.placed = placed
        self.moved = moved
        self.joints = sorted({above for joint in placed for above in _path(skeleton, int(joint))})
        self._column = {int(dof): column for column, dof in enumerate(moved)}
        self._turns = [_cross_matrix(axis) for axis in skeleton.dof_axis]
        # below[p, i]: whether placed joint p hangs on movable DOF i, a path through the tree.
        self._below = np.array(
            [[skeleton.dof_joint[dof] in _path(skeleton, int(p)) for dof in moved] for p in placed], dtype=bool
        ).reshape(len(placed), len(moved))

    def positions(self, q: Floats) -> Floats:
        """(T, P, 3) m of the joints to place."""
        return self._walk(q)[0]

    def positions_and_jacobian(self, q: Floats) -> tuple[Floats, Floats]:
        """(T, P, 3) m and (T, P, 3, m), m per radian or per metre."""
        at, axes, origins = self._walk(q)
        turning = self.skeleton.dof_kind[self.moved] == ROTATION
        arms = at[:, :, None, :] - origins[:, None, :, :]
        slope = np.where(turning[:, None], np.cross(axes[:, None, :, :], arms), axes[:, None, :, :])
        return at, np.asarray((slope * self._below[..., None]).transpose(0, 1, 3, 2))

    def _walk(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Places of the joints to place (T, P, 3); axis and origin of each movable DOF in the world (T, m, 3)."""
        body = self.skeleton
        frames = len(q)
        axes = np.zeros((frames, len(self.moved), 3))
        origins = np.zeros((frames, len(self.moved), 3))
        place: dict[int, Floats] = {}
        turn: dict[int, Floats] = {}
        for joint in self.joints:
            parent = int(body.parents[joint])
            if parent < 0:
                here = np.broadcast_to(body.offsets[joint], (frames, 3))
                frame = np.broadcast_to(np.eye(3), (frames, 3, 3))
            else:
                here = place[parent] + turn[parent] @ body.offsets[joint]
                frame = turn[parent]
            for dof in body.dofs_of(joint):
                axis = frame @ body.dof_axis[dof]
                if body.dof_kind[dof] == ROTATION:
                    column = self._column.get(int(dof))
                    if column is not None:
                        axes[:, column], origins[:, column] = axis, here
                    frame = frame @ _rotations(self._turns[dof], q[:, dof])
                else:
                    column = self._column.get(int(dof))
                    if column is not None:
                        axes[:, column] = axis
                    here = here + axis * q[:, dof, None]
            place[joint], turn[joint] = here, frame
        at = np.stack([place[int(p)] for p in self.placed], axis=1) if len(self.placed) else np.empty((frames, 0, 3))
        return at, axes, origins


def _above(skeleton: Skeleton, joints: Ints) -> Ints:
    """DOFs on which the place of any of the joints depends."""
    return np.flatnonzero(np.isin(skeleton.dof_joint, [above for j in joints for above in _path(skeleton, int(j))]))


def _path(skeleton: Skeleton, joint: int) -> set[int]:
    """The joint and all joints above it."""
    path = set()
    while joint >= 0:
        path.add(joint)
        joint = int(skeleton.parents[joint])
    return path


def _cross_matrix(axis: Floats) -> Floats:
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _rotations(cross: Floats, angles: Floats) -> Floats:
    """(T, 3, 3) rotations by `angles` about one axis (Rodrigues' formula)."""
    sine, versine = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))


def _indices(name: str, values: Sequence[int] | Ints, size: int) -> Ints:
    indices = np.asarray(values, dtype=np.int64).reshape(-1)
    if len(indices) and (indices.min() < 0 or indices.max() >= size):
        raise MismatchError(f"{name} must lie in 0..{size - 1} for this skeleton, came {indices.tolist()}")
    return indices


def _spread(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[Any]:
    try:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), shape)
    except ValueError:
        raise MismatchError(f"{name} must be {shape} or fit it by repetition, came {np.shape(values)}") from None
