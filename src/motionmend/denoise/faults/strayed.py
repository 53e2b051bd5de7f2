"""Markers that stray just before they are lost, and as they come back: half hidden, or taken for one with another.

A camera that sees the edge of a marker, or two in one, has it elsewhere by millimetres and centimetres. It gets there
by and by, so that nothing leaps, and the gap is filled from where it strayed to. The samples beside each gap are
hidden, filled from the markers about them, and believed again but for those from the gap on that are far from there.
"""

from collections.abc import Iterable

import numpy as np

from ...arrays import Bools, Floats, runs
from ..channels.pieces import PIECE, blocks
from ..gaps.markers import LEAST_FRAMES, fill_gaps

BESIDE = 2.0  # s of a long recording that a piece sees of its neighbours
EDGE, FEWEST = 0.08, 3  # s and frames beside a gap that may have strayed
SHORTEST = 0.03  # s; a gap no longer is bridged by how the marker moves
SEEN = 3.0  # times as many frames have to be seen on end beside a gap, or none of them is asked
SURE, BEGINS = 4.0, 2.0  # deviations: who is farther has strayed, and began to where it was as far as that
LEAST = 0.004  # m; skin moves as far
BACK = 0.2  # of that, the mean of the other frames asked: a hand that moves as nowhere else stays away in all of them
AT_LEAST = 2  # frames; one alone is found among outliers, or hardly matters


def strayed(positions: Floats, std: Floats, missing: Bools, fps: float) -> Bools:
    """Samples of markers that strayed beside a gap.

    Parameters
    ----------
    positions : (T, M, 3) m, repaired; NaN = missing or not believed.
    std : (T, M) m per coordinate.
    missing : (T, M) True where none was recorded.
    fps : Hz.

    Returns
    -------
    (T, M) True from where a marker begins to stray to the gap, and from the gap to where it is back.
    """
    found = np.zeros(missing.shape, dtype=np.bool_)
    if not missing.any():
        return found
    for own, seen in blocks(len(positions), PIECE, round(BESIDE * fps)):
        part = _strayed(positions[seen], std[seen], missing[seen], fps)
        found[own] = part[own.start - seen.start : own.stop - seen.start]
    return found


def away_and_doubt(positions: Floats, std: Floats, asked: Bools, fps: float) -> tuple[Floats, Floats]:
    """How far samples are from where the markers about them have them, and the standard deviation of that.

    Parameters
    ----------
    positions, std : (T, M, 3) m, NaN = missing or not believed, and (T, M) m per coordinate.
    asked : (T, M) which samples; all of them are hidden at once.
    fps : Hz.

    Returns
    -------
    (T, M) and (T, M) m; NaN where nothing tells, or nothing is asked.
    """
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    filled = fill_gaps(np.where((asked | ~seen)[..., None], np.nan, positions), fps, asked=asked)
    told = asked & seen & filled.filled
    away = np.where(told, np.sqrt(np.square(positions - filled.values).sum(axis=2)), np.nan)
    return away, np.where(told, np.sqrt(3.0 * (np.square(filled.std) + np.square(std))), np.nan)


def _strayed(positions: Floats, std: Floats, missing: Bools, fps: float) -> Bools:
    found = np.zeros(missing.shape, dtype=np.bool_)
    edges = _edges(np.asarray(np.isfinite(positions).all(axis=2)), missing, fps)
    if not edges or len(positions) < 2 * LEAST_FRAMES:
        return found
    asked = np.zeros(missing.shape, dtype=np.bool_)
    for marker, frames in edges:
        asked[frames, marker] = True
    away, doubt = away_and_doubt(positions, std, asked, fps)
    off = away > BEGINS * doubt
    far = away > np.maximum(SURE * doubt, LEAST)
    for marker, frames in edges:
        count = int(np.logical_and.accumulate(off[frames, marker]).sum())
        here, home = frames[:count], frames[count:]
        # all of them: the marker may be at home there
        if count >= AT_LEAST and home and far[here, marker].any():
            found[here, marker] |= _mean_of_known(away[home, marker]) <= BACK * away[here, marker].max()
    return found


def _mean_of_known(away: Floats) -> float:
    known = away[np.isfinite(away)]
    return float(known.mean()) if len(known) else 0.0


def _edges(seen: Bools, missing: Bools, fps: float) -> list[tuple[int, list[int]]]:
    """Markers, and frames beside a gap in which each is seen, that next to the gap first."""
    length, shortest = max(FEWEST, round(EDGE * fps)), SHORTEST * fps
    found: list[tuple[int, list[int]]] = []

    def beside(marker: int, gap: slice, frames: Iterable[int]) -> None:
        if gap.stop - gap.start > shortest and missing[gap, marker].any():
            found.append((marker, list(frames)))

    for marker in np.flatnonzero(missing.any(axis=0)).tolist():
        stretches = runs(seen[:, marker])
        ends = [0, *(stop for _, stop in stretches)]
        starts = [*(start for start, _ in stretches), len(seen)]
        for number, (start, stop) in enumerate(stretches):
            if stop - start >= SEEN * length:
                beside(marker, slice(ends[number], start), range(start, start + length))
                beside(marker, slice(stop, starts[number + 1]), range(stop - 1, stop - 1 - length, -1))
    return found
