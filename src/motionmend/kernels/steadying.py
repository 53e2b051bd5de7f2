"""Joints made steady while frames come: a Kalman filter for each, as lively as its innovations are alike.

Noise makes innovations that point this way and that, motion such that point the same way in one frame after the other:
the product of a frame's innovation with that of the frame before says how freely the joint's speed changes just now.

What is known of a joint is a row of thirteen numbers: its place and speed (3 each), in m and frames of a thirtieth of a
second, the variances of a coordinate of both, their covariance, the variance by which speed drifts in a frame, and the
last innovation (3).
"""

from math import exp, isfinite
from typing import Any

import numpy as np

from ..arrays import Floats
from .compile import compiled
from .putting import put

RATE = 30.0  # Hz, in whose frames time is counted here
NOISE = 0.005  # m, of a coordinate in a thirtieth of a second
BEGUN = 0.03  # m a frame, deviation of the speed of who is first seen
CALMEST = 0.001  # m a frame, by which speed drifts at least
ROUSED, RESTED = 1.0, 4.0  # frames in which all but a share of 1 / e of a livelier, or a calmer, motion is believed
SHORTEST, LONGEST = 0.0025, 0.5  # s, beyond which the time since the frame before says nothing
STATE = 13
PLACE_VAR, SPEED_VAR, COVARIANCE, DRIFT, INNOVATION = 6, 7, 8, 9, 10


@compiled
def steady_frame(
    positions: Floats, seconds: float, motion: Floats, later: Floats, steps: Floats, shaking: float
) -> Any:
    """One live frame made steady, by what came before it and, where that is known, after it.

    Parameters
    ----------
    positions : (J, 3) m, NaN = missing.
    seconds : since the frame before; NaN = none, or not known.
    motion : (J, 13) of that one; NaN = not known.
    later : (N, J, 3) m, where joints are in the frames after it, NaN = not known.
    steps : (N,) s, each since the one before.
    shaking : m, deviation of a coordinate by which all joints shake; less than `NOISE` is usual.

    Returns
    -------
    positions (J, 3), NaN where they came so, and motion (J, 13) by what came before alone.

    Source
    ------
    Rauch, Tung, Striebel, Maximum likelihood estimates of linear dynamic systems, 1965, for the frames after it.
    """
    calm, after = positions.copy(), np.full(motion.shape, np.nan)
    count, noise = len(steps), max(NOISE, shaking) ** 2
    expected, found = np.empty((count + 1, STATE)), np.empty((count + 1, STATE))
    for j in range(positions.shape[0]):
        if not _there(positions[j]):
            continue
        if told(seconds) and isfinite(motion[j, 0]):
            _predict(motion[j], RATE * seconds, expected[0])
            _update(expected[0], positions[j], RATE * seconds, noise, after[j])
        else:
            for d in range(3):
                after[j, d], after[j, 3 + d] = positions[j, d], 0.0
            after[j, PLACE_VAR], after[j, SPEED_VAR] = noise, BEGUN**2
            after[j, COVARIANCE], after[j, DRIFT] = 0.0, CALMEST**2
            after[j, INNOVATION:] = 0.0
        found[0] = after[j]
        known = 0
        for n in range(count):
            if not told(steps[n]):
                break
            _predict(found[n], RATE * steps[n], expected[n + 1])
            if _there(later[n, j]):
                _update(expected[n + 1], later[n, j], RATE * steps[n], noise, found[n + 1])
                known = n + 1
            else:
                found[n + 1] = expected[n + 1]
        for n in range(known - 1, -1, -1):
            _smooth_back(found[n], expected[n + 1], found[n + 1], RATE * steps[n])
        calm[j] = found[0, :3]
    return calm, after


@compiled
def told(seconds: float) -> bool:
    """Whether so long a time says how far joints went on."""
    return SHORTEST < seconds < LONGEST


@compiled
def _there(place: Floats) -> bool:
    return isfinite(place[0]) and isfinite(place[1]) and isfinite(place[2])


@compiled
def _predict(state: Floats, frames: float, ahead: Floats) -> None:
    """What is expected so many frames on, put into `ahead` (13,)."""
    put(ahead, state)
    drift = state[DRIFT]
    for d in range(3):
        ahead[d] += frames * state[3 + d]
    ahead[PLACE_VAR] += 2.0 * frames * state[COVARIANCE] + frames**2 * state[SPEED_VAR] + drift * frames**3 / 3.0
    ahead[COVARIANCE] += frames * state[SPEED_VAR] + drift * frames**2 / 2.0
    ahead[SPEED_VAR] += drift * frames


@compiled
def _update(ahead: Floats, seen: Floats, frames: float, noise: float, state: Floats) -> None:
    """What is known with a place (3,) that is seen so many frames after the last one, its coordinates of the variance
    `noise` in m², put into `state` (13,).

    A livelier motion than was expected counts in this frame already, and is put into `ahead`, too.
    """
    alike = 0.0
    for d in range(3):
        off = seen[d] - ahead[d]
        alike += off * ahead[INNOVATION + d] / 3.0
        state[INNOVATION + d] = off
    alike -= noise - NOISE**2  # as much as innovations are alike by chance where all shakes
    lively, drift = max(alike / frames**2, CALMEST**2), ahead[DRIFT]
    drift = lively + exp(-frames / (ROUSED if lively > drift else RESTED)) * (drift - lively)
    more = max(drift - ahead[DRIFT], 0.0)
    ahead[PLACE_VAR] += more * frames**3 / 3.0
    ahead[COVARIANCE] += more * frames**2 / 2.0
    ahead[SPEED_VAR] += more * frames
    place, both = ahead[PLACE_VAR], ahead[COVARIANCE]
    noise /= min(frames, 1.0)  # frames that follow faster are no news
    gain, faster = place / (place + noise), both / (place + noise)
    for d in range(3):
        off = state[INNOVATION + d]
        state[d], state[3 + d] = ahead[d] + gain * off, ahead[3 + d] + faster * off
    state[PLACE_VAR], state[COVARIANCE] = (1.0 - gain) * place, (1.0 - gain) * both
    state[SPEED_VAR], state[DRIFT] = ahead[SPEED_VAR] - faster * both, drift


@compiled
def _smooth_back(state: Floats, ahead: Floats, later: Floats, frames: float) -> None:
    """A state (13,) by what is known so many frames later, where it had expected `ahead`: place and speed."""
    placed, going = state[PLACE_VAR] + frames * state[COVARIANCE], state[COVARIANCE] + frames * state[SPEED_VAR]
    size = ahead[PLACE_VAR] * ahead[SPEED_VAR] - ahead[COVARIANCE] ** 2
    for d in range(3):
        off, faster = later[d] - ahead[d], later[3 + d] - ahead[3 + d]
        to_place = (ahead[SPEED_VAR] * off - ahead[COVARIANCE] * faster) / size
        to_speed = (ahead[PLACE_VAR] * faster - ahead[COVARIANCE] * off) / size
        state[d] += placed * to_place + state[COVARIANCE] * to_speed
        state[3 + d] += going * to_place + state[SPEED_VAR] * to_speed
