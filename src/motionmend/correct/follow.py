"""A sensor's posture followed through failures: which joints fail, and where those that do would have been.

A few factors explain how sensors see people move. What the trusted joints and the past say of the factors tells
where every joint is to be expected, with a variance. A joint that is far from there, judged by all others, is not
trusted; the joints that are not trusted take the expected places. All is in standard form (normalise.py).
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..kernels import following as kernel
from ..numerics import factors as model
from ..numerics.factors import Belief, Factors
from .reliability import FAILING_SECONDS, HONEST_SECONDS, Detector

LASTING = np.array([HONEST_SECONDS, FAILING_SECONDS])


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
    met : (J,) s, how long the joint was seen going well.
    leapt : (J,) s since it left where it went well as no joint moves; infinite = it did not, or is back.
    """

    belief: Belief
    own: Floats
    failing: Floats
    forecast: Floats
    jerk: Floats
    posture: Floats
    std: Floats
    met: Floats
    leapt: Floats


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
        zero,
        np.full(count, np.inf),
    )


def follow(
    factors: Factors,
    detector: Detector,
    before: Followed,
    forecast: Belief,
    ahead: tuple[Floats, Floats],
    standard: Floats,
    seconds: float,
    signs: kernel.Signs,
) -> Followed:
    """One frame on.

    Parameters
    ----------
    forecast : the belief of the factors before this frame is looked at.
    ahead : what it expects, (J, 3) and (J, 3, 3).
    standard : (J, 3) the sensor's posture in standard form, NaN = missing.
    seconds : since the frame before; 0 for the first.
    signs : of this frame.
    """
    mean, cov, own, failing, chance, jerk, posture, std, met, leapt = kernel.follow(
        factors.mean,
        factors.loadings,
        factors.noise,
        detector.weights,
        LASTING,
        before.own,
        before.failing,
        before.jerk,
        before.met,
        forecast.mean,
        forecast.cov,
        *ahead,
        standard,
        seconds,
        signs,
        before.leapt,
    )
    return Followed(Belief(mean, cov), own, failing, chance, jerk, posture, std, met, leapt)
