"""Takes that were spliced, or a scene that was put elsewhere: from one frame to the next everything leaps, and stays.

Where the markers of two limbs or of two people change their labels most may leap, too, but each to another's place: no
take begins where they are given back. Where nothing tells which side is right they are not, and each side is a take.

No smoother may look across: it would take one side for outliers of the other. Each side is repaired on its own.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion, Recording, Repaired
from ...bodies.skeleton import positions
from ...numerics.quantiles import quantile_of_known
from ..channels.layout import own_layout
from ..channels.pieces import pieces
from ..channels.recording import to_channels
from ..labels.relabelling import right_at_first_sight
from .held import SAID
from .thrown_root import HARDEST, LONGEST, RUN_UP, closes, thrown

LEAST, LEAPS = 0.3, 6.0  # m and times the usual surprise from frame to frame; where half of all leaps by less is motion
SHORTEST = 0.25  # s of a take; what is elsewhere for less is a burst of outliers
LASTS = 0.5  # of the leap, by which what comes before and after it must fail to meet
ONCE = 0.6  # of the leap; where takes are joined nothing leaps so far just before or after, as what rattles does
EXCHANGED = 0.2  # of the way between two markers, within which each takes the other's place when they change labels
SEEN = 3  # markers or joints that are seen on both sides


def repaired_in_takes(recording: Recording, repair: Callable[[Recording], Repaired[Recording]]) -> Repaired[Recording]:
    """The repair of a recording, of each of its takes on its own.

    Parameters
    ----------
    recording : T frames.
    repair : of one take.

    Returns
    -------
    All frames of the recording; where it is cut a sentence says so.
    """
    cuts: list[int] = first_frames(recording).tolist()
    if not cuts:
        return repair(recording)
    edges = [0, *cuts, recording.frames]
    parts = [repair(recording.at_frames(slice(a, b))) for a, b in pairwise(edges)]
    common: list[str] = [warning for warning in parts[0].warnings if all(warning in part.warnings for part in parts)]
    told: list[str] = [
        warning if not first else f"from frame {first} on, counted from there: {warning}"
        for first, part in zip(edges, parts, strict=False)
        for warning in part.warnings
        if warning not in common
    ]
    named = ", ".join(str(cut) for cut in cuts[:SAID])
    cut = (
        f"from one frame to the next everything leaps and stays there, as where takes are joined, before frame {named}"
        f"{', ...' if len(cuts) > SAID else ''}; each part was repaired on its own"
    )
    if change := [str(frame) for frame in cuts if _labels_change_hands(recording, frame)]:
        cut += (
            f"; before frame {', '.join(change[:SAID])}{', ...' if len(change) > SAID else ''} many markers change "
            "places: labels may be swapped on one side of it, and were not exchanged; look at them"
        )
    lengths = np.diff(edges)
    noises = [part.noise for part in parts]
    noise = None
    if all(one is not None for one in noises):
        noise = np.sqrt(np.average(np.square(np.array(noises, dtype=np.float64)), axis=0, weights=lengths))
    return Repaired(
        _joined(recording, [part.recording for part in parts]),
        np.concatenate([part.origin for part in parts]),
        np.concatenate([part.std for part in parts]),
        np.concatenate([part.weights for part in parts]),
        parts[0].method,
        iterations=sum(part.iterations for part in parts),
        converged=all(part.converged for part in parts),
        warnings=(*common, cut, *told),
        noise=noise,
    )


def first_frames(recording: Motion | Markers) -> Ints:
    """Frames before which a recording leaps and stays elsewhere: where takes after the first begin.

    Parameters
    ----------
    recording : markers, or a motion whose joints are looked at.

    Returns
    -------
    (N,) frame numbers, in order.
    """
    cuts = _leaps_that_stay(recording)
    if isinstance(recording, Markers) and any(_labels_change_hands(recording, cut) for cut in cuts.tolist()):
        right, _ = right_at_first_sight(recording, to_channels(recording, own_layout(recording)))
        return _leaps_that_stay(right)
    return cuts


def _leaps_that_stay(recording: Motion | Markers) -> Ints:
    """(N,) frames before which a recording leaps and stays elsewhere, its labels as they are."""
    surprise = np.concatenate([_surprise(recording, part) for part in pieces(recording.frames)])
    told = np.isfinite(surprise)
    if not told.any():
        return np.zeros(0, dtype=np.int64)
    surprise = np.where(told, surprise, 0.0)
    far = max(LEAST, HARDEST / recording.fps**2, LEAPS * float(np.median(surprise[told])))
    before, after = np.r_[0.0, surprise[:-1]], np.r_[surprise[1:], 0.0]
    leaps = [t for t in np.flatnonzero((surprise > far) & (surprise >= before) & (surprise > after)).tolist() if t]
    reach = _reach(recording.fps)
    leaps = [t for t in leaps if not _others(surprise, t, reach, ONCE * surprise[t])]
    cuts = [t for t in leaps if _stays_away(recording, t, reach, LASTS * surprise[t])]
    cuts = _but_for_those_that_close(recording, cuts, reach)
    if cuts and isinstance(recording, Motion):
        away = np.flatnonzero(thrown(recording).any(axis=1))
        cuts = [t for t in cuts if t not in away and t - 1 not in away]
    shortest = SHORTEST * recording.fps
    edges = np.array([0, *cuts, recording.frames])
    long = np.diff(edges) >= shortest
    return np.array([cut for cut, left, right in zip(cuts, long, long[1:], strict=False) if left and right], np.int64)


def _others(surprise: Floats, leap: int, reach: int, least: float) -> bool:
    """True if within reach of a leap, but not in the frames beside it which share it, others are as large."""
    before, after = surprise[max(0, leap - reach) : leap - 1], surprise[leap + 2 : leap + reach + 1]
    return bool((before > least).any() or (after > least).any())


def _surprise(recording: Motion | Markers, part: slice) -> Floats:
    """(N,) m by which half of all places leap from the frame before to each of the part's, beyond how they move.

    NaN where too few are seen.
    """
    around = slice(max(0, part.start - 2), min(recording.frames, part.stop + 1))
    steps = np.diff(_places(recording, around), axis=0)
    found = np.full(part.stop - part.start, np.nan)
    if len(steps) < 3:
        return found
    away = np.linalg.norm(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:]), axis=2)
    enough = np.isfinite(away).sum(axis=1) >= SEEN
    median = np.full(len(away), np.nan)
    if enough.any():
        median[enough] = quantile_of_known(away[enough].T, 0.5)
    first = around.start + 2  # the frame that the first of them leaps to
    found[first - part.start : first - part.start + len(median)] = median
    return found


def _stays_away(recording: Motion | Markers, cut: int, reach: int, least: float) -> bool:
    """True if what comes before a frame and what comes from it on do not meet, whatever single samples do."""
    before, after = _on_either_side(recording, cut, reach)
    apart = np.linalg.norm(after - before, axis=1)
    apart = apart[np.isfinite(apart)]
    return len(apart) >= SEEN and bool(np.median(apart) > least)


def _on_either_side(recording: Motion | Markers, cut: int, reach: int) -> tuple[Floats, Floats]:
    """(P, 3) m each: where places are at a frame by what is before it, and by what is from it on; NaN = not seen."""
    before = _places(recording, slice(max(0, cut - reach - 1), cut))
    after = _places(recording, slice(cut, min(recording.frames, cut + reach + 1)))
    ends = []
    for side in (before[::-1], after):  # from the cut on, either way
        there = np.full(side.shape[1:], np.nan)
        if min(len(before), len(after)) > 1:
            seen = np.isfinite(np.diff(side, axis=0)).all(axis=2).any(axis=0)
            pace = quantile_of_known(np.diff(side[:, seen], axis=0), 0.5)
            there[seen] = quantile_of_known(side[:, seen] - pace * (np.arange(len(side)) + 0.5)[:, None, None], 0.5)
        ends.append(there)
    return ends[0], ends[1]


def _labels_change_hands(recording: Recording, cut: int) -> bool:
    """True if some markers take each other's places from one frame to the next."""
    if not isinstance(recording, Markers):
        return False
    return int(_exchanged(*_on_either_side(recording, cut, _reach(recording.fps))).sum()) >= SEEN


def _reach(fps: float) -> int:
    """Frames on either side that tell how everything moves."""
    return max(2, round(RUN_UP * fps))


def _exchanged(before: Floats, after: Floats) -> Bools:
    """(M,) whether a marker is where another one was and that one where it was: labels change hands there, of limbs or
    of whole people, but what is seen stays. Who is put elsewhere never is: two of theirs would have to go both ways.

    Parameters
    ----------
    before, after : (M, 3) m, places on either side of a frame; NaN = not seen.
    """
    way = np.linalg.norm(before[:, None] - after[None], axis=2)
    apart = np.nan_to_num(np.diagonal(way))
    way = np.where(np.isfinite(way), way, np.inf)
    with_another = np.maximum(way, way.T)
    np.fill_diagonal(with_another, np.inf)
    return np.asarray(with_another.min(axis=1, initial=np.inf) < EXCHANGED * apart)


def _but_for_those_that_close(recording: Motion | Markers, cuts: list[int], reach: int) -> list[int]:
    """The cuts but for pairs between which everything is elsewhere for a while: that is no other take."""
    kept = list(cuts)
    for start, stop in pairwise(cuts):
        if start in kept and stop - start <= LONGEST * recording.fps:
            around = slice(max(0, start - reach - 1), min(recording.frames, stop + reach + 1))
            places = _places(recording, around)
            seen = np.isfinite(places).all(axis=(0, 2))
            if seen.sum() < SEEN:
                continue
            if closes(np.median(places[:, seen], axis=1), start - around.start, stop - around.start, reach, alone=True):
                kept = [cut for cut in kept if cut not in (start, stop)]
    return kept


def _places(recording: Motion | Markers, part: slice) -> Floats:
    """(N, P, 3) m of markers, or of a motion's joints; NaN = missing."""
    if isinstance(recording, Markers):
        return recording.positions[part]
    return positions(recording.skeleton, recording.q[part])


def _joined(recording: Recording, parts: list[Recording]) -> Recording:
    if isinstance(recording, Motion):
        return recording.with_q(np.concatenate([part.q for part in parts if isinstance(part, Motion)]))
    assert isinstance(recording, Markers)
    joined = [part for part in parts if isinstance(part, Markers)]
    residuals = [part.residuals for part in joined if part.residuals is not None]
    return replace(
        joined[0],
        positions=np.concatenate([part.positions for part in joined]),
        residuals=np.concatenate(residuals) if len(residuals) == len(joined) else None,
    )
