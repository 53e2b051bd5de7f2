"""Left and right taken for each other: found by what goes on, put right when sure, refused when not (section 6).

A sensor that confuses the sides of a body, as when a person turns around, makes the trunk face the other way within one
frame, or moves two limbs to each other's place. No person does that. Both the posture as given and the one with sides
changed back are compared with what is expected from the frames before.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from .anatomy import Anatomy

SURE = 12.0  # log-likelihood ratio at which sides are changed back; half of it decides nothing
STAYS = 0.0  # the same for a pair that was changed back a frame ago
CAP = 60.0  # squared Mahalanobis distance beyond which distance says nothing more
OPPOSED = -0.5  # cosine between trunk directions of successive frames at which the trunk has been turned around
MEMORY = 0.5  # s; after a longer break the trunk may face anywhere


@dataclass(frozen=True, eq=False)
class Sides:
    """Which joints were changed back, (J,), and whether it could not be told for some."""

    swapped: Bools
    unsure: bool


def trunk_turned(positions: Floats, before: Floats, seconds: float, body: Anatomy) -> Bools:
    """(P,) which left-right pairs of the trunk face against where it faced a moment ago.

    Parameters
    ----------
    positions : (J, 3) m, upright.
    before : (2,) horizontal direction from right to left; zero = not known.
    seconds : since then.
    """
    length = float(np.hypot(before[0], before[1]))
    if not len(body.across) or length <= 0 or seconds > MEMORY:
        return np.zeros(len(body.across), dtype=np.bool_)
    apart = positions[body.across[:, 0], ::2] - positions[body.across[:, 1], ::2]
    size = np.sqrt((apart**2).sum(axis=1))
    cosine = (apart @ before) / np.maximum(size * length, 1e-12)
    return np.asarray(np.isfinite(cosine) & (cosine < OPPOSED) & (size > 0.05))


def changed(positions: Any, pairs: Ints) -> Any:
    """(J, ...) with the members of the pairs (N, 2) in each other's place."""
    other = np.array(positions)
    other[pairs[:, 0]], other[pairs[:, 1]] = positions[pairs[:, 1]], positions[pairs[:, 0]]
    return other


def limbs_changed(standard: Floats, expected: Floats, variance: Floats, before: Bools, pairs: Ints) -> Sides:
    """Which pairs of joints stand where the other one is expected.

    Parameters
    ----------
    standard : (J, 3) as the sensor says, in standard form, NaN = missing.
    expected : (J, 3) from the frames before.
    variance : (J,) of a coordinate of it.
    before : (J,) changed back a frame ago.
    pairs : (N, 2) left and right joints.
    """
    left, right = pairs[:, 0], pairs[:, 1]
    straight = _far(standard[left] - expected[left], variance[left])
    straight = straight + _far(standard[right] - expected[right], variance[right])
    crossed = _far(standard[left] - expected[right], variance[right])
    crossed = crossed + _far(standard[right] - expected[left], variance[left])
    ratio = 0.5 * (straight - crossed)
    known = np.isfinite(ratio)
    limit = np.where(before[left], STAYS, SURE)
    swap = known & (ratio > limit) & (crossed < CAP)
    swapped = np.zeros(len(standard), dtype=np.bool_)
    swapped[left[swap]] = swapped[right[swap]] = True
    unsure = bool((known & ~swap & (ratio > 0.5 * SURE) & (crossed < CAP)).any())
    return Sides(swapped, unsure)


def _far(rest: Floats, variance: Floats) -> Floats:
    return np.asarray(np.minimum((rest**2).sum(axis=1) / variance, CAP))
