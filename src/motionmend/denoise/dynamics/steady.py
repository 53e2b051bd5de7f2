"""Learned dynamics in their steady state: a smoother for recordings that were cleaned, and its share in the repair.

Once outliers are replaced and gaps are filled the noise of a channel never changes, and neither does the gain of a
Kalman smoother: it is found once, for all frames. What the principal poses leave out is taken as if its noise were
independent of theirs, which it is where channels are alike.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from ...arrays import Bools, Floats
from ...numerics.risk import share_of_second
from ...numerics.steady import settled_covariance, settled_sum
from ..bases.support import interpolated
from .model import Dynamics

TRIED = 150  # frames on which the trust in the dynamics is judged
MOST, LEAST = 6, -4  # half decades by which what surprises a recording may differ from what surprises the library
SURER = 0.5  # of what mixing would make a repair surer if both erred independently: they saw the same samples
_TINY = 1e-10  # of the mean variance, so that no covariance is singular


def smooth_steadily(dynamics: Dynamics, values: Floats, noise: Floats, begin: Floats) -> tuple[Floats, Floats]:
    """Smooth a whole recording by learned dynamics, trusted as far as the recording is likely under them.

    Parameters
    ----------
    dynamics : of C channels.
    values : (T, C) at their rate, nothing missing.
    noise : (C,) standard deviations.
    begin : (2, C) the first two frames, as far as they are known already.

    Returns
    -------
    values : (T, C); channels unknown to the dynamics come as they are.
    variance : (C,) of them in the middle of the recording; infinite for unknown channels.

    Source
    ------
    The trust: factors on the variance of what surprises, of the greatest likelihood of the filter's predictions.
    """
    known = dynamics.known
    poses, rest, mean = dynamics.poses[known], dynamics.rest[known], dynamics.mean[known]
    away, told = values[:, known] - mean, np.square(noise[known])
    along, spread = _poses(dynamics, away @ poses, (poses.T * told) @ poses, (begin[:, known] - mean) @ poses)
    beside, unsure = _rest(dynamics, away @ rest, told @ np.square(rest))
    smooth, variance = values.copy(), np.full(values.shape[1], np.inf)
    smooth[:, known] = mean + along @ poses.T + beside @ rest.T
    variance[known] = np.einsum("ck,kl,cl->c", poses, spread, poses) + np.square(rest) @ unsure
    return smooth, variance


def mixed_in(
    steady: Floats, steady_var: Floats, values: Floats, variance: Floats, seen: Bools
) -> tuple[Floats, Floats]:
    """Mix a repair with the same recording smoothed by dynamics, each channel as the deviations of both say.

    Parameters
    ----------
    steady : (T, C) smoothed by dynamics.
    steady_var : (C,); where both lie further apart than that allows it is taken to be what they lie apart.
    values, variance : (T, C) of the repair.
    seen : (T, C) True where there was a sample; gaps are shifted by what changes at their edges.

    Returns
    -------
    Values and variance (T, C), nowhere above the repair's, in gaps the same.
    """
    count = np.maximum(seen.sum(axis=0), 1)
    apart = np.where(seen, steady - values, 0.0)
    square = np.square(apart).sum(axis=0) / count
    own = np.where(seen, variance, 0.0).sum(axis=0) / count
    told = np.isfinite(steady_var) & (square > 0)
    other = np.where(told, np.maximum(steady_var, square - own), own)
    share = share_of_second(own, other, square) * told
    left = (1.0 - share) * own + share * other - share * (1.0 - share) * square
    surer = np.where(told, 1.0 - SURER * (1.0 - np.minimum(left / np.where(own > 0, own, 1.0), 1.0)), 1.0)
    return values + interpolated(np.where(seen, share * apart, np.nan)), np.where(seen, variance * surer, variance)


def _poses(dynamics: Dynamics, seen: Floats, noise_cov: Floats, begin: Floats) -> tuple[Floats, Floats]:
    """(T, K) weights of the poses smoothed, and their covariance (K, K)."""
    count = seen.shape[1]
    transition = np.block([[dynamics.first, dynamics.second], [np.eye(count), np.zeros((count, count))]])
    start = np.concatenate([begin[0], 2.0 * begin[0] - begin[1]])
    information, process = np.zeros(transition.shape), np.zeros(transition.shape)
    information[:count, :count] = np.linalg.inv(noise_cov)
    process[:count, :count] = dynamics.process_cov

    def covariance(steps: int) -> Floats:
        return settled_covariance(transition, information, 10.0 ** (0.5 * steps) * process)

    def surprise(steps: int) -> float:
        predicted = covariance(steps)
        ahead, _ = _filtered(transition, _gain(predicted, noise_cov), seen[:TRIED], start)
        away = (seen[:TRIED] - ahead[:, :count])[2:]  # the first two are where it begins
        spread = predicted[:count, :count] + noise_cov
        square = float(np.einsum("tk,tk->", away @ np.linalg.inv(spread), away))
        return square + len(away) * float(np.linalg.slogdet(spread)[1])

    predicted = covariance(_likeliest(surprise))
    gain = _gain(predicted, noise_cov)
    ahead, found = _filtered(transition, gain, seen, start)
    known = predicted - gain @ predicted[:count]
    sure = predicted + _TINY * np.trace(predicted) / len(predicted) * np.eye(len(predicted))
    back = np.linalg.solve(sure, transition @ known).T
    for t in range(len(found) - 2, -1, -1):
        found[t] += back @ (found[t + 1] - ahead[t + 1])
    variance = settled_sum(back, known - back @ sure @ back.T)
    return found[:, :count], variance[:count, :count]


def _likeliest(surprise: Callable[[int], float]) -> int:
    """Half decades of trust that surprise least, sought step by step from those of the library."""
    asked = cache(surprise)
    best = 0
    for way in (1, -1):
        while LEAST <= best + way <= MOST and asked(best + way) < asked(best):
            best += way
    return best


def _gain(predicted: Floats, noise_cov: Floats) -> Floats:
    count = len(noise_cov)
    return np.asarray(np.linalg.solve(predicted[:count, :count] + noise_cov, predicted[:count]).T)


def _filtered(transition: Floats, gain: Floats, seen: Floats, start: Floats) -> tuple[Floats, Floats]:
    """(T, 2 K) states as predicted and once each frame is seen."""
    count = seen.shape[1]
    ahead, found = np.empty((len(seen), len(start))), np.empty((len(seen), len(start)))
    state = start
    for t in range(len(seen)):
        ahead[t] = state
        found[t] = state + gain @ (seen[t] - state[:count])
        state = transition @ found[t]
    return ahead, found


def _rest(dynamics: Dynamics, seen: Floats, noise_var: Floats) -> tuple[Floats, Floats]:
    """(T, R) what the poses leave out, smoothed, and its variance (R,) in the middle; each direction decays alone."""
    decay = dynamics.rest_decay
    trusts = 10.0 ** (0.5 * np.arange(LEAST, MOST + 1))[:, None]
    ahead, spread, *_ = _decaying(decay, trusts * dynamics.rest_var, noise_var, seen[:TRIED])
    told = spread + noise_var
    cost = (np.square(seen[:TRIED, None] - ahead) / told + np.log(told)).sum(axis=(0, 2))
    ahead, spread, found, known = _decaying(decay, trusts[cost.argmin()] * dynamics.rest_var, noise_var, seen)
    variance = known.copy()
    for t in range(len(found) - 2, -1, -1):
        back = known[t] * decay / spread[t + 1]
        found[t] += back * (found[t + 1] - ahead[t + 1])
        variance[t] += np.square(back) * (variance[t + 1] - spread[t + 1])
    return found, variance[len(variance) // 2]


def _decaying(decay: Floats, lasting: Floats, noise_var: Floats, seen: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Mean and variance (T, ..., R) as predicted and once each frame (T, R) is seen, of walks about 0.

    `lasting` (..., R) is the variance that they have before anything is seen.
    """
    shape = (len(seen), *lasting.shape)
    ahead, spread, found, known = (np.empty(shape) for _ in range(4))
    state, unsure = np.zeros(lasting.shape), lasting
    for t in range(len(seen)):
        ahead[t], spread[t] = state, unsure
        gain = unsure / (unsure + noise_var)
        found[t], known[t] = state + gain * (seen[t] - state), gain * noise_var
        state, unsure = decay * found[t], lasting + np.square(decay) * (known[t] - lasting)
    return ahead, spread, found, known
