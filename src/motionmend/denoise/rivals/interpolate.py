"""Gap fillers that look at one channel only: straight lines and cubic splines. Measured samples stay as they are."""

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from ...numerics.walk import noise_level
from .filtered import Filtered, check_channels

Bridge: TypeAlias = Callable[[Floats], Floats]

_PHASES = 3  # a gap length is left out at this many shifts of its pattern
_CONTEXT = 8  # measured frames at least between gaps that are left out


def linear(values: Floats, fps: float) -> Filtered:
    """Fill each gap with the straight line between its neighbours; gaps at the ends stay open.

    Parameters
    ----------
    values : (T, C) in any unit, NaN = missing.
    fps : Hz; the method does not depend on it.

    Returns
    -------
    std : of measured samples, the noise level of the channel; of filled ones, the error found by leaving gaps of the
        same length out of the recording's own measured stretches, in the shape of a Brownian bridge.
    """
    check_channels(values, fps)
    return _filled(values, bridge_linear)


def spline(values: Floats, fps: float) -> Filtered:
    """Fill each gap with the cubic spline through all measured samples of the channel; gaps at the ends stay open.

    Parameters, returns: as in `linear`.
    """
    check_channels(values, fps)
    return _filled(values, bridge_spline)


def bridge_linear(values: Floats) -> Floats:
    """(T, C) with inner gaps on straight lines; measured samples bit for bit, gaps at the ends NaN."""
    bridged = values.copy()
    for channels, known in _patterns(values):
        at = np.flatnonzero(known)
        if len(at):
            missing = _inner(known)
            right = np.searchsorted(at, missing)
            before, after = at[right - 1], at[right]
            share = ((missing - before) / (after - before))[:, None]
            start = values[np.ix_(before, channels)]
            bridged[np.ix_(missing, channels)] = start + share * (values[np.ix_(after, channels)] - start)
    return bridged


def bridge_spline(values: Floats) -> Floats:
    """(T, C) with inner gaps on cubic splines (not-a-knot); measured samples bit for bit, gaps at the ends NaN."""
    from scipy.interpolate import CubicSpline

    bridged = values.copy()
    for channels, known in _patterns(values):
        at, missing = np.flatnonzero(known), _inner(known)
        if len(missing):
            curve = CubicSpline(at, values[np.ix_(at, channels)])
            bridged[np.ix_(missing, channels)] = curve(missing)
    return bridged


def _filled(values: Floats, bridge: Bridge) -> Filtered:
    bridged = bridge(values)
    measured = np.isfinite(values)
    filled = np.isfinite(bridged) & ~measured
    std = np.where(measured, noise_level(values), np.nan)
    if filled.any():
        std[filled] = gap_std(values, bridge)[filled]
    return Filtered(bridged, std, filled)


def gap_std(values: Floats, bridge: Bridge) -> Floats:
    """Standard deviation of what `bridge` puts into the inner gaps of `values`; (T, C), NaN elsewhere.

    Gaps of 1, 2, 4, ... frames are left out of the measured stretches, bridged and compared with what was there.
    A gap as long as a measured stretch cannot be tried; its error grows with its length from the longest tried.
    """
    std = np.full(values.shape, np.nan)
    gaps = [(c, a, b) for channels, known in _patterns(values) for a, b in _inner_gaps(known) for c in channels]
    if not gaps:
        return std
    lengths, errors = _left_out_errors(values, bridge, max(b - a for _, a, b in gaps))
    for channel, start, stop in gaps:
        length = stop - start
        known = np.isfinite(errors[:, channel])
        if not known.any():
            continue
        tried, found = lengths[known], errors[known, channel]
        error = np.interp(length, tried, found) * max(1.0, (length + 1) / (tried[-1] + 1))
        share = np.arange(1, length + 1) / (length + 1)
        shape = share * (1.0 - share)  # variance of a Brownian bridge along the gap
        std[start:stop, channel] = error * np.sqrt(shape / shape.mean())
    return std


def _left_out_errors(values: Floats, bridge: Bridge, longest: int) -> tuple[Floats, Floats]:
    """RMS error of `bridge` (N, C) over left-out gaps of N lengths; NaN where the recording has no room for one."""
    measured = np.isfinite(values)
    lengths = [1]
    while lengths[-1] < longest and 4 * lengths[-1] < len(values):
        lengths.append(2 * lengths[-1])
    errors = np.full((len(lengths), values.shape[1]), np.nan)
    for row, length in enumerate(lengths):
        squares, count = np.zeros(values.shape[1]), np.zeros(values.shape[1])
        period = max(3 * length, length + _CONTEXT)
        for phase in range(_PHASES):
            out = np.zeros(len(values), dtype=bool)
            for start in range(1 + phase * period // _PHASES, len(values) - length, period):
                out[start : start + length] = True
            trial = np.where(out[:, None], np.nan, values)
            error = bridge(trial) - values
            # Only gaps left out between measured samples stand for a gap of this length.
            usable = out[:, None] & _whole_runs(measured, out)
            usable &= np.isfinite(error)
            squares += np.where(usable, np.square(error, where=usable, out=np.zeros_like(error)), 0.0).sum(axis=0)
            count += usable.sum(axis=0)
        enough = count >= length
        errors[row, enough] = np.sqrt(squares[enough] / count[enough])
    return np.array(lengths, dtype=np.float64), errors


def _whole_runs(measured: Bools, out: Bools) -> Bools:
    """(T, C) True in the runs of `out` (T,) that are measured throughout, with the samples on either side."""
    whole = np.zeros_like(measured)
    for start, stop in runs(out):
        whole[start:stop] = measured[start - 1 : stop + 1].all(axis=0)
    return whole


def _patterns(values: Floats) -> Iterator[tuple[Ints, Bools]]:
    """Channels that are measured at the same frames, and those frames (T,)."""
    groups: dict[bytes, list[int]] = {}
    known = np.isfinite(values)
    for channel in range(values.shape[1]):
        groups.setdefault(known[:, channel].tobytes(), []).append(channel)
    for channels in groups.values():
        yield np.array(channels), known[:, channels[0]]


def _inner_gaps(known: Bools) -> list[tuple[int, int]]:
    """Gaps between measured samples as (start, stop)."""
    return [(start, stop) for start, stop in runs(~known) if start > 0 and stop < len(known)]


def _inner(known: Bools) -> Ints:
    """Frames of the inner gaps."""
    at = np.flatnonzero(known)
    if len(at) == 0:
        return at
    return np.asarray(at[0] + np.flatnonzero(~known[at[0] : at[-1] + 1]))
