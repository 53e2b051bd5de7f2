"""How lively a motion is, by channel and moment: the variance of its second differences relative to the usual."""

import numpy as np

from ...arrays import Floats
from ...numerics.gaussian import gaussian_smooth

LIVELY = 0.05  # s, the width in which motion is as lively as it is
LIVELY_ABOUT = 1.0  # s, the width in which it is about as lively, never livelier than usual
# samples' worth of how lively it is about a moment, to tell that moment's, and of how lively it is as a rule, to tell
# that: next to nothing, for a pose that is held is livelier nowhere, and moves a thousand times less than the clips do
LIVELY_PRIOR, USUAL_PRIOR = 4.0, 0.1
LEAST_LIVELY, MOST_LIVELY = 1e-4, 1000.0  # of the variance of second differences


def liveliness_of(values: Floats, usual: Floats, doubt: Floats, fps: float) -> Floats:
    """(T, C) variance of second differences relative to the library's, smoothed over a moment.

    Parameters
    ----------
    values : (T, C) smoothed.
    usual : (C,) the library's.
    doubt : (T, C) share of the variance of second differences that the samples leave open.
    fps : Hz.

    Source
    ------
    The squares over as many as the samples determine: MacKay, Bayesian interpolation, Neural Computation 4(3), 1992.
    """
    square = np.square(values[:-2] - 2.0 * values[1:-1] + values[2:]) / usual
    told = 1.0 - doubt[2:]

    def over(width: float, prior: Floats | float, samples: float) -> Floats:
        span = 2.0 * width * np.sqrt(np.pi)  # frames that a Gaussian of this width averages
        squares, count = (span * gaussian_smooth(one, width) for one in (square, told))
        return np.asarray((samples * prior + squares) / (samples + count))

    found = np.ones(values.shape)
    found[2:] = over(LIVELY * fps, np.minimum(over(LIVELY_ABOUT * fps, 1.0, USUAL_PRIOR), 1.0), LIVELY_PRIOR)
    return np.clip(found, LEAST_LIVELY, MOST_LIVELY)


def lively_around(liveliness: Floats, calm: Floats) -> Floats:
    """(T, C) liveliness, at least that of the channels that go with each: a burst seldom comes alone."""
    spread = np.sqrt(np.diag(calm))
    share = np.square(calm / np.multiply.outer(spread, spread)) - np.eye(len(calm))
    share = share / np.maximum(share.sum(axis=1, keepdims=True), 1e-9)
    return np.asarray(np.maximum(liveliness, np.exp(np.log(liveliness) @ share.T)))
