"""Corrected joints made steady: as much as the sensor's own noise asks for, and no quick move less quick.

The temporal term of eq. 20 over a whole recording is Whittaker's smoother. One weight for all of it either leaves the
noise or takes the peaks of quick moves. Two things are read off the recording instead: the noise of each joint, by what
is left above 4 Hz in the median frame, and how sharply the joint turns about each moment, by its slow course. Their
ratio is the weight of that moment. A sensor also throws joints away for a frame or two; residuals that are large count
by their size, not by its square. What is quick, in the middle one of three frames and for a tenth of a second, stays as
it came.
"""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import make_interp_spline

from ..arrays import Bools, Floats, Ints
from ..kernels.bones import BREAK_STEPS
from ..numerics.whittaker import whittaker

STILLEST = 2.3  # weight of second differences by that of the values, at 30 Hz: half passes at 4 Hz, the rest is noise
NOISIER, MOST = 1.7, 0.006  # times the median of that rest; and m, at most: where all is quick it is motion
COURSE = 14.0  # as STILLEST, of the slow course by which a joint is seen to turn: half passes at 2.5 Hz
ABOUT = 520.0  # and of how sharply it turns, which is asked of about a second
CALMEST = 0.4 / 30.0**2  # m by (1/30 s)²: who rests is let go by 0.4 m/s²
OUTLYING = 2.5  # standard deviations from which on a residual counts by its size, not by its square
ROUNDS = 5  # of weighing residuals
FEWEST = 10  # frames in a row: fewer do not show how sharply a joint turns
GUESSED = 0.1  # weight of a frame in which the joint is not believed
QUICK, TREMBLES = 0.6, 0.01  # m/s; and m of noise, by whose cube it takes more: what trembles widely looks quick
MOVE = 0.1  # s that a quick move takes
SHARPLY = 8.0  # power by which a move above that speed is left alone


def steadied(positions: Floats, times: Floats, trust: Floats) -> Floats:
    """(T, J, 3) each joint made as steady as its noise, and how sharply it turns, make likeliest; quick moves stay.

    Parameters
    ----------
    positions : (T, J, 3) m; NaN = missing.
    times : (T,) s.
    trust : (T, J) in [0, 1].
    """
    usual = _usual_step(times)
    steady = np.array(positions)
    if usual <= 0:
        return steady
    noise = _noise(positions - smoothed(positions, times, STILLEST))
    rate = (1.0 / (30.0 * usual)) ** 4
    for joints, frames, at in _stretches(positions, times, usual):
        if len(frames) < FEWEST:
            continue
        some, shape = np.ix_(frames, joints), (at[-1] + 1, len(joints))
        values, believed, weights = np.zeros((*shape, 3)), np.zeros(shape), np.zeros(shape)
        values[at], believed[at] = positions[some], trust[some]
        weights[at] = np.maximum(trust[some], GUESSED)
        turning = _turning(values, weights > 0, rate)
        quick = _speed(positions[some], at, usual) / np.hypot(QUICK, (noise[joints] / TREMBLES) ** 3)
        for k, j in enumerate(joints):
            variance = min(NOISIER * noise[j], MOST) ** 2
            if variance > 0:
                much = 1.0 + believed[:, k] * quick[:, k] ** SHARPLY
                penalty = rate * variance / (turning[:, k] * much)
                steady[frames, j] = _likeliest(values[:, k], weights[:, k], variance * much, penalty)[at]
    return steady


def smoothed(values: Floats, times: Floats, weight: float) -> Floats:
    """(T, J, 3) each joint smoothed where it is seen without a long break; what is missing stays so.

    Parameters
    ----------
    weight : of the second differences by that of the values, at 30 Hz.
    """
    usual = _usual_step(times)
    steady = np.array(values)
    if usual <= 0:
        return steady
    smoothness = weight * (1.0 / (30.0 * usual)) ** 4
    for joints, frames, at in _stretches(values, times, usual):
        flat, weights = np.zeros((at[-1] + 1, 3 * len(joints))), np.zeros(at[-1] + 1)
        flat[at], weights[at] = values[np.ix_(frames, joints)].reshape(len(frames), -1), 1.0
        steady[np.ix_(frames, joints)] = whittaker(flat, weights, smoothness)[at].reshape(len(frames), -1, 3)
    return steady


def _usual_step(times: Floats) -> float:
    """s between frames; 0 where that is not known."""
    return float(np.median(np.diff(times))) if len(times) > 1 else 0.0


def _stretches(values: Floats, times: Floats, usual: float) -> Iterator[tuple[Ints, Ints, Ints]]:
    """Joints that are seen in the same frames, those frames up to a long break, and each one's place in usual steps of
    time: frames that were dropped, or in which nobody is seen, take their time all the same."""
    there = np.isfinite(values).all(axis=2)
    patterns, same = np.unique(there, axis=1, return_inverse=True)
    for k, pattern in enumerate(patterns.T):
        joints, seen = np.flatnonzero(same.ravel() == k), np.flatnonzero(pattern)
        steps = np.diff(times[seen])
        for stretch in np.split(seen, np.flatnonzero((steps > BREAK_STEPS * usual) | (steps <= 0)) + 1):
            if len(stretch) >= 4:
                passed = np.maximum(np.rint(np.diff(times[stretch]) / usual), 1)
                yield joints, stretch, np.cumsum(np.append(0, passed)).astype(int)


def _noise(rest: Floats) -> Floats:
    """(J,) m, root mean square of a coordinate of what is left (T, J, 3), in the median frame; 0 if there is none."""
    sizes = np.sqrt((rest * rest).sum(axis=2) / 3.0)
    return np.array([np.median(one[np.isfinite(one)]) if np.isfinite(one).any() else 0.0 for one in sizes.T])


def _turning(values: Floats, seen: Bools, rate: float) -> Floats:
    """(T, J) variance of second differences, of a coordinate at 30 Hz, that joints (T, J, 3) show about each moment."""
    frames, joints = seen.shape
    course = whittaker(values.reshape(frames, -1), seen[:, 0].astype(np.float64), COURSE * rate)
    turns = np.zeros((frames, joints))
    turns[1:-1] = np.square(np.diff(course, 2, axis=0)).reshape(-1, joints, 3).mean(axis=2) * rate
    around = whittaker(turns, np.ones(frames), ABOUT * rate)
    return np.asarray(np.maximum(around, 0.0) + CALMEST**2)


def _speed(values: Floats, at: Ints, usual: float) -> Floats:
    """(T, J) m/s, how quick joints (F, J, 3) are in the quickest tenth of a second about each step of time.

    Parameters
    ----------
    at : (F,) the step of each frame, from 0 to T - 1. usual : s, a step.
    """
    course = make_interp_spline(at, _middle_of_three(values), k=1)(np.arange(at[-1] + 1))
    apart = min(max(1, round(MOVE / usual)), at[-1])
    away = course[apart:] - course[:-apart]
    going = np.sqrt((away * away).sum(axis=2)) / (apart * usual)
    padded = np.pad(going, ((apart, apart), (0, 0)))
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, apart + 1, axis=0).max(axis=2))


def _middle_of_three(values: Floats) -> Floats:
    """(F, J, 3) of three places in a row, about each frame, the one that is nearest to both others."""
    middle = np.clip(np.arange(len(values)), 1, len(values) - 2)
    three = values[np.stack([middle, middle - 1, middle + 1])]
    apart = three - np.roll(three, 1, axis=0)
    far = np.sqrt((apart * apart).sum(axis=3))
    nearest = np.argmin(far + np.roll(far, -1, axis=0), axis=0)
    return np.asarray(np.take_along_axis(three, nearest[None, ..., None], axis=0)[0])


def _likeliest(values: Floats, weights: Floats, variance: Floats, penalty: Floats) -> Floats:
    """(T, 3) the course that is near and bends little: under Charbonnier's estimator, by weights that are renewed.

    Parameters
    ----------
    values, weights : (T, 3) m and (T,), 0 = missing. variance : (T,) m² of a residual. penalty : (T,) of its bends.
    """
    course = whittaker(values, weights, penalty)
    for _ in range(ROUNDS):
        off = np.square(values - course).sum(axis=1) / variance
        course = whittaker(values, weights / np.sqrt(1.0 + off / OUTLYING**2), penalty)
    return course
