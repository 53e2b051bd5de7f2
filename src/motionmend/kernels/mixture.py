"""Mean and variance of the nearest local Gaussian processes, all joints of all frames in one call."""

from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled


@compiled
def predict(
    centres: Floats,
    inputs: Floats,
    factors: Floats,
    weights: Floats,
    counts: Ints,
    hyper: Floats,
    queries: Floats,
    nearest: int,
) -> Any:
    """Weighted prediction of the most similar local models (algorithm 1, eq. 10-13).

    Parameters
    ----------
    centres : (J, Q, D).
    inputs : (J, Q, S, D).
    factors : (J, Q, S, S) lower Cholesky factors of the noisy covariances.
    weights : (J, Q, S, P) prediction vectors.
    counts : (J, Q) samples in use; 0 = the model is not used.
    hyper : (J, Q, 4) signal, bias, width (inverse squared length), noise.
    queries : (T, J, D).
    nearest : L.

    Returns
    -------
    means (T, J, P), variances (T, J): of the mixture, so that disagreement of the models counts.
    """
    frames, joints, wide = queries.shape
    models, size, depth = centres.shape[1], inputs.shape[2], weights.shape[3]
    means = np.zeros((frames, joints, depth))
    variances = np.full((frames, joints), np.inf)
    likeness = np.empty(models)
    cross = np.empty(size)
    local = np.empty(depth)
    second = np.empty(depth)
    for t in range(frames):
        for j in range(joints):
            used = 0
            for q in range(models):
                likeness[q] = -np.inf
                if counts[j, q] > 0:
                    used += 1
                    square = 0.0
                    for d in range(wide):
                        apart = queries[t, j, d] - centres[j, q, d]
                        square += apart * apart
                    likeness[q] = -0.5 * hyper[j, q, 2] * square  # logarithm of eq. 10
            if used == 0:
                continue
            total = 0.0
            variance = 0.0
            best = 0.0
            second[:] = 0.0
            for place in range(min(nearest, used)):
                q = int(np.argmax(likeness))
                if place == 0:
                    best = likeness[q]
                weight = np.exp(likeness[q] - best)
                likeness[q] = -np.inf
                if weight < 1e-12:
                    break
                signal, bias, width, count = hyper[j, q, 0], hyper[j, q, 1], hyper[j, q, 2], counts[j, q]
                local[:] = 0.0
                known = 0.0
                for s in range(count):
                    square = 0.0
                    for d in range(wide):
                        apart = queries[t, j, d] - inputs[j, q, s, d]
                        square += apart * apart
                    value = signal * np.exp(-0.5 * width * square) + bias
                    for p in range(depth):
                        local[p] += value * weights[j, q, s, p]  # eq. 8
                    for r in range(s):
                        value -= factors[j, q, s, r] * cross[r]
                    cross[s] = value / factors[j, q, s, s]
                    known += cross[s] * cross[s]
                variance += weight * max(signal + bias - known, 0.0)  # eq. 9
                total += weight
                for p in range(depth):
                    means[t, j, p] += weight * local[p]
                    second[p] += weight * local[p] * local[p]
            spread = 0.0
            for p in range(depth):
                means[t, j, p] /= total
                spread += second[p] / total - means[t, j, p] * means[t, j, p]
            variances[t, j] = variance / total + max(spread, 0.0) / depth
    return means, variances
