"""A marker that froze by itself: it repeats to the last digit while those about it go on, and then leaps after them.

What a marker at rest repeats is where those about it have it, too. A program that holds the last place of a marker
leaves it behind.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.motion import Markers
from ..channels.joints import CENTIMETRES
from ..channels.pieces import PIECE, blocks
from ..gaps.markers import LEAST_FRAMES
from .displaced import BESIDE, ELSEWHERE, place_by_guides, steadiest_guides
from .frozen import LEAPS, ROUNDED, parts_of, repeats

FEWEST = 2  # repeats; one alone is hardly behind
LEFT_BEHIND = 0.003  # m, at least, from where those about it have it
CAUGHT_UP = 0.5  # of that is left at most after the leap


@dataclass(frozen=True)
class _Hold:
    """Samples of a marker that repeat the one before, from frame `start` to before frame `stop`.

    Attributes
    ----------
    least : m, from which it is left behind.
    """

    marker: int
    start: int
    stop: int
    least: float

    def since(self, frame: int) -> "_Hold":
        """The same in a part of the recording that begins at this frame."""
        return replace(self, start=self.start - frame, stop=self.stop - frame)


def frozen_alone(markers: Markers, lost: Bools) -> Bools:
    """Samples of single markers that are frozen.

    Parameters
    ----------
    markers : T frames, M markers.
    lost : (T, M) samples known to be wrong.

    Returns
    -------
    (T, M) True where a marker repeats the sample before, those about it have it elsewhere, and it then leaps to where
    they have it.
    """
    found: Bools = np.zeros(lost.shape, dtype=np.bool_)
    held = [
        _Hold(int(columns[0]), start + 1, stop + 1, max(LEFT_BEHIND, ROUNDED * step / CENTIMETRES))
        for columns, values, step in parts_of(markers)
        for start, stop in _leaping(values, step, markers.fps)
        if not lost[start + 1 : stop + 1, columns[0]].any()
    ]
    if not held:
        return found
    beside = round(BESIDE * markers.fps)
    for own, seen in blocks(markers.frames, PIECE, beside):
        begun = [one for one in held if own.start <= one.start < own.stop]
        if not begun:
            continue
        part = slice(seen.start, min(markers.frames, max(seen.stop, *(one.stop + beside for one in begun))))
        believed = np.isfinite(markers.positions[part]).all(axis=2) & ~lost[part]
        for one in held:
            believed[max(one.start - part.start, 0) : max(one.stop - part.start, 0), one.marker] = False
        positions = np.where(lost[part, :, None], np.nan, markers.positions[part])
        for one in _left_behind(positions, believed, [one.since(part.start) for one in begun]):
            found[part.start + one.start : part.start + one.stop, one.marker] = True
    return found


def _leaping(values: Floats, step: float, fps: float) -> list[tuple[int, int]]:
    """Runs of repeats, from step to before step, after which a marker's path (T, 3) leaps on."""
    found = repeats(values, step, fps)
    some = (found.out > LEAPS) & (found.stop - found.start >= FEWEST)
    return list(zip(found.start[some].tolist(), found.stop[some].tolist(), strict=True))


def _left_behind(positions: Floats, believed: Bools, held: list[_Hold]) -> list[_Hold]:
    """Of some holds in positions (T, M, 3) m those in which the marker is left behind by its guides.

    Only what is believed (T, M) tells how it moves with them.
    """
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    places, about = steadiest_guides(np.where(believed[..., None], positions, np.nan))
    found = []
    told = set(np.flatnonzero(believed.sum(axis=0) >= LEAST_FRAMES).tolist())
    for marker in sorted({one.marker for one in held} & set(about) & told):
        of_marker = [one for one in held if one.marker == marker]
        bridged = places[:, marker].copy()
        places[seen[:, marker], marker] = positions[seen[:, marker], marker]
        edges = np.array(sorted({edge for one in of_marker for edge in (one.start, one.stop)}), dtype=np.int64)
        away = place_by_guides(places, marker, *about[marker], believed[:, marker], edges)
        places[:, marker] = bridged  # as those that it guides are to see it
        usual = float(np.median(away[believed[:, marker]]))
        for one in of_marker:
            behind = away[one.stop - 1]
            if behind > max(one.least, ELSEWHERE * usual) and away[one.stop] < CAUGHT_UP * behind:
                found.append(one)
    return found
