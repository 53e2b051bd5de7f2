"""Products with a trajectory matrix that is never built.

The trajectory matrix (eq. 2.1-2.2) has one row per lag window. Here its rows exist only in blocks small enough
for the cache, so that memory does not grow with the recording and the matrix products run at full speed. Rows
are time-major: entry (m, c) of a window stands at m * C + c.
"""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import as_strided

from ..arrays import Floats, Ints

BLOCK_BYTES = 2 << 20  # a block of window rows; a few fit the last-level cache


def _rows(series: Floats, starts: Ints, length: int) -> Floats:
    """(S, length * C) copies of the windows of `series` (T, C) that begin at `starts`."""
    frames, channels = series.shape
    step = series.strides[0]
    windows = as_strided(
        series,
        shape=(frames - length + 1, length * channels),
        strides=(step, series.strides[1]),
        writeable=False,
    )
    return windows[starts]


def _blocks(count: int, row_bytes: int) -> list[slice]:
    size = max(1, min(count, BLOCK_BYTES // max(row_bytes, 1)))
    return [slice(i, min(i + size, count)) for i in range(0, count, size)]


def lag_products(stretches: Sequence[Floats], window: int) -> Floats:
    """Sum over all windows of the outer product of the window with itself: D^T D of eq. 2.3.

    Of several series no window reaches into another.

    Neighbouring windows share all but two frames, so block (j+1, j'+1) is block (j, j') less one outer product
    of frames at the head of the series and plus another of frames at its tail; only the first block row needs the
    whole series. Heads and tails of all series go into one matrix product, so that many short series cost little
    more than one long one.

    Parameters
    ----------
    stretches : at least one; each (T, C) C-contiguous, finite, T >= window.
    window : M, frames per window.

    Returns
    -------
    (M * C, M * C) symmetric.
    """
    channels = stretches[0].shape[1]
    first = np.zeros((channels, window * channels))
    for series in stretches:
        for block in _blocks(len(series) - window + 1, 8 * window * channels):
            starts = np.arange(block.start, block.stop)
            first += series[block].T @ _rows(series, starts, window)  # eq. 2.5, j = 1
    ends = np.zeros((window - 1, channels, window - 1, channels))
    most = max(1, BLOCK_BYTES // (8 * window * channels))
    for some in (stretches[i : i + most] for i in range(0, len(stretches), most)):
        heads = np.stack([series[: window - 1].ravel() for series in some])
        tails = np.stack([series[len(series) - window + 1 :].ravel() for series in some])
        ends += (tails.T @ tails - heads.T @ heads).reshape(ends.shape)
    products = np.empty((window, channels, window, channels))
    products[0] = first.reshape(channels, window, channels)
    for j in range(window - 1):
        products[j + 1, :, j + 1 :] = products[j, :, j:-1] + ends[j, :, j:]
        products[j + 1 :, :, j] = products[j, :, j + 1 :].transpose(1, 2, 0)
    return products.reshape(window * channels, window * channels)


def project(series: Floats, bases: Floats, starts: Ints) -> Floats:
    """Coefficients of every window on every basis: c_s = E^T z_s (eq. 2.13).

    Parameters
    ----------
    series : (T, C) C-contiguous, finite.
    bases : (K, M, C).
    starts : (S,) first frame of each window.

    Returns
    -------
    (S, K).
    """
    count, window, channels = bases.shape
    columns = np.ascontiguousarray(bases.reshape(count, window * channels).T)
    coefficients = np.empty((len(starts), count))
    for block in _blocks(len(starts), 8 * window * channels):
        np.matmul(_rows(series, starts[block], window), columns, out=coefficients[block])
    return coefficients


def overlap_add(coefficients: Floats, bases: Floats, starts: Ints, frames: int) -> Floats:
    """Sum of all windows' reconstructions E c_s, each laid at its own frames (eq. 2.14's sum over m).

    Parameters
    ----------
    coefficients : (S, K).
    bases : (K, M, C).
    starts : (S,) first frame of each window.
    frames : T.

    Returns
    -------
    (T, C); divide by `coverage` for the diagonal average.
    """
    count, window, channels = bases.shape
    rows = bases.reshape(count, window * channels)
    total = np.zeros(frames * channels)
    for block in _blocks(len(starts), 8 * window * channels):
        for start, row in zip(starts[block], coefficients[block] @ rows, strict=True):
            total[start * channels : (start + window) * channels] += row
    return total.reshape(frames, channels)


def coverage(starts: Ints, window: int, frames: int) -> Floats:
    """(T,) how many windows hold each frame: the number of terms of eq. 2.14, fewer at both ends."""
    steps = np.zeros(frames + 1)
    np.add.at(steps, starts, 1.0)
    np.add.at(steps, starts + window, -1.0)
    return np.cumsum(steps)[:frames]
