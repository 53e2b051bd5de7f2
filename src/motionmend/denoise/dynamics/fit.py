"""Dynamics from clean clips. All that says how sure they are is measured on clips held out from the learning."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...errors import MismatchError
from ...numerics.ssa import whole_stretches
from .model import Dynamics

MOST_POSES = 30
ENERGY = 0.999  # of the poses' variance, kept by the principal poses
LEAST_FRAMES = 12
_FOLDS = 5
_RIDGES = np.logspace(-1.0, 4.0, 6)  # frames of data that the belief in constant velocity is worth
_SLOWEST = 0.999  # per frame: no pattern lasts for ever, so that no gap makes it grow
_LEAST_VAR = 1e-6  # of the poses' mean variance; what a direction at rest may still stray


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Complete frames (T, C), T at least 3, and the fold in which they are held out."""

    values: Floats
    fold: int


@dataclass(frozen=True, eq=False)
class _Moments:
    """Sums over a fold. Predictors are (z(t), z(t) - z(t-1)), 2 K; what follows is z(t+1), K."""

    frames: int
    predictors: Floats  # (2 K, 2 K)
    crossed: Floats  # (2 K, K)
    followers: Floats  # (K, K)

    def __add__(self, other: "_Moments") -> "_Moments":
        return _Moments(
            self.frames + other.frames,
            self.predictors + other.predictors,
            self.crossed + other.crossed,
            self.followers + other.followers,
        )

    def __sub__(self, other: "_Moments") -> "_Moments":
        return _Moments(
            self.frames - other.frames,
            self.predictors - other.predictors,
            self.crossed - other.crossed,
            self.followers - other.followers,
        )


def fit_dynamics(clips: Sequence[Floats], fps: float, *, apart: bool = False) -> Dynamics:
    """Learn dynamics from clean clips.

    The autoregression is drawn towards constant velocity as strongly as predicts held-out clips best. Clips that are
    interleaved phases of one recording are recognised and never held out against each other.

    Parameters
    ----------
    clips : each (T, C) at `fps`, in comparable units; a frame with a missing sample cuts a clip.
    fps : Hz.
    apart : the clips are short windows of recordings, in their order: each is held out as a whole, with its neighbours.

    Raises
    ------
    MismatchError : no clip, clips of different channels, none that moves, or fewer than twelve frames to learn from.

    Source
    ------
    The data-driven Kalman filter of Lou, Example-based human motion denoising, 2012, section 2.3.2, whose system
    matrices are learned "from the same set of training data"; the form of the matrices is ours.
    """
    known = _moving(clips)
    stretches = _folded([clip[:, known] for clip in clips], apart)
    values = np.concatenate([s.values for s in stretches])
    mean = values.mean(axis=0)
    variance, directions = _principal(values - mean)
    share = np.cumsum(variance) / variance.sum()
    count = min(MOST_POSES, int(np.searchsorted(share, ENERGY)) + 1)
    poses, rest = directions[:, :count], directions[:, count:]

    folds = sorted({s.fold for s in stretches})
    moments = [_moments([(s.values - mean) @ poses for s in stretches if s.fold == fold]) for fold in folds]
    first, second, process_cov = _autoregression(moments)
    decay, rest_var = _rest_dynamics(stretches, count, rest)

    def spread_out(part: Floats) -> Floats:
        whole = np.zeros((len(known), *part.shape[1:]))
        whole[known] = part
        return whole

    return Dynamics(
        fps=fps,
        known=known,
        mean=spread_out(mean),
        poses=spread_out(poses),
        first=first,
        second=second,
        process_cov=process_cov,
        start_cov=_start_cov(moments),
        rest=spread_out(rest),
        rest_decay=decay,
        rest_var=np.maximum(rest_var, _LEAST_VAR * float(variance.mean())),
    )


def _moving(clips: Sequence[Floats]) -> Bools:
    """(C,) channels that are measured and move in the clips."""
    if not clips:
        raise MismatchError("dynamics are learned from clean clips, came none")
    if len({clip.shape[1:] for clip in clips}) != 1 or clips[0].ndim != 2:
        raise MismatchError(f"all clips need the same channels, came {sorted({clip.shape[1:] for clip in clips})}")
    values = np.concatenate(list(clips))
    measured = np.isfinite(values)
    low = np.where(measured, values, np.inf).min(axis=0, initial=np.inf)
    high = np.where(measured, values, -np.inf).max(axis=0, initial=-np.inf)
    moving = high - low > 1e-9 * np.maximum(np.abs(low), np.abs(high))
    if not moving.any():
        raise MismatchError("dynamics are learned from motion, came clips in which no channel moves")
    return np.asarray(moving)


def _folded(clips: Sequence[Floats], apart: bool = False) -> list[_Stretch]:
    """Whole stretches of the clips, dealt to folds by recording, or each `apart`; one recording alone is cut into folds
    over time."""
    recording, group = [0], 0
    for before, clip in pairwise(clips):
        group += apart or not _phases_of_one(before, clip)
        recording.append(group)
    frames = np.array([len(clip) for clip in clips], dtype=np.float64)
    by_recording = np.bincount(recording, weights=frames)
    middle = np.cumsum(by_recording) - by_recording / 2
    fold_of = np.minimum(middle / frames.sum() * _FOLDS, _FOLDS - 1).astype(np.int64)
    stretches: list[_Stretch] = []
    for clip, of in zip(clips, recording, strict=True):
        cuts: Ints = np.linspace(0, len(clip), _FOLDS + 1 if group == 0 else 2).astype(np.int64)
        for fold, (a, b) in enumerate(pairwise(cuts)):
            for start, stop in whole_stretches(clip[a:b]):
                if stop - start >= 3:
                    part = np.ascontiguousarray(clip[a + start : a + stop])
                    stretches.append(_Stretch(part, fold if group == 0 else int(fold_of[of])))
    if sum(len(s.values) for s in stretches) < LEAST_FRAMES:
        raise MismatchError(
            f"dynamics need at least {LEAST_FRAMES} frames in stretches of 3 or more without a missing sample, "
            f"came {sum(len(s.values) for s in stretches)}: give longer or more complete clips"
        )
    return stretches


def _phases_of_one(before: Floats, clip: Floats) -> bool:
    """Whether two clips are neighbouring phases of one recording: closer to each other than a frame is to the next."""
    frames = min(len(before), len(clip))
    if abs(len(before) - len(clip)) > 1 or frames < 2:
        return False
    apart, step = np.abs(before[:frames] - clip[:frames]), np.abs(np.diff(before[:frames], axis=0))
    both = np.isfinite(apart[1:]) & np.isfinite(step)
    return bool(both.any() and apart[1:][both].mean() < step[both].mean())


def _principal(centred: Floats) -> tuple[Floats, Floats]:
    """Variances (C,), falling, and orthonormal directions (C, C) of centred samples (N, C)."""
    values, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    vectors = vectors[:, ::-1]
    # An eigenvector's sign is arbitrary; the largest entry is made positive, so that the same clips give the same.
    largest = vectors[np.abs(vectors).argmax(axis=0), np.arange(len(vectors))]
    return np.maximum(values[::-1], 0.0), vectors * np.sign(largest)


def _moments(paths: Sequence[Floats]) -> _Moments:
    before, now, after = (np.concatenate([z[k : len(z) - 2 + k] for z in paths]) for k in range(3))
    predictors = np.hstack([now, now - before])
    return _Moments(len(after), predictors.T @ predictors, predictors.T @ after, after.T @ after)


def _autoregression(moments: Sequence[_Moments]) -> tuple[Floats, Floats, Floats]:
    """first, second and process_cov (K, K) from the moments of each fold."""
    total = moments[0]
    for more in moments[1:]:
        total = total + more
    count = len(total.followers)
    # With nothing to hold out the ridge cannot be chosen: a hundred frames' worth is near what recordings choose.
    ridges = _RIDGES if len(moments) > 1 else _RIDGES[3:4]
    best_score, best_ridge, process_cov = np.inf, ridges[0], np.eye(count)
    for ridge in ridges:
        missed = np.zeros((count, count))
        for held_out in moments:
            others = total - held_out if len(moments) > 1 else total
            missed += _missed(held_out, _coefficients(others, total, ridge))
        missed = 0.5 * (missed + missed.T) / total.frames
        score = float(np.log(np.maximum(missed.diagonal(), 1e-300)).sum())
        if score < best_score:
            best_score, best_ridge, process_cov = score, ridge, missed
    both = _coefficients(total, total, best_ridge)
    first, second = (both[:count] + both[count:]).T, -both[count:].T
    lag = np.block([[first, second], [np.eye(count), np.zeros((count, count))]])
    fastest = float(np.abs(np.linalg.eigvals(lag)).max())
    if fastest > _SLOWEST:
        # Powers of one factor on both lags scale every eigenvalue by it.
        first, second = first * (_SLOWEST / fastest), second * (_SLOWEST / fastest) ** 2
    return first, second, 0.9 * process_cov + 0.1 * np.diag(process_cov.diagonal())


def _coefficients(moments: _Moments, scale: _Moments, ridge: float) -> Floats:
    """(2 K, K) of ridge regression towards constant velocity, z(t+1) = z(t) + (z(t) - z(t-1))."""
    count = len(moments.followers)
    steady = np.vstack([np.eye(count), np.eye(count)])
    penalty = np.diag(ridge * np.maximum(scale.predictors.diagonal() / scale.frames, 1e-300))
    return np.asarray(
        steady + np.linalg.solve(moments.predictors + penalty, moments.crossed - moments.predictors @ steady)
    )


def _missed(moments: _Moments, coefficients: Floats) -> Floats:
    """(K, K) sum of squared prediction errors."""
    crossed = coefficients.T @ moments.crossed
    return np.asarray(moments.followers - crossed - crossed.T + coefficients.T @ moments.predictors @ coefficients)


def _start_cov(moments: Sequence[_Moments]) -> Floats:
    """(2 K, 2 K) second moment of (z(t), z(t-1))."""
    count = len(moments[0].followers)
    total = sum(m.predictors for m in moments) / sum(m.frames for m in moments)
    back = np.block([[np.eye(count), np.eye(count)], [np.zeros((count, count)), -np.eye(count)]])
    return np.asarray(back.T @ total @ back)


def _rest_dynamics(stretches: Sequence[_Stretch], count: int, rest: Floats) -> tuple[Floats, Floats]:
    """Decay and variance (R,) of what principal poses of the other folds leave of each fold, along `rest` (C, R)."""
    square, lagged, at_start = (np.zeros(rest.shape[1]) for _ in range(3))
    frames = 0
    folds = sorted({s.fold for s in stretches})
    for fold in folds:
        others = [s.values for s in stretches if s.fold != fold or len(folds) == 1]
        mean = np.concatenate(others).mean(axis=0)
        poses = _principal(np.concatenate(others) - mean)[1][:, :count]
        left = rest - poses @ (poses.T @ rest)
        for stretch in stretches:
            if stretch.fold == fold:
                along = (stretch.values - mean) @ left
                square += np.square(along).sum(axis=0)
                lagged += (along[1:] * along[:-1]).sum(axis=0)
                at_start += np.square(along[:-1]).sum(axis=0)
                frames += len(along)
    decay = np.clip(lagged / np.maximum(at_start, 1e-300), 0.0, _SLOWEST)
    return decay, square / frames
