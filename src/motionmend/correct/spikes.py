"""Joints that a sensor throws away for a frame or two and has back: what comes after a frame tells of them."""

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..kernels.hops import BESIDE, HOP, SHARPEST

LONGEST = 2  # frames away
SECOND, OFTEN = 1.0, 3  # s and frames: who is away in more of them shakes


def thrown_and_back(positions: Floats, times: Floats, mirror: Ints) -> Bools:
    """Which joints were away from where the frames on either side have them.

    Parameters
    ----------
    positions : (T, J, 3) m, NaN = missing.
    times : (T,) s.
    mirror : (J,) the joint's other side, or itself.

    Returns
    -------
    (T, J) True for joints that were farther away than any joint goes and comes back in the time, and not where their
    other side should be. Who is thrown about again and again shakes, as joints that are guessed do: it is left, for its
    shaking tells.
    """
    found = np.zeros(positions.shape[:2], dtype=np.bool_)
    frames = len(positions)
    for count in range(1, LONGEST + 1):
        first, last = positions[: frames - count - 1], positions[count + 1 :]
        if not len(last):
            break
        begun, lasts = times[: len(first)], times[count + 1 :] - times[: len(first)]
        known = lasts > 0
        went = np.linalg.norm(last - first, axis=2)
        least = np.full(went.shape, np.inf)
        lost = np.broadcast_to(known[:, None], went.shape).copy()
        for n in range(1, count + 1):
            here = positions[n : n + len(first)]
            share = (times[n : n + len(first)] - begun) / np.where(known, lasts, 1.0)
            usual = first + share[:, None, None] * (last - first)
            away = np.linalg.norm(here - usual, axis=2)
            beside = np.linalg.norm(here - usual[:, mirror], axis=2)
            lost &= ~(beside < BESIDE * away)
            least = np.minimum(least, away)
        lost &= (least > HOP + SHARPEST / 8.0 * lasts[:, None] ** 2) & (went < least)  # else it went on
        for n in range(1, count + 1):
            found[n : n + len(first)] |= lost
    return found & (_about(found, times) <= OFTEN)


def _about(found: Bools, times: Floats) -> Ints:
    """(T, J) how many of these there are in the second about each frame."""
    before = np.concatenate([np.zeros((1, found.shape[1]), np.int64), np.cumsum(found, axis=0)])
    order = np.maximum.accumulate(times)  # a clock that goes back stands still
    first = np.searchsorted(order, order - 0.5 * SECOND, side="left")
    last = np.searchsorted(order, order + 0.5 * SECOND, side="right")
    return np.asarray(before[last] - before[first])
