"""Systems of successive moments, each tied to the line between its two neighbours: solved all at once."""

import numpy as np
from scipy.linalg import solveh_banded

from ..arrays import Floats

LIFT = 1e-3  # of a diagonal element, as Levenberg and Marquardt's
LEAST = 1e-9  # of the largest element: what nothing is known of stays


def chained(normal: Floats, right: Floats, bent: Floats, stiffness: Floats, share: Floats) -> Floats:
    """The steps x that minimise the sum over t of

        x_tᵀ N_t x_t - 2 r_tᵀ x_t + k_t (b_t + x_t - (1 - s_t) x_{t-1} - s_t x_{t+1})².

    Parameters
    ----------
    normal, right : (T, D, D) symmetric, positive semi-definite, and (T, D): N and r of each moment by itself.
    bent : (T, D) b, what each moment is off the line between its neighbours before the step.
    stiffness : (T, D) k, at least 0; those of the first and the last moment are not used.
    share : (T,) s, how far from the neighbour before to the one after a moment lies, 0 to 1.

    Returns
    -------
    (T, D); damped a little, by `LIFT` of the diagonal.
    """
    count, size = right.shape
    bands = np.zeros((3 * size, count, size))  # of the lower triangle: bands[k, t, d] is k rows below the diagonal
    for k in range(size):
        bands[k, :, : size - k] = np.diagonal(normal, -k, axis1=1, axis2=2)
    bands[0] += LIFT * bands[0] + LEAST * bands[0].max(initial=1e-300)
    wanted = right.copy()
    inner = slice(1, count - 1)
    hold, off = stiffness[inner], stiffness[inner] * bent[inner]
    before, after = -(1.0 - share[inner, None]), -share[inner, None]
    for at, much in ((slice(0, count - 2), before), (inner, 1.0), (slice(2, count), after)):
        bands[0, at] += much * much * hold
        wanted[at] -= much * off
    bands[size, : count - 2] += before * hold  # a moment and the one before
    bands[size, inner] += after * hold
    bands[2 * size, : count - 2] += before * after * hold  # its two neighbours
    solved = solveh_banded(bands.reshape(3 * size, -1), wanted.ravel(), lower=True, check_finite=False)
    return np.asarray(solved.reshape(count, size))
