"""The random walk seen through noise, z(t+1) = z(t) + N(0, q), y(t) = z(t) + N(0, r), one per channel."""

from dataclasses import dataclass
from math import comb, pi

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..errors import MismatchError, UsageError
from .quantiles import quantile_of_known

# Ratios q/r that are tried, and those about the best of them.
_COARSE = np.logspace(-5.0, 5.0, 31)
_FINE = np.logspace(-0.25, 0.25, 9)
LEAST_SAMPLES = 8  # of a channel from which its variances can be told
# Noise variance below which a channel counts as exact, in its mean squared step.
_LEAST = 1e-5
# How far (natural logarithm) the noise variance may lightly stray from what the differences of the recording say.
# Pure likelihood calls smooth motion noise; the differences alone call outliers motion.
_LOG_SPREAD = np.sqrt(2.0)
# A standard normal distribution's median absolute deviation.
NORMAL_MEDIAN = 0.6744897501960817


@dataclass(frozen=True, eq=False)
class WalkEstimate:
    """Random walks over time, one per channel.

    Attributes
    ----------
    mean : (T, C); NaN in a channel without a single observation.
    variance : (T, C); inf there.
    log_likelihood : (C,) of the observations after the first of each channel.
    """

    mean: Floats
    variance: Floats
    log_likelihood: Floats


def smooth_random_walk(observed: Floats, step_var: Floats, noise_var: Floats) -> WalkEstimate:
    """State of every channel at each frame given all its observations, with nothing known before the first.

    Parameters
    ----------
    observed : (T, C), NaN = missing.
    step_var : (C,), q, not below 0, in the square of the channel's unit.
    noise_var : (C,) or (T, C), r, not below 0.

    Raises
    ------
    MismatchError : shapes that do not fit.
    UsageError : a variance below 0.

    Source
    ------
    The model: Lou, Example-based human motion denoising, 2012, section 2.3.2. The smoother: Rauch, Tung and Striebel,
    AIAA Journal 3(8), 1965; with one state each of its steps is arithmetic on all channels at once.
    """
    measured, noise = _check(observed, noise_var)
    if step_var.shape != observed.shape[1:]:
        raise MismatchError(f"step_var must be {observed.shape[1:]}, came {step_var.shape}")
    if not (step_var >= 0).all():
        raise UsageError("the variance of a random walk's steps must not be below 0")
    values = np.where(measured, observed, 0.0)
    mean, variance, log_likelihood = _forward(values, measured, step_var, noise)
    for t in range(len(values) - 2, -1, -1):
        # Nothing seen so far, or nothing left in doubt: the state of the frame after is the state.
        open_end = ~np.isfinite(variance[t])
        below = np.where(open_end, 1.0, variance[t] + step_var)
        gain = np.where(open_end | (below == 0), 1.0, variance[t] / np.where(below == 0, 1.0, below))
        mean[t] = np.where(open_end, mean[t + 1], mean[t] + gain * (mean[t + 1] - mean[t]))
        variance[t] = gain * step_var + gain**2 * variance[t + 1]
    mean[:, ~measured.any(axis=0)] = np.nan
    return WalkEstimate(mean, variance, log_likelihood)


def fit_random_walk(observed: Floats, noise_var: Floats | None = None) -> tuple[Floats, Floats]:
    """Variances q and r of each channel that make its recording likeliest.

    r has a light log-normal prior at the noise level of the channel's differences (`noise_level`): likelihood
    alone would take smooth motion, which is no random walk, for noise.

    Parameters
    ----------
    observed : (T, C), NaN = missing.
    noise_var : None = estimate r; or r itself, (C,) or (T, C), not below 0.

    Returns
    -------
    step_var : (C,), q; NaN where fewer than `LEAST_SAMPLES` samples tell nothing.
    noise_var : r as given, or (C,); NaN likewise.
    """
    measured, given = _check(observed, np.ones(observed.shape[1]) if noise_var is None else noise_var)
    size = _mean_square_step(observed)
    known = np.isfinite(size)
    moves = known & (size > 0)
    unit = np.where(moves, size, 1.0)
    values = np.where(measured, observed, 0.0) / np.sqrt(unit)
    # Steps are tried in units of the noise: of the noise itself where it is known, of 1 where it is sought.
    shape = given if noise_var is None else np.maximum(given / unit, _LEAST)
    level = np.where(measured, shape, 0.0).sum(axis=0) / np.maximum(measured.sum(axis=0), 1)
    around = None
    if noise_var is None:
        told = noise_level(observed)  # too few samples tell none: then a step's, whatever the unit
        around = np.log(np.maximum(np.where(np.isfinite(told), told**2 / unit, 1.0), _LEAST))
    ratio, noise = _likeliest(values, measured, shape, level, around)
    step = np.where(known, np.where(moves, ratio * level * noise * unit, 0.0), np.nan)
    if noise_var is not None:
        return step, noise_var
    return step, np.where(known, np.where(moves, noise * unit, 0.0), np.nan)


def _likeliest(
    values: Floats, measured: Bools, shape: Floats, level: Floats, around: Floats | None
) -> tuple[Floats, Floats]:
    """Ratio of step to noise variance and noise variance in units of `shape`, (C,) each; noise 1 if it is given."""
    count = np.maximum(measured.sum(axis=0) - 1, 1)
    channels = np.arange(values.shape[1])
    ratio, noise = np.ones(len(channels)), np.ones(len(channels))
    for ratios in (_COARSE, _FINE):
        tried = ratios[:, None] * ratio
        logs, squares = _profile(values, measured, shape, tried * level)
        if around is None:
            best = _lowest(logs + squares)
        else:
            log_noise = _likeliest_noise(count, squares, around)
            stray = (log_noise - around) / _LOG_SPREAD
            best = _lowest(count * log_noise + logs + squares * np.exp(-log_noise) + stray**2)
            noise = np.exp(log_noise[best, channels])
        ratio = tried[best, channels]
    return ratio, noise


def noise_level(values: Floats) -> Floats:
    """Standard deviation of the white noise on each channel, by its differences over time.

    Differences of order 2 to 6 remove motion better and better and suffer from outliers more and more; each gives
    a median absolute deviation, scaled by what the difference does to white noise, and the smallest is taken.

    Parameters
    ----------
    values : (T, C), NaN = missing; a difference counts where all its samples are measured.

    Returns
    -------
    (C,) in the channel's unit; NaN where no stretch is long enough.
    """
    levels = np.full((7, values.shape[1]), np.nan)
    step = np.diff(values, axis=0)
    for order in range(2, 7):
        step = np.diff(step, axis=0)
        enough = np.isfinite(step).sum(axis=0) >= (8 if order > 2 else 2)
        if enough.any():
            deviation = quantile_of_known(np.abs(step[:, enough]), 0.5)
            levels[order, enough] = deviation / (NORMAL_MEDIAN * np.sqrt(comb(2 * order, order)))
    some = np.isfinite(levels).any(axis=0)
    found = np.full(values.shape[1], np.nan)
    found[some] = np.nanmin(levels[:, some], axis=0)
    return found


def _check(observed: Floats, noise_var: Floats) -> tuple[Bools, Floats]:
    if observed.ndim != 2 or noise_var.shape not in (observed.shape, observed.shape[1:]):
        raise MismatchError(
            f"values must be (frames, channels) with as many noises, came {observed.shape}, {noise_var.shape}"
        )
    measured = np.isfinite(observed)
    noise = np.broadcast_to(noise_var, observed.shape)
    if not (noise[measured] >= 0).all():
        raise UsageError("the variance of the observation noise must not be below 0")
    return measured, np.where(measured, noise, 0.0)


def _forward(values: Floats, measured: Bools, step_var: Floats, noise_var: Floats) -> tuple[Floats, Floats, Floats]:
    """Filtered mean and variance (T, C) and log-likelihood (C,); variance inf before the first observation."""
    frames, channels = values.shape
    mean, variance = np.empty((frames, channels)), np.empty((frames, channels))
    log_likelihood = np.zeros(channels)
    state, cov, started = np.zeros(channels), np.zeros(channels), np.zeros(channels, dtype=bool)
    for t in range(frames):
        seen = measured[t]
        total = cov + noise_var[t]
        certain = total == 0
        total = np.where(certain, 1.0, total)
        innovation = np.where(seen, values[t] - state, 0.0)
        counted = seen & started & ~certain
        log_likelihood -= np.where(counted, 0.5 * (np.log(2 * pi * total) + innovation**2 / total), 0.0)
        gain = np.where(started, np.where(seen, cov / total, 0.0), 1.0)
        state = state + gain * innovation
        cov = np.where(seen, gain * noise_var[t], cov)
        started = started | seen
        mean[t], variance[t] = state, np.where(started, cov, np.inf)
        cov = cov + step_var
    return mean, variance, log_likelihood


def _profile(values: Floats, measured: Bools, noise_shape: Floats, step_var: Floats) -> tuple[Floats, Floats]:
    """Sums of log S and of e²/S over the innovations e with variance S, of G walks per channel: `step_var` (G, C)."""
    walks = step_var.shape
    state, cov = np.zeros(walks), np.zeros(walks)
    logs, squares = np.zeros(walks), np.zeros(walks)
    started = np.zeros(walks[1], dtype=bool)
    for t in range(len(values)):
        seen = measured[t]
        if seen.any():
            total = np.where(seen, cov + noise_shape[t], 1.0)
            innovation = np.where(seen, values[t] - state, 0.0)
            counted = seen & started
            logs += np.where(counted, np.log(total), 0.0)
            squares += np.where(counted, innovation**2 / total, 0.0)
            gain = np.where(started, np.where(seen, cov / total, 0.0), 1.0)
            state += gain * innovation
            cov = np.where(seen, gain * noise_shape[t], cov)
            started |= seen
        cov = cov + step_var
    return logs, squares


def _lowest(cost: Floats) -> Ints:
    """(C,) row of the least cost (G, C); the first of those that only rounding tells apart."""
    return np.asarray((cost <= cost.min(axis=0) + 1e-9 * np.abs(cost).max(axis=0)).argmax(axis=0))


def _likeliest_noise(count: Floats, squares: Floats, around: Floats) -> Floats:
    """log r that minimises the convex  n log r + squares/r + ((log r - around)/spread)², by Newton's method."""
    log_noise = np.log(np.maximum(squares / count, _LEAST))
    for _ in range(50):
        pull = squares * np.exp(-log_noise)
        slope = count - pull + 2 * (log_noise - around) / _LOG_SPREAD**2
        log_noise = log_noise - np.clip(slope / (pull + 2 / _LOG_SPREAD**2), -1.0, 1.0)
    return np.asarray(log_noise)


def _mean_square_step(observed: Floats) -> Floats:
    """(C,) mean squared difference between neighbouring measured samples, per frame; NaN below `LEAST_SAMPLES`."""
    size = np.full(observed.shape[1], np.nan)
    for channel, column in enumerate(observed.T):
        at = np.flatnonzero(np.isfinite(column))
        if len(at) >= LEAST_SAMPLES:
            size[channel] = np.mean(np.diff(column[at]) ** 2 / np.diff(at))
    return size
