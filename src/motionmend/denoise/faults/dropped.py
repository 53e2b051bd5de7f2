"""Joints that fall to exactly 0 for a while: so is written what could not be solved.

A knee that is stretched to its limit is 0 as well, and a joint that nobody measures throughout. But they come to it by
and by, and one at a time.
"""

from collections import defaultdict

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from ...bodies.motion import Markers, Motion
from .frozen import LEAPS, ROUNDED, parts_of, repeats_throughout

ALONE = 20.0  # degrees or cm that a joint leaps at either end; less where others fall with it
TOGETHER = 2  # joints
BESIDE = 2.0  # times the steps before and after; knees that come to their limit leap by 1.5 times as much
AT_HOME = 1.0 / 3.0  # of the recording; what is 0 for longer may be so


def dropped(recording: Motion | Markers) -> Bools:
    """Samples of joints that fall to exactly 0 by a leap, and leap back.

    Parameters
    ----------
    recording : T frames, C channels or markers; a marker at 0 was never read as one.

    Returns
    -------
    (T, C) True where all angles of a joint, or all of the root's places, are 0 for that.
    """
    found: Bools = np.zeros((recording.frames, len(recording.channels)), dtype=np.bool_)
    if isinstance(recording, Markers):
        return found
    shared: defaultdict[tuple[int, int], list[tuple[Ints, float]]] = defaultdict(list)
    for columns, values, coarse in parts_of(recording):
        zero, steps = (values == 0.0).all(axis=1), np.diff(values, axis=0)
        same = (steps == 0.0).all(axis=1)
        if not zero.any() or zero.mean() > AT_HOME or repeats_throughout(same, ~same):
            continue
        least = max(LEAPS * _usual_change(steps, zero), ROUNDED * coarse)
        for start, stop in runs(zero):
            if start >= 2 and stop + 2 <= len(values):  # else nothing tells whether it leaps
                into, out = _leap(steps[start - 1], steps[start - 2], least), _leap(steps[stop - 1], steps[stop], least)
                shared[start, stop].append((columns, min(into, out)))
    for (start, stop), together in shared.items():
        leaps = np.array([leap for _, leap in together])
        if (leaps > 0.0).sum() >= TOGETHER or leaps.max() >= ALONE:
            found[start:stop, np.concatenate([columns for columns, _ in together])] = True
    return found


def _usual_change(steps: Floats, zero: Bools) -> float:
    """Median change of a step (T - 1, N) to the next where a part is not 0; infinite where nothing tells."""
    changes = np.sqrt(np.square(np.diff(steps, axis=0)).sum(axis=1))
    told = changes[np.isfinite(changes) & ~(zero[2:] | zero[1:-1] | zero[:-2])]
    return float(np.median(told)) if len(told) else np.inf


def _leap(step: Floats, beside: Floats, least: float) -> float:
    """How far a step (N,) leaps beside that which is before or after it; 0 where it does not, or nothing tells."""
    change = float(np.linalg.norm(step - beside))
    leaps = change > max(least, BESIDE * float(np.linalg.norm(beside)))
    return float(np.linalg.norm(step)) if leaps else 0.0
