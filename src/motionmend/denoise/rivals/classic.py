"""The filters a user can choose instead: each looks at one channel only, at any rate, in any unit.

All but `kalman` bridge gaps with straight lines before they filter, as such tools do; `filled` says where.
Gaps at the ends of a channel stay open: nothing on their far side supports a value.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

import numpy as np

from ...arrays import Floats
from ...errors import UsageError
from ...numerics.risk import excess, stein_risk
from ...numerics.walk import fit_random_walk, noise_level, smooth_random_walk
from .filtered import Filtered, check_channels
from .interpolate import linear, spline

Method: TypeAlias = Callable[[Floats, float], Filtered]

WINDOW = 11 / 30  # s, the dissertation's 11 frames at 30 frames per second
CUT_OFF = 6.0  # Hz, half power
_BUTTERWORTH_REACH = 1.0  # s after which the Butterworth filter's response has died away


def gaussian(values: Floats, fps: float) -> Filtered:
    """Gaussian of 11/30 s, its standard deviation a sixth of that; the kernel is cut and renormalised at the ends.

    Parameters
    ----------
    values : (T, C) in any unit, NaN = missing.
    fps : Hz; the filter is the same in seconds at every rate.

    Returns
    -------
    std : the channel's noise level (`noise_level`) times the filter's gain at that sample, and the error of the
        straight lines under the kernel.

    Source
    ------
    Lou, Example-based human motion denoising, 2012, section 2.3.2.
    """
    from scipy.ndimage import convolve1d

    check_channels(values, fps)
    half = _half_window(fps)
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / (WINDOW * fps / 6)) ** 2)

    def apply(stretch: Floats) -> Floats:
        share = convolve1d(np.ones(len(stretch)), kernel, mode="constant")
        return np.asarray(convolve1d(stretch, kernel, axis=0, mode="constant") / share[:, None])

    return _linear_filter(values, fps, apply, half)


def savgol(values: Floats, fps: float) -> Filtered:
    """Savitzky-Golay: the cubic nearest to 11/30 s about each sample, at the ends the last window's cubic.

    Parameters, returns: as in `gaussian`. A stretch shorter than the window is its own window.

    Source
    ------
    Savitzky and Golay, Analytical Chemistry 36(8), 1964.
    """
    from scipy.signal import savgol_filter

    check_channels(values, fps)
    half = _half_window(fps)

    def apply(stretch: Floats) -> Floats:
        window = min(2 * half + 1, len(stretch) - (len(stretch) + 1) % 2)
        return np.asarray(savgol_filter(stretch, window, min(3, window - 1), axis=0, mode="interp"))

    return _linear_filter(values, fps, apply, half)


def butterworth(values: Floats, fps: float) -> Filtered:
    """Butterworth low-pass of 6 Hz, second order run forward and backward: fourth order without lag.

    The half-power point of both runs together is at 6 Hz. A stretch continues beyond its ends turned about its last
    sample, once the straight line nearest to it is taken out.

    Parameters, returns: as in `gaussian`.

    Raises
    ------
    UsageError : a rate at which 6 Hz cannot be told from anything else.

    Source
    ------
    Winter, Biomechanics and Motor Control of Human Movement, 4th edition, 2009, section 3.4.4.2.
    """
    from scipy.signal import butter, sosfiltfilt

    check_channels(values, fps)
    if fps <= 2 * CUT_OFF:
        raise UsageError(
            f"a low-pass of {CUT_OFF:g} Hz needs a recording above {2 * CUT_OFF:g} Hz, came {fps:g} Hz: use gaussian"
        )
    # Two runs at the same cut-off would halve the power twice; the tangent undoes the bilinear transform's warp.
    warped = np.tan(np.pi * CUT_OFF / fps) / (np.sqrt(2.0) - 1.0) ** 0.25
    sections = butter(2, np.arctan(warped) * fps / np.pi, fs=fps, output="sos")
    reach = int(np.ceil(_BUTTERWORTH_REACH * fps))

    def apply(stretch: Floats) -> Floats:
        line = _nearest_line(stretch)
        padding = min(len(stretch) - 1, reach)
        return np.asarray(line + sosfiltfilt(sections, stretch - line, axis=0, padlen=padding))

    return _linear_filter(values, fps, apply, reach)


def kalman(values: Floats, fps: float, noise: float | Floats | None = None) -> Filtered:
    """Random walk z(t+1) = z(t) + N(0, q) seen through noise N(0, r), smoothed over the whole recording.

    q and r of each channel are those that make the recording likeliest (`fit_random_walk`). Inside a gap the walk
    bridges; at the ends it stays open.

    Parameters
    ----------
    values : (T, C) in any unit, NaN = missing.
    fps : Hz; the method does not depend on it.
    noise : None = estimate; or the standard deviation of the noise, one number, (C,) or (T, C).

    Returns
    -------
    std : of the walk given the whole recording.

    Source
    ------
    Lou, Example-based human motion denoising, 2012, section 2.3.2.
    """
    check_channels(values, fps)
    given = None if noise is None else variance_of(noise, values.shape)
    step_var, noise_var = fit_random_walk(values, given)
    # A channel of a few samples tells nothing about its noise: it stays as it is.
    silent = ~np.isfinite(step_var)
    noise_var = np.where(silent, 0.0, noise_var)
    walk = smooth_random_walk(values, np.where(silent, 0.0, step_var), noise_var)
    measured = np.isfinite(values)
    inner = np.logical_or.accumulate(measured) & np.logical_or.accumulate(measured[::-1])[::-1]
    inner &= measured | ~silent
    kept = np.where(inner, walk.mean, np.nan)
    kept[:, silent] = values[:, silent]
    variance = np.where(inner & ~silent, walk.variance, np.nan)
    # The smoothed value moves by P/r when its own sample moves by 1.
    own = np.divide(variance, noise_var, out=np.ones(values.shape), where=variance < noise_var)
    level = noise_level(values) if noise is None else np.sqrt(noise_var)
    variance = variance + excess(stein_risk(values - kept, own, level), variance, values)
    return Filtered(kept, np.sqrt(variance), inner & ~measured)


def _linear_filter(values: Floats, fps: float, apply: Callable[[Floats], Floats], reach: int) -> Filtered:
    """Bridge, filter each channel between its first and last sample, and follow the noise through the filter."""
    bridged = linear(values, fps)
    noise = noise_level(values)
    result, std = np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    for channels, start, stop in _spans(values):
        here = np.ix_(range(start, stop), channels)
        result[here] = apply(bridged.values[here])
        gain, own, response = _responses(apply, stop - start, reach)
        passed = np.square(np.outer(gain, noise[channels]))
        bridge = np.where(bridged.filled[here], bridged.std[here], 0.0)
        risk = stein_risk(values[here] - result[here], own[:, None], noise[channels])
        lost = excess(risk, passed, values[here])
        std[here] = np.sqrt(passed + lost + np.square(_spread(response, bridge)))
    return Filtered(result, std, bridged.filled)


def _responses(apply: Callable[[Floats], Floats], frames: int, reach: int) -> tuple[Floats, Floats, Floats]:
    """What the filter does to white noise, sqrt(sum h²) (T,), each sample's own weight (T,), and the response |h|.

    The response is the whole operator (T, T) for a short stretch, the kernel (2 reach + 1,) for a long one, where the
    ends do not see each other and the middle is the same throughout.
    """
    tried = min(frames, 4 * reach + 1)
    operator = apply(np.eye(tried))
    gain = np.sqrt(np.square(operator).sum(axis=1))
    own = operator.diagonal()
    if frames == tried:
        return gain, own, np.abs(operator)
    middle = 2 * reach
    rows = np.concatenate([np.arange(middle), np.full(frames - tried + 1, middle), np.arange(middle + 1, tried)])
    return gain[rows], own[rows], np.abs(operator[middle, middle - reach : middle + reach + 1])


def _spread(response: Floats, error: Floats) -> Floats:
    """Errors (T, C) of bridged samples after the filter, taken as wholly correlated within its reach."""
    from scipy.ndimage import convolve1d

    if not error.any():
        return error
    if response.ndim == 2:
        return np.asarray(response @ error)
    return np.asarray(convolve1d(error, response, axis=0, mode="constant"))


def _spans(values: Floats) -> Iterator[tuple[list[int], int, int]]:
    """Channels with the same first and last measured frame, as (channels, start, stop)."""
    groups: dict[tuple[int, int], list[int]] = {}
    for channel, known in enumerate(np.isfinite(values).T):
        at = np.flatnonzero(known)
        if len(at):
            groups.setdefault((int(at[0]), int(at[-1]) + 1), []).append(channel)
    for (start, stop), channels in groups.items():
        yield channels, start, stop


def _half_window(fps: float) -> int:
    """Frames on either side, so that 11 frames at 30 Hz are 11/30 s at every rate."""
    return round((WINDOW * fps - 1) / 2)


def _nearest_line(stretch: Floats) -> Floats:
    """(T, C) straight line nearest to each channel by least squares."""
    time = np.arange(len(stretch)) - (len(stretch) - 1) / 2
    slope = time @ stretch / max(float(time @ time), 1.0)
    return np.asarray(stretch.mean(axis=0) + np.outer(time, slope))


def variance_of(noise: float | Floats, shape: tuple[int, ...]) -> Floats:
    """Variance (C,) or (T, C) of noise whose standard deviation is one number, (C,) or (T, C)."""
    spread = np.asarray(noise, dtype=np.float64)
    if spread.shape not in ((), shape[1:], shape) or not (np.nan_to_num(spread) >= 0).all():
        raise UsageError(
            f"noise is one standard deviation, one for each of {shape[1]} channels or one for each sample, "
            f"not below 0; came {spread.shape}"
        )
    return np.square(np.broadcast_to(spread, shape[1:]) if spread.ndim == 0 else spread)


FILTERS: Mapping[str, Method] = {
    "gaussian": gaussian,
    "savgol": savgol,
    "butterworth": butterworth,
    "kalman": kalman,
}
GAP_FILLERS: Mapping[str, Method] = {"linear": linear, "spline": spline}
