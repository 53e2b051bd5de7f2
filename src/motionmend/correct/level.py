"""How far a sensor looks up, down or aside, by who stands before it (section 3.1).

A posture is like learned ones only if it is seen upright. Sensors are tilted by up to 30 degrees, and which way is up
a table of joints does not say; but who stands with straight legs and a trunk in line with them stands over their feet.
In 351 recordings from level sensors and of mocap those frames are within 13 degrees of upright, in all but three
within 9, however people move in others.
"""

from dataclasses import dataclass, replace
from itertools import product
from math import acos, cos, degrees, radians

import numpy as np

from ..arrays import Floats
from .anatomy import Anatomy
from .normalise import upright

STRAIGHT, IN_LINE = cos(radians(25.0)), cos(radians(20.0))  # knees, and the trunk with the legs, of who stands
TOLD = 8  # frames in which somebody stands, from which it is told
TILTED, LYING = radians(16.0), radians(45.0)  # less is how people stand, more is how they lie or lean
SELDOM = 5  # frames, live, until it is asked again whether somebody stands who does not
STEADY = 1 / 3  # of the tilt, by which half of those frames stray at most


@dataclass(frozen=True, eq=False)
class Lean:
    """What frames so far say of the tilt.

    Attributes
    ----------
    axes : (N, 3) from the feet to the shoulders of who stood, upright.
    told : it is known, and asked no more.
    wait : frames that are not asked, after one in which nobody stands.
    """

    axes: Floats
    told: bool = False
    wait: int = 0

    def with_frame(self, rows: Floats, body: Anatomy) -> "Lean":
        """One frame on; rows (J, 3) m upright, NaN = missing."""
        if self.wait > 0:
            return replace(self, wait=self.wait - 1)
        axes = standing(rows[None], body)
        if not len(axes):
            return replace(self, wait=SELDOM)
        return Lean(np.concatenate([self.axes, axes]), len(self.axes) + len(axes) >= TOLD)


UNASKED = Lean(np.empty((0, 3)))
TOLD_ALREADY = Lean(np.empty((0, 3)), True)


def level(positions: Floats, body: Anatomy) -> Floats:
    """(3, 3) the rotation that brings a recording upright: of `upright`, and by the tilt of the sensor.

    Parameters
    ----------
    positions : (T, J, 3) m, NaN = missing.
    """
    turn = upright(positions, body)
    return np.asarray(tilt(standing(positions @ turn.T, body)) @ turn)


def standing(rows: Floats, body: Anatomy) -> Floats:
    """(N, 3) unit vectors from the feet to the shoulders in the frames (T, J, 3) in which somebody stands straight."""
    shoulders = body.across[~np.isin(body.across[:, 0], body.legs)][-1:].ravel()  # the last: fewer have collars
    if len(body.legs) < 2 or not len(shoulders):
        return np.empty((0, 3))
    hips, knees, ankles = np.moveaxis(rows[:, body.legs], 2, 0)
    hip, ankle, shoulder = hips.mean(axis=1), ankles.mean(axis=1), rows[:, shoulders].mean(axis=1)
    straight = np.zeros(len(rows), dtype=np.bool_)
    for knee, foot in product((knees, knees[:, ::-1]), (ankles, ankles[:, ::-1])):  # sides may be taken for each other
        straight |= (_along(knee - hips, foot - knee) > STRAIGHT).all(axis=1)
    straight &= _along(hip - ankle, shoulder - hip) > IN_LINE
    axes = (shoulder - ankle)[straight]
    return np.asarray(axes / np.sqrt((axes * axes).sum(axis=1, keepdims=True)))


def tilt(axes: Floats) -> Floats:
    """(3, 3) the least rotation that brings upright who stands along these axes (N, 3); none where it is not sure."""
    if len(axes) < TOLD:
        return np.eye(3)
    middle = np.median(axes, axis=0)
    middle /= np.sqrt(middle @ middle)
    angle = acos(min(max(float(middle[1]), -1.0), 1.0))
    stray = float(np.median(np.arccos(np.clip(axes @ middle, -1.0, 1.0))))
    if not TILTED < angle < LYING or stray > STEADY * angle:
        return np.eye(3)
    y = np.array([0.0, 1.0, 0.0])
    side = np.cross(middle, y) / np.sin(angle)
    ahead, there = np.cross(side, y), np.cross(side, middle)
    return np.asarray(np.outer(y, middle) + np.outer(side, side) + np.outer(ahead, there))


def tilted(turn: Floats) -> float:
    """Degrees by which a sensor was found tilted whose axes `turn` (3, 3) brings upright."""
    return degrees(acos(min(float(np.abs(turn[1]).max()), 1.0)))


def _along(one: Floats, other: Floats) -> Floats:
    """(...,) cosine of the angle between vectors (..., 3); NaN where one is not known or has no length."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((one * other).sum(axis=-1) / np.sqrt((one * one).sum(axis=-1) * (other * other).sum(axis=-1)))
