"""How sharply a recording bends by its own account, for repairs without a library (section 2.4)."""

from functools import partial

import numpy as np

from ...arrays import Floats
from ..library.exemplars import typical_bends
from .band_limited import BandLimited
from .lasting import Lasting
from .quiet import quiet_bends, quiet_variance

LEAST_SHARE = 0.02  # of the variance of second differences that is taken for motion at least
MOSTLY_MOTION = 0.5  # of the variance of second differences from which they tell of motion
GROWS = 2.0  # times that those of motion are larger over two frames than over one; those of noise are not
# s, lag beyond which nothing is asked any more: steps of motion are not independent for longer. Joints turn back sooner
# than markers do, and asked over longer lags angles seem to bend less than they do.
LONGEST_OF_ANGLES, LONGEST_OF_MARKERS = 0.07, 0.15
COUPLED = 0.9  # of the correlations that a recording's own few frames show


def first_bends(
    measured: Floats,
    fps: float,
    longest: float = LONGEST_OF_ANGLES,
    lasting: Lasting | BandLimited | None = None,
) -> Floats:
    """(C, C) diagonal: variance of the second differences of the motion beneath noise and outliers.

    Steps of variance q and white noise of variance r give second differences of k (2 k² + 1) / 3 q + 6 r over k frames,
    and third differences of 2 q + 20 r over one. Where noise hides the motion from frame to frame, longer lags show it:
    the shortest one that does is asked, doubling.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing. A channel that tells nothing takes the median of the others.
    fps : Hz.
    longest : s, lag beyond which none is asked.
    lasting : noise that lasts, or was smoothed; None = it is new in every frame.
    """
    longest = min(longest * fps, len(measured) / 32)
    lags = [1, 2]
    while lags[-1] <= longest:
        lags.append(2 * lags[-1])
    over = np.array(lags)[:, None]
    found = np.array([quiet_bends(measured, lag) for lag in lags])
    once, twice, third = found[0], found[1], quiet_variance(measured, partial(np.diff, n=3))
    noise = np.where(twice < GROWS * once, np.minimum(once, twice), np.clip(0.75 * third - 1.5 * once, 0.0, None))
    if lasting is not None:
        noise = np.maximum(noise, [lasting.of_bends(lag) for lag in lags])
    shortest = ((found - noise > MOSTLY_MOTION * found) | (over > longest)).argmax(axis=0)
    steps = np.maximum(found - noise, LEAST_SHARE * found) / (over * (2 * over**2 + 1) / 3)
    bends = steps[shortest, np.arange(measured.shape[1])]
    told = np.isfinite(bends)
    return np.diag(np.where(told, bends, np.median(bends[told]) if told.any() else 1.0))


def own_bends(values: Floats, unseen: Floats) -> Floats:
    """(C, C) covariance of the second differences of a first repair, with what it left open added.

    Parameters
    ----------
    values : (T, C) the first repair; NaN = left open.
    unseen : (C,) mean variance of second differences that its samples left open.
    """
    seen = typical_bends(values[None])
    coupled = COUPLED * seen + (1.0 - COUPLED) * np.diag(np.diag(seen))
    return np.asarray(coupled + np.diag(unseen))
