"""What correction is compared with: filters that know nothing, and learners from the literature.

Filters: One-Euro (Casiez et al., CHI 2012), Savitzky-Golay, a Kalman filter of constant velocity with its smoother.
Learners, on postures in standard form: the constant offset of each joint, ridge regression from all joints, a Gaussian
process per posture (Zhou et al., VRST 2014) and exemplars (Shen et al., CVPR 2012: the offsets of the nearest ones).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ..arrays import Floats
from ..numerics.local_gp import Hyper, covariance, fit_hyper
from ..numerics.whittaker import whittaker

MIN_CUTOFF, BETA, SPEED_CUTOFF = 1.0, 0.5, 1.0  # Hz, 1/m, Hz: One-Euro's own defaults, for metres
SAVGOL_SECONDS = 0.25
KALMAN_SMOOTHNESS = 1.0  # at 30 Hz
RIDGE = 0.1  # by the features' mean variance
EXEMPLARS = 16
GP_SAMPLES, GP_SEARCH = 1200, 300  # samples of the process, and of the search for its parameters


@dataclass(frozen=True, eq=False)
class Samples:
    """What learners learn from: postures (N, J, 3) and offsets (N, J, 3) in standard form, NaN = not known."""

    postures: Floats
    offsets: Floats


Learner = Callable[[Samples], Callable[[Floats], Floats]]


def one_euro(positions: Floats, times: Floats) -> Floats:
    """(T, J, 3) filtered frame by frame; missing samples keep the filter waiting."""
    filtered = np.array(positions)
    value, speed = np.array(positions[:1]), np.zeros_like(positions[:1])
    for t in range(1, len(positions)):
        passed = max(float(times[t] - times[t - 1]), 1e-3)
        here = positions[t : t + 1]
        value = np.where(np.isfinite(value), value, here)
        known = np.isfinite(here)
        now = np.where(known, (here - value) / passed, speed)
        speed = speed + _share(SPEED_CUTOFF, passed) * (now - speed)
        cutoff = MIN_CUTOFF + BETA * np.abs(speed)
        value = np.where(known, value + _share(cutoff, passed) * (here - value), value)
        filtered[t] = np.where(known[0], value[0], np.nan)
    return filtered


def savitzky_golay(positions: Floats, times: Floats) -> Floats:
    """(T, J, 3) second-order polynomials over a quarter of a second; gaps are bridged by straight lines meanwhile."""
    from scipy.signal import savgol_filter

    if len(positions) < 5:
        return np.array(positions)
    usual = float(np.median(np.diff(times))) or 1.0 / 30.0
    window = min(max(5, 2 * round(SAVGOL_SECONDS / usual / 2.0) + 1), len(positions) - 1 + len(positions) % 2)
    bridged = _bridged(positions)
    return np.where(np.isfinite(positions), savgol_filter(bridged, window, 2, axis=0, mode="interp"), np.nan)


def kalman(positions: Floats, times: Floats) -> Floats:
    """(T, J, 3) the smoother of a Kalman filter whose velocity walks at random: Whittaker's, in closed form."""
    if len(positions) < 3:
        return np.array(positions)
    usual = float(np.median(np.diff(times))) or 1.0 / 30.0
    flat = _bridged(positions).reshape(len(positions), -1)
    smooth = whittaker(flat, np.ones(len(flat)), KALMAN_SMOOTHNESS * (1.0 / (30.0 * usual)) ** 4)
    return np.where(np.isfinite(positions), smooth.reshape(positions.shape), np.nan)


def constant(samples: Samples) -> Callable[[Floats], Floats]:
    """Each joint's mean offset."""
    mean = _mean(samples.offsets)
    return lambda postures: np.broadcast_to(mean, postures.shape)


def ridge(samples: Samples) -> Callable[[Floats], Floats]:
    """Linear regression from the places of all joints, with a penalty."""
    mean, rest = _split(samples.offsets)
    flat = samples.postures.reshape(len(samples.postures), -1)
    centre = flat.mean(axis=0)
    inner = (flat - centre).T @ (flat - centre)
    inner[np.diag_indices(len(inner))] += RIDGE * np.trace(inner) / len(inner)
    slope = np.linalg.solve(inner, (flat - centre).T @ rest)
    return lambda postures: mean + ((postures.reshape(len(postures), -1) - centre) @ slope).reshape(postures.shape)


def full_gp(samples: Samples) -> Callable[[Floats], Floats]:
    """One Gaussian process on all samples at once, its parameters by marginal likelihood (Zhou et al. 2014)."""
    chosen = np.linspace(0, len(samples.postures) - 1, min(len(samples.postures), GP_SAMPLES)).astype(int)
    mean, rest = _split(samples.offsets[chosen])
    inputs = samples.postures[chosen].reshape(len(chosen), -1)
    few = np.linspace(0, len(chosen) - 1, min(len(chosen), GP_SEARCH)).astype(int)
    hyper: Hyper = fit_hyper(inputs[few], rest[few])
    noisy = covariance(inputs, inputs, hyper)
    noisy[np.diag_indices(len(noisy))] += hyper.noise
    weights = cho_solve(cho_factor(noisy, lower=True), rest)

    def predict(postures: Floats) -> Floats:
        cross = covariance(postures.reshape(len(postures), -1), inputs, hyper)
        return np.asarray(mean + (cross @ weights).reshape(postures.shape))

    return predict


def exemplar(samples: Samples) -> Callable[[Floats], Floats]:
    """The mean offset of the nearest samples, the nearer the more (Shen et al. 2012)."""
    from scipy.spatial import cKDTree

    mean, rest = _split(samples.offsets)
    flat = samples.postures.reshape(len(samples.postures), -1)
    tree = cKDTree(flat)
    count = min(EXEMPLARS, len(flat))

    def predict(postures: Floats) -> Floats:
        far, nearest = tree.query(postures.reshape(len(postures), -1), k=count)
        far, nearest = np.reshape(far, (len(postures), count)), np.reshape(nearest, (len(postures), count))
        weight = np.exp(-0.5 * (far / np.maximum(far[:, -1:], 1e-9)) ** 2)
        weight /= weight.sum(axis=1, keepdims=True)
        return np.asarray(mean + np.einsum("tk,tkd->td", weight, rest[nearest]).reshape(postures.shape))

    return predict


FILTERS: dict[str, Callable[[Floats, Floats], Floats]] = {
    "one-euro": one_euro,
    "savgol": savitzky_golay,
    "kalman": kalman,
}
LEARNERS: dict[str, Learner] = {"constant": constant, "ridge": ridge, "gp": full_gp, "exemplar": exemplar}


def _share(cutoff: float | Floats, passed: float) -> Floats:
    return np.asarray(1.0 / (1.0 + 1.0 / (2.0 * np.pi * np.asarray(cutoff) * passed)))


def _mean(offsets: Floats) -> Floats:
    known = np.isfinite(offsets)
    return np.asarray(np.where(known, offsets, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1))


def _split(offsets: Floats) -> tuple[Floats, Floats]:
    """The mean (J, 3) and what is left (N, J*3), 0 where not known."""
    mean = _mean(offsets)
    return mean, np.where(np.isfinite(offsets), offsets - mean, 0.0).reshape(len(offsets), -1)


def _bridged(positions: Floats) -> Floats:
    """Gaps filled by straight lines, ends held; 0 for what is never there."""
    filled = np.array(positions)
    frames = np.arange(len(positions), dtype=np.float64)
    flat = filled.reshape(len(positions), -1)
    for column in flat.T:
        known = np.isfinite(column)
        column[~known] = np.interp(frames[~known], frames[known], column[known]) if known.any() else 0.0
    return flat.reshape(positions.shape)
