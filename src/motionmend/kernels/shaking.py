"""How far joints turn back on themselves from frame to frame."""

import numpy as np

from ..arrays import Floats
from . import rising
from .compile import compiled

FEWEST = 6  # joints that tell
WHITE = 8.989  # median of the same of white noise in space, by the variance of a coordinate

_insert, _middle = rising.insert, rising.middle


@compiled
def turned_back(rows: Floats, last: Floats, earlier: Floats, before: Floats) -> tuple[Floats, float]:
    """Second differences of joints, and by how much those of the median joint turn back on those of the frame before.

    Parameters
    ----------
    rows, last, earlier : (J, 3) m, positions of a frame and the two before it, NaN = missing.
    before : (J, 3) m, second differences of the frame before, NaN = not known.

    Returns
    -------
    (J, 3) m, and the variance in m² of a coordinate of white noise that turns back so far, negative where joints go on
    as they went; NaN where few joints tell.
    """
    joints = rows.shape[0]
    bent, turns, known = np.empty((joints, 3)), np.empty(joints), 0
    for j in range(joints):
        turn = 0.0
        for d in range(3):
            bent[j, d] = rows[j, d] - 2.0 * last[j, d] + earlier[j, d]
            turn -= bent[j, d] * before[j, d]
        if np.isfinite(turn):
            _insert(turns, known, turn)
            known += 1
    return bent, _middle(turns, known) / WHITE if known >= FEWEST else np.nan
