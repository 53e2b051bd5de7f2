"""Gaps of joint angles as poses follow each other in the library, and with what surprises in the recording itself."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from ...arrays import Bools, Floats
from ..dynamics.model import Dynamics

ROUNDS = 4  # of filling and learning what surprises
LIBRARY = 20.0  # frames' worth of the library's own surprises
FEWEST = 10  # frames without gaps to begin with; where there are fewer all are asked
LEAST = 1e-3  # square of degrees or cm, of what surprises a channel at least
HELD = 1e-4  # inverse square of degrees or cm, by which a first guess holds what nothing else does, as at a clip's ends


@dataclass(frozen=True, eq=False)
class Process:
    """x(t) = mean + first (x(t-1) - mean) + second (x(t-2) - mean) + N(0, surprise) over C channels, degrees and cm.

    Attributes
    ----------
    fps : Hz.
    known : (C,) True for the channels it tells of; the K others are not in what follows.
    mean : (K,).
    first, second, surprise : (K, K).
    dynamics : that it was made of; None = it was made of none.
    """

    fps: float
    known: Bools
    mean: Floats
    first: Floats
    second: Floats
    surprise: Floats
    dynamics: Dynamics | None = None


def process_of(dynamics: Dynamics) -> Process:
    """Learned dynamics as a process of the channels themselves."""
    known = dynamics.known
    poses, rest = dynamics.poses[known], dynamics.rest[known]
    lasting = (1.0 - dynamics.rest_decay**2) * dynamics.rest_var
    return Process(
        dynamics.fps,
        known,
        dynamics.mean[known],
        poses @ dynamics.first @ poses.T + (rest * dynamics.rest_decay) @ rest.T,
        poses @ dynamics.second @ poses.T,
        poses @ dynamics.process_cov @ poses.T + (rest * lasting) @ rest.T,
        dynamics,
    )


def fill_likeliest(process: Process, values: Floats, gone: Bools, fps: float) -> tuple[Floats, Floats]:
    """Fill gaps by the likeliest values under a process whose surprises are those of the recording.

    In turn the surprises are learned, drawn towards the library's, and the gaps filled. What the channels have in
    common where the recording surprises the library is so carried into its gaps.

    Parameters
    ----------
    process : of the library.
    values : (T, C) without noise, and in gaps a first guess.
    gone : (T, C) True in gaps; channels without any sample are taken as they are guessed.
    fps : Hz of the recording; frames at the process's rate are filled, and lines join what that changes.

    Returns
    -------
    filled : (T, C) with the gaps of known channels filled.
    variance : (T, C) of what was filled, as the process has it; 0 where it says nothing.

    Source
    ------
    Shumway and Stoffer, An approach to time series smoothing and forecasting using the EM algorithm, Journal of Time
    Series Analysis 3(4), 1982.
    """
    steps = max(1, round(fps / process.fps))
    some, lost = values[::steps, process.known], (gone & ~gone.all(axis=0))[::steps, process.known]
    filled, variance = values.copy(), np.zeros(values.shape)
    if not lost.any():
        return filled, variance
    everywhere = np.ones(len(some) - 2, dtype=bool)
    whole = np.asarray(~(lost[2:] | lost[1:-1] | lost[:-2]).any(axis=1), dtype=bool)
    guess = _Filled(some, np.zeros(some.shape), np.zeros((3, 3, *process.surprise.shape)))
    best = _likeliest(_with_surprises(process, guess, whole if whole.sum() >= FEWEST else everywhere), some, lost)
    for _ in range(ROUNDS - 1):
        best = _likeliest(_with_surprises(process, best, everywhere), best.values, lost)
    frames = np.arange(len(values))
    for column, channel in enumerate(np.flatnonzero(process.known)):
        inside = np.flatnonzero(gone[:, channel])
        changed = best.values[:, column] - some[:, column]
        filled[inside, channel] += np.interp(inside, frames[::steps], changed)
        variance[inside, channel] = np.interp(inside, frames[::steps], best.variance[:, column])
    return filled, variance


@dataclass(frozen=True, eq=False)
class _Filled:
    """Values with gaps filled (T, K), their variance, and products (3, 3, K, K) of `gap_spread`."""

    values: Floats
    variance: Floats
    products: Floats


def _with_surprises(process: Process, filled: _Filled, asked: Bools) -> Process:
    """The process with the covariance of what surprises it in these values, in the frames (T - 2,) asked."""
    away = filled.values - process.mean
    surprise = (away[2:] - away[1:-1] @ process.first.T - away[:-2] @ process.second.T)[asked]
    usual = process.surprise
    rules = (np.eye(len(usual)), -process.first, -process.second)
    unsure = sum(rules[k] @ filled.products[k, m] @ rules[m].T for k in range(3) for m in range(3))
    seen = surprise.T @ surprise + unsure
    livelier = float(np.median(np.diag(seen) / np.maximum(np.diag(usual), LEAST))) / len(surprise)
    own = (LIBRARY * max(livelier, LEAST) * usual + seen) / (LIBRARY + len(surprise))
    return replace(process, surprise=own + LEAST * np.eye(len(own)))


def _likeliest(process: Process, values: Floats, gone: Bools) -> _Filled:
    """The samples that are gone at their likeliest, and how far they may be off."""
    from ...kernels.gap_bands import gap_spread, gap_system

    frames, channels = values.shape
    root = np.linalg.inv(np.linalg.cholesky(process.surprise))
    rules = np.stack([root, -root @ process.first, -root @ process.second])
    away = values - process.mean
    surprise = sum(away[2 - k : frames - k] @ rules[k].T for k in range(3))
    slope = np.zeros(values.shape)
    for k in range(3):
        slope[2 - k : frames - k] += surprise @ rules[k]
    frame, channel = np.nonzero(gone)
    first = np.searchsorted(frame, np.arange(frames + 3))
    band = int((first[3:] - first[:-3]).max())
    products = np.einsum("kea,leb->klab", rules, rules, optimize=True)
    lower = gap_system(np.ascontiguousarray(products), frame, channel, frames, band)
    lower[0] += HELD
    factor = cholesky_banded(lower, overwrite_ab=True, lower=True)
    filled, variance = values.copy(), np.zeros(values.shape)
    filled[frame, channel] -= cho_solve_banded((factor, True), slope[frame, channel])
    variance[frame, channel], unsure = gap_spread(np.ascontiguousarray(factor.T), frame, channel, frames, channels)
    return _Filled(filled, variance, unsure)
