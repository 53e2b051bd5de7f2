"""Small dense systems: what LAPACK needs longer to be called for than to solve."""

from math import atan2, sqrt

from ..arrays import Floats
from .compile import compiled


@compiled
def factored(matrix: Floats) -> bool:
    """Cholesky's factor of a symmetric positive definite matrix (D, D), in its lower triangle: only that is read.

    Returns
    -------
    False when the matrix is not positive definite; its lower triangle is then spoilt.
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
    return True


@compiled
def factor_and_solve(matrix: Floats, right: Floats) -> bool:
    """Solve a symmetric positive definite system by Cholesky, both arguments being overwritten.

    Parameters
    ----------
    matrix : (D, D), of which only the lower triangle is read; it becomes the factor.
    right : (D,) becomes the solution.

    Returns
    -------
    False when the matrix is not positive definite; `right` is then spoilt.
    """
    if not factored(matrix):
        return False
    size = matrix.shape[0]
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
    twice_x = twice_y = twice_z = trace = 0.0
    for k in range(3):  # of to · originᵀ what is needed
        twice_x += to[2, k] * origin[1, k] - to[1, k] * origin[2, k]
        twice_y += to[0, k] * origin[2, k] - to[2, k] * origin[0, k]
        twice_z += to[1, k] * origin[0, k] - to[0, k] * origin[1, k]
        trace += to[0, k] * origin[0, k] + to[1, k] * origin[1, k] + to[2, k] * origin[2, k]
    x, y, z = 0.5 * twice_x, 0.5 * twice_y, 0.5 * twice_z
    sine, cosine = sqrt(x * x + y * y + z * z), 0.5 * (trace - 1.0)
    angle = atan2(sine, cosine)
    scale = 1.0 if sine < 1e-9 else angle / sine
    vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z
    return angle


@compiled
def inverted(matrix: Floats, inverse: Floats) -> bool:
    """The inverse (D, D) of a symmetric positive definite matrix (D, D), whose lower triangle is overwritten.

    Returns
    -------
    False when the matrix is not positive definite; `inverse` is then spoilt.
    """
    if not factored(matrix):
        return False
    size = matrix.shape[0]
    # Rows of the inverse of the factor, each from those before it; then the product with its own transpose.
    for i in range(size):
        for k in range(size):
            inverse[i, k] = 0.0
        inverse[i, i] = 1.0
        for j in range(i):
            factor = matrix[i, j]
            for k in range(j + 1):
                inverse[i, k] -= factor * inverse[j, k]
        over = 1.0 / matrix[i, i]
        for k in range(i + 1):
            inverse[i, k] *= over
    for i in range(size):
        for k in range(i + 1):
            total = 0.0
            for j in range(i, size):
                total += inverse[j, i] * inverse[j, k]
            matrix[i, k] = total
    for i in range(size):
        for k in range(i + 1):
            inverse[i, k] = matrix[i, k]
            inverse[k, i] = matrix[i, k]
    return True
