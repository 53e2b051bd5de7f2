"""How large differences are in the quieter moments, which outliers hardly reach."""

from collections.abc import Callable

import numpy as np

from ...arrays import Floats
from ...numerics.quantiles import quantile_of_known

QUIET = 0.3  # quantile of differences that outliers hardly reach
QUIET_NORMAL = 0.3853205  # the same quantile of |N(0, 1)|


def quiet_variance(values: Floats, differences: Callable[[Floats], Floats]) -> Floats:
    """(C,) variance of differences of each column by a low quantile of their size; NaN where there are none.

    Parameters
    ----------
    values : (T, C), NaN = missing.
    differences : of one column (T,), fewer of them.
    """
    sizes = np.abs(np.stack([differences(column) for column in np.ascontiguousarray(values.T)], axis=1))
    if not len(sizes):
        return np.full(values.shape[1], np.nan)
    return np.square(quantile_of_known(sizes, QUIET) / QUIET_NORMAL)


def quiet_bends(values: Floats, lag: int) -> Floats:
    """(C,) variance of second differences over `lag` frames of each column (T, C) by their low quantile, as above."""
    return quiet_variance(values, lambda one: one[: -2 * lag] - 2.0 * one[lag:-lag] + one[2 * lag :])
