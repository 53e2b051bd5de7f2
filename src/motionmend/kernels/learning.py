"""Local Gaussian processes that take in samples one by one, in memory that never grows."""

from math import exp, inf, log, sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled
from .putting import put


@compiled
def learn(
    centres: Floats,
    inputs: Floats,
    outputs: Floats,
    factors: Floats,
    weights: Floats,
    counts: Ints,
    hyper: Floats,
    samples: Floats,
    values: Floats,
    which: Bools,
    fresh: Floats,
    similar: float,
) -> None:
    """Take one sample of each joint into its most similar model, or open a new one; the models change in place.

    Parameters
    ----------
    centres, inputs, outputs, factors, weights, counts, hyper : of `numerics.local_gp.Mixture`.
    samples, values : (J, D), (J, P).
    which : (J,) the joints that learn.
    fresh : (4,) parameters of new models.
    similar : w_similar; below this similarity (eq. 10) to all models a new one is opened.
    """
    size = inputs.shape[2]
    for j in range(which.shape[0]):
        if not which[j]:
            continue
        q = _place_for(centres[j], counts[j], hyper[j], samples[j], similar)
        if counts[j, q] == 0:
            put(hyper[j, q], fresh)
        x, lower, count = inputs[j, q], factors[j, q], counts[j, q]
        if count == size:
            lost = _least(lower, weights[j, q], hyper[j, q, 3])
            count -= 1
            for s in range(lost, count):
                x[s] = x[s + 1]
                outputs[j, q, s] = outputs[j, q, s + 1]
            for s in range(lost, count):
                extend(x, lower, hyper[j, q], s)
        x[count] = samples[j]
        outputs[j, q, count] = values[j]
        extend(x, lower, hyper[j, q], count)
        counts[j, q] = count + 1
        _solve(lower, outputs[j, q], weights[j, q], count + 1)
        for d in range(x.shape[1]):
            total = 0.0
            for s in range(count + 1):
                total += x[s, d]
            centres[j, q, d] = total / (count + 1)


@compiled
def _place_for(centres: Floats, counts: Ints, hyper: Floats, sample: Floats, similar: float) -> int:
    """The most similar model (eq. 10); one not in use when that is not similar enough and there is one."""
    best, free, most = -1, -1, -inf
    for q in range(counts.shape[0]):
        if counts[q] == 0:
            free = q if free < 0 else free
            continue
        square = 0.0
        for d in range(sample.shape[0]):
            square += (sample[d] - centres[q, d]) ** 2
        likeness = -0.5 * hyper[q, 2] * square
        if likeness > most:
            best, most = q, likeness
    return free if free >= 0 and (best < 0 or exp(most) < similar) else best


@compiled
def extend(x: Floats, lower: Floats, hyper: Floats, count: int) -> None:
    """Row `count` of the Cholesky factor of the noisy covariance in O(N^2), the rows before it being there (eq. 15-17).

    Parameters
    ----------
    x : (N, D) samples; hyper : (4,) as in `numerics.local_gp.Hyper`.
    lower : (N, N), the row is written.
    """
    signal, bias, width, noise = hyper[0], hyper[1], hyper[2], hyper[3]
    own = signal + bias + noise
    left = own
    for s in range(count):
        square = 0.0
        for d in range(x.shape[1]):
            square += (x[count, d] - x[s, d]) ** 2
        total = signal * exp(-0.5 * width * square) + bias
        for r in range(s):
            total -= lower[s, r] * lower[count, r]
        lower[count, s] = total / lower[s, s]
        left -= lower[count, s] ** 2
    lower[count, count] = sqrt(max(left, 1e-12 * own))


@compiled
def _solve(lower: Floats, outputs: Floats, weights: Floats, count: int) -> None:
    """The prediction vectors alpha of eq. 8 into `weights`."""
    for p in range(outputs.shape[1]):
        for s in range(count):
            total = outputs[s, p]
            for r in range(s):
                total -= lower[s, r] * weights[r, p]
            weights[s, p] = total / lower[s, s]
        for s in range(count - 1, -1, -1):
            total = weights[s, p]
            for r in range(s + 1, count):
                total -= lower[r, s] * weights[r, p]
            weights[s, p] = total / lower[s, s]


@compiled
def _least(lower: Floats, weights: Floats, noise: float) -> int:
    """The sample of a full model whose loss changes the prediction at itself least (eq. 1-2)."""
    count, depth = weights.shape
    back = np.zeros((count, count))  # the inverse of the factor
    worst, least = 0, inf
    for s in range(count):
        back[s, s] = 1.0 / lower[s, s]
        for c in range(s):
            total = 0.0
            for r in range(c, s):
                total -= lower[s, r] * back[r, c]
            back[s, c] = total / lower[s, s]
    for s in range(count):
        diagonal = 0.0  # of the precision
        for r in range(s, count):
            diagonal += back[r, s] ** 2
        without = 1.0 / diagonal
        ratio = max(2.0 * noise - noise * noise * diagonal, 1e-12 * without) / without
        loss = depth * (ratio - 1.0 - log(ratio))
        for p in range(depth):
            loss += (weights[s, p] * (noise - without)) ** 2 / without
        if loss < least:
            worst, least = s, loss
    return worst
