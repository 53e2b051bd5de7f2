"""Second-order walks whose steps go together: all channels of a body smoothed at once.

    minimise over z  sum w (z - y)² + sum over t of |Q^(-1/2) S(t)⁻¹ (z(t) - 2 z(t-1) + z(t-2))|²

with a weight w for each sample, the covariance Q of second differences over the channels and a scale S(t) for each
of them. No mean, no pose: what is known is only how sharply bodies bend their ways, and which channels do so together.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats

TOLERANCE = 1e-3  # of the residual, in the norm of the preconditioner, against that of the right side
MOST_STEPS = 60  # of conjugate gradients
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
    weight : (T, C) inverse variances, 0 = missing; some above 0.
    covariance : (C, C) Q, symmetric, positive semi-definite.
    """
    typical = weight.mean(axis=0)
    unit = 1.0 / np.sqrt(np.maximum(typical, 1e-6 * typical.mean()))
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
    (T, C), and the number of steps.

    Source
    ------
    The preconditioner takes the weights of each channel for constant: then the eigenvectors of Q part the channels into
    walks of their own, each a pentadiagonal system.
    """
    from ..kernels.banded import solve_walks, walk_factors

    usual = np.exp(np.log(scale[2:]).mean(axis=0))
    coupling = couple(weight, covariance * np.multiply.outer(usual, usual))
    unit, vectors, values = coupling.unit, coupling.vectors, coupling.values
    # in the axes of the eigenvectors Q is diagonal; weights and scales act in those of the channels
    w = weight * np.square(unit)
    factors = walk_factors(np.einsum("ck,c->k", np.square(vectors), w.mean(axis=0)), 1.0 / values, len(observed))
    evenly = bool(np.allclose(scale[2:], usual))
    calm = usual / scale[2:]

    def curved(x: Floats) -> Floats:
        bend = x[:-2] - 2.0 * x[1:-1] + x[2:]
        if not evenly:
            bend = ((bend @ vectors.T) * calm) @ vectors
        bend = bend / values
        if not evenly:
            bend = ((bend @ vectors.T) * calm) @ vectors
        return _second_differences_back(bend)

    def normal(x: Floats) -> Floats:
        return np.asarray((w * (x @ vectors.T)) @ vectors + curved(x))

    def preconditioned(r: Floats) -> Floats:
        return np.asarray(solve_walks(*factors, r))

    right = (w * observed / unit) @ vectors
    x = np.zeros_like(right) if start is None else (start / unit) @ vectors
    residual = right - normal(x)
    nearer = preconditioned(residual)
    direction, size = nearer, float((residual * nearer).sum())
    enough = TOLERANCE**2 * float((right * preconditioned(right)).sum())
    steps = 0
    while steps < MOST_STEPS and size > enough:
        turned = normal(direction)
        length = size / float((direction * turned).sum())
        x = x + length * direction
        residual = residual - length * turned
        nearer = preconditioned(residual)
        before, size = size, float((residual * nearer).sum())
        direction = nearer + (size / before) * direction
        steps += 1
    return np.asarray((x @ vectors.T) * unit), steps


def _second_differences_back(bend: Floats) -> Floats:
    """D₂ᵀ of (T - 2, C): (T, C)."""
    result = np.zeros((len(bend) + 2, bend.shape[1]))
    result[:-2] += bend
    result[1:-1] -= 2.0 * bend
    result[2:] += bend
    return result


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
