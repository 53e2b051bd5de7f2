"""Factors of a posture one frame on: forecast, update, and what each group looks like to all others."""

from math import log, sqrt
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
    told, right = np.zeros((count, count)), np.zeros(count)
    for j in range(joints):
        if precision[j] == 0.0:
            continue
        for p in range(depth):
            for k in range(count):
                weighted = precision[j] * loadings[j, p, k]
                right[k] += weighted * values[j, p]
                for m in range(count):
                    told[k, m] += weighted * loadings[j, p, m]
    # (1 + told P) gain = told and (1 + told P) step = right - told mean, P the covariance of the factors themselves
    system, gain, step = np.zeros((count, count)), told.copy(), np.empty(count)
    for k in range(count):
        system[k, k] = 1.0
        step[k] = right[k]
        for n in range(count):
            step[k] -= told[k, n] * mean[n]
            for m in range(count):
                system[k, m] += told[k, n] * cov[n, m]
    _eliminate(system, gain, step)
    moved, after = mean.copy(), cov.copy()
    row = np.empty(count)
    for k in range(2 * count):
        row[:] = 0.0
        for n in range(count):
            moved[k] += cov[k, n] * step[n]
            for m in range(count):
                row[m] += cov[k, n] * gain[n, m]
        for n in range(count):  # along the rows of a symmetric matrix, for these lie in memory
            for m in range(2 * count):
                after[k, m] -= row[n] * cov[n, m]
    for k in range(2 * count):
        for m in range(k):
            after[m, k] = after[k, m]
    return moved, after


@compiled
def _eliminate(system: Floats, several: Floats, one: Floats) -> None:
    """Solve system x = several (K, K) and system x = one (K,) in place, by elimination with pivots by rows."""
    count = system.shape[0]
    for k in range(count):
        best = k
        for n in range(k + 1, count):
            if abs(system[n, k]) > abs(system[best, k]):
                best = n
        if best != k:
            for m in range(count):
                system[k, m], system[best, m] = system[best, m], system[k, m]
                several[k, m], several[best, m] = several[best, m], several[k, m]
            one[k], one[best] = one[best], one[k]
        scale = 1.0 / system[k, k]
        for n in range(k + 1, count):
            share = system[n, k] * scale
            if share == 0.0:
                continue
            one[n] -= share * one[k]
            for m in range(k + 1, count):
                system[n, m] -= share * system[k, m]
            for m in range(count):
                several[n, m] -= share * several[k, m]
    for k in range(count - 1, -1, -1):
        for n in range(k + 1, count):
            share = system[k, n]
            one[k] -= share * one[n]
            for m in range(count):
                several[k, m] -= share * several[n, m]
        scale = 1.0 / system[k, k]
        one[k] *= scale
        for m in range(count):
            several[k, m] *= scale


@compiled
def expected(loadings: Floats, mean: Floats, cov: Floats) -> Any:
    """Deviations (J, P) that the factors make, and the covariance (J, P, P) of each group's."""
    joints, depth, count = loadings.shape
    values, covs = np.zeros((joints, depth)), np.empty((joints, depth, depth))
    half = np.empty((depth, count))
    for j in range(joints):
        half[:] = 0.0
        for p in range(depth):
            for k in range(count):
                values[j, p] += loadings[j, p, k] * mean[k]
                for m in range(count):
                    half[p, m] += loadings[j, p, k] * cov[k, m]
        for p in range(depth):
            for q in range(p + 1):
                total = 0.0
                for k in range(count):
                    total += half[p, k] * loadings[j, q, k]
                covs[j, p, q] = covs[j, q, p] = total
    return values, covs


@compiled
def forecast(loadings: Floats, mean: Floats, cov: Floats, rates: Floats, seconds: float) -> Any:
    """Factors after a time as of `ahead`, and what they then make as of `expected`: in one call, for live frames."""
    moved, later = ahead(mean, cov, rates, seconds)
    values, covs = expected(loadings, moved, later)
    return moved, later, values, covs


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
    keep, back, free = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    far = np.empty(3)
    for j in range(len(rest)):
        for p in range(3):
            for q in range(3):
                keep[p, q] = (1.0 + 1e-9 if p == q else 0.0) - cov[j, p, q] * precision[j]
        _inverse(keep, back)
        for p in range(3):
            far[p] = 0.0
            for q in range(3):
                far[p] += back[p, q] * rest[j, q]
                free[p, q] = 0.0
                for r in range(3):
                    free[p, q] += back[p, r] * cov[j, r, q]
        for p in range(3):
            for q in range(3):
                keep[p, q] = 0.5 * (free[p, q] + free[q, p]) + (noise[j] if p == q else 0.0)
        size = _inverse(keep, back)
        square = 0.0
        for p in range(3):
            for q in range(3):
                square += far[p] * back[p, q] * far[q]
        found[j] = sqrt(max(square, 0.0))
        volume[j] = log(max(size, 1e-300))
    return found, volume


@compiled
def _inverse(matrix: Floats, out: Floats) -> float:
    """The inverse of a 3 x 3 matrix by cofactors into `out`, and the determinant."""
    for p in range(3):
        a, b = (p + 1) % 3, (p + 2) % 3
        for q in range(3):
            c, d = (q + 1) % 3, (q + 2) % 3
            out[q, p] = matrix[a, c] * matrix[b, d] - matrix[a, d] * matrix[b, c]
    size: float = matrix[0, 0] * out[0, 0] + matrix[0, 1] * out[1, 0] + matrix[0, 2] * out[2, 0]
    for p in range(3):
        for q in range(3):
            out[p, q] /= size
    return size
