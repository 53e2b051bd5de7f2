"""Two poses of one body where one frame does not tell which is right: the second is followed beside the first.

An arm that comes out from behind the body explains a few pixels more where it is than where it was taken to be. One
frame of noise gains as much, so that in one frame no limb may leap far for it; but noise gains now here, now there,
and the truth gains in every frame. So the best pose that was not taken, or the one that was given up, is followed
for some frames (two hypotheses, as of Reid 1979 and of Cham and Rehg 1999), and is taken when its gains add up to what
a leap as long as that asks for.
"""

from dataclasses import replace

import numpy as np

from ...arrays import frozen
from ...bodies.performer import Performer, Pose, landmarks
from ...numerics.least_squares import Solution
from ..frame.evidence import Evidence
from ..limbs.certainty import shown_and_denied, trust_of
from ..limbs.other_poses import Coarse, disagreement
from ..model import TrackerModel
from ..settings import TrackSettings
from ..state import Hypothesis, TrackState
from ..terms.contract import Term
from ..terms.objective import PAUSE, expected_pose, terms_of
from ..terms.prior import strangeness
from ..terms.smooth import difference
from ..terms.solve import solve_pose

GAIN = 0.008  # share of the person's pixels that another pose must explain better
STEP = 0.2  # m, by which an arm or leg may leap for twice that gain
MOST = 10.0  # times that gain that frames together must show for the longest leap
FADES = 0.9  # of what earlier frames gained, in each frame
LEAST = -0.03  # gained in sum; a hypothesis that has lost more is given up
STEPS = 6  # of Gauss-Newton for it in one frame
LASTS = 15  # frames that a hypothesis is followed
ONE = 0.06  # m; two poses whose limbs are closer are one
OWN = 2.0 * ONE  # m apart, from where on a pose is worth following beside the other


def asked(leap: float) -> float:
    """Share of the person's pixels that a pose must explain better, in sum, for a limb to leap so far, in m."""
    return GAIN * min(1.0 + (leap / STEP) ** 2, MOST)


def apart(performer: Performer, pose: Pose, other: Pose) -> float:
    """m between two poses of a body: the mean of the two joints that are farthest apart, an arm's or a leg's."""
    gap = np.linalg.norm(landmarks(performer, pose) - landmarks(performer, other), axis=1)
    return float(np.sort(gap)[-2:].mean())


def contested(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    evidence: Evidence,
    coarse: Coarse,
    terms: list[Term],
    solution: Solution[Pose],
    wrong: float,
    elapsed: float,
    fresh: Hypothesis | None,
) -> tuple[TrackState, list[Term], Solution[Pose], float]:
    """The other pose of the frame before against this frame's solution: what is followed from here, and what beside it.

    Parameters
    ----------
    model, settings : of the tracker.
    state : of this frame, but that pose, velocity, trust and hypothesis are still those of the frame before.
    evidence, coarse, terms : what the frame says, its coarse raster, the terms made for the solution.
    solution, wrong : of this frame, and the share of the person's pixels that it explains wrongly.
    elapsed : s since the frame before.
    fresh : one that this frame suggests, its pose of this frame; None as a rule.

    Returns
    -------
    State, terms, solution and share. If the hypothesis is taken the state's pose and velocity are what its own were.
    """
    old = state.hypothesis
    if old is not None and 0.0 < elapsed < PAUSE:
        twin = replace(state, pose=old.pose, velocity=old.velocity, trust=old.trust, before=None)
        expected = expected_pose(twin, settings, elapsed, coarse)
        others = terms_of(model, settings, twin, evidence, expected)
        found = solve_pose(state.performer, evidence, others, expected, settings, STEPS)
        share = disagreement(state.performer, found.state, coarse)
        odd = strangeness(others, found.state) - strangeness(terms, solution.state)
        gained = FADES * old.gained + wrong - share - odd
        gap = apart(state.performer, found.state, solution.state)
        if gap > ONE and gained > asked(gap):
            given_up = _followed(state, solution.state, state.pose, -0.5 * gained, 0, elapsed, evidence, coarse)
            return replace(twin, before=state.before, hypothesis=given_up), others, found, share
        stays = gap > ONE and gained > LEAST and old.frames + 1 < LASTS
        known = _followed(state, found.state, old.pose, gained, old.frames + 1, elapsed, evidence, coarse)
        state = replace(state, hypothesis=known if stays else None)
    else:
        state = replace(state, hypothesis=None)
    better = state.hypothesis is None or (fresh is not None and fresh.gained > max(state.hypothesis.gained, 0.0))
    if fresh is not None and better and apart(state.performer, fresh.pose, solution.state) > OWN:
        shown, _ = shown_and_denied(state.performer, fresh.pose, coarse, evidence.weight)
        state = replace(state, hypothesis=replace(fresh, trust=frozen(trust_of(shown)[0])))
    return state, terms, solution, wrong


def _followed(
    state: TrackState,
    pose: Pose,
    last: Pose | None,
    gained: float,
    frames: int,
    elapsed: float,
    evidence: Evidence,
    coarse: Coarse,
) -> Hypothesis:
    """A hypothesis with what this frame shows of it and how it has moved since the frame before."""
    assert last is not None
    shown, _ = shown_and_denied(state.performer, pose, coarse, evidence.weight)
    trust = trust_of(shown)[0]
    velocity = difference(pose, last) / elapsed
    velocity[6:] *= np.minimum(1.0, 0.2 + trust)
    return Hypothesis(pose, gained, frozen(velocity), frozen(trust), frames)
