"""The banded system of the missing samples of a process that looks two frames back, and how sure it leaves them."""

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled


@compiled
def gap_system(products: Floats, frame: Ints, channel: Ints, frames: int, band: int) -> Floats:
    """Lower bands of the second derivatives of sum over t >= 2 of |W0 x(t) + W1 x(t-1) + W2 x(t-2)|² / 2.

    Parameters
    ----------
    products : (3, 3, C, C) W_kᵀ W_l.
    frame, channel : (N,) of each missing sample, by frame.
    frames : T.
    band : samples, from the first of a frame to the last of the second frame after it at most.

    Returns
    -------
    (band, N) as `scipy.linalg.solveh_banded` has it with `lower`.
    """
    count = len(frame)
    lower = np.zeros((band, count))
    for i in range(count):
        for j in range(i, min(count, i + band)):
            apart = frame[j] - frame[i]
            if apart > 2:
                break
            total = 0.0
            for k in range(3 - apart):
                if 2 <= frame[j] + k < frames:
                    total += products[k, k + apart, channel[j], channel[i]]
            lower[j - i, i] = total
    return lower


@compiled
def gap_spread(factor: Floats, frame: Ints, channel: Ints, frames: int, channels: int) -> tuple[Floats, Floats]:
    """How far missing samples may be off, and what of it the surprises of a process take up.

    Only the elements of the inverse that lie within the band are worked out (Takahashi, Fagan and Chen, Formation of a
    sparse bus impedance matrix and its application to short circuit study, 8th PICA conference, 1973).

    Parameters
    ----------
    factor : (N, band) Cholesky factor of `gap_system`, what `scipy.linalg.cholesky_banded` has with `lower`, turned.
    frame, channel : (N,) of each missing sample, by frame.
    frames, channels : T, C.

    Returns
    -------
    variance : (N,).
    products : (3, 3, C, C); [k, l] is the sum over t >= 2 of the covariance of x(t-k) and x(t-l).
    """
    count, band = factor.shape
    variance, products = np.empty(count), np.zeros((3, 3, channels, channels))
    # row i % band: covariances of sample i with the `band` samples before and after it; later ones are forgotten
    inverse, row = np.zeros((band, 2 * band - 1)), np.empty(band)
    reach = count - 1  # the last sample within two frames; the factor holds nothing further
    for i in range(count - 1, -1, -1):
        while frame[reach] - frame[i] > 2:
            reach -= 1
        last, own = reach - i, 1.0 / factor[i, 0]
        row[: last + 1] = 0.0
        for e in range(1, last + 1):
            rule, other, start = factor[i, e] / factor[i, 0], (i + e) % band, band - 1 - e
            for d in range(1, last + 1):
                row[d] -= rule * inverse[other, start + d]
        for d in range(1, last + 1):
            own -= factor[i, d] * row[d]
            inverse[(i + d) % band, band - 1 - d] = row[d]
        row[0] = own / factor[i, 0]
        inverse[i % band, band - 1 : band + last] = row[: last + 1]
        variance[i] = row[0]
        for d in range(last + 1):
            apart = frame[i + d] - frame[i]
            for k in range(3 - apart):
                if 2 <= frame[i + d] + k < frames:
                    products[k, k + apart, channel[i + d], channel[i]] += row[d]
                    if d > 0:
                        products[k + apart, k, channel[i], channel[i + d]] += row[d]
    return variance, products
