"""Second-order walks whose steps go together: all channels of a body smoothed at once.

    minimise over z  sum w (z - y)² + sum over t of |Q^(-1/2) S(t)⁻¹ (z(t) - 2 z(t-1) + z(t-2))|²

with a weight w for each sample, the covariance Q of second differences over the channels and a scale S(t) for each
of them. No mean, no pose: what is known is only how sharply bodies bend their ways, and which channels do so together.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats

TOLERANCE = 1e-5  # error of the solution as a share of the standard deviation that the samples leave: reproducible
MOST_STEPS = 300  # of conjugate gradients
UNEVEN = 1e-2  # of the usual weight: a sample this light is as good as missing
LIVELIER = 3.0  # times the usual scale: beyond it a moment is not like the others
LEAST_WEIGHT = 1e-9  # of the usual weight, for a channel without any sample
_LEAST = 1e-12  # share of the largest eigenvalue


@dataclass(frozen=True, eq=False)
class Coupling:
    """Q with channels scaled so that all samples weigh about 1, taken apart.

    Attributes
    ----------
    unit : (C,) channel units per scaled unit.
    vectors : (C, C) eigenvectors of the scaled Q, columns.
    values : (C,) its eigenvalues, above 0.
    """

    unit: Floats
    vectors: Floats
    values: Floats


def couple(weight: Floats, covariance: Floats) -> Coupling:
    """Scale and take apart the covariance of second differences for samples of these weights.

    Parameters
    ----------
    weight : (T, C) inverse variances, 0 = missing.
    covariance : (C, C) Q, symmetric, positive semi-definite.
    """
    typical = weight.mean(axis=0)
    unit = 1.0 / np.sqrt(np.maximum(typical, 1e-6 * (typical.mean() or 1.0)))
    values, vectors = np.linalg.eigh(covariance / np.multiply.outer(unit, unit))
    return Coupling(unit, vectors, np.maximum(values, _LEAST * values[-1]))


def smooth_coupled(
    observed: Floats, weight: Floats, covariance: Floats, scale: Floats, start: Floats | None = None
) -> tuple[Floats, int]:
    """The smoothest motion near the samples, all channels together, by preconditioned conjugate gradients.

    Parameters
    ----------
    observed : (T, C) finite; what stands where the weight is 0 does not count. T >= 3.
    weight : (T, C) w, inverse variances.
    covariance : (C, C) Q, second differences per frame.
    scale : (T, C) S, standard deviations of the second difference into each frame relative to Q; rows 0, 1 unused.
    start : (T, C) to begin with; None = 0.

    Returns
    -------
    (T, C), off the minimum by a small share of what the samples leave open, and the number of steps.

    Source
    ------
    Two preconditioners. Where all samples and moments are much alike, the eigenvectors of Q part the channels into
    walks of their own. Where samples are missing or motion bursts, each channel is taken for a walk of its own, with
    every weight and scale as it is.
    """
    from ..kernels.banded import bend_back, bend_forward, step_along

    if not weight.any():
        return (np.zeros(observed.shape) if start is None else start), 0
    usual = np.exp(np.log(scale[2:]).mean(axis=0))
    coupling = couple(weight, covariance * np.multiply.outer(usual, usual))
    unit, vectors, values = coupling.unit, coupling.vectors, coupling.values
    w, calm = weight * np.square(unit), usual / scale
    calm[:2] = 1.0
    precision = (vectors / values) @ vectors.T
    even = w.min() > UNEVEN and calm.min() > 1.0 / LIVELIER and calm.max() < LIVELIER
    preconditioned = _parted(w, coupling) if even else _channelwise(w, calm, coupling)

    def normal(x: Floats) -> Floats:
        return bend_back(x, w, bend_forward(x, calm) @ precision, calm)

    right = w * observed / unit
    x = np.zeros_like(right) if start is None else start / unit
    residual = right - normal(x)
    nearer = preconditioned(residual)
    direction, size = nearer.copy(), float(np.vdot(residual, nearer))
    # the size is the squared error in units of what the samples leave open, summed over all values
    enough = TOLERANCE**2 * observed.size
    steps = 0
    while steps < MOST_STEPS and size > enough:
        turned = normal(direction)
        step_along(x, residual, direction, turned, size / float(np.vdot(direction, turned)))
        nearer = preconditioned(residual)
        before, size = size, float(np.vdot(residual, nearer))
        direction *= size / before
        direction += nearer
        steps += 1
    return np.asarray(x * unit), steps


def _parted(w: Floats, coupling: Coupling) -> Callable[[Floats], Floats]:
    """The system with each channel's weight held at its mean, parted by the eigenvectors of Q."""
    from ..kernels.banded import solve_walks, walk_factors

    vectors, values = coupling.vectors, coupling.values
    level = np.einsum("ck,c->k", np.square(vectors), w.mean(axis=0))
    factors = walk_factors(_each_frame(level, len(w)), _each_frame(1.0 / values, len(w)))
    return lambda r: np.asarray(solve_walks(*factors, r @ vectors) @ vectors.T)


def _channelwise(w: Floats, calm: Floats, coupling: Coupling) -> Callable[[Floats], Floats]:
    """The system without the coupling of the channels."""
    from ..kernels.banded import solve_walks, walk_factors

    alone = np.einsum("ck,k->c", np.square(coupling.vectors), 1.0 / coupling.values)
    factors = walk_factors(np.maximum(w, LEAST_WEIGHT), np.square(calm) * alone)
    return lambda r: np.asarray(solve_walks(*factors, np.ascontiguousarray(r)))


def _each_frame(row: Floats, frames: int) -> Floats:
    return np.ascontiguousarray(np.broadcast_to(row, (frames, len(row))))


def lone_step_variance(weight: Floats, covariance: Floats) -> Floats:
    """(C,) variance of second differences with which each channel, smoothed alone, would be as sure as with the others.

    The surety of a walk smoothed alone goes with the fourth root of the variance of its steps; that of the coupled
    walks is found in the axes of the eigenvectors, at the middle of the recording.

    Parameters
    ----------
    weight : (T, C) inverse variances, 0 = missing.
    covariance : (C, C) Q.
    """
    from ..kernels.banded import walk_certainty

    frames, channels = weight.shape
    coupling = couple(weight, covariance)
    vague = np.full(channels, 1e6)
    spread = np.diag(covariance) / np.square(coupling.unit)
    length = min(frames, 256)  # the middle of so long a walk does not feel its ends
    usual = np.minimum(np.square(coupling.unit) * np.maximum(weight.mean(axis=0), 1e-9), 1.0)
    level = np.broadcast_to(usual, (length, channels))
    parted = np.einsum("ck,c->k", np.square(coupling.vectors), usual)
    together, _ = walk_certainty(
        np.ascontiguousarray(np.broadcast_to(parted, (length, channels))),
        np.ascontiguousarray(np.broadcast_to(coupling.values, (length, channels))),
        vague,
        vague,
    )
    alone, _ = walk_certainty(
        np.ascontiguousarray(level), np.ascontiguousarray(np.broadcast_to(spread, (length, channels))), vague, vague
    )
    middle = length // 2
    surer = (np.square(coupling.vectors) @ together[middle]) / alone[middle]
    return np.asarray(np.diag(covariance) * np.minimum(surer, 1.0) ** 4)
