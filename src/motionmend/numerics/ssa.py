"""Multi-channel singular spectrum analysis: the grand lag covariance and its eigenbases (section 2.2.1)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import blas, eigh_tridiagonal, lapack
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from ..arrays import Floats, frozen, runs
from ..errors import MismatchError

FIRST = 16  # eigenvectors that are asked for first: motion has seldom more
FEW = 64  # that Lanczos iteration finds sooner than a decomposition does
TRIDIAGONAL_LIMIT = 3000  # above this order Lanczos iteration goes on to more of them


@dataclass(frozen=True, eq=False)
class LagCovariance:
    """Sums over lag windows from which the grand lag covariance is made; sums of parts add.

    Attributes
    ----------
    window : M frames.
    channels : C.
    count : S_N, windows seen.
    total : (M * C,) sum of the windows, time-major: entry (m, c) at m * C + c.
    products : (M * C, M * C) sum of their outer products; (0, 0) while no window was seen.
    """

    window: int
    channels: int
    count: int
    total: Floats
    products: Floats

    def __add__(self, other: "LagCovariance") -> "LagCovariance":
        if (self.window, self.channels) != (other.window, other.channels):
            raise MismatchError(
                f"lag covariances add only when window and channels agree: "
                f"{self.window} x {self.channels} and {other.window} x {other.channels}"
            )
        if not self.count or not other.count:
            return self if self.count else other
        return LagCovariance(
            self.window,
            self.channels,
            self.count + other.count,
            self.total + other.total,
            self.products + other.products,
        )

    def mean(self) -> Floats:
        """(M * C,) the mean window."""
        return self.total / max(self.count, 1)

    def matrix(self) -> Floats:
        """(M * C, M * C) the grand lag covariance C_D about the mean window (eq. 2.3); of one window or more."""
        mean = self.mean()
        return self.products / max(self.count, 1) - np.multiply.outer(mean, mean)


def lag_covariance(series: Floats | Sequence[Floats], window: int) -> LagCovariance:
    """The lag sums of one clip, or of several; frames with a missing sample cut it, and no window straddles a cut.

    Parameters
    ----------
    series : (T, C) any unit, NaN = missing; or several such.
    window : M, frames per lag window.

    Returns
    -------
    Sums over all windows that lie within one whole stretch; count 0 where none is long enough.

    Source
    ------
    Section 2.2.1, eq. 2.1-2.5.
    """
    from ..kernels.lagged import lag_products

    several = [series] if isinstance(series, np.ndarray) else list(series)
    channels = several[0].shape[1]
    total = np.zeros(window * channels)
    stretches = []
    for one in several:
        for start, stop in whole_stretches(one):
            windows = stop - start - window + 1
            if windows < 1:
                continue
            stretch = np.ascontiguousarray(one[start:stop])
            running = np.vstack([np.zeros(channels), np.cumsum(stretch, axis=0)])
            total += (running[windows : windows + window] - running[:window]).ravel()
            stretches.append(stretch)
    count = sum(len(stretch) - window + 1 for stretch in stretches)
    # a window longer than every clip would take (M C)^2 numbers to say nothing: 30 GB for 1,000 frames of 62 channels
    products = lag_products(stretches, window) if stretches else np.zeros((0, 0))
    return LagCovariance(window, channels, count, total, products)


def whole_stretches(series: Floats) -> list[tuple[int, int]]:
    """(start, stop) of every longest run of frames of `series` (T, C) without a missing sample."""
    return runs(np.isfinite(series).all(axis=1))


@dataclass(frozen=True, eq=False)
class Eigenbases:
    """Leading orthonormal patterns of lag windows.

    Attributes
    ----------
    mean : (M, C) the mean window.
    vectors : (K, M, C) orthonormal, by falling eigenvalue.
    values : (K,) eigenvalues: variance along each pattern.
    total : variance of all M * C patterns together.
    discarded : (C,) variance per sample of a channel that the K patterns leave out.
    """

    mean: Floats
    vectors: Floats
    values: Floats
    total: float
    discarded: Floats

    def __post_init__(self) -> None:
        for name in ("mean", "vectors", "values", "discarded"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def count(self) -> int:
        """K."""
        return len(self.values)

    @property
    def window(self) -> int:
        """M."""
        return int(self.mean.shape[0])

    @property
    def energy(self) -> float:
        """Share of the variance that the K patterns hold."""
        return float(self.values.sum() / self.total) if self.total > 0 else 1.0


def eigenbases(covariance: LagCovariance, energy: float, most: int | None = None) -> Eigenbases:
    """The fewest leading eigenvectors of the grand lag covariance that hold `energy` of its trace.

    Parameters
    ----------
    covariance : at least two windows.
    energy : share of the variance to keep, in (0, 1].
    most : an upper bound on K.

    Raises
    ------
    MismatchError : fewer than two windows.

    Source
    ------
    Section 2.2.1, eq. 2.6, and "keeping 99 % of the original motion variation" (eq. 2.7).
    """
    if covariance.count < 2:
        raise MismatchError(
            f"bases of {covariance.window} frames need at least two whole windows, came {covariance.count}: "
            "give longer clips or a shorter --window"
        )
    matrix = covariance.matrix()
    size = len(matrix)
    total = float(np.trace(matrix))
    values, vectors = _leading(matrix, total, energy)  # e^k of eq. 2.6
    reached = np.cumsum(values) >= energy * total * (1 - 1e-12)
    count = int(np.argmax(reached)) + 1 if reached.any() else len(values)
    count = min(count, covariance.count - 1, most or size)
    values, vectors = np.clip(values[:count], 0.0, None), vectors[:, :count]
    vectors = vectors * np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(count)])
    shape = (covariance.window, covariance.channels)
    kept = np.einsum("dk,k,dk->d", vectors, values, vectors)
    discarded = np.clip(np.diag(matrix) - kept, 0.0, None).reshape(shape).mean(axis=0)
    return Eigenbases(covariance.mean().reshape(shape), vectors.T.reshape(count, *shape), values, total, discarded)


def _leading(matrix: Floats, total: float, energy: float) -> tuple[Floats, Floats]:
    """Leading eigenpairs by falling value, at least as many as hold `energy` of the trace, or all.

    Few patterns come from Lanczos iteration. Where more are needed, in matrices that fit, the tridiagonal form says
    how many, and only their vectors are made.
    """
    size = len(matrix)
    most = size // 5 if size > TRIDIAGONAL_LIMIT else min(FEW, size // 5)
    wanted = min(FIRST, most)
    products: Any = blas
    # a symmetric matrix is read by half: Lanczos iteration waits for memory
    product = LinearOperator(
        matrix.shape, lambda x: products.dsymv(1.0, matrix.T, x.ravel(), lower=1), dtype=matrix.dtype
    )
    # fixed, so that the same clips give the same bases, and random, so that no pattern is orthogonal to it
    start = np.random.default_rng(0).normal(size=size)
    while total > 0 and 0 < wanted <= most:
        try:
            values, vectors = eigsh(product, k=wanted, which="LA", v0=start)
        except ArpackNoConvergence:
            break
        if values.sum() >= energy * total:
            return values[::-1], vectors[:, ::-1]
        wanted = max(2 * wanted, FEW)
    return _by_tridiagonal(matrix, energy * total)


def _by_tridiagonal(matrix: Floats, wanted: float) -> tuple[Floats, Floats]:
    """The fewest leading eigenpairs whose values sum to `wanted`, or all."""
    size = len(matrix)
    routines: Any = lapack
    room = int(routines.dsytrd_lwork(size, lower=1)[0])
    reflectors, diagonal, beside, factors, _ = routines.dsytrd(matrix, lower=1, lwork=room)
    held = np.cumsum(eigh_tridiagonal(diagonal, beside, eigvals_only=True)[::-1]) >= wanted * (1 - 1e-12)
    count = int(np.argmax(held)) + 1 if held.any() else size
    values, inner = eigh_tridiagonal(diagonal, beside, select="i", select_range=(size - count, size - 1))
    # the reflectors stand below the subdiagonal, as those of a QR decomposition of all rows but the first would
    shape, rest = np.asfortranarray(reflectors[1:, :-1]), np.asfortranarray(inner[1:])
    room = int(routines.dormqr("L", "N", shape, factors, rest, -1)[1][0])
    vectors: Floats = np.vstack([inner[:1], routines.dormqr("L", "N", shape, factors, rest, room)[0]])
    return np.asarray(values[::-1], dtype=np.float64), vectors[:, ::-1]


def at_rate(bases: Eigenbases, fps: float, recording_fps: float) -> tuple[Eigenbases, int]:
    """The same patterns sampled at another rate, and how many frames of that rate one frame step of theirs is.

    A recording keeps its own frames: not it but the patterns are resampled (cubic spline along the window), then
    made orthonormal again. A window lasts as long as before.

    Parameters
    ----------
    bases : patterns at `fps` Hz.
    recording_fps : Hz.

    Returns
    -------
    bases : (K', M', C) with M' the frames of the recording that fit in a window; K' is K, or M' C where that is fewer.
    stride : frames of the recording between the starts of neighbouring windows, at least 1.
    """
    ratio = recording_fps / fps
    if abs(ratio - 1.0) < 1e-6:
        return bases, 1
    from scipy.interpolate import CubicSpline  # takes a third of a second to load, and is seldom needed

    length = max(2, int(np.floor((bases.window - 1) * ratio + 1e-9)) + 1)
    times = np.minimum(np.arange(length) / ratio, bases.window - 1)
    knots = np.arange(bases.window)
    mean = CubicSpline(knots, bases.mean, axis=0)(times)
    count = min(bases.count, length * bases.mean.shape[1])  # so few samples have no room for more orthonormal patterns
    bent = CubicSpline(knots, bases.vectors[:count], axis=1)(times)
    flat, upper = np.linalg.qr(bent.reshape(count, -1).T)
    flat = flat * np.sign(np.diag(upper))
    vectors = flat.T.reshape(count, length, -1)
    scale = length / bases.window  # a window of more samples has as much more variance
    return (
        Eigenbases(mean, vectors, bases.values[:count] * scale, bases.total * scale, bases.discarded),
        max(1, round(ratio)),
    )


def sum_covariances(parts: Iterable[LagCovariance]) -> LagCovariance:
    """The lag sums of many clips."""
    found = iter(parts)
    whole = next(found)
    for part in found:
        whole = whole + part
    return whole
