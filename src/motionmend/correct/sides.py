"""Left and right taken for each other: found by what goes on, put right when sure, refused when not (section 6).

A sensor that confuses the sides of a body, as when a person turns around, makes the trunk face the other way within one
frame, or moves two limbs to each other's place. No person does that. Both the posture as given and the one with sides
changed back are compared with what is expected from the frames before.
"""

from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..kernels import sighting as kernel
from .anatomy import Anatomy

MEMORY = 0.5  # s; after a longer break the trunk may face anywhere


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
