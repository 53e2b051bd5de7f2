"""Joints followed along their courses while frames come, by a sensor that throws them about.

What is known of a joint is a row of nine numbers: its place and speed (3 each), in m and m/s, the variances of a
coordinate of both, and their covariance.
"""

from math import exp, isfinite, log, sqrt
from typing import Any

import numpy as np

from ..arrays import Bools, Floats
from . import rising
from .compile import compiled

AWAY, SHARP = 0.02, 30.0  # m and m/s²; half of all joints never are farther off the line between two frames
OFF = 3.0  # deviations of a coordinate, the same of noise
SECOND, SECOND_DEVIATION = 1, 0.87  # the second least of twenty such distances, by the deviation of a coordinate
FINEST, COARSEST = 0.007, 0.05  # m, deviation of a coordinate that is seen well
SPEED, FORCE = 3.0, 10.0  # m/s and m/s², of a coordinate: of who is first seen, and by which speed changes
TAIL, FARTHER, OFTEN = 0.08, 4.0, 0.4  # m, and times the noise, a coordinate's deviation if thrown; how often it is
STATE = 9
PLACE_VAR, SPEED_VAR, COVARIANCE = 6, 7, 8

_insert = rising.insert


@compiled
def off_line(
    rows: Floats, last: Floats, earlier: Floats, seconds: float, before: float, noise: float
) -> tuple[Bools, Bools, float]:
    """Which joints were off the line between the frames before and after, farther than half of all joints go by noise.

    Parameters
    ----------
    rows, last, earlier : (J, 3) m, of this frame and the two before it, NaN = missing.
    seconds, before : s since the frame before, and from the one before that; both above 0.
    noise : m, deviation of a coordinate of joints that are not thrown.

    Returns
    -------
    (J,) and of how many that is known (J,), and m by which a coordinate of those that are seen best is off by noise;
    NaN where that is not known.
    """
    joints = rows.shape[0]
    found, known = np.zeros(joints, dtype=np.bool_), np.zeros(joints, dtype=np.bool_)
    least, count = np.empty(joints), 0
    share = before / (before + seconds)
    limit = AWAY + 0.5 * SHARP * before * seconds + OFF * noise
    for j in range(joints):
        square = 0.0
        for d in range(3):
            square += (last[j, d] - earlier[j, d] - share * (rows[j, d] - earlier[j, d])) ** 2
        if isfinite(square):
            known[j], found[j] = True, square > limit**2
            _insert(least, count, sqrt(square))
            count += 1
    return found, known, least[SECOND] / SECOND_DEVIATION if count > SECOND else np.nan


@compiled
def along(rows: Floats, seconds: float, motion: Floats, noise: float) -> Any:
    """One frame on: where joints are, and how far what the sensor says of them is believed.

    Parameters
    ----------
    rows : (J, 3) m, NaN = missing.
    seconds : since the frame before, above 0.
    motion : (J, 9) after that one; NaN = not known.
    noise : m, deviation of a coordinate of joints that are not thrown.

    Returns
    -------
    motion (J, 9), believed (J,) in [0, 1], 0 where it says nothing, and squared z-scores of a coordinate (J,), of where
    the sensor has joints by where they were expected; 1 where nothing is known.

    Source
    ------
    Bar-Shalom, Daum, Huang, The probabilistic data association filter, IEEE Control Systems 29(6), 2009: what is not
    sure to be the joint's place makes its place the less sure.
    """
    after, believed, strange = motion.copy(), np.zeros(rows.shape[0]), np.ones(rows.shape[0])
    drift, own, tail = FORCE**2, noise**2, max(TAIL, FARTHER * noise) ** 2
    for j in range(rows.shape[0]):
        there = isfinite(rows[j, 0]) and isfinite(rows[j, 1]) and isfinite(rows[j, 2])
        if not isfinite(motion[j, 0]):
            if there:
                after[j, :3], after[j, 3:6] = rows[j], 0.0
                after[j, PLACE_VAR], after[j, SPEED_VAR], after[j, COVARIANCE] = own, SPEED**2, 0.0
                believed[j] = 1.0
            continue
        place, speed, both = motion[j, PLACE_VAR], motion[j, SPEED_VAR], motion[j, COVARIANCE]
        place += 2.0 * seconds * both + seconds**2 * speed + drift * seconds**4 / 4.0
        both += seconds * speed + drift * seconds**3 / 2.0
        speed += drift * seconds**2
        square = 0.0
        for d in range(3):
            after[j, d] += seconds * motion[j, 3 + d]
            square += (rows[j, d] - after[j, d]) ** 2
        if there:
            near, wide = place + own, place + own + tail
            odds = log(1.0 / OFTEN - 1.0) + 1.5 * log(wide / near) - 0.5 * square * (1.0 / near - 1.0 / wide)
            share = 1.0 / (1.0 + exp(-odds))
            gain, faster = place / near, both / near
            for d in range(3):
                off = rows[j, d] - after[j, d]
                after[j, d] += share * gain * off
                after[j, 3 + d] += share * faster * off
            doubt = share * (1.0 - share) * square / 3.0
            place += gain * (doubt * gain - share * place)
            speed += faster * (doubt * faster - share * both)
            both += gain * (doubt * faster - share * both)
            believed[j], strange[j] = share, square / (3.0 * near)
        after[j, PLACE_VAR], after[j, SPEED_VAR], after[j, COVARIANCE] = place, speed, both
    return after, believed, strange
