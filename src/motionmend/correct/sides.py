"""Left and right taken for each other: found by what goes on, put right when sure, refused when not (section 6).

A sensor that confuses the sides of a body, as when a person turns around, makes the trunk face the other way within one
frame, or moves two limbs to each other's place. No person does that. Both the posture as given and the one with sides
changed back are compared with what is expected from the frames before. That tells that sides have changed, not which of
the two was right; confusions do not last, and a body tells its sides.
"""

from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..kernels import sighting as kernel
from ..kernels.following import STRANGER
from ..numerics import factors as process
from ..numerics.factors import Factors
from .anatomy import Anatomy
from .normalise import Standard, bone_lengths
from .reliability import FAILING_SECONDS

MEMORY = 0.5  # s; after a longer break the trunk may face anywhere
REVISED = 3.0  # log-odds at which it was before that sides were confused
BONE_SPREAD = 0.2  # deviation of the logarithm of a bone's length among people and sensors, their size taken out
FARTHEST = 9.0  # squared z-score beyond which a joint's place or a bone's length says nothing more


def trunk_turned(positions: Floats, before: Floats, seconds: float, body: Anatomy) -> Bools:
    """(P,) which left-right pairs of the trunk face against where it faced a moment ago.

    Parameters
    ----------
    positions : (J, 3) m, upright.
    before : (2,) horizontal direction from right to left; zero = not known.
    seconds : since somebody was seen.
    """
    if seconds > MEMORY:
        return np.zeros(len(body.across), dtype=np.bool_)
    return np.asarray(kernel.turned_around(positions, before, body.across))


def changed(positions: Any, pairs: Ints) -> Any:
    """(J, ...) with the members of the pairs (N, 2) in each other's place."""
    other = np.array(positions)
    other[pairs[:, 0]], other[pairs[:, 1]] = positions[pairs[:, 1]], positions[pairs[:, 0]]
    return other


def confused_until_now(
    factors: Factors, usual: Standard, body: Anatomy, posture: Floats, pairs: Ints, seconds: float
) -> bool:
    """Whether limbs that have changed places were confused before and are right now, rather than the other way round.

    Parameters
    ----------
    usual : the standard body.
    posture : (J, 3) as given now, in standard form, NaN = missing.
    pairs : (N, 2) joints that have changed places.
    seconds : for which they were where they were.
    """
    return bool(-_odds(factors, usual, body, posture[None], pairs)[0] - seconds / FAILING_SECONDS > REVISED)


def confused_limbs(factors: Factors, usual: Standard, body: Anatomy, postures: Floats) -> Bools:
    """(J,) joints of limbs that hang on the wrong side, by what bodies look like and how long bones are.

    Of what may be confused of a limb, from each joint outward, the likeliest is taken.

    Parameters
    ----------
    usual : the standard body.
    postures : (T, J, 3) in standard form, NaN = missing; what most of them say counts.
    """
    confused = np.zeros(len(body.names), dtype=np.bool_)
    seen = postures[np.isfinite(postures).any(axis=(1, 2))]
    if not len(seen):
        return confused
    for parts in body.limbs:
        odds = [float(_odds(factors, usual, body, seen, pairs).mean()) for pairs in parts]
        if max(odds) > REVISED:
            confused[parts[int(np.argmax(odds))].ravel()] = True
    return confused


def _odds(factors: Factors, usual: Standard, body: Anatomy, postures: Floats, pairs: Ints) -> Floats:
    """(T,) log-odds that the members of pairs (N, 2) stand in each other's place in postures (T, J, 3)."""
    joints = pairs.ravel()
    other = np.array(postures)
    other[:, joints] = postures[:, pairs[:, ::-1].ravel()]
    _, cov = process.expected(factors, process.start(factors))
    variance = (np.trace(cov, axis1=1, axis2=2) / 3.0 + factors.noise + STRANGER**2)[joints]
    total = np.zeros(len(postures))
    for sign, one in ((0.5, postures), (-0.5, other)):
        far = ((one[:, joints] - factors.mean[joints]) ** 2).sum(axis=2) / variance
        off = (np.log(np.maximum(bone_lengths(one, body), 1e-6) / usual.lengths) / BONE_SPREAD) ** 2
        total += sign * (np.nansum(np.minimum(far, FARTHEST), axis=1) + np.nansum(np.minimum(off, FARTHEST), axis=1))
    return total
