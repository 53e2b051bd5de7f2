"""Quantiles of many columns at once that lack samples, and medians of few values."""

import numpy as np

from ..arrays import Floats


def quantile_of_known(values: Floats, share: float) -> Floats:
    """The quantile of each column's known values, to the last bit as `numpy.nanquantile` has it, many times as fast.

    Parameters
    ----------
    values : (N, ...), NaN = unknown; N at least 1.
    share : in [0, 1].

    Returns
    -------
    (...), interpolated linearly; NaN where nothing is known.
    """
    count = int(np.prod(values.shape[1:]))
    columns = np.sort(values.reshape(len(values), count).T, axis=1)  # unknown ones come last
    at = np.maximum(np.isfinite(columns).sum(axis=1) - 1, 0) * share
    before = np.floor(at)
    rest = at - before
    low, high = (np.take_along_axis(columns, k.astype(np.intp)[:, None], 1)[:, 0] for k in (before, np.ceil(at)))
    step = high - low
    return np.asarray(np.where(rest < 0.5, low + step * rest, high - step * (1.0 - rest)).reshape(values.shape[1:]))


def median(values: Floats) -> Floats:
    """The median of N values (N, ...), as `numpy.median` has it along the first axis; of few in a tenth of the time.

    N is at least 1; NaN where any is NaN.
    """
    ordered, count = np.sort(values, axis=0), len(values)
    middle = (ordered[(count - 1) // 2] + ordered[count // 2]) / 2.0
    return np.asarray(np.where(np.isnan(ordered[-1]), np.nan, middle))
