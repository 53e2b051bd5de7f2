"""Gap fillers that learn from the recording how its markers move together. Measured samples stay as they are."""

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from ...arrays import Bools, Floats, Ints, runs
from ...errors import MismatchError
from ...numerics.smoother import StateSpace, kalman_smoother
from .filtered import Filtered, marker_std

# Gloersen and Federolf's parameters
NEAR = 0.2  # m, sigma of the weight by distance
FAR = 30.0  # sigmas, beyond which markers are alike in saying nothing: what is smaller has no inverse
MISSING_WEIGHT = 0.02  # of the missing marker itself
DISTAL = 0.5  # of the mean distance; a marker beyond it that has gaps of its own is not used
KEPT = 0.99  # of the sum of singular values
# Burke and Lasenby's parameter
DROPPED = 0.0025  # of the sum of singular values

LEAST_FRAMES = 20  # complete frames below which nothing is learned
_HIDDEN_FRAMES = 30  # length of the stretches hidden from the smoother to see how wrong it is
_BLOCKS = 4  # parts of the training frames, each of which is predicted from the others to find the error


def fill_pca(positions: Floats, wanted: Bools | None = None) -> Filtered:
    """Fill missing markers from the principal components of the others, each gap by the markers that are there.

    The body's mean trajectory is taken out first. A gap of a marker is filled from frames in which it and all markers
    used are there; used are those not missing in the gap and, of those with gaps elsewhere, the near ones (their
    strategy R2).

    Parameters
    ----------
    positions : (T, M, 3) m, NaN = missing.
    wanted : (T, M) True in the gaps to fill; None = all.

    Returns
    -------
    Filtered over markers; a gap stays open where fewer than `LEAST_FRAMES` frames teach. std : m per coordinate; of
    measured samples the noise level, of filled ones the error on blocks of frames held out from the learning.

    Source
    ------
    Gloersen and Federolf, Predicting missing marker trajectories in human motion data using marker intercorrelations,
    PLoS ONE 11(3), 2016; the reconstruction after Federolf, PLoS ONE 8(10), 2013, equation 1. Gaps are taken one by
    one here, so that a marker is left out only where it is missing itself.
    """
    seen = _present(positions)
    std = marker_std(positions, seen)
    if seen.all() or not seen.any():
        return Filtered(positions, std, np.zeros(seen.shape, dtype=bool))
    with threadpool_limits(1, user_api="blas"):  # many small products: threads would wait for each other
        return _fill_pca(positions, seen, std, ~seen if wanted is None else wanted)


def _fill_pca(positions: Floats, seen: Bools, std: Floats, wanted: Bools) -> Filtered:
    filled, std = positions.copy(), std.copy()
    body = _body(positions, seen)
    posture = positions - body[:, None]
    distances = _mean_distances(positions, seen)
    whole: Bools = np.asarray(seen.all(axis=0))
    learned: dict[tuple[int, bytes], _Predictor | None] = {}
    for marker in np.flatnonzero(wanted.any(axis=0) & ~whole & seen.any(axis=0)):
        far = distances[marker] > DISTAL * np.nanmean(distances[marker])
        candidates: Bools = whole | (~far & np.isfinite(distances[marker]))
        candidates[marker] = False
        for start, stop in runs(~seen[:, marker]):
            if not wanted[start:stop, marker].any():
                continue
            # A frame in which nothing is seen stays open and takes no marker away from the others.
            frames = start + np.flatnonzero(seen[start:stop].any(axis=1))
            used: Bools = candidates & np.asarray(seen[frames].all(axis=0))
            key = int(marker), used.tobytes()
            if key not in learned:
                learned[key] = _learn(posture, seen, int(marker), used, distances[marker])
            predictor = learned[key]
            if predictor is not None:
                lost = ~np.isfinite(positions[frames, marker])
                found, doubt = predictor(posture[frames])
                filled[frames, marker] = np.where(lost, body[frames] + found, positions[frames, marker])
                std[frames, marker] = doubt
    return Filtered(filled, std, ~seen & np.isfinite(filled).all(axis=2))


def fill_kalman_lowdim(positions: Floats) -> Filtered:
    """Fill missing markers by a Kalman smoother in the principal components of the complete frames.

    The body's mean trajectory is taken out first. The components walk at random, with the covariance of their steps
    between complete frames; what the components of other frames leave of a coordinate is its noise.

    Parameters, returns: as in `fill_pca`, but nothing is filled when there are too few complete frames.

    Source
    ------
    Burke and Lasenby, Estimating missing marker positions using low dimensional Kalman smoothing, Journal of
    Biomechanics 49(9), 2016. Taking out the trajectory and measuring the noise are ours; theirs is fixed.
    """
    seen = _present(positions)
    std = marker_std(positions, seen)
    with threadpool_limits(1, user_api="blas"):
        return _fill_kalman_lowdim(positions, seen, std)


def _fill_kalman_lowdim(positions: Floats, seen: Bools, std: Floats) -> Filtered:
    unfilled = Filtered(positions, std, np.zeros(seen.shape, dtype=bool))
    complete: Bools = np.asarray(seen.all(axis=1))
    follows = complete[1:] & complete[:-1]
    if complete.all() or follows.sum() < LEAST_FRAMES:
        return unfilled
    body = _body(positions, seen)
    values = (positions - body[:, None]).reshape(len(positions), 3 * seen.shape[1])
    mean = values[complete].mean(axis=0)
    spread, directions = _principal(values[complete] - mean)
    count = _dimensions(spread, 1.0 - DROPPED)
    if count == 0:
        return unfilled
    basis = directions[:, :count]
    left = np.maximum(_left_by_others(values[complete]), 1e-6 * float(spread.mean()))
    steps = np.diff(values @ basis, axis=0)[follows]
    model = StateSpace(
        transition=np.eye(count),
        process_cov=steps.T @ steps / len(steps),
        observation=basis,
        start_mean=np.zeros(count),
        start_cov=np.diag(spread[:count]),
    )

    def smoothed(there: Bools) -> tuple[Floats, Floats]:
        observed = np.where(np.repeat(there, 3, axis=1), values, np.nan) - mean
        found = kalman_smoother(model, observed, left)
        return mean + found.mean @ basis.T, found.variance(basis) + left

    guess, variance = smoothed(seen)
    # What the components leave is slow, not white as the smoother takes it: the doubt is put right by what it says of
    # samples hidden from it, a tenth of those in frames that are incomplete anyway.
    block = np.arange(len(seen))[:, None] // _HIDDEN_FRAMES + np.arange(seen.shape[1])
    hidden = seen & ~complete[:, None] & (block % 10 == 0)
    if hidden.any():
        guessed, expected = smoothed(seen & ~hidden)
        lost = np.repeat(hidden, 3, axis=1)
        variance = variance * max(1.0, float(np.mean(np.square(guessed - values)[lost] / expected[lost])))
    filled = np.where(np.isfinite(positions), positions, guess.reshape(positions.shape) + body[:, None])
    new = ~seen & np.isfinite(filled).all(axis=2)
    doubt = np.sqrt(variance.reshape(positions.shape).mean(axis=2))
    return Filtered(filled, np.where(seen, std, np.where(new, doubt, np.nan)), new)


def _left_by_others(values: Floats) -> Floats:
    """(C,) mean square of what the principal components of the other blocks of frames leave of each block (N, C)."""
    missed = np.zeros(values.shape[1])
    for held_out in np.array_split(np.arange(len(values)), _BLOCKS):
        rest = np.setdiff1d(np.arange(len(values)), held_out)
        mean = values[rest].mean(axis=0)
        variance, directions = _principal(values[rest] - mean)
        basis = directions[:, : _dimensions(variance, 1.0 - DROPPED)]
        centred = values[held_out] - mean
        missed += np.square(centred - centred @ basis @ basis.T).sum(axis=0)
    return np.asarray(missed / len(values))


@dataclass(frozen=True, eq=False)
class _Predictor:
    """One marker from P others by their principal components, with and without it."""

    others: Ints  # (P,)
    mean: Floats  # (3 P,)
    scale: Floats  # (3 P,) standard deviation over weight
    matrix: Floats  # (3 P, 3)
    marker_mean: Floats  # (3,)
    usual: float  # mean square of a frame's scaled inputs
    error: float = np.nan  # m per coordinate, on frames held out

    def __call__(self, posture: Floats) -> tuple[Floats, Floats]:
        """Postures (T, M, 3) to the place of the marker (T, 3) and its standard deviation (T,), m per coordinate.

        The error grows with the distance of a posture from the mean, beyond that of the frames learned from.
        """
        normal = (posture[:, self.others].reshape(len(posture), len(self.mean)) - self.mean) / self.scale
        strange = np.square(normal).mean(axis=1) / self.usual if self.usual > 0 else np.ones(len(normal))
        doubt = self.error * np.sqrt(np.maximum(strange, 1.0))
        return self.marker_mean + normal @ self.matrix, doubt


def _learn(posture: Floats, seen: Bools, marker: int, used: Bools, distances: Floats) -> _Predictor | None:
    """Learn to predict a marker from those used; None where too few frames have them all."""
    frames = np.flatnonzero(seen[:, marker] & seen[:, used].all(axis=1))
    if not used.any() or len(frames) < LEAST_FRAMES:
        return None
    examples, others = posture[frames], np.flatnonzero(used)
    missed = []
    for held_out in np.array_split(np.arange(len(frames)), _BLOCKS):
        rest = np.setdiff1d(np.arange(len(frames)), held_out)
        predict = _fit(examples[rest], marker, others, distances)
        missed.append(predict(examples[held_out])[0] - examples[held_out, marker])
    error = float(np.sqrt(np.square(np.concatenate(missed)).mean()))
    return replace(_fit(examples, marker, others, distances), error=error)


def _fit(posture: Floats, marker: int, others: Ints, distances: Floats) -> _Predictor:
    """Weighted principal components of postures (N, M, 3) with the marker, and with the marker set to zero."""
    inputs, target = posture[:, others].reshape(len(posture), -1), posture[:, marker]
    mean, marker_mean = inputs.mean(axis=0), target.mean(axis=0)
    marker_spread = _spread(target)
    nearness = np.exp(-0.5 * np.minimum(distances[others] / NEAR, FAR) ** 2)
    scale = _spread(inputs) / np.repeat(nearness, 3)
    normal = np.hstack([(inputs - mean) / scale, (target - marker_mean) / marker_spread * MISSING_WEIGHT])
    width = inputs.shape[1]
    cov = normal.T @ normal / len(normal)
    without = cov.copy()
    without[width:], without[:, width:] = 0.0, 0.0
    values, full = _ordered(cov)
    values_without, lacking = _ordered(without)
    count = max(_dimensions(values, KEPT), _dimensions(values_without, KEPT))
    full, lacking = full[:, :count], lacking[:, :count]
    # Scores of the incomplete frame become those with the marker: T = PC0ᵀ PC. PCᵀ PC0, as published (equation 1),
    # is its transpose: the signs of components, which are arbitrary, would decide what comes out.
    matrix = (lacking @ (lacking.T @ full) @ full.T)[:width, width:]
    usual = float(np.trace(without)) / width
    return _Predictor(others, mean, scale, matrix * (marker_spread / MISSING_WEIGHT), marker_mean, usual)


def _spread(values: Floats) -> Floats:
    """Standard deviation of each column, 1 for one that stands still."""
    spread = values.std(axis=0)
    return np.where(spread > 0, spread, 1.0)


def _principal(centred: Floats) -> tuple[Floats, Floats]:
    return _ordered(centred.T @ centred / len(centred))


def _ordered(cov: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues, falling and not below 0, and their vectors as columns."""
    values, vectors = np.linalg.eigh(cov)
    return np.maximum(values[::-1], 0.0), vectors[:, ::-1]


def _dimensions(variance: Floats, share: float) -> int:
    """How many components hold this share of the sum of singular values; 0 of nothing."""
    singular = np.sqrt(variance)
    if not singular.any():
        return 0
    return min(int(np.searchsorted(np.cumsum(singular), share * singular.sum())) + 1, len(singular))


def _body(positions: Floats, seen: Bools) -> Floats:
    """(T, 3) mean trajectory of the markers without gaps or, if there are not three, of all as if none were missing."""
    whole = seen.all(axis=0)
    if whole.sum() >= 3:
        return np.asarray(positions[:, whole].mean(axis=1))
    values = np.where(seen[:, :, None], positions, 0.0)
    per_frame, per_marker = seen.sum(axis=1)[:, None], seen.sum(axis=0)[:, None]
    place = np.zeros((seen.shape[1], 3))
    body = np.zeros((len(seen), 3))
    for _ in range(20):
        shifted = np.where(seen[:, :, None], values - place, 0.0)
        body = shifted.sum(axis=1) / np.maximum(per_frame, 1)
        place = np.where(seen[:, :, None], values - body[:, None], 0.0).sum(axis=0) / np.maximum(per_marker, 1)
        place -= place[per_marker[:, 0] > 0].mean(axis=0)
    body[per_frame[:, 0] == 0] = np.nan
    return body


def _mean_distances(positions: Floats, seen: Bools) -> Floats:
    """(M, M) m, mean over frames that show both markers; NaN where none does."""
    count = seen.shape[1]
    distances = np.full((count, count), np.nan)
    for marker in range(count):
        both = seen & seen[:, [marker]]
        gap = np.where(both[:, :, None], positions - positions[:, [marker]], 0.0)
        known = both.any(axis=0)
        distances[marker, known] = (np.sqrt(np.square(gap).sum(axis=2)).sum(axis=0) / np.maximum(both.sum(axis=0), 1))[
            known
        ]
    return distances


def _present(positions: Floats) -> Bools:
    if positions.ndim != 3 or positions.shape[2] != 3:
        raise MismatchError(f"markers must be (frames, markers, 3), came {positions.shape}")
    return np.asarray(np.isfinite(positions).all(axis=2))
