"""How large differences are in the quieter moments, which outliers hardly reach."""

from collections.abc import Callable

import numpy as np

from ...arrays import Floats

QUIET = 0.3  # quantile of differences that outliers hardly reach
QUIET_NORMAL = 0.3853205  # the same quantile of |N(0, 1)|


def quiet_variance(values: Floats, differences: Callable[[Floats], Floats]) -> Floats:
    """(C,) variance of differences of each column by a low quantile of their size; NaN where there are none.

    Parameters
    ----------
    values : (T, C), NaN = missing.
    differences : of one column (T,), fewer of them.
    """
    result = np.full(values.shape[1], np.nan)
    for c in range(values.shape[1]):
        size = np.abs(differences(values[:, c]))
        known = size[np.isfinite(size)]
        if known.size:
            result[c] = (np.quantile(known, QUIET) / QUIET_NORMAL) ** 2
    return result


def quiet_bends(values: Floats, lag: int) -> Floats:
    """(C,) variance of second differences over `lag` frames of each column (T, C) by their low quantile, as above."""
    return quiet_variance(values, lambda one: one[: -2 * lag] - 2.0 * one[lag:-lag] + one[2 * lag :])
