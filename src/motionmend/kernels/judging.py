"""A cast body beside the depth that is seen, pixel by pixel: what is explained, what is left over, what is denied."""

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from .compile import compiled


@compiled
def judged(
    seen: Singles,
    free: Bools,
    rendered: Singles,
    solid: np.ndarray,
    carriers: Ints,
    gate: float,
    loose: Ints,
    visible: Floats,
    denied: Floats,
    counts: Ints,
) -> float:
    """Count pixels of a picture of the body by what the observed depth says of them.

    At the outline of either a pixel may fall beside: what has a neighbour that is explained is not left over, and
    what has one of the person is not denied.

    Parameters
    ----------
    seen, free : (H, W) m of the person, NaN = none, and True where nobody is.
    rendered, solid : (H, W) m, NaN = none, and which solid, -1 = none. carriers : (P,) the bone of each solid.
    gate : m, farther apart along z is not explained.
    loose : (H · W, 2) row and column of each of the person's pixels that is left over, written.
    visible, denied : (B,) pixels of each bone, and of those that are denied, added to.
    counts : (5,) pixels of the person, of the body, of either where the body counts, left over, denied; written.

    Returns
    -------
    The sum over those of either of how wrong each is, 0 to 1.
    """
    height, width = seen.shape
    near, here = np.zeros(seen.shape, np.bool_), np.zeros(seen.shape, np.bool_)
    for row in range(height):
        for column in range(width):
            apart = np.float64(seen[row, column]) - np.float64(rendered[row, column])
            here[row, column] = not np.isnan(seen[row, column])
            near[row, column] = abs(apart) < gate  # not where either is missing
    off = 0.0
    counts[:] = 0
    for row in range(height):
        for column in range(width):
            person, bone = here[row, column], -1
            if solid[row, column] >= 0:
                bone = carriers[solid[row, column]]
                visible[bone] += 1.0
                counts[1] += 1
            if person:
                counts[0] += 1
                counts[2] += 1
                if bone < 0:
                    off += 1.0
                else:
                    apart = np.float64(seen[row, column]) - np.float64(rendered[row, column])
                    off += min(abs(apart) / gate, 1.0)
                    if apart > gate:
                        denied[bone] += 1.0
                        counts[4] += 1
                if not near[row, column] and not beside(near, row, column):
                    loose[counts[3], 0], loose[counts[3], 1] = row, column
                    counts[3] += 1
            elif bone >= 0 and free[row, column]:
                off += 1.0
                counts[2] += 1
                if not beside(here, row, column):
                    denied[bone] += 1.0
                    counts[4] += 1
    return off


@compiled
def beside(mask: Bools, row: int, column: int) -> bool:
    """Whether one of a pixel's four neighbours is of the mask (H, W)."""
    return bool(
        (row > 0 and mask[row - 1, column])
        or (row + 1 < mask.shape[0] and mask[row + 1, column])
        or (column > 0 and mask[row, column - 1])
        or (column + 1 < mask.shape[1] and mask[row, column + 1])
    )
