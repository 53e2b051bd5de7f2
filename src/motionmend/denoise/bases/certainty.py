"""How sure a robust fit is of each sample."""

import numpy as np
from scipy.ndimage import median_filter

from ...arrays import Bools, Floats
from ...numerics.ssa import Eigenbases
from .optimise import PRIOR_WEIGHT, Fit

TRUSTED = 0.5  # robust weight from which a sample counts as a measurement; below it was rejected
RUNNING = 9  # samples of the running median: 0.3 s at 30 Hz
TRIMMED = 0.1  # share of the largest left out: where outliers crowd, the running median is theirs
NOISE_FLOOR = 1e-3  # degrees or cm; keeps a noiseless channel from infinite weight


def deviations(measured: Floats, fit: Fit, bases: Eigenbases, noise: Floats, misfit: Floats) -> Floats:
    """Standard deviation of each filtered sample.

    The patterns with their eigenvalues are a Gaussian prior on windows, the discarded variance a floor below it
    and the measured samples, as noisy as their third differences say, the evidence. Where samples of a window
    are missing the posterior is worked out for just those that are there. What the fit misses of a channel
    beyond its noise is added: a channel that the patterns describe badly is not sure.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing.
    fit : of `measured`.
    bases : at the rate the model was learned at or at the recording's; a window spans `bases.window` samples.
    noise, misfit : (C,) of `noise_and_misfit`.

    Returns
    -------
    (T, C) in channel units.
    """
    present = np.isfinite(measured)
    spread = np.square(noise) + bases.discarded + NOISE_FLOOR**2
    used = present & (fit.weights >= TRUSTED)
    seen = present.sum(axis=0)
    share = np.where(seen > 0, used.sum(axis=0) / np.maximum(seen, 1), 0.0)
    flat = np.ascontiguousarray(bases.vectors.reshape(bases.count, -1))
    window = bases.window
    full = (share * (seen > 0) / spread)[None].repeat(window, axis=0)
    prior = np.diag(1.0 / np.maximum(bases.values, 1e-9 * max(float(bases.values.max(initial=1e-12)), 1e-12)))
    information = prior + (flat * full.ravel()) @ flat.T
    middle = window // 2
    variance = np.broadcast_to(_variance_at(information, bases.vectors[:, middle]), measured.shape).copy()
    variance = _with_gaps(variance, present, information, full, bases)
    # the share of its own noise that eq. 2.15 leaves in a fully trusted sample
    kept = present / (1.0 + 2.0 * PRIOR_WEIGHT * bases.window)
    return np.sqrt(variance + bases.discarded + np.square(misfit) + np.square(kept * noise) + NOISE_FLOOR**2)


def _variance_at(information: Floats, patterns: Floats) -> Floats:
    """(C,) variance of a frame with patterns (K, C) when the coefficients have this information (K, K)."""
    lower = np.linalg.cholesky(information)
    half = np.linalg.solve(lower, patterns)
    return np.asarray(np.square(half).sum(axis=0))


def _with_gaps(variance: Floats, present: Bools, information: Floats, full: Floats, bases: Eigenbases) -> Floats:
    """Replace the variance of frames with missing samples by that of the window about them."""
    frames, window = len(present), bases.window
    gaps = present.any(axis=0) & ~present  # a channel missing throughout is out of `information` already
    lost = ~present
    flat = bases.vectors.reshape(bases.count, -1)
    known: dict[bytes, Floats] = {}
    for t in np.flatnonzero(lost.any(axis=1)):
        start = min(max(int(t) - window // 2, 0), max(frames - window, 0))
        gap = gaps[start : start + window]
        if len(gap) < window:
            gap = np.vstack([gap, np.zeros((window - len(gap), gap.shape[1]), dtype=bool)])
        at = min(int(t) - start, window - 1)
        key = at.to_bytes(4, "little") + np.packbits(gap).tobytes()
        if key not in known:
            columns = np.flatnonzero(gap.ravel())
            taken = flat[:, columns]
            left = information - (taken * full.ravel()[columns]) @ taken.T
            known[key] = _variance_at(left, bases.vectors[:, at])
        variance[t, lost[t]] = known[key][lost[t]]
    return variance


def noise_and_misfit(measured: Floats, fit: Fit) -> tuple[Floats, Floats]:
    """How noisy each channel is, and by how much the bases miss it; (C,) each, in channel units.

    Noise is white and misfit is not: noise shows in the third differences of the trusted samples, misfit in what a
    running median leaves of the residual, rejected samples included. A channel without any sample takes the median
    of the others.

    Parameters
    ----------
    measured : (T, C), NaN = missing, about 30 Hz.
    fit : of `measured`.
    """
    trusted = np.where(fit.weights >= TRUSTED, measured, np.nan)
    third = np.diff(trusted, n=3, axis=0) / np.sqrt(20.0)  # third differences multiply white noise by √20
    noise = _or_typical(_spreads(third))
    residual = measured - fit.values
    square = np.full(measured.shape[1], np.nan)
    frames = np.arange(len(residual))
    for c in range(measured.shape[1]):
        known = np.isfinite(residual[:, c])
        if known.any():
            bridged = np.interp(frames, frames[known], residual[known, c])
            slow_part = np.sort(np.square(median_filter(bridged, size=RUNNING, mode="nearest")[known]))
            square[c] = slow_part[: max(1, round((1.0 - TRIMMED) * len(slow_part)))].mean()
    # what a running median of n samples leaves of white noise: variance pi / (2 n)
    slow = square - np.pi / (2.0 * RUNNING) * np.square(noise)
    return noise, _or_typical(np.sqrt(np.clip(slow, 0.0, None)))


def _or_typical(values: Floats) -> Floats:
    known = np.isfinite(values)
    return np.where(known, values, np.median(values[known]) if known.any() else 0.0)


def _spreads(values: Floats) -> Floats:
    """(C,) robust root mean square of each column about zero, NaN where a column is empty."""
    result = np.full(values.shape[1], np.nan)
    for c in range(values.shape[1]):
        known = values[np.isfinite(values[:, c]), c]
        if known.size:
            result[c] = 1.4826 * np.median(np.abs(known))
    return result
