"""Joints made steady while frames come: a Kalman filter for each, as lively as what it did not expect.

What is known of a joint is a row of ten numbers: its place and speed (3 each), in m and frames of a thirtieth of a
second, the variances of a coordinate of both, their covariance, and the variance by which speed drifts in a frame.
"""

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
STATE = 10
PLACE, SPEED, BOTH, DRIFT = 6, 7, 8, 9


@compiled
def steady_frame(positions: Floats, seconds: float, motion: Floats, later: Floats, steps: Floats) -> Any:
    """One live frame made steady, by what came before it and, where that is known, after it.

    Parameters
    ----------
    positions : (J, 3) m, NaN = missing.
    seconds : since the frame before; NaN = none.
    motion : (J, 10) of that one; NaN = not known.
    later : (N, J, 3) m, where joints are in the frames after it, NaN = not known.
    steps : (N,) s, each since the one before.

    Returns
    -------
    positions (J, 3), NaN where they came so, and motion (J, 10) by what came before alone.

    Source
    ------
    Rauch, Tung, Striebel, Maximum likelihood estimates of linear dynamic systems, 1965, for the frames after it.
    """
    calm, after = positions.copy(), np.full(motion.shape, np.nan)
    count = len(steps)
    expected, found = np.empty((count + 1, STATE)), np.empty((count + 1, STATE))
    for j in range(positions.shape[0]):
        if not _there(positions[j]):
            continue
        if 0.0 < seconds < LOST_SECONDS and isfinite(motion[j, 0]):
            _go_on(motion[j], RATE * seconds, expected[0])
            _meet(expected[0], positions[j], RATE * seconds, after[j])
        else:
            for d in range(3):
                after[j, d], after[j, 3 + d] = positions[j, d], 0.0
            after[j, PLACE], after[j, SPEED] = NOISE**2, BEGUN**2
            after[j, BOTH], after[j, DRIFT] = 0.0, CALMEST**2
        found[0] = after[j]
        known = 0
        for n in range(count):
            if not 0.0 < steps[n] < LOST_SECONDS:
                break
            _go_on(found[n], RATE * steps[n], expected[n + 1])
            if _there(later[n, j]):
                _meet(expected[n + 1], later[n, j], RATE * steps[n], found[n + 1])
                known = n + 1
            else:
                found[n + 1] = expected[n + 1]
        for n in range(known - 1, -1, -1):
            _look_back(found[n], expected[n + 1], found[n + 1], RATE * steps[n])
        calm[j] = found[0, :3]
    return calm, after


@compiled
def _there(place: Floats) -> bool:
    return isfinite(place[0]) and isfinite(place[1]) and isfinite(place[2])


@compiled
def _go_on(state: Floats, frames: float, ahead: Floats) -> None:
    """What is expected so many frames on, put into `ahead` (10,)."""
    kept = LASTING**frames
    place, speed, both, drift = state[PLACE], state[SPEED], state[BOTH], state[DRIFT]
    for d in range(3):
        ahead[d], ahead[3 + d] = state[d] + frames * state[3 + d], kept * state[3 + d]
    ahead[PLACE] = place + 2.0 * frames * both + frames**2 * speed + drift * frames**3 / 3.0
    ahead[BOTH] = kept * (both + frames * speed) + drift * frames**2 / 2.0
    ahead[SPEED], ahead[DRIFT] = kept**2 * speed + drift * frames, drift


@compiled
def _meet(ahead: Floats, seen: Floats, frames: float, state: Floats) -> None:
    """What is known with a place (3,) that is seen so many frames after the last one, put into `state` (10,)."""
    noise = NOISE**2 / min(frames, 1.0)  # frames that follow faster are no news
    gain, faster = ahead[PLACE] / (ahead[PLACE] + noise), ahead[BOTH] / (ahead[PLACE] + noise)
    surprise = 0.0
    for d in range(3):
        off = seen[d] - ahead[d]
        surprise += off * off / 3.0
        state[d], state[3 + d] = ahead[d] + gain * off, ahead[3 + d] + faster * off
    state[PLACE], state[BOTH] = (1.0 - gain) * ahead[PLACE], (1.0 - gain) * ahead[BOTH]
    state[SPEED] = ahead[SPEED] - faster * ahead[BOTH]
    lively = max(LIVELIER * (surprise - noise) / frames**2, CALMEST**2)
    state[DRIFT] = lively + exp(-frames / PASSING) * (ahead[DRIFT] - lively)


@compiled
def _look_back(state: Floats, ahead: Floats, later: Floats, frames: float) -> None:
    """A state (10,) by what is known so many frames later, where it had expected `ahead`: place and speed."""
    kept = LASTING**frames
    placed, both = state[PLACE] + frames * state[BOTH], kept * state[BOTH]
    going, speed = state[BOTH] + frames * state[SPEED], kept * state[SPEED]
    size = ahead[PLACE] * ahead[SPEED] - ahead[BOTH] ** 2
    for d in range(3):
        off, faster = later[d] - ahead[d], later[3 + d] - ahead[3 + d]
        to_place = (ahead[SPEED] * off - ahead[BOTH] * faster) / size
        to_speed = (ahead[PLACE] * faster - ahead[BOTH] * off) / size
        state[d] += placed * to_place + both * to_speed
        state[3 + d] += going * to_place + speed * to_speed
