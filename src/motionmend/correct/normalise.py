"""Heading, place and size taken out of a posture, and put back (section 3.1).

A posture in standard form stands upright (y up), faces +z with its left at +x, lies with its trunk about the origin and
has the size of the standard body. Turning or moving the person changes the placement and nothing else.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats, frozen
from .anatomy import Anatomy


@dataclass(frozen=True, eq=False)
class Standard:
    """The body that others are brought to.

    Attributes
    ----------
    lengths : (B,) m, of the bones of the model's anatomy.
    trunk : (J, 3) m, mean places of the joints in standard form.
    """

    lengths: Floats
    trunk: Floats

    def __post_init__(self) -> None:
        for name in ("lengths", "trunk"):
            object.__setattr__(self, name, frozen(getattr(self, name)))


@dataclass(frozen=True, eq=False)
class Placement:
    """Where people stand, which way they face and how large they are.

    Attributes
    ----------
    turn : (T, 3, 3) standard = turn @ (world - origin) / scale.
    origin : (T, 3) m.
    scale : (T,) size of the person by that of the standard body.
    """

    turn: Floats
    origin: Floats
    scale: Floats

    def inward(self, positions: Floats) -> Floats:
        """(T, J, 3) from the sensor's axes to standard form."""
        return np.asarray((positions - self.origin[:, None]) @ self.turn.swapaxes(1, 2) / self.scale[:, None, None])

    def outward(self, standard: Floats) -> Floats:
        """(T, J, 3) from standard form to the sensor's axes."""
        return np.asarray((standard * self.scale[:, None, None]) @ self.turn + self.origin[:, None])

    def turned(self, vectors: Floats) -> Floats:
        """(T, J, 3) vectors such as offsets, from the sensor's axes to standard form."""
        return np.asarray(vectors @ self.turn.swapaxes(1, 2) / self.scale[:, None, None])


def upright(positions: Floats, body: Anatomy) -> Floats:
    """(3, 3) the rotation that brings the sensor's up axis to +y: whichever axis runs along the trunk and legs.

    Parameters
    ----------
    positions : (T, J, 3), NaN = missing.

    Returns
    -------
    The identity when that cannot be told.
    """
    if not len(body.upper) or not len(body.lower) or not len(positions):
        return np.eye(3)
    above, below = positions[:, body.upper], positions[:, body.lower]
    seen = np.isfinite(above).any(axis=(1, 2)) & np.isfinite(below).any(axis=(1, 2))
    if not seen.any():
        return np.eye(3)
    rise = np.median(np.nanmean(above[seen], axis=1) - np.nanmean(below[seen], axis=1), axis=0)
    if not np.isfinite(rise).all() or not rise.any():
        return np.eye(3)
    axis = int(np.argmax(np.abs(rise)))
    if axis == 1:
        return np.eye(3) if rise[1] > 0 else np.diag([1.0, -1.0, -1.0])
    up = np.zeros(3)
    up[axis] = np.sign(rise[axis])
    side = np.cross(up, np.array([0.0, 1.0, 0.0]))  # a quarter turn that takes `up` to y
    y = np.array([0.0, 1.0, 0.0])
    return np.asarray(np.outer(side, side) + np.outer(y, up) + np.outer(np.cross(side, y), np.cross(side, up)))


def facing(positions: Floats, weights: Floats, body: Anatomy) -> Floats:
    """(T, 2) the horizontal direction (x, z) from right to left across the trunk, not of unit length; 0 = not known.

    Parameters
    ----------
    positions : (T, J, 3) y up.
    weights : (T, J) how much each joint is to be trusted, 0 for missing ones.
    """
    total = np.zeros((len(positions), 2))
    for left, right in body.across:
        share = weights[:, left] * weights[:, right]
        across = np.where(share[:, None] > 0, positions[:, left, ::2] - positions[:, right, ::2], 0.0)
        total += share[:, None] * across
    return total


def turns(direction: Floats) -> Floats:
    """(T, 3, 3) rotations about y that bring the directions (T, 2) to +x."""
    length = np.hypot(direction[:, 0], direction[:, 1])
    safe = np.where(length > 0, length, 1.0)
    cos = np.where(length > 0, direction[:, 0] / safe, 1.0)
    sin = np.where(length > 0, direction[:, 1] / safe, 0.0)
    turn = np.zeros((len(direction), 3, 3))
    turn[:, 0, 0] = turn[:, 2, 2] = cos
    turn[:, 0, 2], turn[:, 2, 0] = sin, -sin
    turn[:, 1, 1] = 1.0
    return turn


def origins(
    positions: Floats, weights: Floats, turn: Floats, scale: Floats, standard: Standard, body: Anatomy
) -> Floats:
    """(T, 3) where the standard body's origin lies: every trusted joint of the trunk says so, the mean counts.

    Parameters
    ----------
    positions : (T, J, 3) y up; rows of weight 0 may be NaN.
    weights : (T, J).
    """
    trusted = np.where(body.trunk, weights, 0.0)
    fallback = trusted.sum(axis=1) <= 0
    trusted[fallback] = weights[fallback]
    place = (standard.trunk * scale[:, None, None]) @ turn
    says = np.where(trusted[..., None] > 0, positions - place, 0.0)
    total = np.maximum(trusted.sum(axis=1), 1e-12)
    return np.asarray((trusted[..., None] * says).sum(axis=1) / total[:, None])


def placed(positions: Floats, weights: Floats, scale: Floats, standard: Standard, body: Anatomy) -> Placement:
    """Where people of known sizes stand and which way they face, frame by frame; parameters as of `origins`."""
    turn = turns(facing(positions, weights, body))
    return Placement(turn, origins(positions, weights, turn, scale, standard, body), scale)


def bone_lengths(positions: Floats, body: Anatomy) -> Floats:
    """(T, B) m, NaN where an end is missing."""
    apart = positions[:, body.bones[:, 1]] - positions[:, body.bones[:, 0]]
    return np.asarray(np.sqrt((apart * apart).sum(axis=2)))


def sizes(lengths: Floats, standard: Standard, trusted: Bools) -> float:
    """How large a person is by the standard body: the ratio of summed median bone lengths; 1 when none is known.

    Parameters
    ----------
    lengths : (T, B) m.
    trusted : (T, B) which of them count.
    """
    mine = other = 0.0
    for b in range(lengths.shape[1]):
        some = lengths[trusted[:, b] & np.isfinite(lengths[:, b]), b]
        if len(some) and standard.lengths[b] > 0:
            mine += float(np.median(some))
            other += float(standard.lengths[b])
    return mine / other if mine > 0 and other > 0 else 1.0
