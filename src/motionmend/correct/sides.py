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
    other = changed(posture, pairs)
    joints = pairs.ravel()
    _, cov = process.expected(factors, process.start(factors))
    variance = (np.trace(cov, axis1=1, axis2=2) / 3.0 + factors.noise + STRANGER**2)[joints]
    far = [((one[joints] - factors.mean[joints]) ** 2).sum(axis=1) / variance for one in (posture, other)]
    lengths = [bone_lengths(one[None], body)[0] for one in (posture, other)]
    off = [(np.log(np.maximum(one, 1e-6) / usual.lengths) / BONE_SPREAD) ** 2 for one in lengths]
    now, before = (
        np.nansum(np.minimum(a, FARTHEST)) + np.nansum(np.minimum(b, FARTHEST)) for a, b in zip(far, off, strict=True)
    )
    return bool(0.5 * (before - now) - seconds / FAILING_SECONDS > REVISED)
