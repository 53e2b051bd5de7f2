"""A root that leaps away and back: nobody's pelvis does, whatever it does in between.

A body that is taken for another, or lost by its markers, is thrown to another place for some frames. There it moves as
smoothly as ever, so that a smoother takes the leaps for motion. No muscle throws a pelvis so far in one frame.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ..channels.joints import root_rows

HARDEST = 300.0  # m/s²; pelves of jumpers and gymnasts are thrown by a third of that
LEAST, LEAPS = 0.1, 6.0  # m and times the usual surprise from frame to frame; what leaps by less is noise
MEDIAN_OF_QUARTILE = 1.4  # of how far noise leaps in space
LONGEST = 1.0  # s away; whoever stays longer may have been put there
CLOSES = 0.3  # of the leap, by which what comes before and after it may fail to meet
BESIDE = 3  # steps on either side of one that tell whether it leaps
FEW = 2  # frames, each of which may be elsewhere of its own
WITHIN = 1, 3, 7  # frames at the ends of a stretch that tell where it lies
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
    # where more than a quarter of all frames are off, half of all leap there or back
    middle = min(float(np.median(surprise)), MEDIAN_OF_QUARTILE * float(np.quantile(surprise, 0.25)))
    hard, usual = HARDEST / motion.fps**2, max(LEAST, LEAPS * middle)
    # who is away for one frame is thrown there and back at once, twice as hard as by each leap
    leaps = np.flatnonzero(surprise > max(usual, 0.5 * hard)).tolist()
    edges = np.array(leaps, dtype=np.int64)
    put_aside = {n: _leaps(place, steps, edges, ABOUT, n) for n in WITHIN}
    put_back = {n: _leaps(place, steps, edges, n, ABOUT) for n in WITHIN}
    over = {n: np.linalg.norm(_leaps(place, steps, edges, ABOUT, ABOUT, between=n), axis=1) for n in range(1, FEW + 1)}
    run_up, free = max(1, round(RUN_UP * motion.fps)), 0
    for k, start in enumerate(leaps):
        if start < free:
            continue
        for j, stop in enumerate(leaps[k + 1 :], k + 1):
            if stop - start > LONGEST * motion.fps:
                break
            away, length = min(surprise[start], surprise[stop]), stop - start
            within = 1 if length <= FEW else max(n for n in WITHIN if n <= length)
            put, back = put_aside[within][k], put_back[within][j]
            far = min(np.linalg.norm(put), np.linalg.norm(back))
            if np.isnan(far) or far < NEARER * away or (length > 1 and away <= hard):
                continue
            missed = over[length][k] if length <= FEW else np.linalg.norm(put + back)
            alone = j == k + 1 and _apart(leaps, k)
            if missed < CLOSES * far or closes(place, start, stop, run_up, alone=alone):
                if length > FEW:
                    start = _edge(place, steps, start, put, ABOUT, min(ABOUT, length))
                    stop = _edge(place, steps, stop, back, min(ABOUT, stop - start), ABOUT)
                found[start:stop, moves], free = True, stop
                break
    return found


def _edge(place: Floats, steps: Floats, about: int, leap: Floats, before: int, after: int) -> int:
    """The frame near a leap (3,) m from which on most lie where it leads; single ones that are off do not tell it.

    So many frames `before` and `after` are looked at.
    """
    frames = np.arange(max(0, about - before), min(len(place), about + after))
    pace = _middle(steps[None, np.minimum(frames, len(steps) - 1)])[0]
    at_once = place[frames] - pace * (frames - about)[:, None]
    origin = _middle(at_once[None, frames < about])[0]
    most = 0.5 * float(np.linalg.norm(leap))
    off, gone = (
        np.minimum(np.nan_to_num(np.linalg.norm(at_once - there, axis=1), nan=most), most)
        for there in (origin, origin + leap)
    )
    cost = np.r_[0.0, np.cumsum(off)] + np.r_[np.cumsum(gone[::-1])[::-1], 0.0]
    # frames that are in neither place cost the same on either side: rounding does not choose
    return int(frames[0] + np.flatnonzero(cost <= cost.min() + 1e-9 * most)[0])


def _leaps(place: Floats, steps: Floats, leaps: Ints, before: int, after: int, between: int = 0) -> Floats:
    """(N, 3) m by which most of the frames from each leap on lie off, whatever single ones do, and those `between`."""
    away = np.r_[-before:0, between : between + after]
    frames = leaps[:, None] + away
    there = ((frames >= 0) & (frames < len(place)))[..., None]
    some = np.where(there, place[np.clip(frames, 0, len(place) - 1)], np.nan)
    pace = _middle(np.where(there, steps[np.clip(frames, 0, len(steps) - 1)], np.nan))
    at_once = some - pace[:, None] * away[:, None]
    return _middle(at_once[:, before:]) - _middle(at_once[:, :before])


def _apart(leaps: list[int], k: int) -> bool:
    """Whether the k-th leap and the one after it are far from each other and from all others."""
    gaps = np.diff([-np.inf, *leaps[max(k - 1, 0) : k + 3], np.inf])
    return bool((gaps > 2 * BESIDE).all())


def _usual_steps(place: Floats) -> Floats:
    """(T - 1, 3) m, the middle of the steps about each; NaN where it cannot be told.

    Neither of the two steps of who is away for one frame makes the other look usual.
    """
    steps = np.pad(np.diff(place, axis=0), ((BESIDE, BESIDE), (0, 0)), mode="edge")
    about: Floats = sliding_window_view(steps, 2 * BESIDE + 1, axis=0).swapaxes(1, 2)
    known: Bools = np.asarray(np.isfinite(about).all(axis=2))
    return np.where(known.sum(axis=1, keepdims=True) > BESIDE, _middle(about), np.nan)


def _middle(points: Floats) -> Floats:
    """(N, 3), the one of least distance to all K known of (N, K, 3) in sum (a geometric median), NaN if none is known.

    It is the same whichever way the axes lie.
    """
    from ...kernels.medians import geometric_medians

    return np.asarray(geometric_medians(np.ascontiguousarray(points), WEISZFELD, 1e-6))


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
