"""Joints made steady while frames come: a Kalman filter for each, as lively as what it did not expect."""

from math import exp, isfinite
from typing import Any

import numpy as np

from ..arrays import Floats
from .compile import compiled

RATE = 30.0  # Hz, in whose frames time is counted here
NOISE = 0.006  # m, of a coordinate in a thirtieth of a second
BEGUN = 0.01  # m a frame, deviation of the speed of who is first seen
CALMEST = 0.001  # m a frame, by which speed drifts at least
LIVELIER = 0.1  # of what was not expected goes into that
PASSING = 5.0  # frames in which all but a share of 1 / e of it is forgotten
LASTING = 0.9  # of its speed that a joint keeps in a frame: the past alone cannot tell when it will stop
LOST_SECONDS = 0.5  # nothing is known of a joint after so long
STATE = 10  # place and speed (3 each), their variances and covariance, drift


@compiled
def steady_frame(positions: Floats, seconds: float, motion: Floats) -> Any:
    """One live frame made steady.

    Parameters
    ----------
    positions : (J, 3) m, NaN = missing.
    seconds : since the frame before; NaN = none.
    motion : (J, 10) of it: place and speed, in m and frames of a thirtieth of a second, the variance of a coordinate of
        each, their covariance, and the variance by which speed drifts in a frame; NaN = not known.

    Returns
    -------
    positions (J, 3), NaN where they came so, and motion (J, 10).
    """
    calm, after = positions.copy(), np.full(motion.shape, np.nan)
    frames = RATE * seconds
    known = 0.0 < seconds < LOST_SECONDS
    for j in range(positions.shape[0]):
        if not (isfinite(positions[j, 0]) and isfinite(positions[j, 1]) and isfinite(positions[j, 2])):
            continue
        if not (known and isfinite(motion[j, 0])):
            for d in range(3):
                after[j, d], after[j, 3 + d] = positions[j, d], 0.0
            after[j, 6], after[j, 7], after[j, 8], after[j, 9] = NOISE**2, BEGUN**2, 0.0, CALMEST**2
            continue
        noise = NOISE**2 / min(frames, 1.0)  # frames that follow faster are no news
        kept = LASTING**frames
        place, speed, both, drift = motion[j, 6], motion[j, 7], motion[j, 8], motion[j, 9]
        place += 2.0 * frames * both + frames**2 * speed + drift * frames**3 / 3.0
        both = kept * (both + frames * speed) + drift * frames**2 / 2.0
        speed = kept**2 * speed + drift * frames
        surprise = 0.0
        for d in range(3):
            surprise += (positions[j, d] - motion[j, d] - frames * motion[j, 3 + d]) ** 2 / 3.0
        gain, faster = place / (place + noise), both / (place + noise)
        for d in range(3):
            ahead = motion[j, d] + frames * motion[j, 3 + d]
            calm[j, d] = ahead + gain * (positions[j, d] - ahead)
            after[j, d] = calm[j, d]
            after[j, 3 + d] = kept * motion[j, 3 + d] + faster * (positions[j, d] - ahead)
        after[j, 6], after[j, 7], after[j, 8] = (1.0 - gain) * place, speed - faster * both, (1.0 - gain) * both
        lively = max(LIVELIER * (surprise - noise) / frames**2, CALMEST**2)
        after[j, 9] = lively + exp(-frames / PASSING) * (drift - lively)
    return calm, after
