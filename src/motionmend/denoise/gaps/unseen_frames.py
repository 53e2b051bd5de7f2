"""Frames without any marker, before the first, after the last or between: only the motion's going on tells of them.

How far a body is then from where it seemed to go is read off the recording itself: what is seen of it is followed from
anywhere in it for as long, by the line it moved along and by staying where it was, and the nearer of the two counts.
Between two ends it is led from one to the other instead, straight and by a cubic.
"""

from dataclasses import replace
from functools import cache, partial

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.motion import Markers, Origin, Recording, Repaired
from ..channels.joints import CENTIMETRES

FAR, MUCH = 0.05, 0.01  # m, and share of all samples: what is filled beyond what was seen of markers, and is said
LOOKED = 400  # frames from which it is followed, at most
BACK = 2  # frames over which a velocity is taken


def as_unsure_as_it_moves(outcome: Repaired[Recording]) -> Repaired[Recording]:
    """The repair with deviations of what is filled in frames without a marker, and a sentence for either end.

    Parameters
    ----------
    outcome : of any recording.

    Returns
    -------
    Just the same of joint angles, and where every frame has a marker.
    """
    some = np.flatnonzero((outcome.origin == Origin.MEASURED).any(axis=1))
    filled = outcome.origin == Origin.FILLED
    markers = outcome.recording
    if not (isinstance(markers, Markers) and 0 < len(some) < len(filled)):
        return outcome
    gaps = np.flatnonzero(np.diff(some) > 1)
    std = outcome.std.copy()
    if len(gaps):
        known = np.where((outcome.origin == Origin.MEASURED)[..., None], markers.positions, np.nan)
        across = cache(partial(between, known))  # gaps of one length are alike
        for before in gaps:
            gap = slice(int(some[before]) + 1, int(some[before + 1]))
            std[gap] = np.where(filled[gap], np.fmax(std[gap], across(gap.stop - gap.start)), std[gap])
        outcome = replace(outcome, std=std)
    first, last, frame = int(some[0]), int(some[-1]), np.arange(len(filled))
    ahead = np.maximum(first - frame, frame - last)  # frames beyond the ends
    beyond = filled & (ahead > 0)[:, None]
    rows = np.flatnonzero(beyond.any(axis=1))
    if not len(rows):
        return outcome
    off = farther_each_frame(markers.positions[first : last + 1], int(ahead[rows].max()))
    std[rows] = np.where(beyond[rows], np.fmax(std[rows], off[ahead[rows] - 1]), std[rows])
    said: list[str] = [
        f"no marker is seen in the {name} {count} frames: what is filled there goes on as the motion seems to, "
        f"and may be off by {CENTIMETRES * float(np.nanmax(std[part][beyond[part]])):.0f} cm and more"
        for name, count, part in (
            ("first", first, slice(0, first)),
            ("last", len(filled) - 1 - last, slice(last + 1, None)),
        )
        if beyond[part].any()
    ]
    return replace(outcome, std=std, warnings=(*outcome.warnings, *said))


def made_up_beyond(outcome: Repaired[Recording]) -> tuple[str, ...]:
    """A sentence where much is filled of markers before they come into view, or after they leave it, and is unsure."""
    markers, filled = outcome.recording, np.asarray(outcome.origin == Origin.FILLED)
    seen: Bools = np.asarray(outcome.origin <= Origin.REPAIRED)
    if not isinstance(markers, Markers) or not seen.any():
        return ()
    inside = np.logical_or.accumulate(seen, axis=0) & np.logical_or.accumulate(seen[::-1], axis=0)[::-1]
    somebody: Bools = np.asarray(seen.any(axis=1))
    beyond = filled & ~inside & seen.any(axis=0) & somebody[:, None]
    unsure = beyond & (outcome.std > FAR)
    if unsure.sum() < MUCH * filled.size:
        return ()
    return (
        f"{int(unsure.any(axis=0).sum())} markers come into view late or leave it early: what is filled of them there "
        f"({unsure.sum() / filled.size:.0%} of all samples) is led by the markers still seen and may be off by "
        f"{CENTIMETRES * float(np.quantile(outcome.std[unsure], 0.95)):.0f} cm; a limit (--max-std) leaves it open",
    )


def farther_each_frame(places: Floats, count: int) -> Floats:
    """How far points are, as a rule, from where they seemed to go so many frames ago.

    Parameters
    ----------
    places : (T, M, 3) m, NaN = missing.
    count : frames, at least 1.

    Returns
    -------
    (count, M) m, root mean square of one coordinate, never falling; what the recording is too short for goes on in
    proportion. NaN for a point of which nothing is known.
    """
    frames, points = places.shape[:2]
    off = np.full((count, points), np.nan)
    known = min(count, frames - 1)
    for ahead in range(1, known + 1):
        begin = np.arange(min(BACK, frames - 1 - ahead), frames - ahead)
        begin = begin[:: max(1, len(begin) // LOOKED)]
        moved = places[begin + ahead] - places[begin]
        speed = (places[begin] - places[np.maximum(begin - BACK, 0)]) / BACK
        ways = [np.square(moved), np.square(moved - ahead * speed)]
        seen = [np.isfinite(way).all(axis=2) for way in ways]
        squares = [np.where(there[..., None], way, 0.0).sum(axis=(0, 2)) for way, there in zip(ways, seen, strict=True)]
        counts = [np.where(there.any(axis=0), 3.0 * there.sum(axis=0), np.nan) for there in seen]
        off[ahead - 1] = np.sqrt(np.fmin(squares[0] / counts[0], squares[1] / counts[1]))
    if known:
        off[known:] = off[known - 1] * (np.arange(known, count) + 1.0)[:, None] / known
    return np.fmax.accumulate(off, axis=0)


def between(places: Floats, count: int) -> Floats:
    """How far points are, as a rule, from the line or the cubic (Hermite's) across frames in which nothing is seen.

    Parameters
    ----------
    places, count : as of `farther_each_frame`.

    Returns
    -------
    (count, M) m, root mean square of one coordinate. Where the recording shows a point nowhere for so long, what it
    moves ahead of the nearer end.
    """
    squares, seen = np.zeros((2, count, places.shape[1])), np.zeros((count, places.shape[1]))
    at = (np.arange(1, count + 1) / (count + 1))[:, None, None]
    begin = np.arange(BACK, len(places) - count - 1 - BACK)
    for start in begin[:: max(1, len(begin) // LOOKED)].tolist():
        end = start + count + 1
        step = places[end] - places[start]
        leaves = (count + 1) / BACK * (places[start] - places[start - BACK]) - step
        comes = step - (count + 1) / BACK * (places[end + BACK] - places[end])
        straight = places[start + 1 : end] - (places[start] + at * step)
        off = np.square([straight, straight - at * (1.0 - at) * ((1.0 - at) * leaves + at * comes)]).mean(axis=3)
        told = np.isfinite(off).all(axis=0)
        squares += np.where(told, off, 0.0)
        seen += told
    off = np.sqrt(squares.min(axis=0) / np.maximum(seen, 1.0))
    if seen.all():
        return np.asarray(off)
    nearer = np.minimum(np.arange(count), np.arange(count)[::-1])
    return np.where(seen > 0, off, farther_each_frame(places, int(nearer.max()) + 1)[nearer])
