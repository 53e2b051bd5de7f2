"""Rejected samples that moved away from the rest bit by bit: who stood still and then moved, not what slipped.

An outlier may go on to be off by as much as the one before, as a marker does that slips and an angle whose sensor is
knocked. So does, to who has seen a recording hardly move, all that comes after a quick move. But what slips is off from
one frame to the next, and what moves has been everywhere in between.
"""

import numpy as np
from scipy.ndimage import binary_opening, find_objects, label

from ...arrays import Bools, Floats

LASTS = 0.2  # s on end that are rejected at least
AT_ONCE = 1 / 30  # s in which a slip is off, and a motion is not yet
NO_LEAP = 0.35  # of how far a run is off: neither at its beginning nor at its end does it leap by more
STEADY = 0.15  # of that: it changes by less from one frame to the next, as a rule, but for noise
ONE_SIDE = 0.8  # of how far its samples are off that their mean is: garbage lies on all sides


def moved_away(off: Floats, outlier: Bools, noise: Floats, fps: float, together: int) -> tuple[Bools, Bools]:
    """Rejected samples of runs that begin and end without a leap, or with the recording.

    Parameters
    ----------
    off : (T, C) samples less what was repaired; NaN = missing.
    outlier : (T, C) rejected.
    noise : (T, C) standard deviations.
    fps : Hz.
    together : neighbouring columns that are outliers together.

    Returns
    -------
    moved : (T, C) True where a rejected sample is no outlier.
    moving : (T, C) True for those of them at which a run gets as far away as it is as a rule, or comes back.
    """
    fewest, at_once = max(3, round(LASTS * fps)), max(1, round(AT_ONCE * fps))
    runs, count = label(
        binary_opening(outlier[:, ::together], np.ones((fewest, 1), dtype=np.bool_)), np.array([[0, 1, 0]] * 3)
    )
    moved, moving = np.zeros(outlier.shape, dtype=np.bool_), np.zeros(outlier.shape, dtype=np.bool_)
    for frames, columns in find_objects(runs, count):
        own = slice(columns.start * together, (columns.start + 1) * together)
        run, chance = off[frames, own], float(np.square(noise[frames, own]).sum(axis=1).mean())
        sizes = np.linalg.norm(run, axis=1)
        size = float(np.nanmedian(sizes))
        if not size > 0:  # rejected, and off by nothing
            continue
        leap = max(_leap(off[:, own], at, at_once) for at in (frames.start, frames.stop))
        changes = float(np.nanmedian(np.square(np.diff(run, axis=0)).sum(axis=1))) - 2.0 * chance
        one_side = float(np.linalg.norm(np.nanmean(run, axis=0)) / np.nanmean(sizes))
        if leap < NO_LEAP * size and changes < (STEADY * size) ** 2 and one_side > ONE_SIDE:
            moved[frames, own] = True
            far = np.flatnonzero(sizes >= size)
            moving[frames, own] = True
            moving[frames.start + far[0] : frames.start + far[-1] + 1, own] = False
    return moved, moving


def _leap(off: Floats, at: int, width: int) -> float:
    """By how much the mean of so many frames off (T, G) before one differs from theirs after it; 0 at either end.

    Nor is there a leap where samples are missing: nobody has seen one.
    """
    before, after = off[max(0, at - width) : at], off[at : at + width]
    if not (np.isfinite(before).all(axis=1).any() and np.isfinite(after).all(axis=1).any()):
        return 0.0
    return float(np.linalg.norm(np.nanmean(before, axis=0) - np.nanmean(after, axis=0)))
