"""A root that leaps away and back: nobody's pelvis does, whatever it does in between.

A body that is taken for another, or lost by its markers, is thrown to another place for some frames. There it moves as
smoothly as ever, so that a smoother takes the leaps for motion. No muscle throws a pelvis so far in one frame.
"""

from itertools import combinations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...arrays import Bools, Floats
from ...bodies.motion import Motion
from ..channels.joints import root_rows

HARDEST = 300.0  # m/s²; pelves of jumpers and gymnasts are thrown by a third of that
LEAST, LEAPS = 0.1, 6.0  # m and times the usual surprise from frame to frame; what leaps by less is noise
LONGEST = 1.0  # s away; whoever stays longer may have been put there
CLOSES = 0.3  # of the leap, by which what comes before and after it may fail to meet
BESIDE = 2  # steps on either side of one that tell whether it leaps
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
    surprise = _surprises(place)
    hard, usual = HARDEST / motion.fps**2, max(LEAST, LEAPS * float(np.median(surprise)))
    # who is away for one frame is thrown there and back at once, twice as hard as by each leap
    leaps = np.flatnonzero(surprise > max(usual, 0.5 * hard)).tolist()
    run_up, free = max(1, round(RUN_UP * motion.fps)), 0
    for k, start in enumerate(leaps):
        if start < free:
            continue
        for stop in leaps[k + 1 :]:
            if stop - start > LONGEST * motion.fps:
                break
            harder = stop == start + 1 or min(surprise[start], surprise[stop]) > hard
            alone = stop == leaps[k + 1] and _apart(leaps, k)
            if harder and closes(place, start, stop, run_up, alone=alone):
                found[start:stop, moves], free = True, stop + 1
                break
    return found


def _apart(leaps: list[int], k: int) -> bool:
    """Whether the k-th leap and the one after it are far from each other and from all others."""
    gaps = np.diff([-np.inf, *leaps[max(k - 1, 0) : k + 3], np.inf])
    return bool((gaps > 2 * BESIDE).all())


def _surprises(place: Floats) -> Floats:
    """(T,) m by which the step to each frame differs from the middle one about it; 0 where it cannot be told.

    The middle one is that nearest to all others, whichever way the axes lie. Neither of the two steps of who is away
    for one frame makes the other look usual.
    """
    steps = np.pad(np.diff(place, axis=0), ((BESIDE, BESIDE), (0, 0)), mode="edge")
    about = sliding_window_view(steps, 2 * BESIDE + 1, axis=0)
    known = np.isfinite(about).all(axis=1)
    away = np.where(known, 0.0, np.inf)  # of each step, the distances to the others in sum
    for one, other in combinations(range(about.shape[2]), 2):
        apart = np.nan_to_num(np.linalg.norm(about[:, :, one] - about[:, :, other], axis=1))
        away[:, one] += apart
        away[:, other] += apart
    usual = np.take_along_axis(about, np.argmin(away, axis=1)[:, None, None], axis=2)[:, :, 0]
    usual = np.where(known.sum(axis=1, keepdims=True) > BESIDE, usual, np.nan)
    surprise = np.zeros(len(place))
    surprise[1:] = np.nan_to_num(np.linalg.norm(steps[BESIDE:-BESIDE] - usual, axis=1))
    return surprise


def closes(place: Floats, start: int, stop: int, run_up: int, *, alone: bool = False) -> bool:
    """True if a path goes on after a stretch much as it came, and not within it.

    Parameters
    ----------
    place : (T, 3) m.
    start, stop : the stretch's first frame and the one after its last.
    run_up : frames on either side that tell how fast it moves.
    alone : nothing leaps near its ends or between them, so that it is enough if it leaps back by as much as away.
    """
    last, first = start - 1, stop
    back, on = max(0, last - run_up), min(len(place) - 1, first + run_up)
    speeds = [(place[b] - place[a]) / (b - a) for a, b in ((back, last), (first, on)) if b > a]
    if not speeds:
        return False
    way = np.mean(speeds, axis=0)
    missed = place[first] - place[last] - way * (first - last)
    leaps = [place[start] - place[last] - way, place[stop] - place[stop - 1] - way]
    # Who turns or jumps meanwhile comes out elsewhere than straight ahead; what was put aside comes back by as much.
    least = min(np.linalg.norm(missed), np.linalg.norm(leaps[0] + leaps[1]) if alone else np.inf)
    return bool(least < CLOSES * min(np.linalg.norm(leap) for leap in leaps))
