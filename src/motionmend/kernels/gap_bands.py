"""The banded system of the missing samples of a process that looks two frames back."""

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
