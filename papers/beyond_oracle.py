"""The oracle: smoothers that are told what no repair can know."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Floats
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise.channels.joints import root_rows, triples
from motionmend.denoise.channels.layout import Layout
from motionmend.denoise.channels.recording import Channels, to_channels
from motionmend.numerics.smoother import StateSpace, kalman_smoother
from motionmend.numerics.walk import fit_random_walk, smooth_random_walk

from .common import FPS, body, motion, reduced

POSES = 30  # principal poses of the learned dynamics
RIDGE = 1e-3  # of the regression, as a share of the mean variance
TINY = 1e-9  # of the variance, so that no covariance is singular


@dataclass(frozen=True, eq=False)
class PoseDynamics:
    """Principal poses that follow each other by a linear rule of second order, and what the poses leave out.

    Attributes
    ----------
    mean : (C,) pose, degrees and centimetres.
    space : 2 K states: the poses' weights now and a frame before.
    discarded : (C,) variance outside of the principal poses.
    """

    mean: Floats
    space: StateSpace
    discarded: Floats


def learn_dynamics(mocap: Path, clips: tuple[str, ...], layout: Layout) -> PoseDynamics:
    """Dynamics at 30 Hz by least squares, from all phases of the 120 Hz clips."""
    taught = [motion(mocap, clip) for clip in clips]
    series = [
        to_channels(reduced(clip, FPS, phase), layout).values
        for clip in taught
        for phase in range(round(clip.fps / FPS))
    ]
    poses = np.concatenate(series)
    mean = poses.mean(axis=0)
    patterns = np.linalg.svd(poses - mean, full_matrices=False)[2][:POSES]
    weights = [(one - mean) @ patterns.T for one in series]
    before = np.concatenate([np.hstack([w[1:-1], w[:-2]]) for w in weights])
    after = np.concatenate([w[2:] for w in weights])
    normal = before.T @ before
    normal += RIDGE * np.trace(normal) / len(normal) * np.eye(len(normal))
    rule = np.linalg.solve(normal, before.T @ after).T
    left = after - before @ rule.T
    k = len(patterns)
    transition = np.vstack([rule, np.eye(k, 2 * k)])
    process = np.zeros((2 * k, 2 * k))
    process[:k, :k] = left.T @ left / len(left)
    start = np.zeros((2 * k, 2 * k))
    start[:k, :k] = start[k:, k:] = np.cov(np.concatenate(weights).T)
    for covariance in (process, start):
        covariance += TINY * np.trace(covariance) * np.eye(2 * k)
    centred = poses - mean
    space = StateSpace(transition, process, np.vstack([patterns, np.zeros_like(patterns)]).T, np.zeros(2 * k), start)
    return PoseDynamics(mean, space, (centred - centred @ patterns.T @ patterns).var(axis=0))


def by_dynamics(dynamics: PoseDynamics, values: Floats, noise: float, rejected: Bools) -> Floats:
    """(T, C) channels smoothed with the learned dynamics, told the noise; rejected samples count as missing."""
    observed = np.where(rejected, np.nan, values - dynamics.mean)
    spread = noise**2 + dynamics.discarded + 1e-3
    estimate = kalman_smoother(dynamics.space, observed, spread)
    return np.asarray(estimate.mean @ dynamics.space.observation.T + dynamics.mean)


def by_walk(values: Floats, noise: float, rejected: Bools) -> Floats:
    """(T, C) channels smoothed as random walks whose steps are the likeliest, told the noise."""
    observed = np.where(rejected, np.nan, values)
    step_var, noise_var = fit_random_walk(observed, np.full(values.shape[1], noise**2))
    return np.asarray(smooth_random_walk(observed, np.nan_to_num(step_var, nan=1.0), noise_var).mean)


@dataclass(frozen=True, eq=False)
class Told:
    """What an oracle is told of a spoilt clip, channels as the layout orders them.

    Attributes
    ----------
    clean : the truth.
    values : (T, C) the noisy channels, of all angles that mean the same with those the truth has.
    outlier : (T, C) where outliers were put.
    counted : (C,) True for body angles.
    """

    clean: Channels
    values: Floats
    outlier: Bools
    counted: Bools


def all_told(truth: mm.Motion, bad: mm.evaluate.Corrupted[mm.Motion], layout: Layout) -> Told:
    """The outliers of a spoilt clip, and its channels turned as the truth has them."""
    clean, noisy = to_channels(truth, layout), to_channels(bad.recording, layout)
    hit = bad.outlier.copy()
    for rows in root_rows(truth.skeleton):  # in the travelling frame the root's channels are mixed
        hit[:, rows] = hit[:, rows].any(axis=1, keepdims=True)
    values = as_turned(clean, noisy, truth, bad.recording)
    return Told(clean, values, hit[:, noisy.columns], body(truth)[noisy.columns])


def told_errors(
    truth: mm.Motion, bad: mm.evaluate.Corrupted[mm.Motion], noise: float, dynamics: PoseDynamics, layout: Layout
) -> dict[str, float]:
    """RMS degrees over body angles of both smoothers: told noise, outliers and turns, and told the noise only."""
    told, noisy = all_told(truth, bad, layout), to_channels(bad.recording, layout)
    found = {}
    for name, values, rejected in (
        ("told all", told.values, told.outlier),
        ("told noise", noisy.values, np.zeros_like(told.outlier)),
    ):
        found[f"dynamics, {name}"] = rms(by_dynamics(dynamics, values, noise, rejected), told)
        found[f"walk, {name}"] = rms(by_walk(values, noise, rejected), told)
    return found


def rms(smooth: Floats, told: Told) -> float:
    """Degrees over body angles, modulo a full turn."""
    away = (smooth - told.clean.values)[:, told.counted]
    return float(np.sqrt(np.mean(np.square((away + 180.0) % 360.0 - 180.0))))


def as_turned(clean: Channels, noisy: Channels, truth: mm.Motion, recording: mm.Motion) -> Floats:
    """(T, C) the noisy channels, of all angles that mean the same with those the truth has.

    Noise near the border between two triples of angles turns all three over, by up to 180 degrees. A smoother that is
    told which samples are outliers has to be told that too, or one frame of a dance spoils its figure.
    """
    skeleton = truth.skeleton
    turns, _ = root_rows(skeleton)
    angles = np.setdiff1d(np.flatnonzero(skeleton.dof_kind == ROTATION), turns)
    added = np.degrees(recording.q - truth.q)
    at = {int(row): c for c, row in enumerate(clean.columns) if row >= 0}
    for rows in triples(skeleton):
        middle = int(rows[1])
        if middle in at:
            apart = clean.values[:, at[middle]] - np.degrees(truth.q[:, middle])
            turned = np.abs((apart + 180.0) % 360.0 - 180.0) > 1e-6
            added[:, middle] *= np.where(turned, -1.0, 1.0)  # of the other triple the middle angle runs backwards
    values = noisy.values.copy()
    for row in angles:
        if int(row) in at:
            values[:, at[int(row)]] = clean.values[:, at[int(row)]] + added[:, row]
    return values
