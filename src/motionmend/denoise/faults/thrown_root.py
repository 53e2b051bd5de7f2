"""A root that leaps away and back: nobody's pelvis does, whatever it does in between.

A body that is taken for another, or lost by its markers, is thrown to another place for some frames. There it moves as
smoothly as ever, so that a smoother takes the leaps for motion. No muscle throws a pelvis so far in one frame.
"""

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
ABOUT, NEARER = 7, 0.7  # frames on either side, and of a leap how far most of them have to be from a stretch
WEISZFELD = 12  # iterations
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
    steps = _usual_steps(place)
    surprise = np.zeros(len(place))
    surprise[1:] = np.nan_to_num(np.linalg.norm(np.diff(place, axis=0) - steps, axis=1))
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
            away, alone = min(surprise[start], surprise[stop]), stop == leaps[k + 1] and _apart(leaps, k)
            there = (stop == start + 1 or away > hard) and closes(place, start, stop, run_up, alone=alone)
            if there and _elsewhere(place, steps, start, stop, away):
                found[start:stop, moves], free = True, stop + 1
                break
    return found


def _apart(leaps: list[int], k: int) -> bool:
    """Whether the k-th leap and the one after it are far from each other and from all others."""
    gaps = np.diff([-np.inf, *leaps[max(k - 1, 0) : k + 3], np.inf])
    return bool((gaps > 2 * BESIDE).all())


def _elsewhere(place: Floats, steps: Floats, start: int, stop: int, away: float) -> bool:
    """Whether a stretch [start, stop) lies elsewhere than most frames about it, and not only than those at its ends.

    `place` (T, 3) and the usual `steps` (T - 1, 3) are in m, and so is how far `away` it leaps at its ends. Between two
    frames that are off by much the same everything is at home.
    """
    for inside, outside in (
        (start, np.arange(max(0, start - ABOUT), start)),
        (stop - 1, np.arange(stop, min(len(place), stop + ABOUT))),
    ):
        way = steps[np.clip(outside, 0, len(steps) - 1)]
        gone = np.linalg.norm(place[inside] - place[outside] - way * (inside - outside)[:, None], axis=1)
        if np.isfinite(gone).any() and np.nanmedian(gone) < NEARER * away:
            return False
    return True


def _usual_steps(place: Floats) -> Floats:
    """(T - 1, 3) m, the middle of the steps about each; NaN where it cannot be told.

    The middle one has the least distance to all in sum (a geometric median), whichever way the axes lie. Neither of the
    two steps of who is away for one frame makes the other look usual.

    Source
    ------
    Weiszfeld, Sur le point pour lequel la somme des distances de n points donnes est minimum, Tohoku Mathematical
    Journal 43, 1937.
    """
    steps = np.pad(np.diff(place, axis=0), ((BESIDE, BESIDE), (0, 0)), mode="edge")
    about = sliding_window_view(steps, 2 * BESIDE + 1, axis=0)
    known: Bools = np.asarray(np.isfinite(about).all(axis=1))
    some = np.where(known[:, None], about, 0.0)
    middle = some.sum(axis=2) / np.maximum(known.sum(axis=1), 1)[:, None]
    for _ in range(WEISZFELD):
        worth = known / np.maximum(np.linalg.norm(some - middle[:, :, None], axis=1), 1e-6)
        middle = (some * worth[:, None]).sum(axis=2) / np.maximum(worth.sum(axis=1), 1e-12)[:, None]
    return np.asarray(np.where(known.sum(axis=1, keepdims=True) > BESIDE, middle, np.nan))


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
