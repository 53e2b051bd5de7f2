"""Markers that are elsewhere in the last frame before a gap, or the first after it, and leap from there or to there.

How the marker came there nobody saw, so that a search for outliers may as soon believe the one sample and take all that
follow for a slip; where these are few it does, and fills the gap from there. But no marker goes on as calmly as that
just after such a leap.
"""

import numpy as np

from ...arrays import Bools, Floats, runs
from ...bodies.motion import Markers

SHORTEST = 0.1  # s; across a shorter gap how the marker moves tells
MOST = 2  # frames that are elsewhere; more are told by the markers about them
CALM = 3  # second differences that follow the leap, and that are no leaps
LEAPS, LEAST = 4.0, 0.02  # times those, and the marker's usual ones; m, no leap is shorter
HARD = 50.0  # m/s2; bodies are as quick, so that at low rates they bend by more from frame to frame


def leapt_back(recording: Markers) -> Bools:
    """Samples beside gaps that are elsewhere.

    Parameters
    ----------
    recording : T frames of M markers.

    Returns
    -------
    (T, M) True in up to `MOST` frames beside a gap, if the marker leaps from there to where it goes on calmly.
    """
    present = recording.present
    found = np.zeros(present.shape, dtype=np.bool_)
    for marker in np.flatnonzero(~present.all(axis=0) & present.any(axis=0)).tolist():
        path = recording.positions[:, marker]
        bends = np.linalg.norm(np.diff(path, n=2, axis=0), axis=1)
        told = bends[np.isfinite(bends)]
        if not len(told):
            continue
        least = max(LEAST, HARD / recording.fps**2, LEAPS * float(np.median(told)))
        for start, stop in runs(~present[:, marker]):
            if stop - start >= SHORTEST * recording.fps:
                last, after = _elsewhere(path[:start][::-1], least), _elsewhere(path[stop:], least)
                found[start - last : start, marker] = found[stop : stop + after, marker] = True
    return found


def _elsewhere(path: Floats, least: float) -> int:
    """How many frames, from the first on, of a path (T, 3) m lie before a leap to where it goes on calmly; 0 = none."""
    bends = np.linalg.norm(np.diff(path[: MOST + CALM + 2], n=2, axis=0), axis=1)
    for number in range(1, MOST + 1):
        calm = bends[number : number + CALM]
        if len(calm) == CALM and bends[number - 1] > max(least, LEAPS * float(calm.max())):
            return number
    return 0
