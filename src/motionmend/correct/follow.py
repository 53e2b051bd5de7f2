"""A sensor's posture followed through failures: which joints fail, and where those that do would have been.

A few factors explain how sensors see people move. What the trusted joints and the past say of the factors tells
where every joint is to be expected, with a variance. A joint that is far from there, judged by all others, is not
trusted; the joints that are not trusted take the expected places. All is in standard form (normalise.py).
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..numerics import factors as model
from ..numerics.factors import Belief, Factors
from .reliability import Detector, chain_forward

HOLD_SECONDS = 0.4  # how fast the part of a person's shape that factors do not explain is learned while it is seen
DOUBT_SECONDS = 1.5  # the same for a joint out of place of which nothing else is wrong: it may be this sensor's way
STRANGER = 0.05  # standard metres, of a joint's place in people and sensors not met yet, beside the factors' noise
MET_SECONDS = 0.5  # how long a joint is a stranger
SETTLED = 0.02  # change of the probability to fail below which nothing is weighed again
ROUNDS = 2  # of weighing the joints by what the others say


@dataclass(frozen=True, eq=False)
class Followed:
    """What is known of the sensor's posture.

    Attributes
    ----------
    belief : of the factors, this frame included.
    own : (J, 3) what is this person's own in the shape, beyond the factors.
    failing : (J,) probability that the joint fails.
    forecast : (J,) the same before this frame was seen.
    jerk : (J,) running size of second differences, by the usual one.
    posture : (J, 3) with the joints that fail where they are expected.
    std : (J,) of a coordinate of `posture`.
    features : (J, F) the evidence.
    met : (J,) s, how long the joint was seen going well.
    """

    belief: Belief
    own: Floats
    failing: Floats
    forecast: Floats
    jerk: Floats
    posture: Floats
    std: Floats
    features: Floats
    met: Floats


def begin(factors: Factors) -> Followed:
    """Before the first frame."""
    count = len(factors.mean)
    zero = np.zeros(count)
    return Followed(
        model.start(factors),
        np.zeros((count, 3)),
        np.full(count, 0.05),
        np.full(count, 0.05),
        zero,
        factors.mean,
        zero,
        np.zeros((count, 8)),
        zero,
    )


def follow(
    factors: Factors,
    detector: Detector,
    before: Followed,
    forecast: Belief,
    ahead: tuple[Floats, Floats],
    standard: Floats,
    seconds: float,
    raw: Floats,
    bones: tuple[Floats, Floats],
    told: Floats,
) -> Followed:
    """One frame on.

    Parameters
    ----------
    forecast : the belief of the factors before this frame is looked at.
    ahead : what it expects, (J, 3) and (J, 3, 3).
    standard : (J, 3) the sensor's posture in standard form, NaN = missing.
    seconds : since the frame before; 0 for the first.
    raw : (J,) size of the joint's second difference by the usual one; 0 where not known.
    bones : two (J,) of `bone_features`.
    told : (J, 3) of `state_features`.
    """
    present = np.asarray(np.isfinite(standard).all(axis=1))
    values = np.where(present[:, None], standard, factors.mean) - factors.mean - before.own
    jerk = raw + (before.jerk - raw) * np.exp(-seconds / 0.1)
    nothing = np.zeros(len(standard))
    expected, cov = ahead
    own_variance = factors.noise + STRANGER**2 * np.exp(-before.met / MET_SECONDS)
    first = np.log1p(model.left_out(values - expected, cov, own_variance, nothing)[0])
    features = np.column_stack([first, first, bones[0], bones[1], np.log1p(np.maximum(raw, jerk)), told])
    chance, failing = chain_forward(before.failing, detector.evidence(features), seconds)
    belief = forecast
    for _ in range(ROUNDS):
        trust = np.where(present, 1.0 - failing, 0.0)
        trust = np.where(trust > 0.02, trust, 0.0)
        precision = trust / own_variance
        belief = model.seen(factors, forecast, values, precision)
        expected, cov = model.expected(factors, belief)
        left = np.log1p(model.left_out(values - expected, cov, own_variance, precision)[0])
        features = np.column_stack([left, first, bones[0], bones[1], np.log1p(np.maximum(raw, jerk)), told])
        judged, (_, failing) = failing, chain_forward(before.failing, detector.evidence(features), seconds)
        if np.abs(failing - judged).max() < SETTLED:
            break
    failing = np.where(present, failing, 1.0)
    trust = np.where(present, 1.0 - failing, 0.0)[:, None]
    posture = np.where(present[:, None], trust * values, 0.0) + (1.0 - trust) * expected
    passed = max(seconds, 1.0 / 30.0)
    steady = 1.0 / (1.0 + np.exp(detector.evidence(np.column_stack([np.ones((len(told), 2)), features[:, 2:]]))))
    gain = np.where(
        trust[:, 0] > 0.5,
        trust[:, 0] * (1.0 - np.exp(-passed / HOLD_SECONDS)),
        np.where(steady > 0.8, 1.0 - np.exp(-passed / DOUBT_SECONDS), 0.0),
    )
    rest = np.where(present[:, None], values - expected, 0.0)
    own = before.own + gain[:, None] * rest
    unsure = np.sqrt(np.trace(cov, axis1=1, axis2=2) / 3.0 + own_variance)
    return Followed(
        belief,
        own,
        failing,
        chance,
        jerk,
        posture + factors.mean + before.own,
        (1.0 - trust[:, 0]) * unsure,
        features,
        before.met + passed * trust[:, 0],
    )
