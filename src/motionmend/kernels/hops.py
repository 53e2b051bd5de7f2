"""Joints that are farther off than any gets from one frame to the next."""

from math import isfinite

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled

HOP, SHARPEST = 0.12, 100.0  # m and m/s^2; a sensor's joint is unsteady by less, and no joint turns round more sharply
BESIDE = 0.5  # of how far off it is: within, it is where its other side should be, and was taken for it


@compiled
def hopped(rows: Floats, before: Floats, earlier: Floats, seconds: float, mirror: Ints) -> Bools:
    """(J,) which joints are farther than any gets from where they were and from where they went, and not at their other
    side's place.

    Parameters
    ----------
    rows, before, earlier : (J, 3) m, of this frame and the two before it, NaN = missing.
    seconds : since the frame before.
    mirror : (J,) the joint's other side, or itself.
    """
    found = np.zeros(rows.shape[0], dtype=np.bool_)
    for j in range(rows.shape[0]):
        if _far(rows[j], before[j], earlier[j], seconds):
            stayed, went = _off(rows[j], before[mirror[j]], earlier[mirror[j]])
            _, off = _off(rows[j], before[j], earlier[j])
            found[j] = not (stayed < BESIDE**2 * off or went < BESIDE**2 * off)
    return found


@compiled
def leaps(rows: Floats, before: Floats, earlier: Floats, seconds: float, mirror: Ints) -> Bools:
    """(J,) which joints are farther than any gets from where they were and from where they went, and not for having
    changed places with their other side.

    Parameters
    ----------
    rows, before, earlier, seconds, mirror : as of `hopped`.
    """
    found = np.zeros(rows.shape[0], dtype=np.bool_)
    for j in range(rows.shape[0]):
        if _far(rows[j], before[j], earlier[j], seconds):
            there = mirror[j]
            over, _ = _off(rows[j], before[there], before[there])
            back, _ = _off(rows[there], before[j], before[j])
            stayed, _ = _off(rows[j], before[j], before[j])
            near = BESIDE**2 * stayed
            found[j] = there == j or not (over < near and back < near)
    return found


@compiled
def _far(row: Floats, before: Floats, earlier: Floats, seconds: float) -> bool:
    """True for a joint (3,) that is seen in all three frames and farther off than any gets."""
    stayed, went = _off(row, before, earlier)
    least = HOP + 0.5 * SHARPEST * max(seconds, 0.0) ** 2
    return isfinite(stayed + went) and min(stayed, went) > least**2


@compiled
def _off(row: Floats, before: Floats, earlier: Floats) -> tuple[float, float]:
    """Squared distances of a place (3,) from the one before, and from where it went by the two before."""
    stayed, went = 0.0, 0.0
    for d in range(3):
        stayed += (row[d] - before[d]) ** 2
        went += (row[d] - 2.0 * before[d] + earlier[d]) ** 2
    return stayed, went
