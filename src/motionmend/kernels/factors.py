"""Factors of a posture one frame on: forecast, update, and what each group looks like to all others."""

from typing import Any

import numpy as np

from ..arrays import Floats
from .compile import compiled


@compiled
def ahead(mean: Floats, cov: Floats, rates: Floats, seconds: float) -> Any:
    """Mean (2K,) and covariance (2K, 2K) of factors and speeds after a time: each a Matern-3/2 process of variance 1.

    The process turns each factor and its speed by a 2 x 2 matrix of their own, so blocks are enough.
    """
    count = len(rates)
    a, b, c, d = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    for k in range(count):
        rate = rates[k]
        decay = np.exp(-rate * seconds)
        a[k], b[k] = decay * (1.0 + rate * seconds), decay * seconds
        c[k], d[k] = -decay * rate * rate * seconds, decay * (1.0 - rate * seconds)
    moved = np.empty(2 * count)
    later = np.empty((2 * count, 2 * count))
    for k in range(count):
        moved[k] = a[k] * mean[k] + b[k] * mean[k + count]
        moved[k + count] = c[k] * mean[k] + d[k] * mean[k + count]
        for m in range(count):
            pp, pv, vp, vv = cov[k, m], cov[k, m + count], cov[k + count, m], cov[k + count, m + count]
            left_p, left_v = a[k] * pp + b[k] * vp, a[k] * pv + b[k] * vv
            low_p, low_v = c[k] * pp + d[k] * vp, c[k] * pv + d[k] * vv
            later[k, m] = left_p * a[m] + left_v * b[m]
            later[k, m + count] = left_p * c[m] + left_v * d[m]
            later[k + count, m] = low_p * a[m] + low_v * b[m]
            later[k + count, m + count] = low_p * c[m] + low_v * d[m]
        square = rates[k] * rates[k]
        later[k, k] += 1.0 - a[k] * a[k] - b[k] * b[k] * square
        cross = -a[k] * c[k] - b[k] * d[k] * square
        later[k, k + count] += cross
        later[k + count, k] += cross
        later[k + count, k + count] += square - c[k] * c[k] - d[k] * d[k] * square
    return moved, later


@compiled
def seen(loadings: Floats, mean: Floats, cov: Floats, values: Floats, precision: Floats) -> Any:
    """Mean (2K,) and covariance (2K, 2K) after groups were seen.

    Parameters
    ----------
    loadings : (J, P, K) C-contiguous.
    values : (J, P) deviations from the mean, finite.
    precision : (J,) one over the variance of each coordinate; 0 = not seen.
    """
    joints, depth, count = loadings.shape
    flat = loadings.reshape(joints * depth, count)
    weighted = np.empty((joints * depth, count))
    told_values = np.zeros(count)
    for j in range(joints):
        for p in range(depth):
            for k in range(count):
                weighted[j * depth + p, k] = precision[j] * loadings[j, p, k]
                told_values[k] += weighted[j * depth + p, k] * values[j, p]
    told = np.dot(weighted.T, flat)
    inner = np.ascontiguousarray(cov[:count, :count])
    right = np.empty((count, count + 1))
    right[:, :count] = told
    right[:, count] = told_values - np.dot(told, mean[:count])
    gain = np.linalg.solve(np.eye(count) + np.dot(told, inner), right)
    tall = np.ascontiguousarray(cov[:, :count])
    after = cov - np.dot(np.dot(tall, np.ascontiguousarray(gain[:, :count])), tall.T)
    moved = mean + np.dot(tall, np.ascontiguousarray(gain[:, count]))
    for k in range(2 * count):
        for m in range(k):
            after[k, m] = after[m, k] = 0.5 * (after[k, m] + after[m, k])
    return moved, after


@compiled
def expected(loadings: Floats, mean: Floats, cov: Floats) -> Any:
    """Deviations (J, P) that the factors make, and the covariance (J, P, P) of each group's."""
    joints, depth, count = loadings.shape
    flat = loadings.reshape(joints * depth, count)
    values = np.dot(flat, mean[:count]).reshape(joints, depth)
    half = np.dot(flat, np.ascontiguousarray(cov[:count, :count]))
    covs = np.empty((joints, depth, depth))
    for j in range(joints):
        for p in range(depth):
            for q in range(depth):
                total = 0.0
                for k in range(count):
                    total += half[j * depth + p, k] * flat[j * depth + q, k]
                covs[j, p, q] = total
    return values, covs


@compiled
def left_out(rest: Floats, cov: Floats, noise: Floats, precision: Floats) -> Any:
    """How far each group of three coordinates is from where all others expect it.

    With leverage h = cov * precision the residual without the group itself is (1 - h)^-1 rest (as in PRESS), and its
    covariance noise + (1 - h)^-1 cov. A group that was not seen (precision 0) is as far as its residual says.

    Parameters
    ----------
    rest : (J, 3) value less what is expected.
    cov : (J, 3, 3) of what is expected.
    noise : (J,) variance of a coordinate.
    precision : (J,) with which the group itself was seen.

    Returns
    -------
    distance (J,) by Mahalanobis, and volume (J,), the logarithm of the determinant of the covariance.
    """
    found, volume = np.empty(len(rest)), np.empty(len(rest))
    for j in range(len(rest)):
        keep = np.eye(3) * (1.0 + 1e-9) - cov[j] * precision[j]
        right = np.empty((3, 4))
        right[:, 0] = rest[j]
        right[:, 1:] = cov[j]
        free = np.linalg.solve(keep, right)
        whole = 0.5 * (free[:, 1:] + free[:, 1:].T) + noise[j] * np.eye(3)
        far = np.ascontiguousarray(free[:, 0])
        found[j] = np.sqrt(max(np.dot(far, np.linalg.solve(whole, far)), 0.0))
        volume[j] = np.log(max(np.linalg.det(whole), 1e-300))
    return found, volume
