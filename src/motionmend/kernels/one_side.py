"""Where somebody faces of whose trunk one side is seen, as of who stands side-on to a sensor."""

from math import hypot

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled

ONE_SIDE = 0.03  # of where one side says that the trunk points, beside where it pointed a frame ago


@compiled
def facing(rows: Floats, trust: Floats, trunk: Bools, across: Ints, standard_trunk: Floats, before: Floats) -> Floats:
    """Where the trunk points from right to left: as it did, brought to where the standard body's trunk, turned about
    its height, comes nearest to the joints that are seen.

    Parameters
    ----------
    rows : (J, 3) m, y up, NaN = missing.
    trust : (J,) how much each joint is to be trusted, 0 for missing ones.
    trunk, across : (J,), (P, 2) joints of the trunk; left and right ones of it, of no pair of which both are seen.
    standard_trunk : (J, 3) m, of the standard body.
    before : (2,) horizontal direction in which it pointed a frame ago, 0 = not known.

    Returns
    -------
    (2,) not of unit length; 0 where it is not known, as without any joint of either side.
    """
    direction, total = np.zeros(2), 0.0
    here, there = np.zeros(2), np.zeros(2)
    for p in range(across.shape[0]):
        total += trust[across[p, 0]] + trust[across[p, 1]]
    length = hypot(before[0], before[1])
    if length > 0.0:
        direction[0], direction[1] = before[0] / length, before[1] / length
    if total == 0.0:
        return direction
    total = 0.0
    for j in range(trust.shape[0]):
        if trunk[j] and trust[j] > 0.0:
            total += trust[j]
            for d in range(2):
                here[d] += trust[j] * rows[j, 2 * d]
                there[d] += trust[j] * standard_trunk[j, 2 * d]
    along, side = 0.0, 0.0
    for j in range(trust.shape[0]):
        if trunk[j] and trust[j] > 0.0:
            x, z = rows[j, 0] - here[0] / total, rows[j, 2] - here[1] / total
            a, b = standard_trunk[j, 0] - there[0] / total, standard_trunk[j, 2] - there[1] / total
            along += trust[j] * (a * x + b * z)
            side += trust[j] * (a * z - b * x)
    turn = hypot(along, side)
    if turn > 0.0:
        direction[0] += ONE_SIDE * along / turn
        direction[1] += ONE_SIDE * side / turn
    return direction
