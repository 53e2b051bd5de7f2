"""How sharply a recording bends by its own account, for repairs without a library (section 2.4)."""

import numpy as np

from ..arrays import Floats
from .library import typical_bends

QUIET = 0.3  # quantile of differences that outliers hardly reach
_QUIET_NORMAL = 0.3853205  # the same quantile of |N(0, 1)|
LEAST_SHARE = 0.02  # of the variance of second differences that is taken for motion at least
COUPLED = 0.9  # of the correlations that a recording's own few frames show


def first_bends(measured: Floats) -> Floats:
    """(C, C) diagonal: variance of the second differences of the motion beneath noise and outliers.

    Steps of variance q and white noise of variance r give second differences q + 6 r and third differences 2 q + 20 r.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing. A channel that tells nothing takes the median of the others.
    """
    second, third = (_quiet_variance(np.diff(measured, n=order, axis=0)) for order in (2, 3))
    noise = np.clip((third - 2.0 * second) / 8.0, 0.0, None)
    bends = np.maximum(second - 6.0 * noise, LEAST_SHARE * second)
    told = np.isfinite(bends)
    return np.diag(np.where(told, bends, np.median(bends[told]) if told.any() else 1.0))


def own_bends(values: Floats, unseen: Floats) -> Floats:
    """(C, C) covariance of the second differences of a first repair, with what it left open added.

    Parameters
    ----------
    values : (T, C) the first repair; NaN = left open.
    unseen : (C,) mean variance of second differences that its samples left open.
    """
    finite = np.nan_to_num(values)
    seen = typical_bends(finite[None])
    coupled = COUPLED * seen + (1.0 - COUPLED) * np.diag(np.diag(seen))
    return np.asarray(coupled + np.diag(unseen))


def _quiet_variance(differences: Floats) -> Floats:
    """(C,) variance of each column by a low quantile of its size; NaN where a column is empty."""
    result = np.full(differences.shape[1], np.nan)
    for c in range(differences.shape[1]):
        known = np.abs(differences[np.isfinite(differences[:, c]), c])
        if known.size:
            result[c] = (np.quantile(known, QUIET) / _QUIET_NORMAL) ** 2
    return result
