"""A recording written at a higher rate than it was made at: 30 Hz in 60, by showing its frames twice, or lines between.

What repeats itself measures nothing, nor does what lies halfway. Taken for samples, repeats make stairs of motion, and
noise that lasts for as many frames passes for motion; points on lines look as if there were hardly any noise.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...arrays import Bools, Bytes, Floats, Ints, Singles
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ...bodies.skeleton import ROTATION
from ..channels.joints import CENTIMETRES, unit
from ..noise.digits import coarseness

REPEATED, DRAWN = "repeats", "lines"  # how a recording was brought to a higher rate
_SAID = {REPEATED: "repeat the one before", DRAWN: "lie on lines"}
FEWEST = 10  # frames with something new that tell how regularly they come
LEAST, MOST = 1.4, 5.0  # frames for each of them: less are single stale ones, more are poses that somebody drew
STEADY = 0.95  # of the ways from one to the next that are as long as the others, to a frame
IN_STEP, WINDOW = 0.9, 8  # of stretches of so many such ways those that are as long as their number says, to a frame
RESTING = 2.0  # times the usual way; for longer somebody rests
LEAP = np.radians(60.0)  # of an angle from one frame to the next; what is between is not half of both
CLOSER = 2.0**-1.5  # of the error of a way twice as long: what changes its speed by chance strays so
ROUNDED = 2.0  # steps of a channel's rounding by which three samples on a line may miss it
SLOWEST = 20.0  # Hz; at lower rates lines may be all that somebody meant, and what they leave out cannot be told
FINEST = 1e-4  # degrees or cm; a step no finer is not looked for
DIGITS = 2e-5  # of a channel's size, by which they may if six digits are written of each
ABOUT = 0.5  # s before and after, of which errors are alike


def but_for_repeats(repair: Callable[[Recording], Repaired[Recording]], recording: Recording) -> Repaired[Recording]:
    """Repair a recording that shows its frames several times, or lines between them, as the slower one that it is.

    Parameters
    ----------
    repair : of a whole recording.
    recording : motion or markers.

    Returns
    -------
    All frames, at the recording's rate. What repeats the frame before, or lies on the line to the next, is replaced by
    what lies between, as sure as frames between twice as far ones turn out to be, and that is said. Others are repaired
    as they are.
    """
    shown, how = shown_once(recording), REPEATED
    if shown is None:
        shown, how = ends_of_lines(recording), DRAWN
    if shown is None:
        return repair(recording)
    outcome: Repaired[Recording] = repair(replace(recording.at_frames(shown), fps=recording.fps / _way(shown)))
    between = _between(outcome, shown, recording)
    said = (
        f"{as_slower(recording, shown, how)}; {recording.frames - len(shown)} frames that {_SAID[how]} were "
        "replaced by what lies between; frames that other warnings name are counted without them"
    )
    return replace(
        outcome,
        recording=recording.with_values(between.values.reshape(recording.values.shape)),
        origin=between.origin,
        std=between.std,
        weights=between.weights,
        warnings=(*outcome.warnings, said),
    )


def shown_once(recording: Motion | Markers) -> Ints | None:
    """Frames that show something new, where these come regularly and seldom enough.

    Parameters
    ----------
    recording : T frames.

    Returns
    -------
    (S,) frame numbers, in order; frames of a rest are among them, as many as there would be if something moved. None
    where every frame may show something new.
    """
    if recording.frames <= FEWEST:
        return None
    values, new = _values(recording), np.zeros(recording.frames, dtype=np.bool_)
    new[:1] = True
    for channel in range(values.shape[1]):  # one at a time: a recording may be long
        one = values[:, channel]
        new[1:] |= ((one[1:] != one[:-1]) & ~(np.isnan(one[1:]) & np.isnan(one[:-1]))).any(axis=1)
        if new.mean() > 1.0 / LEAST:
            return None
    return regular(new)


def regular(new: Bools) -> Ints | None:
    """Frames that show something new (T,), with as many in a rest; None unless they come regularly and seldom."""
    frames = np.flatnonzero(new)
    ways = np.diff(frames)
    if len(ways) < FEWEST:
        return None
    moving = ways[ways <= RESTING * np.median(ways)]
    way = float(moving.mean())
    if not LEAST <= way <= MOST or (np.abs(ways - way) < 1.0).mean() < STEADY:
        return None
    together = np.convolve(moving, np.ones(WINDOW), mode="valid")
    if (np.abs(together - WINDOW * way) <= 1.0).mean() < IN_STEP:
        return None
    ends = zip(frames, [*frames[1:], len(new)], strict=True)
    rests = [start + np.round(np.arange(0.0, stop - start - 0.5 * way, way)).astype(np.int64) for start, stop in ends]
    return np.unique(np.concatenate([frames, *rests]))


def ends_of_lines(recording: Motion | Markers) -> Ints | None:
    """Frames between which all channels go along straight lines, where these come regularly and seldom enough.

    Parameters
    ----------
    recording : T frames.

    Returns
    -------
    (S,) frame numbers, in order, the first and the last among them; None where any frame may be on no line.
    """
    if recording.frames <= FEWEST:
        return None
    values, new = _values(recording), np.zeros(recording.frames, dtype=np.bool_)
    new[:1] = True
    scale = unit(recording.skeleton) if isinstance(recording, Motion) else np.full(values.shape[1], CENTIMETRES)
    steps = np.maximum(coarseness(recording).reshape(values.shape[1], -1), FINEST) / scale[:, None]
    for channel, step in enumerate(steps):
        one = values[:, channel]
        size = np.fmax.reduce(np.abs(one), axis=0, initial=0.0)
        bends = np.abs(np.diff(one, n=2, axis=0))
        new[1:-1] |= (bends > np.maximum(ROUNDED * step, DIGITS * size)).any(axis=1)
        if new.mean() > 1.0 / LEAST:
            return None
    found = regular(new)
    if found is None or recording.fps / _way(found) < SLOWEST:
        return None
    return np.union1d(found, [recording.frames - 1])


def as_slower(recording: Motion | Markers, shown: Ints, how: str) -> str:
    """The sentence that says how often a recording shows its frames.

    Parameters
    ----------
    recording : T frames.
    shown, how : (S,) of `shown_once`, and `REPEATED`; or of `ends_of_lines`, and `DRAWN`.
    """
    way = _way(shown)
    what = f"each frame is shown {way:.3g} times"
    if how == DRAWN:
        what = f"only every {way:.3g}th frame is on no straight line"
    return f"{what} throughout: taken for a recording of {recording.fps / way:.4g} Hz written at {recording.fps:.4g} Hz"


def _way(shown: Ints) -> float:
    """Frames from one that shows something new to the next; a recording may begin and end between two of them."""
    return float(np.diff(shown[1:-1]).mean())


@dataclass(frozen=True, eq=False)
class _Between:
    """(T, C, N) values, (T, C) the rest, rad or m."""

    values: Floats
    origin: Bytes
    std: Singles
    weights: Singles


def _between(outcome: Repaired[Motion] | Repaired[Markers], shown: Ints, recording: Motion | Markers) -> _Between:
    """All frames of what was repaired in some: values (T, C, N), origin, std and weights (T, C)."""
    here = _values(outcome.recording)
    turns = recording.skeleton.dof_kind == ROTATION if isinstance(recording, Motion) else np.zeros(here.shape[1], bool)
    path = here.copy()
    for channel in np.flatnonzero(turns & np.isfinite(here[:, :, 0]).all(axis=0)):
        path[:, channel] = np.unwrap(path[:, channel], axis=0)
    every = np.arange(recording.frames)
    last = np.maximum(np.searchsorted(shown, every, side="right") - 1, 0)
    again = every != shown[last]
    found = _along(path, shown, every, turns) + (here - path)[last]  # full turns as they were written
    open_ = ~np.isfinite(found).all(axis=2)
    values = np.where((~again[:, None] | open_)[..., None], here[last], found)
    if len(shown) > 2:
        off = _along(path[::2], shown[::2], shown, turns)[1::2] - path[1::2]
        square = np.nan_to_num(np.square(off).sum(axis=2) / off.shape[2])
        span = max(1, 2 * round(ABOUT * outcome.recording.fps / 2.0) + 1)
        strays = CLOSER**2 * uniform_filter1d(square, span, axis=0)[np.minimum(last // 2, len(square) - 1)]
    else:
        strays = np.zeros(open_.shape)
    later = np.minimum(last + 1, len(shown) - 1)
    var = np.square(outcome.std.astype(np.float64))
    var = np.where(again[:, None], np.fmax(var[last], var[later]) + strays, var[last])
    origin = outcome.origin[last].copy()
    recorded = recording.present
    origin[again] = np.where(recorded[again], Origin.REPAIRED, np.maximum(origin[again], Origin.FILLED))
    gone = ~np.isfinite(values).all(axis=2)
    origin[gone] = Origin.LEFT_OPEN
    return _Between(
        values,
        origin.astype(np.uint8),
        np.where(gone, np.nan, np.sqrt(var)).astype(np.float32),
        np.where(again[:, None], np.float32(0.0), outcome.weights[last]),
    )


def _along(path: Floats, shown: Ints, asked: Ints, turns: Bools) -> Floats:
    """(A, C, N) the path (S, C, N) seen at some frames, at others; NaN beyond it, and where it leaps or is open."""
    from scipy.interpolate import CubicHermiteSpline

    if len(shown) < 2:
        return np.full((len(asked), *path.shape[1:]), np.nan)
    time = np.diff(shown).astype(np.float64)
    pace = np.diff(path, axis=0) / time[:, None, None]
    leaps = turns & (np.abs(np.diff(path, axis=0)) > LEAP).any(axis=2)
    pace[leaps] = np.nan
    before, after = np.concatenate([pace[:1], pace]), np.concatenate([pace, pace[-1:]])
    slope = np.where(np.isnan(before), after, np.where(np.isnan(after), before, 0.5 * (before + after)))
    curve = CubicHermiteSpline(shown, np.nan_to_num(path), np.nan_to_num(slope), axis=0)
    part = np.clip(np.searchsorted(shown, asked, side="right") - 1, 0, len(time) - 1)
    found = np.where(np.isnan(pace[part]), np.nan, curve(asked))
    return np.where(((asked >= shown[0]) & (asked <= shown[-1]))[:, None, None], found, np.nan)


def _values(recording: Motion | Markers) -> Floats:
    """(T, C, N): an angle or shift of each channel, or the place of each marker."""
    return recording.values.reshape(recording.frames, len(recording.channels), -1)
