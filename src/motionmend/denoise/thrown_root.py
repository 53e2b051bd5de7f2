"""A root that leaps away and back: nobody's pelvis does, whatever it does in between.

A body that is taken for another, or lost by its markers, is thrown to another place for some frames. There it moves as
smoothly as ever, so that a smoother takes the leaps for motion. No muscle throws a pelvis so far in one frame.
"""

from itertools import pairwise

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.motion import Motion
from .joints import root_rows

HARDEST = 300.0  # m/s²; pelves of jumpers and gymnasts are thrown by a third of that
LEAST, LEAPS = 0.1, 6.0  # m and times the usual surprise from frame to frame; what leaps by less is noise
LONGEST = 1.0  # s away; whoever stays longer may have been put there
CLOSES = 0.3  # of the leap, by which what comes before and after it may fail to meet
RUN_UP = 0.1  # s on either side that tell how fast the root moves


def thrown(motion: Motion) -> Bools:
    """Samples of a root that is elsewhere for some frames.

    Parameters
    ----------
    motion : T frames, D channels; a root without three translations is not asked.

    Returns
    -------
    (T, D) True where the root's translations were recorded elsewhere.
    """
    found = np.zeros(motion.q.shape, dtype=bool)
    _, moves = root_rows(motion.skeleton)
    if len(moves) != 3 or motion.frames < 4:
        return found
    place = motion.q[:, moves] @ motion.skeleton.dof_axis[moves]
    steps = np.diff(place, axis=0)
    surprise = np.zeros(motion.frames)
    surprise[2:-1] = np.nan_to_num(np.sqrt(np.square(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])).sum(axis=1)))
    far = max(LEAST, HARDEST / motion.fps**2, LEAPS * float(np.median(surprise)))
    before, after = np.r_[0.0, surprise[:-1]], np.r_[surprise[1:], 0.0]
    leaps = np.flatnonzero((surprise > far) & (surprise >= before) & (surprise > after)).tolist()
    run_up, free = max(1, round(RUN_UP * motion.fps)), 0
    for start, stop in pairwise(leaps):
        if start >= free and stop - start <= LONGEST * motion.fps and closes(place, start, stop, run_up):
            found[start:stop, moves], free = True, stop + 1
    return found


def closes(place: Floats, start: int, stop: int, run_up: int) -> bool:
    """True if a path goes on after a stretch much as it came, and not within it.

    Parameters
    ----------
    place : (T, 3) m.
    start, stop : the stretch's first frame and the one after its last.
    run_up : frames on either side that tell how fast it moves.
    """
    last, first = start - 1, stop
    back, on = max(0, last - run_up), min(len(place) - 1, first + run_up)
    speeds = [(place[b] - place[a]) / (b - a) for a, b in ((back, last), (first, on)) if b > a]
    if not speeds:
        return False
    way = np.mean(speeds, axis=0)
    missed = place[first] - place[last] - way * (first - last)
    leaps = [place[start] - place[last] - way, place[stop] - place[stop - 1] - way]
    return bool(np.linalg.norm(missed) < CLOSES * min(np.linalg.norm(leap) for leap in leaps))
