"""Markers away from their place for a while: at a reflection, at another marker, where a tracker went wrong.

Such a stretch is smooth, and longer than any outlier: only its ends, where the marker leaps away and back, and the
markers about it tell. Where a marker leaps, its stretches between leaps are compared with where the others have it most
of the time. Those that are elsewhere are hidden, filled from the markers about them, and believed again where the
filling comes out where they were.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_opening

from ...arrays import Bools, Floats, Ints, runs
from ...numerics.quantiles import median
from ...numerics.robust import ESTIMATORS
from ..bases.support import interpolated
from ..channels.cloud import distance_change
from ..channels.pieces import PIECE, blocks
from ..gaps.markers import LEAST_FRAMES, fill_gaps
from ..gaps.segment_frame import ANCHORS, segment_frame, within

BESIDE = 2.0  # s of a long recording that a piece sees of its neighbours
LEAPS = 4.0  # times a marker's usual surprise from frame to frame, from which it may have leapt
LEAST = 0.02  # m; no leap is shorter
UNSEEN = 0.04  # m away from which a stretch between two gaps may be elsewhere, though no leap is seen
GUIDES, FEWEST = 8, 3  # markers that tell where one is to be, and how many of them have to
# guides whose distances are asked, quantiles of these at home and away, and m beyond
NEAREST, USUAL, MOSTLY, SLACK = 4, (0.01, 0.99), (0.3, 0.7), 0.01
MOST = 0.5  # of them are more to be unusual where no leap is seen: a limb bends as never before from a few of them
LOOKED, LEARNED = 300, 800  # frames that tell which they are, and how
ELSEWHERE = 3.0  # times as far from where they have it as usual
LONGEST = 1 / 3  # of the recording: what is elsewhere for longer may be at home there
ALONE = 0.5  # of its guides that may be elsewhere at the time; else it is a limb that moves as never before
SURE = 3.0  # deviations of the filling
AT_ONCE = 0.3  # of how far it is away it leaps at either end: a posture never seen before is reached by and by
SHORTEST, FRAMES = 0.05, 2  # s and frames; who is away for no more is found among outliers, and such a gap is no end
_TIMES_USUAL = 3.0  # times the median error from which samples tell little
_LEAST_USUAL = 1e-4  # m
_RIDGE = 0.01  # of the variance of what the guides do
_ROUNDS = 12


def displaced(positions: Floats, fps: float) -> Bools:
    """Samples of markers that are not in their place.

    Parameters
    ----------
    positions : (T, M, 3) m, NaN = missing or known to be wrong.
    fps : Hz.

    Returns
    -------
    (T, M) True where a marker was seen elsewhere.
    """
    found = np.zeros(positions.shape[:2], dtype=bool)
    for own, seen in blocks(len(positions), PIECE, round(BESIDE * fps)):
        found[own] = _displaced(positions[seen], fps)[own.start - seen.start : own.stop - seen.start]
    return found


def lasting(rejected: Bools, fps: float) -> Bools:
    """(T, M) of the samples rejected as outliers those of runs that are too long for a lone outlier or two."""
    length = round(_shortest(fps)) + 1
    return np.asarray(binary_opening(rejected, np.ones((length, 1), dtype=np.bool_)))


def _shortest(fps: float) -> float:
    return max(SHORTEST * fps, FRAMES)


def _displaced(positions: Floats, fps: float) -> Bools:
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    found = np.zeros(seen.shape, dtype=bool)
    shortest = _shortest(fps)
    bridged = _bridged(positions, seen, shortest)
    stretches = _elsewhere(positions, bridged, seen) if len(seen) >= 2 * LEAST_FRAMES else []
    if not stretches:
        return found
    hidden: Bools = np.asarray(np.isnan(bridged).any(axis=2))
    asked = np.zeros(seen.shape, dtype=bool)
    for one in stretches:
        start, stop = _with_gaps_beside(one, seen)  # lines across a leap are no places
        hidden[start:stop, one.marker] = asked[start:stop, one.marker] = True
    filled = fill_gaps(np.where(hidden[..., None], np.nan, bridged), fps, asked=asked)
    noise = np.fmax.reduce(np.where(hidden, np.nan, filled.std), axis=0)
    away = np.where(seen & filled.filled, np.square(positions - filled.values).sum(axis=2), np.nan)
    doubt = 3.0 * (np.square(filled.std) + np.square(noise))
    for one in stretches:
        marker, here = one.marker, one.start + np.flatnonzero(np.isfinite(away[one.start : one.stop, one.marker]))
        if one.odd and len(here) and hidden[one.start : one.stop, one.guides].mean() <= ALONE:
            found[here, marker] = away[here, marker].mean() > max(SURE**2 * doubt[here, marker].mean(), LEAST**2)
    for marker in np.flatnonzero(found.any(axis=0)).tolist():
        there = np.flatnonzero(np.isfinite(away[:, marker]) | (seen[:, marker] & ~found[:, marker]))
        for start, stop in runs(found[there, marker]):  # whatever is missing between
            here, ends = there[start:stop], [start] * (start > 0) + [stop - 1] * (stop < len(there))
            if (away[there[ends], marker] < AT_ONCE**2 * away[here, marker].mean()).any():
                found[here, marker] = False
    found[:, found.sum(axis=0) <= shortest] = False
    return found


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Frames of a marker, from `start` to before `stop`, between leaps and long gaps.

    Attributes
    ----------
    guides : (G,) the markers that tell where it is to be.
    odd : whether its distances to the nearest of them tell of it, too: where they do not it is only no guide.
    """

    marker: int
    guides: Ints
    start: int
    stop: int
    odd: bool


def _with_gaps_beside(one: _Stretch, seen: Bools) -> tuple[int, int]:
    """First frame, and the first after the last, of a stretch and of what is missing just before and after it."""
    there = np.flatnonzero(seen[:, one.marker])
    before, after = there[there < one.start], there[there >= one.stop]
    return int(before[-1]) + 1 if len(before) else 0, int(after[0]) if len(after) else len(seen)


def _elsewhere(positions: Floats, bridged: Floats, seen: Bools) -> list[_Stretch]:
    """The stretches that may be elsewhere."""
    frames = len(seen)
    leaps = _leaps(bridged)
    leaping = leaps.any(axis=0) | _between_gaps(bridged)
    if not leaping.any():
        return []
    places, about = steadiest_guides(positions)
    found = []
    for marker in np.flatnonzero(leaping).tolist():
        if marker not in about:
            continue
        guides, unsteady = about[marker]
        there = seen[:, marker]
        known = np.isfinite(bridged[:, marker, 0])
        edges = np.flatnonzero(leaps[:, marker] | np.diff(known, prepend=known[0]))
        away = place_by_guides(places, marker, guides, unsteady, there, edges)
        limit = max(0.5 * LEAST if leaps[:, marker].any() else UNSEEN, ELSEWHERE * float(np.median(away[there])))
        for start, stop in zip([0, *edges.tolist()], [*edges.tolist(), frames], strict=True):
            here = away[start:stop][there[start:stop]]
            if len(here) and stop - start <= LONGEST * frames and median(here) > limit:
                nearest = positions[:, [marker, *guides[:NEAREST]]]
                at_home: Bools = np.asarray(there & (away <= limit))
                unusual, told = _unusual_distances(nearest[start:stop], nearest[at_home])
                if leaps[[at for at in (start, stop) if at < frames], marker].any():
                    odd = unusual > 0 or told < FEWEST
                else:  # gaps or ends about it: only the guides tell that it came back elsewhere
                    odd = unusual > MOST * told
                found.append(_Stretch(marker, guides, start, stop, odd))
    return found


def _unusual_distances(here: Floats, home: Floats) -> tuple[int, int]:
    """To how many markers the first of some (T, G, 3) m is nearer or farther than at home (U, G, 3), and how many tell.

    How it moves with them was learned from postures that may be others; what is elsewhere is nearer to some or farther.
    """
    apart, usual = (np.linalg.norm(places[:, 1:] - places[:, :1], axis=2) for places in (here, home))
    unusual = told = 0
    for now, then in zip(apart.T, usual.T, strict=True):
        now, then = now[np.isfinite(now)], then[np.isfinite(then)]
        if len(now) and len(then):
            least, most = np.quantile(then, USUAL)
            nearest, farthest = np.quantile(now, MOSTLY)
            unusual += bool(nearest < least - SLACK or farthest > most + SLACK)
            told += 1
    return unusual, told


def _between_gaps(bridged: Floats) -> Bools:
    """(M,) True for a marker that comes back from one long gap and goes into another: it may have leapt in both."""
    known: Bools = np.asarray(np.isfinite(bridged).all(axis=2))
    comes, goes = known[1:] & ~known[:-1], known[:-1] & ~known[1:]
    later = np.cumsum(goes[::-1], axis=0)[::-1] > 0
    return np.asarray((comes & later).any(axis=0))


def _bridged(positions: Floats, seen: Bools, shortest: float) -> Floats:
    """Places (T, M, 3) m with gaps of so many frames at most bridged by lines: they are no leaps."""
    frames, markers = seen.shape
    lines = interpolated(positions.reshape(frames, 3 * markers)).reshape(positions.shape)
    short = np.zeros(seen.shape, dtype=bool)
    for marker in range(markers):
        for start, stop in runs(~seen[:, marker]):
            short[start:stop, marker] = start > 0 and stop < frames and stop - start <= shortest
    return np.where((seen | short)[:, :, None], lines, np.nan)


def _leaps(positions: Floats) -> Bools:
    """(T, M) True in the frames to which a marker may have leapt."""
    steps = np.diff(positions, axis=0)
    about = np.full((2, *steps.shape), np.nan)  # the steps before and after each
    about[0, 1:], about[1, :-1] = steps[:-1], steps[1:]
    known = np.isfinite(about)
    mean = np.where(known, about, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    surprise = np.sqrt(np.square(steps - mean).sum(axis=2))
    usual = np.nanmedian(np.where(np.isfinite(surprise).any(axis=0), surprise, 0.0), axis=0)
    leaps = np.zeros(positions.shape[:2], dtype=bool)
    leaps[1:] = np.nan_to_num(surprise) > np.maximum(LEAST, LEAPS * usual)
    return leaps


def steadiest_guides(positions: Floats) -> tuple[Floats, dict[int, tuple[Ints, Floats]]]:
    """Markers (T, M, 3) m with gaps bridged by lines, and of each its guides, (G,), and how unsteady they are to it, m.

    Markers with too few guides have none.
    """
    frames, markers = positions.shape[:2]
    unsteady = distance_change(positions[:: max(1, frames // LOOKED)])
    np.fill_diagonal(unsteady, np.inf)
    places = interpolated(positions.reshape(frames, 3 * markers)).reshape(positions.shape)
    found = {}
    for marker in range(markers):
        order = np.argsort(unsteady[marker], kind="stable")
        guides = order[np.isfinite(unsteady[marker, order])][:GUIDES]
        if len(guides) >= FEWEST:
            found[marker] = (guides, unsteady[marker, guides])
    return places, found


def place_by_guides(places: Floats, marker: int, guides: Ints, unsteady: Floats, seen: Bools, edges: Ints) -> Floats:
    """(T,) m from where its guides have a marker most of the time.

    How it moves with them is learned from changes between the edges of its stretches, so that no leap tells of it.
    """
    frame = segment_frame(places[:: max(1, len(places) // LOOKED)], guides[:ANCHORS], unsteady[:ANCHORS])
    inside = within(places[:, [*guides, marker]], *frame.at(places))
    mine, others = inside[:, -1], inside[:, :-1].reshape(len(places), -1)
    some = np.flatnonzero(seen)
    some = some[:: max(1, len(some) // LEARNED)]
    stretch = np.searchsorted(edges, some, side="right")
    x, y = _about_means(others[some], stretch), _about_means(mine[some], stretch)
    ridge = _RIDGE * len(some) * max(float(others[some].var(axis=0).mean()), _LEAST_USUAL**2) * np.eye(x.shape[1])
    slope: Floats = np.zeros((x.shape[1], 3))
    for _ in range(_ROUNDS):
        weighted = x * _belief(y - x @ slope)[:, None]
        slope = np.asarray(np.linalg.solve(weighted.T @ x + ridge, weighted.T @ y), dtype=np.float64)
    rest = mine - others @ slope
    home: Floats = np.asarray(np.median(rest[some], axis=0), dtype=np.float64)
    for _ in range(_ROUNDS):
        weight = _belief(rest[some] - home)
        home = np.asarray(weight @ rest[some] / weight.sum(), dtype=np.float64)
    return np.asarray(np.sqrt(np.square(rest - home).sum(axis=1)))


def _belief(errors: Floats) -> Floats:
    """(N,) Welsch's weights of errors (N, 3) m, by their median."""
    size = np.sqrt(np.square(errors).sum(axis=1))
    usual = max(float(median(size)), _LEAST_USUAL)
    return np.asarray(ESTIMATORS["welsch"].weight(size / (_TIMES_USUAL * usual), 1.0))


def _about_means(values: Floats, group: Ints) -> Floats:
    """(N, F) values less the mean of their group (N,), which never falls."""
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    length = np.diff([*starts, len(group)])
    return np.asarray(values - (np.add.reduceat(values, starts, axis=0) / length[:, None]).repeat(length, axis=0))
