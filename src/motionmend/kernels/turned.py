"""Frames that move with a group of points: where they are and how they are turned."""

from typing import Any

import numpy as np

from ..arrays import Floats
from .compile import compiled

SWEEPS = 12  # of rotations; four or five are needed
ENOUGH = 1e-32  # of the squared size of a matrix, that is left beside its diagonal


@compiled
def places_and_axes(points: Floats, weights: Floats, shape: Floats) -> Any:
    """Weighted mean of some points, and the rotation that takes their shape closest to them, never a mirroring.

    Parameters
    ----------
    points : (T, A, 3) m, finite.
    weights : (A,) sum 1.
    shape : (A, 3) m about its own weighted mean, times the weights.

    Returns
    -------
    place : (T, 3) m.
    axes : (T, 3, 3), the frame's axes in columns.

    Source
    ------
    Horn, Closed-form solution of absolute orientation using unit quaternions, Journal of the Optical Society of America
    A 4(4), 1987; the largest eigenvector by Jacobi's rotations, which stay exact where points lie in a plane.
    """
    frames, count = points.shape[0], points.shape[1]
    place, axes = np.zeros((frames, 3)), np.empty((frames, 3, 3))
    s, n, v = np.empty((3, 3)), np.empty((4, 4)), np.empty((4, 4))
    for t in range(frames):
        for a in range(count):
            for i in range(3):
                place[t, i] += weights[a] * points[t, a, i]
        s[:, :] = 0.0
        for a in range(count):
            for i in range(3):
                for j in range(3):
                    s[i, j] += shape[a, i] * (points[t, a, j] - place[t, j])
        n[0, 0] = s[0, 0] + s[1, 1] + s[2, 2]
        n[1, 1] = s[0, 0] - s[1, 1] - s[2, 2]
        n[2, 2] = s[1, 1] - s[0, 0] - s[2, 2]
        n[3, 3] = s[2, 2] - s[0, 0] - s[1, 1]
        n[0, 1] = n[1, 0] = s[1, 2] - s[2, 1]
        n[0, 2] = n[2, 0] = s[2, 0] - s[0, 2]
        n[0, 3] = n[3, 0] = s[0, 1] - s[1, 0]
        n[1, 2] = n[2, 1] = s[0, 1] + s[1, 0]
        n[1, 3] = n[3, 1] = s[2, 0] + s[0, 2]
        n[2, 3] = n[3, 2] = s[1, 2] + s[2, 1]
        best = _diagonalised(n, v)
        w, x, y, z = v[0, best], v[1, best], v[2, best], v[3, best]
        axes[t, 0, 0] = w * w + x * x - y * y - z * z
        axes[t, 1, 1] = w * w - x * x + y * y - z * z
        axes[t, 2, 2] = w * w - x * x - y * y + z * z
        axes[t, 0, 1], axes[t, 1, 0] = 2.0 * (x * y - w * z), 2.0 * (x * y + w * z)
        axes[t, 0, 2], axes[t, 2, 0] = 2.0 * (x * z + w * y), 2.0 * (x * z - w * y)
        axes[t, 1, 2], axes[t, 2, 1] = 2.0 * (y * z - w * x), 2.0 * (y * z + w * x)
    return place, axes


@compiled
def _diagonalised(n: Floats, v: Floats) -> int:
    """Diagonalise a symmetric matrix (4, 4) in place; its eigenvectors become the columns of `v`.

    The number of that with the largest eigenvalue is given back.
    """
    size = 0.0
    for i in range(4):
        for j in range(4):
            v[i, j] = 1.0 if i == j else 0.0
            size += n[i, j] * n[i, j]
    for _ in range(SWEEPS):
        beside = 0.0
        for i in range(3):
            for j in range(i + 1, 4):
                beside += n[i, j] * n[i, j]
        if beside <= ENOUGH * size:
            break
        for i in range(3):
            for j in range(i + 1, 4):
                if n[i, j] != 0.0:
                    half = 0.5 * (n[j, j] - n[i, i]) / n[i, j]
                    tangent = 1.0 / (abs(half) + np.sqrt(half * half + 1.0))
                    if half < 0.0:
                        tangent = -tangent
                    cosine = 1.0 / np.sqrt(tangent * tangent + 1.0)
                    sine = tangent * cosine
                    for k in range(4):
                        n[k, i], n[k, j] = cosine * n[k, i] - sine * n[k, j], sine * n[k, i] + cosine * n[k, j]
                    for k in range(4):
                        n[i, k], n[j, k] = cosine * n[i, k] - sine * n[j, k], sine * n[i, k] + cosine * n[j, k]
                        v[k, i], v[k, j] = cosine * v[k, i] - sine * v[k, j], sine * v[k, i] + cosine * v[k, j]
    best = 0
    for i in range(1, 4):
        if n[i, i] > n[best, best]:
            best = i
    return best
