"""Gaps of joint angles as poses follow each other in the library, and with what surprises in the recording itself."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solveh_banded

from ..arrays import Bools, Floats
from .dynamics_model import Dynamics

ROUNDS = 5  # of filling and learning what surprises
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


def fill_likeliest(process: Process, values: Floats, gone: Bools, fps: float) -> Floats:
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
    (T, C) with the gaps of known channels filled.

    Source
    ------
    Shumway and Stoffer, An approach to time series smoothing and forecasting using the EM algorithm, Journal of Time
    Series Analysis 3(4), 1982, with the likeliest values of the gaps for their distribution.
    """
    steps = max(1, round(fps / process.fps))
    some, lost = values[::steps, process.known], (gone & ~gone.all(axis=0))[::steps, process.known]
    everywhere = np.ones(len(some) - 2, dtype=bool)
    whole = np.asarray(~(lost[2:] | lost[1:-1] | lost[:-2]).any(axis=1), dtype=bool)
    asked: Bools = whole if whole.sum() >= FEWEST else everywhere
    for _ in range(ROUNDS):
        some = _likeliest(_with_surprises(process, some, asked), some, lost)
        asked = everywhere
    return _spread(process, values, gone, some, steps)


def _with_surprises(process: Process, values: Floats, asked: Bools) -> Process:
    """The process with the covariance of what surprises it in these values (T, K), in the frames (T - 2,) asked."""
    away = values - process.mean
    surprise = (away[2:] - away[1:-1] @ process.first.T - away[:-2] @ process.second.T)[asked]
    seen, usual = surprise.T @ surprise, process.surprise
    livelier = float(np.median(np.diag(seen) / np.maximum(np.diag(usual), LEAST))) / len(surprise)
    own = (LIBRARY * max(livelier, LEAST) * usual + seen) / (LIBRARY + len(surprise))
    return Process(
        process.fps, process.known, process.mean, process.first, process.second, own + LEAST * np.eye(len(own))
    )


def _likeliest(process: Process, values: Floats, gone: Bools) -> Floats:
    """(T, K) with the samples that are gone at their likeliest."""
    from ..kernels.gap_bands import gap_system

    if not gone.any():
        return values
    frames = len(values)
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
    filled = values.copy()
    filled[frame, channel] -= solveh_banded(lower, slope[frame, channel], lower=True, overwrite_ab=True)
    return filled


def _spread(process: Process, values: Floats, gone: Bools, some: Floats, steps: int) -> Floats:
    """(T, C) the values with what filling every `steps`-th frame has changed in the gaps, joined by lines."""
    changed, filled, frames = some - values[::steps, process.known], values.copy(), np.arange(len(values))
    for column, channel in enumerate(np.flatnonzero(process.known)):
        inside = np.flatnonzero(gone[:, channel])
        filled[inside, channel] += np.interp(inside, frames[::steps], changed[:, column])
    return filled
