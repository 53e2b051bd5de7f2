"""Joints that a sensor throws about, now these and now those, all of them again and again: its noise has heavy tails.

A joint that leaps alone fails, and its leaping tells; where most joints leap, none of them does. Nothing that is seen
in one frame can be believed then, but a recording as a whole shows where each joint went: a smooth course that counts
what lies far from it little. What was thrown is put back onto it before anything is looked at.
"""

from dataclasses import dataclass, replace
from math import exp, sqrt
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ..arrays import Bools, Floats, frozen
from ..kernels import throwing as kernel
from ..kernels.throwing import AWAY, FINEST, SHARP
from ..numerics.quantiles import quantile_of_known
from ..numerics.robust import ESTIMATORS
from ..numerics.whittaker import whittaker
from .trembling import SURELY, WHILE

OFTEN, CALMEST = 0.12, 0.25  # share of the frames in which they are, of the joint that this share of joints is below
FEWEST = 10  # frames that tell
ABOUT = 0.1  # s to either side, whose median the course begins with
WEIGHT = 2.28  # of the course's second differences, at 30 Hz: half passes at 4 Hz
ROUNDS, COUNTS, BARELY = 8, 4.2, 1e-6  # of weighing; deviations at which a place counts by 1 / e, and the least
THROWN, LEAST = 4.0, 0.03  # deviations from the course, and m at least, beyond which a joint was thrown
MIDDLE = 1.538  # median distance of white noise in space, by the deviation of a coordinate
AGAIN = 1.8  # times as often as by chance; who is thrown away for longer than a frame is not about the course
OFTEN_LIVE, FEWEST_LIVE = 0.2, 7  # the same live, where less is known, half of it from then on; and frames that tell
SOON = 30  # such frames; until then what was learned of a person was learned from thrown joints, and is asked anew
MEMORY, MEMORY_OF_NOISE = 1.0, 0.5  # s, in which all but a share of 1 / e of what was said before is forgotten
LONGEST = 0.5  # s between frames, after which joints may be anywhere
FAR, ALONE = 16.0, 2.0  # squared z-score that says no more, and times the median joint's by which one is thrown alone
LOST = 0.65  # of the joints; when more are where none was expected, twice, the person went, or is somebody else
TOO_NOISY = 0.035  # m, of a coordinate of the joints that are seen best; beyond it all are put back
NOISY = 0.04  # m of noise, from which on joints are where their courses have them


@dataclass(frozen=True, eq=False)
class PutBack:
    """Positions (T, J, 3) in m with thrown joints put back, which were (T, J), and the deviation of a coordinate of
    those in m."""

    positions: Floats
    thrown: Bools
    deviation: float


def put_back(positions: Floats, times: Floats) -> PutBack:
    """A recording of a sensor that throws its joints about, each put back onto its course; else as it came.

    Parameters
    ----------
    positions : (T, J, 3) m, NaN = missing.
    times : (T,) s.

    Source
    ------
    Holland, Welsch, Robust regression using iteratively reweighted least-squares, 1977.
    """
    nothing = PutBack(positions, np.zeros(positions.shape[:2], dtype=np.bool_), 0.0)
    usual = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if usual <= 0.0 or not throws(positions, times):
        return nothing
    there = np.asarray(np.isfinite(positions).all(axis=2))
    at = np.append(0, np.cumsum(np.maximum(np.rint(np.diff(times) / usual), 1))).astype(int)
    smoothness, told = WEIGHT * (1.0 / (30.0 * usual)) ** 4, np.flatnonzero(there.sum(axis=0) >= FEWEST)
    course = _medians(positions, max(2, round(ABOUT / usual)))
    for _ in range(ROUNDS):
        apart = np.sqrt(np.square(positions - course).sum(axis=2))
        deviation = max(float(np.nanmedian(apart)) / MIDDLE, FINEST)
        count = np.where(there, np.maximum(ESTIMATORS["welsch"].weight(apart / deviation, COUNTS), BARELY), 0.0)
        for j in told:
            values, weights = np.zeros((at[-1] + 1, 3)), np.zeros(at[-1] + 1)
            values[at], weights[at] = np.where(there[:, [j]], positions[:, j], 0.0), count[:, j]
            course[:, j] = whittaker(values, weights, smoothness)[at]
    apart = np.sqrt(np.square(positions - course).sum(axis=2))
    thrown = np.zeros(there.shape, dtype=np.bool_)
    thrown[:, told] = (there & (apart > max(THROWN * deviation, LEAST)))[:, told]
    if not _by_chance(thrown, there):
        return nothing
    thrown &= ~_alone(thrown, usual)
    return PutBack(np.where(thrown[..., None], course, positions), thrown, deviation)


def throws(positions: Floats, times: Floats) -> bool:
    """Whether most joints (T, J, 3) are thrown about, at times (T,) s."""
    first, second = np.diff(times)[:-1], np.diff(times)[1:]
    whole = first + second
    told = (first > 0.0) & (second > 0.0) & (whole < LONGEST)
    share = np.where(told, first / np.where(told, whole, 1.0), np.nan)[:, None, None]
    line = positions[:-2] + share * (positions[2:] - positions[:-2])
    away = np.sqrt(np.square(positions[1:-1] - line).sum(axis=2))
    known = np.isfinite(away)
    enough = known.sum(axis=0) >= FEWEST
    if not enough.any():
        return False
    off = away > (AWAY + 0.5 * SHARP * first * second)[:, None]
    return bool(np.quantile(off.sum(axis=0)[enough] / known.sum(axis=0)[enough], CALMEST) > OFTEN)


def _by_chance(thrown: Bools, there: Bools) -> bool:
    """Whether joints (T, J) that are thrown in a frame hardly are likelier to be in the next, of those there (T, J)."""
    often = thrown.sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    expected = (there[1:] & there[:-1]).sum(axis=0) @ often**2
    return bool((thrown[1:] & thrown[:-1]).sum() < AGAIN * expected)


def _alone(thrown: Bools, usual: float) -> Bools:
    """(T, J) joints that are thrown (T, J) for a while much more than the median joint is: they fail, or go quickly."""
    frames = 2 * max(1, round(WHILE / usual)) + 1
    often = float(np.median(thrown.mean(axis=0)))
    here = uniform_filter1d(thrown.astype(np.float64), frames, axis=0, mode="reflect")
    more = here > often + SURELY * np.sqrt(often * (1.0 - often) / frames)
    return np.asarray(maximum_filter1d(more, frames, axis=0))


def _medians(positions: Floats, half: int) -> Floats:
    """(T, J, 3) each coordinate's median in so many frames to either side; NaN where none of them shows the joint."""
    padded = np.pad(positions, ((half, half), (0, 0), (0, 0)), constant_values=np.nan)
    return quantile_of_known(np.moveaxis(sliding_window_view(padded, 2 * half + 1, axis=0), -1, 0), 0.5)


@dataclass(frozen=True, eq=False)
class Courses:
    """Live, what is known of where J joints went after a frame.

    Attributes
    ----------
    motion : (J, 9) of `kernels.throwing`; NaN = not known.
    often : (J,) share of the frames in which each was off the line between those before and after.
    strange : (J,) mean squared z-score of a coordinate, of where each was by where it was expected.
    variance : m² of a coordinate of joints that are seen well.
    last, earlier : (J, 3) m, what the sensor gave in this frame and before it; NaN = missing.
    time, step : s, of this frame, and since the one before; NaN = none.
    frames : that told of it.
    lost : most joints were elsewhere than expected.
    thrown : joints are put back.
    """

    motion: Floats
    often: Floats
    strange: Floats
    variance: float
    last: Floats
    earlier: Floats
    time: float
    step: float
    frames: int
    lost: bool
    thrown: bool

    @property
    def soon(self) -> bool:
        """Whether hardly anything was seen but thrown joints."""
        return self.frames < SOON


def unknown(joints: int) -> Courses:
    """Before the first frame."""
    nothing = np.full((joints, 3), np.nan)
    return Courses(
        np.full((joints, kernel.STATE), np.nan),
        np.zeros(joints),
        np.ones(joints),
        FINEST**2,
        nothing,
        nothing,
        np.nan,
        np.nan,
        0,
        lost=False,
        thrown=False,
    )


class Believed(NamedTuple):
    """Of a live frame: (J, 3) m where joints are, (J,) how far the sensor was believed, and (J,) m the deviation of a
    coordinate where it was not."""

    positions: Floats
    share: Floats
    deviation: Floats


def followed(before: Courses, given: Floats, time: float) -> tuple[Courses, Believed]:
    """One live frame (J, 3) in m of a sensor that may throw its joints about: those that are thrown are put back.

    As long as most joints were not thrown often, everything is as it came.

    Parameters
    ----------
    before : the frame before.
    given : (J, 3) m, as the sensor has them, NaN = missing.
    time : s, of this frame; unless it is later, and soon after, all begins anew.
    """
    as_came = Believed(given, np.ones(len(given)), np.zeros(len(given)))
    seconds = time - before.time
    if not 0.0 < seconds < LONGEST:
        begun = unknown(len(given))
        motion, _, _ = kernel.along(given, LONGEST, begun.motion, FINEST)  # of who is first seen no time is asked
        return replace(begun, motion=motion, last=frozen(given), time=time), as_came
    often, variance, frames = before.often, before.variance, before.frames
    if before.step > 0.0:
        off, known, noise = kernel.off_line(given, before.last, before.earlier, seconds, before.step, sqrt(variance))
        if np.isfinite(noise):
            frames += 1
            share = max(1.0 - exp(-seconds / MEMORY), 1.0 / frames)
            often = np.where(known, often + share * (off - often), often)
            share = max(1.0 - exp(-seconds / MEMORY_OF_NOISE), 1.0 / frames)
            variance += share * (min(max(noise, FINEST), kernel.COARSEST) ** 2 - variance)
    motion, believed, off_course = kernel.along(given, seconds, before.motion, sqrt(variance))
    share = 1.0 - exp(-seconds / WHILE)
    strange = before.strange + share * (np.minimum(off_course, FAR) - before.strange)
    there = np.isfinite(given[:, 0])
    lost = bool(np.count_nonzero(believed[there] < 0.5) > LOST * np.count_nonzero(there))
    if lost and before.lost:  # they went where none was expected: from here on anew
        motion, _, _ = kernel.along(given, seconds, np.full_like(motion, np.nan), sqrt(variance))
    least = OFTEN_LIVE / 2.0 if before.thrown else OFTEN_LIVE
    most = bool(np.sort(often)[int(CALMEST * len(often))] > least)
    thrown = frames >= FEWEST_LIVE and (most or variance > TOO_NOISY**2)
    seen = frozen(given), before.last, time, seconds
    after = Courses(motion, frozen(often), strange, variance, *seen, frames, lost, thrown)
    if not thrown or (lost and before.lost):
        return after, as_came
    believed = np.where(believed > 0.5, 1.0, believed)
    calm = min(variance / NOISY**2, 1.0) ** 2
    course = motion[:, :3]
    there &= strange < ALONE * np.median(strange)  # who is thrown more than others fails
    positions = np.where(there[:, None], course + (believed * (1.0 - calm))[:, None] * (given - course), given)
    deviation = np.sqrt((1.0 - believed) * motion[:, kernel.PLACE_VAR] + calm * variance)
    return after, Believed(positions, np.where(there, believed, 1.0), np.where(there, deviation, 0.0))
