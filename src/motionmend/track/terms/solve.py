"""The pose of one frame: the terms put together and minimised (section 3.6)."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.performer import DOFS, Performer, Pose, advance
from ...kernels import descend
from ...numerics.least_squares import Solution, System, gauss_newton
from ..frame.evidence import JUMP, Evidence
from ..settings import TrackSettings
from .contract import Term
from .edge import EdgeTerm
from .freespace import FreespaceTerm, far_at
from .limits import SOLID, SOLID_SCALE, LimitsTerm
from .prior import PriorTerm
from .smooth import SmoothTerm
from .surface import WIDER, SurfaceTerm
from .view import BONES_MOVED, MOVED_FIRST, Sums, view_of

TOLERANCE = 5e-3  # m and rad; below what a depth sensor tells
LONGEST = 0.35  # m and rad, of one step
NO_MEAN, NO_FORM, NO_CLEARANCE = frozen(np.zeros(0)), frozen(np.zeros((0, 0))), np.zeros(0)
Kind = TypeVar("Kind", bound=Term)
_ORDER: dict[type, int] = {
    SurfaceTerm: descend.SURFACE,
    EdgeTerm: descend.EDGE,
    FreespaceTerm: descend.FREE,
    SmoothTerm: descend.SMOOTH,
    LimitsTerm: descend.LIMITS,
    PriorTerm: descend.PRIOR,
}


def solve_pose(
    performer: Performer,
    evidence: Evidence,
    terms: Sequence[Term],
    pose: Pose,
    settings: TrackSettings,
    iterations: int | None = None,
) -> Solution[Pose]:
    """Gauss-Newton from `pose`: render, match, solve, move, again (the six steps of section 3.6, equations 3.14-3.16).

    Parameters
    ----------
    performer : the body.
    evidence : what the frame says.
    terms : made for this frame.
    pose : to begin at.
    settings : damping, iterations and raster.
    iterations : at most so many; the settings' when None.

    Returns
    -------
    The pose, its costs and inliers by term, and the normal matrix (34, 34) at the end.
    """

    most = settings.iterations if iterations is None else iterations
    solution = _at_once(performer, evidence, terms, pose, settings, most)
    if solution is not None:
        return solution

    def linearize(at: Pose, iteration: int) -> System:
        return _summed(performer, evidence, terms, at, settings, iteration)

    def move(at: Pose, step: Floats) -> Pose:
        return advance(performer, at, step)

    return gauss_newton(linearize, pose, move, most, settings.damping, TOLERANCE, LONGEST, settings.settled)


def linearized(
    performer: Performer, evidence: Evidence, terms: Sequence[Term], pose: Pose, settings: TrackSettings
) -> System:
    """What the terms ask of a pose near the one sought, looked for no wider than in the last iterations.

    Parameters
    ----------
    performer, evidence, terms, settings : as for `solve_pose`.
    pose : where they are linearised.

    Returns
    -------
    Normal equations over the degrees of freedom (34,), m and rad: `normal` x = `right`, equation 3.16.
    """
    solution = _at_once(performer, evidence, terms, pose, settings, 1, 0)
    return (
        _summed(performer, evidence, terms, pose, settings, settings.iterations)
        if solution is None
        else solution.system
    )


def _summed(
    performer: Performer,
    evidence: Evidence,
    terms: Sequence[Term],
    at: Pose,
    settings: TrackSettings,
    iteration: int,
) -> System:
    view = view_of(performer, at, evidence, settings.every)
    sums = Sums()
    costs, inliers, samples = {}, {}, 0.0
    for term in terms:
        share = term.linearize(view, sums, iteration)
        costs[term.name] = share.cost
        if share.samples:
            inliers[term.name] = share.inliers
            samples += share.samples
    normal, right = sums.assembled(view)
    return System(normal, right, costs, inliers, samples)


def _at_once(
    performer: Performer,
    evidence: Evidence,
    terms: Sequence[Term],
    pose: Pose,
    settings: TrackSettings,
    most: int,
    wide: int = WIDER,
) -> Solution[Pose] | None:
    """The same by one kernel; None where a system is singular, or for terms it does not know: colour, Canny's edges."""
    surface, smooth, limits = _of(terms, SurfaceTerm), _of(terms, SmoothTerm), _of(terms, LimitsTerm)
    edge, free, prior = _of(terms, EdgeTerm), _of(terms, FreespaceTerm), _of(terms, PriorTerm)
    if surface is None or smooth is None or any(type(term) not in _ORDER for term in terms):
        return None
    if surface.before is not None or (edge is not None and edge.settings.canny):
        return None
    wish = np.zeros(1, descend.WISHES)
    wish["every"], wish["two_way"] = settings.every, settings.two_way
    wish["half"], wish["wide"] = settings.window // 2, wide if settings.two_way else 0
    wish["edge_half"], wish["iterations"] = settings.edge_window // 2, max(most, 1)
    wish["gate"], wish["apart"], wish["scale"] = settings.gate, evidence.apart, settings.scale
    wish["along"], wish["back"], wish["surface"] = settings.along_normal, settings.along_back, evidence.weight
    wish["jump"], wish["edge"] = JUMP, 0.0 if edge is None else edge.weight
    wish["reach"], wish["free_scale"] = far_at(pose, evidence), settings.free_scale
    wish["free"] = 0.0 if free is None else settings.freespace * evidence.weight
    wish["limits"], wish["prior"] = 0.0 if limits is None else limits.weight, prior is not None
    wish["solid"], wish["solid_scale"] = SOLID * wish["limits"], SOLID_SCALE
    wish["damping"], wish["tolerance"], wish["longest"] = settings.damping, TOLERANCE, LONGEST
    wish["settled"] = settings.settled
    posed = pose.arrays
    normal, right = np.empty((DOFS, DOFS)), np.empty(DOFS)
    costs, counts = np.zeros(6), np.zeros((6, 2), np.int64)
    taken, converged = descend.descend(
        performer.chain,
        posed,
        performer.solids.arrays,
        MOVED_FIRST,
        BONES_MOVED,
        evidence.intrinsics,
        evidence.depth,
        evidence.free,
        evidence.pixels,
        evidence.samples,
        evidence.edge_pixels,
        evidence.edge_samples,
        smooth.expected.arrays,
        smooth.weights,
        performer.limits.copy(),
        *performer.trunk_and_forearms,
        NO_CLEARANCE if limits is None else limits.clear,
        NO_MEAN if prior is None else prior.mean,
        NO_FORM if prior is None else prior.form,
        wish,
        normal,
        right,
        costs,
        counts,
    )
    if not taken:
        return None
    number = {term.name: _ORDER[type(term)] for term in terms}
    shown = {name: int(counts[i, 0]) for name, i in number.items() if counts[i, 1]}
    system = System(
        normal, right, {name: float(costs[i]) for name, i in number.items()}, shown, float(counts[:, 1].sum())
    )
    return Solution(Pose(*posed), system, taken, converged)


def _of(terms: Sequence[Term], kind: type[Kind]) -> Kind | None:
    for term in terms:
        if isinstance(term, kind):
            return term
    return None
