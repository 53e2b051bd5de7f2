"""Markers that stay where they are, in the room, while the body goes on, and leap to it afterwards.

A tracker that follows a reflection, or that repeats its last word before noise came upon it, says a place that does not
move. It begins where the marker was, so that no leap is seen there, and lasts too long for an outlier: the leap at its
end is then taken for one that leads away, and all that follows for wrong. The markers about it tell: carried along with
them, the marker is not where it stood, but where it leaps to. A foot on the ground stands as well, but does not leap.
"""

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers
from ...numerics.quantiles import median
from ..channels.cloud import distance_change
from ..channels.joints import CENTIMETRES
from ..channels.pieces import PIECE, blocks
from ..gaps.segment_frame import ANCHORS, segment_frame, within, without
from ..noise.level import first_noise

BESIDE = 10.0  # s of a long recording that a piece sees of its neighbours
LEAPS = 4.0  # times a marker's usual surprise from frame to frame, from which it may have leapt
LEAST = 0.02  # m; no leap is shorter
SHORTEST, FRAMES = 0.06, 3  # s and frames; who stands for less is found among outliers
WITHIN = 4.0  # deviations of the noise about a place within which who stands stays
QUIET = 0.0005  # m; less noise than that is not asked for
AGAIN = 2  # frames beyond it, one after the other, with which standing begins
AFTER = 3  # frames that tell whether a leap leads away for good
HALF = 0.5  # of the leap: so far it stood from where those about it have it; and no more than of that after the leap
GUIDES, FEWEST = 8, 4  # markers that move most as it does, and how many of them have to be seen
LOOKED = 300  # frames that tell which they are


def stood_still(recording: Markers) -> Bools:
    """Samples of markers that stood while those about them went on.

    Parameters
    ----------
    recording : T frames of M markers.

    Returns
    -------
    (T, M) True from the frame after the last that was right to the one before it leaps back.
    """
    positions, fps = recording.positions, recording.fps
    found = np.zeros(positions.shape[:2], dtype=np.bool_)
    for own, seen in blocks(len(positions), PIECE, round(BESIDE * fps)):
        found[own] = _stood(positions[seen], fps)[own.start - seen.start : own.stop - seen.start]
    return found


def _stood(positions: Floats, fps: float) -> Bools:
    frames, markers = positions.shape[:2]
    found = np.zeros((frames, markers), dtype=np.bool_)
    least = max(FRAMES, round(SHORTEST * fps))
    if frames <= least or markers <= FEWEST or not (leaps := _leaps(positions)).any():
        return found
    noise = first_noise(CENTIMETRES * positions.reshape(frames, -1)).reshape(markers, 3).max(axis=1) / CENTIMETRES
    reach = WITHIN * np.maximum(noise, QUIET)
    stands = [
        (marker, start, leap)
        for marker in np.flatnonzero(leaps.any(axis=0)).tolist()
        for leap in np.flatnonzero(leaps[:, marker]).tolist()
        if leap - (start := _since(positions[:leap, marker], reach[marker], least)) >= least
    ]
    if not stands:
        return found
    standing = np.zeros((frames, markers), dtype=np.bool_)
    for marker, start, leap in stands:
        standing[start : leap + 1, marker] = True
    unsteady = distance_change(positions[:: max(1, frames // LOOKED)])
    np.fill_diagonal(unsteady, np.inf)
    for marker, start, leap in stands:
        nearest = np.argsort(unsteady[marker], kind="stable")
        nearest = nearest[np.isfinite(unsteady[marker, nearest])]
        frames_asked = np.clip([start, *range(leap - AFTER, leap + AFTER)], start, frames - 1)
        asked = positions[frames_asked]
        there = np.isfinite(asked).all(axis=(0, 2)) & ~standing[start : leap + 1].any(axis=0)
        guides = nearest[there[nearest]][:GUIDES]
        if len(guides) >= FEWEST and _carried_on(asked, marker, guides, unsteady[marker, guides]):
            found[start + 1 : leap, marker] = np.isfinite(positions[start + 1 : leap, marker, 0])
    return found


def _leaps(positions: Floats) -> Bools:
    """(T, M) True in the frames to which a marker leaps, and from which it does not come back at once."""
    steps = np.diff(positions, axis=0)
    before = np.full(steps.shape, np.nan)
    before[1:] = steps[:-1]
    surprise = np.linalg.norm(steps - before, axis=2)
    told = np.where(np.isfinite(surprise).any(axis=0), surprise, 0.0)
    usual = np.nanmedian(told, axis=0)
    leaps = np.zeros(positions.shape[:2], dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        leaps[1:] = surprise > np.maximum(LEAST, LEAPS * usual)
    for frame, marker in np.argwhere(leaps).tolist():
        after = positions[frame : frame + AFTER, marker]
        after = after[np.isfinite(after[:, 0])]
        here = positions[frame - 1, marker]
        far = np.linalg.norm(after - here, axis=1)
        leaps[frame, marker] = bool(median(far) > HALF * far[0] and far[0] > LEAST)
    return leaps


def _since(path: Floats, reach: float, least: int) -> int:
    """The first frame from which a marker (T, 3) m, NaN = missing, stands until the last; that after it if it moves."""
    last = path[-least:]
    place = median(last)
    if len(last) < least or not (np.linalg.norm(last - place, axis=1) <= reach).all():
        return len(path)
    start, beyond = len(path) - least, 0
    for frame in range(start - 1, -1, -1):
        if np.linalg.norm(path[frame] - place) <= reach:
            start, beyond = frame, 0
            if (len(path) - start) % least == 0:
                place = np.nanmedian(path[start:], axis=0)
        else:
            beyond += 1
            if beyond == AGAIN:
                break
    return start


def _carried_on(asked: Floats, marker: int, guides: Ints, unsteady: Floats) -> bool:
    """True where a marker, carried along with its guides, is not where it stood to the last but where it leapt to.

    Parameters
    ----------
    asked : (1 + 2 AFTER, M, 3) m, in the first frame in which it stands, the last ones, and those after the leap.
    unsteady : (G,) m, how unsteady the guides are to it.
    """
    frame = segment_frame(asked, guides[:ANCHORS], unsteady[:ANCHORS])
    place, axes = frame.at(asked)
    at_first = within(asked[:1, [marker]], place[:1], axes[:1])
    carried = without(np.broadcast_to(at_first, (len(asked), 1, 3)), place, axes)[:, 0]
    off = np.linalg.norm(asked[:, marker] - carried, axis=1)
    stood, went_on = slice(1, 1 + AFTER), slice(1 + AFTER, None)
    leap = np.linalg.norm(asked[1 + AFTER, marker] - asked[AFTER, marker])
    away = np.nanmin(off[stood])
    return bool(away >= max(LEAST, HALF * leap) and np.nanmedian(off[went_on]) <= HALF * away)
