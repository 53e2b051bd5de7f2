"""What of the oracle is the verdict: its smoothers have to judge each sample themselves, told all about all others.

They are told the noise, and of every other sample whether it is an outlier. What they expect of the one they judge is
their estimate from all others, and the threshold, one for the clips of a problem and cell, is the best there is, chosen
by the truth.
"""

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.numerics.smoother import kalman_smoother
from motionmend.numerics.walk import fit_random_walk, smooth_random_walk

from .beyond_common import CELLS, PROBLEMS, Cell, in_parallel, spoilt, truth_of
from .beyond_oracle import PoseDynamics, Told, all_told, by_dynamics, by_walk, learn_dynamics, rms
from .common import model_of

LEAST_LEFT = 0.02  # of the noise's variance that an estimate without the sample leaves open


@dataclass(frozen=True)
class Verdict:
    """The oracle judging for itself in one cell of one problem, the best of its smoothers and of two scores.

    Attributes
    ----------
    f1 : of its verdicts on body angles.
    error : RMS degrees of the better smoother on what it believed, mean over the clips.
    told : the same, told which samples are outliers.
    """

    problem: str
    cell: Cell
    f1: float
    error: float
    told: float


@cache
def oracle_verdicts(mocap: Path) -> tuple[Verdict, ...]:
    """Every problem in every cell with outliers."""
    return tuple(one for found in in_parallel(partial(_verdicts, mocap), tuple(PROBLEMS)) for one in found)


def _verdicts(mocap: Path, problem: str) -> list[Verdict]:
    split = PROBLEMS[problem]
    layout = model_of(mocap, split.learn).layout
    dynamics = learn_dynamics(mocap, split.learn, layout)
    truths = [truth_of(mocap, clip) for clip in split.test]
    found = []
    for cell in CELLS:
        if cell[1] > 0.0:
            clips = [all_told(truth, spoilt(truth, cell, seed), layout) for seed, truth in enumerate(truths)]
            found.append(_verdict(problem, cell, clips, dynamics))
    return found


def _verdict(problem: str, cell: Cell, clips: list[Told], dynamics: PoseDynamics) -> Verdict:
    noise = cell[0]
    scores = [_surprises(told, noise, dynamics) for told in clips]
    told = np.mean([_errors(one, one.outlier, noise, dynamics) for one in clips], axis=0)
    outlier = np.concatenate([one.outlier[:, one.counted].ravel() for one in clips])
    best, errors = 0.0, []
    for kind in range(len(scores[0])):
        score = np.concatenate([some[kind][:, one.counted].ravel() for some, one in zip(scores, clips, strict=True)])
        f1, threshold = _best_threshold(score, outlier)
        best = max(best, f1)
        believed = []
        for some, one in zip(scores, clips, strict=True):
            rejected = np.where(one.counted, some[kind] >= threshold, one.outlier)
            believed.append(_errors(one, rejected, noise, dynamics))
        errors.append(np.mean(believed, axis=0))
    return Verdict(problem, cell, best, float(np.min(errors)), float(told.min()))


def _surprises(told: Told, noise: float, dynamics: PoseDynamics) -> list[Floats]:
    """How far (T, C) each sample is from what all others make expect, by both smoothers: degrees, and in deviations."""
    observed = np.where(told.outlier, np.nan, told.values)
    spread = noise**2 + dynamics.discarded + 1e-3
    pose = kalman_smoother(dynamics.space, observed - dynamics.mean, spread)
    step_var, noise_var = fit_random_walk(observed, np.full(observed.shape[1], noise**2))
    walk = smooth_random_walk(observed, np.nan_to_num(step_var, nan=1.0), noise_var)
    found = []
    for mean, variance, left in (
        (pose.mean @ dynamics.space.observation.T + dynamics.mean, pose.variance(dynamics.space.observation), spread),
        (walk.mean, walk.variance, noise_var),
    ):
        # of a sample that was believed, its own part is taken out of the estimate again
        without = np.where(told.outlier, 1.0, np.maximum(1.0 - variance / left, LEAST_LEFT))
        off = np.abs(told.values - mean) / without
        found += [off, off / np.sqrt(np.where(told.outlier, variance + left, left / without))]
    return found


def _best_threshold(score: Floats, outlier: Bools) -> tuple[float, float]:
    """F1 and the score from which samples are rejected."""
    order = np.argsort(-score, kind="stable")
    f1 = 2.0 * np.cumsum(outlier[order]) / (np.arange(1, len(score) + 1) + outlier.sum())
    best = int(f1.argmax())
    return float(f1[best]), float(score[order[best]])


def _errors(told: Told, rejected: Bools, noise: float, dynamics: PoseDynamics) -> tuple[float, float]:
    """RMS degrees of both smoothers."""
    ways = by_dynamics(dynamics, told.values, noise, rejected), by_walk(told.values, noise, rejected)
    return rms(ways[0], told), rms(ways[1], told)
