"""Markers that fall off: from some moment on one lies on the floor, or sticks to something else, to the end.

What is elsewhere for so long may be at home there, by the markers about it; but who belongs to a limb never leaves all
that were nearest to it before. As nothing leaps, for a marker takes half a second to fall, no outlier is seen either.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion, Recording, Repaired
from ..channels.joints import CENTIMETRES
from .held import recorded_but_lost, without

MOMENT = 0.1  # s of frames that are taken as one
MOST_MOMENTS = 1000  # of a recording
BEFORE, AFTER = 10, 5  # moments for which a marker is in its place, and for which it is not, at least
NEAREST, FEWEST = 5, 3  # markers that tell whether it is with them
STEADY, OFF = 0.03, 0.1  # m: standard deviation of its distances to these before, and by how much they are others then
MOSTLY, EACH = 0.8, 0.5  # of the time after, on average over these markers and of each of them
AT_ONCE = 2  # moments; who leaves together with another may have swapped labels with it
BEGINS, EARLIER = 0.03, 10  # m off, by which it is falling, and moments before it was found to
DROP = 0.1  # s in which what falls gets as far


@dataclass(frozen=True)
class Fall:
    """A marker that is not in its place any more.

    Attributes
    ----------
    marker : its number.
    first : the frame from which on it is gone, to the end.
    away : m by which its distances to those that were about it are others then, on average.
    """

    marker: int
    first: int
    away: float


def falls(positions: Floats, fps: float) -> tuple[Fall, ...]:
    """Markers that fall off, or get to another part of the body, and do not come back.

    Parameters
    ----------
    positions : (T, M, 3) m as recorded, NaN = missing.
    fps : Hz.
    """
    markers = range(positions.shape[1])
    length = max(1, round(MOMENT * fps), -(-len(positions) // MOST_MOMENTS))
    if len(markers) <= FEWEST or len(positions) // length < BEFORE + AFTER:
        return ()
    # one marker at a time: a recording may be long
    moments = np.stack([_medians(positions[:, marker], length) for marker in markers], axis=1)
    found: list[tuple[int, Fall]] = []
    for marker in markers:
        apart = np.linalg.norm(moments - moments[:, [marker]], axis=2)
        apart[:, marker] = np.nan
        told = _parted(apart)
        if told is not None:
            last, about, usual = told
            begin = max(last - EARLIER, 0) * length
            first = begin + _first(positions[begin : (last + 1) * length], marker, about, usual)
            away = float(np.nanmean(np.abs(apart[last:, about] - usual)))
            found.append((last, Fall(marker, max(first - round(DROP * fps), 1), away)))
    lasts = np.array([last for last, _ in found])
    return tuple(fall for last, fall in found if (np.abs(lasts - last) <= AT_ONCE).sum() == 1)


def but_for_fallen(repair: Callable[[Recording], Repaired[Recording]], recording: Recording) -> Repaired[Recording]:
    """The repair of a recording, with what was recorded of markers after they fell off taken as missing, and said.

    Parameters
    ----------
    repair : of a recording in which nothing has fallen.
    recording : of joint angles nothing can fall.
    """
    if isinstance(recording, Motion):
        return repair(recording)
    assert isinstance(recording, Markers)
    found = falls(recording.positions, recording.fps)
    if not found:
        return repair(recording)
    gone = np.zeros(recording.present.shape, dtype=np.bool_)
    for fall in found:
        gone[fall.first :, fall.marker] = True
    gone &= recording.present
    said = [
        f"{recording.names[fall.marker]}: from frame {fall.first} to the end it is away from all markers that were "
        f"about it before, by about {CENTIMETRES * fall.away:.0f} cm, as one that fell off; taken as missing there"
        for fall in found
    ]
    return recorded_but_lost(repair(without(recording, gone)), gone, said)


def _medians(places: Floats, length: int) -> Floats:
    """(N, 3) m the medians of every `length` frames (T, 3), so that no outlier is seen; NaN where most are missing."""
    whole = places[: len(places) // length * length].reshape(-1, length, 3)
    missing: Bools = np.asarray(np.isnan(whole).any(axis=2))
    inward = np.sort(np.where(missing[..., None], np.inf, whole), axis=1)
    seen = length - missing.sum(axis=1)
    middle = np.maximum(seen - 1, 0) // 2
    median = inward[np.arange(len(inward)), middle]
    return np.asarray(np.where((2 * seen >= length)[:, None], median, np.nan), dtype=np.float64)


def _parted(apart: Floats) -> tuple[int, Ints, Floats] | None:
    """The moment from which a marker is gone, who (G,) was about it until then, and how far, m; None if it stays.

    Parameters
    ----------
    apart : (N, M) m from each of the others, NaN = not seen.
    """
    known = np.isfinite(apart)
    value = np.where(known, apart, 0.0)
    count = np.cumsum(known, axis=0)
    mean = np.cumsum(value, axis=0) / np.maximum(count, 1)
    spread = np.sqrt(np.maximum(np.cumsum(np.square(value), axis=0) / np.maximum(count, 1) - np.square(mean), 0.0))
    with_it = (spread < STEADY) & (count >= BEFORE)  # from the first moment to each
    if with_it[-1].any():
        return None
    for last in np.flatnonzero(known.any(axis=1) & (with_it.sum(axis=1) >= FEWEST))[::-1].tolist():
        about = np.argsort(np.where(with_it[last], mean[last], np.inf), kind="stable")[:NEAREST]
        about = about[with_it[last, about]]
        usual, later = mean[last, about], apart[last + 1 :, about]
        seen = np.isfinite(later).sum(axis=0)
        if (seen < AFTER).any():
            continue
        gone = (np.abs(later - usual) > OFF).sum(axis=0) / seen
        if gone.mean() >= MOSTLY and gone.min() >= EACH:
            return last + 1, about, usual
    return None


def _first(here: Floats, marker: int, about: Ints, usual: Floats) -> int:
    """The frame of some (T, M, 3) m from which on a marker leaves those about it."""
    off = np.abs(np.linalg.norm(here[:, about] - here[:, [marker]], axis=2) - usual)
    known = np.isfinite(off)
    with_them = known.any(axis=1) & (np.where(known, off, 0.0).sum(axis=1) <= BEGINS * known.sum(axis=1))
    frames: list[int] = np.flatnonzero(with_them).tolist()
    return frames[-1] + 1 if frames else 0
