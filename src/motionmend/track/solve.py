"""The pose of one frame: the terms put together and minimised (section 3.6)."""

from collections.abc import Sequence

from ..arrays import Floats
from ..bodies.performer import Performer, Pose, advance
from ..numerics.least_squares import Solution, System, gauss_newton
from .evidence import Evidence
from .settings import TrackSettings
from .terms import Term
from .view import Sums, view_of

TOLERANCE = 5e-3  # m and rad; below what a depth sensor tells


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

    def linearize(at: Pose, iteration: int) -> System:
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

    def move(at: Pose, step: Floats) -> Pose:
        return advance(performer, at, step)

    return gauss_newton(
        linearize,
        pose,
        move,
        settings.iterations if iterations is None else iterations,
        settings.damping,
        TOLERANCE,
        longest=0.35,
    )
