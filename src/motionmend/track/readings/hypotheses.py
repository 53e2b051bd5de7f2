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
from ..limbs.certainty import shown_and_denied, trust_of
from ..state import Fit, Hypothesis, Sight, TrackState
from ..terms.objective import PAUSE, expected_pose, fitted
from ..terms.prior import strangeness
from ..terms.smooth import difference

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


def contested(sight: Sight, fit: Fit, elapsed: float, fresh: Hypothesis | None) -> Fit:
    """The other pose of the frame before against this frame's fit: what is followed from here, and what beside it.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    elapsed : s since the frame before.
    fresh : one that this frame suggests, its pose of this frame; None as a rule.

    Returns
    -------
    The fit. If the hypothesis is taken the state's pose and velocity are what its own were.
    """
    state, old = fit.state, fit.state.hypothesis
    if old is not None and 0.0 < elapsed < PAUSE:
        twin = replace(state, pose=old.pose, velocity=old.velocity, trust=old.trust, before=None)
        expected = expected_pose(twin, sight.settings, elapsed, sight.coarse)
        other = fitted(sight, twin, expected, STEPS, elapsed=elapsed)
        odd = strangeness(other.terms, other.pose) - strangeness(fit.terms, fit.pose)
        gained = FADES * old.gained + fit.wrong - other.wrong - odd
        gap = apart(state.performer, other.pose, fit.pose)
        if gap > ONE and gained > asked(gap):
            given_up = _followed(sight, state, fit.pose, state.pose, -0.5 * gained, 0, elapsed)
            return replace(other, state=replace(twin, before=state.before, hypothesis=given_up))
        stays = gap > ONE and gained > LEAST and old.frames + 1 < LASTS
        known = _followed(sight, state, other.pose, old.pose, gained, old.frames + 1, elapsed)
        state = replace(state, hypothesis=known if stays else None)
    else:
        state = replace(state, hypothesis=None)
    better = state.hypothesis is None or (fresh is not None and fresh.gained > max(state.hypothesis.gained, 0.0))
    if fresh is not None and better and apart(state.performer, fresh.pose, fit.pose) > OWN:
        shown, *_ = shown_and_denied(state.performer, fresh.pose, sight.coarse, sight.evidence.weight)
        state = replace(state, hypothesis=replace(fresh, trust=frozen(trust_of(shown)[0])))
    return replace(fit, state=state)


def _followed(
    sight: Sight, state: TrackState, pose: Pose, last: Pose | None, gained: float, frames: int, elapsed: float
) -> Hypothesis:
    """A hypothesis with what this frame shows of it and how it has moved since the frame before."""
    assert last is not None
    shown, *_ = shown_and_denied(state.performer, pose, sight.coarse, sight.evidence.weight)
    trust = trust_of(shown)[0]
    velocity = difference(pose, last) / elapsed
    velocity[6:] *= np.minimum(1.0, 0.2 + trust)
    return Hypothesis(pose, gained, frozen(velocity), frozen(trust), frames)
