"""What two joints beside each other do alike is no noise: that is another in every channel.

Hand and thumb hang on one wrist, and many solvers turn both by one marker: what leaps or rattles in one does so in the
other, and looks like noise where frames are few. The difference of two channels bears the noise of both, and nothing of
what they do alike; so neither is noisier than that.
"""

import numpy as np

from ...arrays import Bools, Floats, runs
from ...numerics.quantiles import quantile_of_known
from .level import FEWEST, LEAST_NOISE, size_of

QUANTILE = 0.7  # of the third differences: leaps that the two do not share hardly reach it
UNSURE = 1.2  # times what differences say that noise may be: a few frames tell it no better
ALIKE = 0.3  # of the bends of what rattles those of its difference to another that does the same


def loudest(measured: Floats, believed: Bools, loudness: Floats, beside: Bools) -> Floats:
    """(C,) the standard deviation that each channel's noise has at most; infinite where nothing tells.

    Parameters
    ----------
    measured : (T, C) in degrees, NaN = missing.
    believed : (T, C) True where a sample is no outlier.
    loudness : (T, C) of the noise at each moment relative to what is asked for.
    beside : (C, C) `own_jumps.channels_beside`.
    """
    most = np.full(measured.shape[1], np.inf)
    if len(measured) < FEWEST + 3:
        return most
    seen = np.where(believed, measured, np.nan) / loudness
    for c in np.flatnonzero(beside.any(axis=0)):
        third = np.abs(np.diff(seen[:, [c]] - seen[:, beside[c]], n=3, axis=0)) / np.sqrt(20.0)
        told = quantile_of_known(third, QUANTILE) / size_of(QUANTILE)
        most[c] = UNSURE * told[np.isfinite(third).sum(axis=0) >= FEWEST].min(initial=np.inf)
    return np.asarray(np.maximum(most, LEAST_NOISE))


def rattles_once(rattle: Floats, measured: Floats, beside: Bools | None) -> Floats:
    """(T, C) of `rattling.rattles`, but for what another channel beside does alike.

    Parameters
    ----------
    rattle, measured : (T, C) what `rattles` gives, and of what, in degrees, NaN = missing.
    beside : (C, C) `own_jumps.channels_beside`; None = there are none.
    """
    if beside is None:
        return rattle
    left = rattle.copy()
    for c in np.flatnonzero((rattle > 0).any(axis=0)):
        others = np.flatnonzero(beside[c])
        for start, stop in runs(rattle[:, c] > 0):
            own = measured[start:stop, c]
            bend = _size_of_bends(own[:, None])[0]
            if (_size_of_bends(own[:, None] - measured[start:stop, others]) < ALIKE * bend).any():
                left[start:stop, c] = 0.0
    return left


def _size_of_bends(some: Floats) -> Floats:
    """(N,) median size of the second differences of channels (T, N), infinite where there are none."""
    size = np.abs(np.diff(some, n=2, axis=0))
    if not len(size):
        return np.full(some.shape[1], np.inf)
    return np.asarray(np.nan_to_num(quantile_of_known(size, 0.5), nan=np.inf))
