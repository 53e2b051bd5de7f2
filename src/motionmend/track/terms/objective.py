"""What one frame's pose is to minimise (equation 3.14), where the search for it begins, and where it ends."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...bodies.performer import DOFS, Pose, advance
from ..frame.evidence import Evidence
from ..limbs.other_poses import Coarse, disagreement, disagreements
from ..model import TrackerModel
from ..settings import TrackSettings
from ..stages import Stages
from ..state import Fit, Sight, TrackState
from .contract import Term
from .edge import EdgeTerm
from .freespace import FreespaceTerm
from .limits import limits_term
from .prior import prior_term
from .smooth import SmoothTerm, eased
from .solve import solve_pose
from .surface import SurfaceTerm

PAUSE = 0.3  # s without a frame after which nothing is known of the velocity


def terms_of(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    evidence: Evidence,
    expected: Pose,
    elapsed: float = 0.0,
) -> list[Term]:
    """The terms that the settings ask for, made for one frame (equation 3.14).

    Parameters
    ----------
    model : the library of poses, for the prior.
    settings : which terms, their weights and windows.
    state : after the frame before; it has a pose.
    evidence : what the frame says.
    expected : the pose that smoothness draws to. elapsed : s since the frame before; 0 of a body found anew.
    """
    assert state.pose is not None
    weights = np.full(DOFS, eased(settings.smooth, elapsed))
    terms: list[Term] = [
        SurfaceTerm(evidence, settings, state.before if "color" in settings.terms else None),
        SmoothTerm(expected, weights),
    ]
    if "edge" in settings.terms:
        terms.append(EdgeTerm(evidence, settings))
    if "freespace" in settings.terms:
        terms.append(FreespaceTerm(evidence, settings))
    if "limits" in settings.terms:
        terms.append(limits_term(state.performer, settings.limits, state.trust))
    if "prior" in settings.terms:
        prior = prior_term(model.database, state.pose, settings, state.trust)
        if prior is not None:
            terms.append(prior)
    return terms


def expected_pose(state: TrackState, settings: TrackSettings, elapsed: float, coarse: Coarse) -> Pose:
    """Where the body should be by now: where its motion leads, unless where it was explains the frame better.

    Parameters
    ----------
    state : after the frame before; its velocity (34,) in m/s and rad/s.
    settings : how much of the velocity is expected.
    elapsed : s since the frame before.
    coarse : the frame, for the comparison.
    """
    assert state.pose is not None
    if settings.velocity <= 0.0 or not 0.0 < elapsed < PAUSE:
        return state.pose
    # Half the last step is expected; all of it or none only where the frame says so clearly.
    shares, handicaps = (settings.velocity, 0.0, 1.0), (0.0, 0.01, 0.01)
    ways = [advance(state.performer, state.pose, share * elapsed * state.velocity) for share in shares]
    return ways[int(np.argmin(disagreements(state.performer, ways, coarse) + handicaps))]


def fitted(
    sight: Sight,
    state: TrackState,
    expected: Pose,
    iterations: int | None = None,
    clock: Stages | None = None,
    elapsed: float = 0.0,
) -> Fit:
    """The pose that explains a frame best, as the settings' terms have it, near where the body is expected.

    Parameters
    ----------
    sight : the frame.
    state : after the frame before; it has a pose.
    expected : to begin at, and that smoothness draws to.
    iterations : of Gauss-Newton, at most; the settings' when None.
    clock : is told when the terms are made, and when they are solved.
    elapsed : s since the frame before; 0 of a body found anew.
    """
    terms = terms_of(sight.model, sight.settings, state, sight.evidence, expected, elapsed)
    if clock is not None:
        clock.lap("prior")
    solution = solve_pose(state.performer, sight.evidence, terms, expected, sight.settings, iterations)
    if clock is not None:
        clock.lap("solve")
    return Fit(state, terms, expected, solution, disagreement(state.performer, solution.state, sight.coarse))


def refined(sight: Sight, fit: Fit, pose: Pose, terms: Sequence[Term], iterations: int = 5) -> Fit:
    """The same frame explained from another beginning.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    pose : to begin at. terms : the frame's, or those about another pose (`smooth.about`).
    iterations : of Gauss-Newton, at most.
    """
    performer = fit.state.performer
    solution = solve_pose(performer, sight.evidence, terms, pose, sight.settings, iterations)
    return replace(fit, solution=solution, wrong=disagreement(performer, solution.state, sight.coarse))
