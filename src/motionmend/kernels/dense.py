"""Small dense systems: what LAPACK needs longer to be called for than to solve."""

from math import atan2, sqrt

from ..arrays import Floats
from .compile import compiled


@compiled
def factor_and_solve(matrix: Floats, right: Floats) -> bool:
    """Solve a symmetric positive definite system by Cholesky, both arguments being overwritten.

    Parameters
    ----------
    matrix : (D, D); its lower triangle becomes the factor.
    right : (D,) becomes the solution.

    Returns
    -------
    False when the matrix is not positive definite; `right` is then spoilt.
    """
    size = matrix.shape[0]
    for j in range(size):
        for i in range(j, size):
            value = matrix[i, j]
            for k in range(j):
                value -= matrix[i, k] * matrix[j, k]
            if i == j:
                if not value > 0.0:
                    return False
                matrix[j, j] = sqrt(value)
            else:
                matrix[i, j] = value / matrix[j, j]
    for i in range(size):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]
    return True


@compiled
def turn_between(to: Floats, origin: Floats, vector: Floats) -> float:
    """The rotation vector (3,) of `to` · `origin`ᵀ, both (3, 3) rotations, and its angle, rad.

    Within 1e-6 rad of half a turn the axis is not told apart from noise.
    """
    m = to @ origin.T
    x, y, z = 0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1])
    sine, cosine = sqrt(x * x + y * y + z * z), 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = atan2(sine, cosine)
    scale = 1.0 if sine < 1e-9 else angle / sine
    vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z
    return angle
