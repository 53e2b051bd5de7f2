"""Corrected joints made steady: as far, at each moment, as that brings them nearer to where they were.

The temporal term of eq. 20 over a whole recording is Whittaker's smoother. One weight for all of it either leaves the
noise or takes the peaks of quick moves, and who shakes at 5 Hz is taken for noise. The noise of each joint is read off
the recording by differences of a high order, which those of motion are small beside; then Stein's estimate says at each
moment how much farther from the truth each weight leaves a joint, and the weights share it by that. What a sensor
throws away for a frame is brought near first, and what is quick for a tenth of a second stays as it came.
"""

from collections.abc import Iterator, Sequence
from math import comb

import numpy as np

from ..arrays import Floats, Ints
from ..numerics.whittaker import response, whittaker

WEIGHTS = 104.0, 13.9, 2.28, 0.524, 0.152  # of second differences, at 30 Hz: half passes at 1.5, 2.5, 4, 6 and 9 Hz
DOUBTED = 2.28  # that of a joint which is not believed
ORDER, USUAL = 6, 2.366  # of the differences that tell noise, and median of chi2(3)
NOISIER, MOST = 1.5, 0.02  # times what they say, for a sensor's noise is partly slow; and m, at most
WHITE = 0.8  # of what differences of the order below say those must say, where it is noise
FEWEST = 10  # such differences that tell, and frames in a row that are smoothed
ABOUT = 0.2  # s to either side, over which the risk is asked
THROWN = 4.0  # deviations of the noise, to which a place is brought near that of its neighbours
QUICK, TREMBLES = 1.2, 0.01  # m/s; and m of noise, by whose cube it takes more: what trembles widely looks quick
BREAK_STEPS = 5.0  # usual steps of time; nothing is steadied over longer breaks
MOVE, SHARPLY = 0.1, 8.0  # s that a quick move takes, and the power by which it is left alone above that speed


def steadied(positions: Floats, times: Floats, trust: Floats) -> Floats:
    """(T, J, 3) each joint made as steady as brings it nearer to where it was, by its noise; quick moves stay.

    Parameters
    ----------
    positions : (T, J, 3) m; NaN = missing.
    times : (T,) s.
    trust : (T, J) in [0, 1].

    Source
    ------
    Stein, Estimation of the mean of a multivariate normal distribution, Annals of Statistics 9(6), 1981.
    """
    usual = _usual_step(times)
    steady = np.array(positions)
    if usual <= 0:
        return steady
    noise = _noise(positions, times, usual)
    calm = smoothed(positions, times, DOUBTED)
    rate = (1.0 / (30.0 * usual)) ** 4
    ways = [(weight * rate, float(response(weight * rate).mean())) for weight in WEIGHTS]
    for joints, frames, at in _stretches(positions, times, usual):
        for j in joints[noise[joints] > 0] if len(frames) >= FEWEST else ():
            given, share = positions[frames, j], trust[frames, j][:, None]
            quick = _speed(given, at, usual)[at] / np.hypot(QUICK, (noise[j] / TREMBLES) ** 3)
            as_came = (quick**SHARPLY / (1.0 + quick**SHARPLY))[:, None]
            nearest = _nearest(given, at, usual, min(NOISIER * float(noise[j]), MOST), ways)
            believed = nearest + as_came * (given - nearest)
            steady[frames, j] = calm[frames, j] + share * (believed - calm[frames, j])
    return steady


def smoothed(values: Floats, times: Floats, weight: float) -> Floats:
    """(T, J, 3) each joint smoothed where it is seen without a long break; what is missing stays so.

    Parameters
    ----------
    values : (T, J, 3); NaN = missing.
    times : (T,) s.
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


def difference_squares(positions: Floats, order: int) -> Floats:
    """(T - order, J) m², squares of differences, of which the median is the variance of a coordinate's white noise.

    Parameters
    ----------
    positions : (T, J, 3) m; NaN = missing.
    order : of the differences, at least 1.
    """
    return np.asarray(np.square(np.diff(positions, order, axis=0)).sum(axis=2) / (USUAL * comb(2 * order, order)))


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


def _noise(positions: Floats, times: Floats, usual: float) -> Floats:
    """(J,) m, white noise of a coordinate, by differences of a high order in the median frame; 0 where few tell, or
    those of the order below say more: noise is alike in all of them, motion is not."""
    noise = np.zeros(positions.shape[1])
    if len(times) < ORDER + FEWEST:
        return noise
    even = np.abs(np.diff(times) - usual) < 0.5 * usual
    found = []
    for order in (ORDER - 1, ORDER):
        regular = np.lib.stride_tricks.sliding_window_view(even, order).all(axis=1)
        sizes = difference_squares(positions, order)[regular]
        told = np.isfinite(sizes).sum(axis=0) >= FEWEST
        middle = np.zeros(positions.shape[1])
        middle[told] = np.sqrt(np.nanmedian(sizes[:, told], axis=0))
        found.append(middle)
    return np.where(found[1] > WHITE * found[0], found[1], 0.0)


def _nearest(positions: Floats, at: Ints, usual: float, noise: float, ways: Sequence[tuple[float, float]]) -> Floats:
    """(F, 3) a joint that is seen at steps `at` (F,), smoothed in several ways, by the risk of each.

    Parameters
    ----------
    positions : (F, 3) m. usual : s, a step. noise : m, above 0, of a coordinate.
    ways : smoothness of each, and the share of a sample that comes of itself.
    """
    middle = _medoid_of_three(positions)
    apart = np.sqrt(np.square(positions - middle).sum(axis=1, keepdims=True))
    near = middle + (positions - middle) * np.minimum(1.0, THROWN * noise / np.maximum(apart, 1e-12))
    values, weights = np.zeros((at[-1] + 1, 3)), np.zeros(at[-1] + 1)
    values[at], weights[at] = near, 1.0
    half = max(1, round(ABOUT / usual))
    count = _sums_around(weights, half)[at]
    courses, risks = [near], [np.full(len(at), noise**2)]
    for smoothness, own in ways:
        smooth = whittaker(values, weights, smoothness)
        rest = np.square(smooth - values).mean(axis=1) * weights
        courses.append(smooth[at])
        risks.append(_sums_around(rest, half)[at] / count + (2.0 * own - 1.0) * noise**2)
    risk = np.stack(risks)
    # Coordinates in a thirtieth of a second tell each for itself; what two of them leave is partly the same.
    told = 3.0 * count * min(1.0, 30.0 * usual) / (4.0 * noise**2)
    likely = np.exp((risk.min(axis=0) - risk) * told)
    return np.asarray(np.einsum("wt,wtd->td", likely / likely.sum(axis=0), np.stack(courses)))


def _sums_around(values: Floats, half: int) -> Floats:
    """(T,) sums over so many steps to either side; the first and last ones stand for what is beyond."""
    sums = np.cumsum(np.concatenate([[0.0], np.pad(values, half, mode="edge")]))
    return np.asarray(sums[2 * half + 1 :] - sums[: -2 * half - 1])


def _speed(values: Floats, at: Ints, usual: float) -> Floats:
    """(T,) m/s, how quick a joint (F, 3) is in the quickest tenth of a second about each step of time.

    Parameters
    ----------
    at : (F,) the step of each frame, from 0 to T - 1. usual : s, a step.
    """
    steps = np.arange(at[-1] + 1)
    course = np.stack([np.interp(steps, at, column) for column in _medoid_of_three(values).T], axis=1)
    apart = min(max(1, round(MOVE / usual)), at[-1])
    away = course[apart:] - course[:-apart]
    going = np.pad(np.sqrt((away * away).sum(axis=1)) / (apart * usual), apart)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(going, apart + 1).max(axis=1))


def _medoid_of_three(values: Floats) -> Floats:
    """(F, 3) of three places in a row, about each frame, the one nearest to both others; the first and last stay."""
    three = np.stack([values[1:-1], values[:-2], values[2:]])
    apart = three - np.roll(three, 1, axis=0)
    far = np.sqrt((apart * apart).sum(axis=2))
    nearest = np.argmin(far + np.roll(far, -1, axis=0), axis=0)
    found = np.array(values)
    found[1:-1] = np.take_along_axis(three, nearest[None, :, None], axis=0)[0]
    return found
