"""Capture that froze: samples repeat to the last digit in several markers or joints at once, and then leap on.

What rests repeats itself as well where digits are few, a joint at its limit for long, and an animator's poses for as
long as they like. But rests begin and end alone, and nobody leaves one by a leap to where the motion would have been.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from ...bodies.motion import Markers, Motion
from ...bodies.skeleton import ROTATION
from ...numerics.quantiles import median
from ..channels.joints import CENTIMETRES, unit
from ..noise.digits import coarseness

TOGETHER = 3  # markers or joints that leap from the same run; a foot and its toes, a hand and its thumb rest together
OF_ALL = 1.0 / 3.0  # of those that share a run: feet stand while the rest is frozen, and leap nowhere
BY_CHANCE = 4.0  # deviations above how many begin to repeat themselves in a frame by chance
# times the median change of a step to the next: of three that repeat themselves together, and of many
LEAPS, LEAST_LEAPS = 6.0, 2.0
BEYOND = 0.5  # of the step after the leap; what is kicked, or runs at an even pace, begins with a step like the next
ROUNDED = 3.0  # steps of the digits
FINEST = 1e-6  # degrees or cm; single precision is as coarse
OFTEN = 0.3  # runs for each step that moves: who repeats itself so often is drawn so, or slower than the recording
# Of all parts, that repeat themselves in the same frames: then it is enough if their steps after it are on the whole
# nearer to those that make up for it than to those beside it. In calm motion, or a little noise, none leaps by itself.
ALL = 0.9
RESTS = 0.2  # s; who rests for as long without a leap may have rested here, too
FAST, AT_MOST = 0.99, 2.0  # of its steps, and times as fast, on the whole way from where it froze to where it goes on


@dataclass(frozen=True, eq=False)
class Repeats:
    """Runs of repeats of one part, each from step `start` to before step `stop`; the step to frame t has number t - 1.

    Attributes
    ----------
    start, stop : (N,).
    into, out : (N,) how far the steps before and after leap, in median changes of a step to the next; 0 = not at all.
    step, beside : (N,) the step after, and those before and after both on average, in the same unit; 0 = not known.
    """

    start: Ints
    stop: Ints
    into: Floats
    out: Floats
    step: Floats
    beside: Floats


def frozen(recording: Motion | Markers) -> Bools:
    """Samples that are frozen.

    Parameters
    ----------
    recording : T frames, C channels or markers.

    Returns
    -------
    (T, C) True where a sample repeats the one before it and the motion then leaps on. The first of such a run is good,
    unless the motion leaps there, too; where it leaps only there, the last is.
    """
    found: Bools = np.zeros((recording.frames, len(recording.channels)), dtype=np.bool_)
    parts = [(columns, repeats(values, step, recording.fps)) for columns, values, step in parts_of(recording)]
    if not parts:
        return found
    start, stop, into, out, step_out, beside = (
        np.concatenate([getattr(of_part, field.name) for _, of_part in parts]) for field in fields(Repeats)
    )
    part = np.arange(len(parts)).repeat([len(of_part.start) for _, of_part in parts])
    by_chance = len(start) / max(recording.frames, 1)  # parts that begin to repeat themselves in one frame
    order = np.lexsort((stop, start))
    same_run = (np.diff(start[order]) == 0) & (np.diff(stop[order]) == 0)
    holds = 0
    for first, last in runs(same_run):
        together = order[first : last + 1]
        fewest = max(TOGETHER, by_chance + BY_CHANCE * np.sqrt(by_chance), OF_ALL * len(together))
        goes_on = max(LEAPS * np.sqrt(TOGETHER / len(together)), LEAST_LEAPS)
        leaves, comes = (into[together] > LEAPS).sum() >= fewest, (out[together] > goes_on).sum() >= fewest
        begins, ends = int(start[together[0]]), int(stop[together[0]])
        makes_up = (1.0 + 0.5 * (ends - begins)) * beside[together].sum()
        if not leaves and len(together) >= fewest and 0.0 < makes_up < step_out[together].sum():
            comes |= ((start <= begins) & (stop >= ends)).sum() >= ALL * len(parts)
        if leaves or comes:
            # who rested as it froze, or rests on, repeats itself for longer than the others
            covering = (start <= begins) & (stop >= ends)
            covering &= ((stop == ends) & comes) | ((start == begins) & leaves)
            columns = np.concatenate([parts[n][0] for n in part[covering].tolist()])
            found[begins + (not leaves) : ends + bool(comes), columns] = True
        if len(together) >= fewest and ends - begins >= RESTS * recording.fps:
            holds += 1 if leaves or comes else -1
    return found if holds >= 0 else np.zeros_like(found)  # who holds poses more often without a leap is drawn


def held_ends(recording: Motion | Markers) -> tuple[int, int]:
    """How many frames at the start and at the end repeat each other to the last digit in all that is seen.

    A pose before or after the motion, or capture that had not begun or went on no more: nothing tells which.

    Returns
    -------
    (first, last), each 0 or more frames than `RESTS` lasts; (0, 0) for what never moves.
    """
    steps = max(recording.frames - 1, 0)
    moves, seen = np.zeros(steps, dtype=np.bool_), np.zeros(steps, dtype=np.bool_)
    values = recording.q[:, :, None] if isinstance(recording, Motion) else recording.positions
    for channel in range(values.shape[1]):
        step = np.diff(values[:, channel], axis=0)
        there = np.isfinite(step).all(axis=1)
        changes = there & (step != 0.0).any(axis=1)
        if changes.any():  # what never moves, at rest or gone, shows nothing
            moves, seen = moves | changes, seen | there
    if not moves.any():
        return 0, 0
    same = seen & ~moves  # steps; a frame of which nothing is seen repeats nothing
    first, last = (int(np.argmax(~way)) for way in (same, same[::-1]))
    least = max(1.0, RESTS * recording.fps)
    return (first + 1 if first >= least else 0), (last + 1 if last >= least else 0)


def parts_of(recording: Motion | Markers) -> Iterator[tuple[Ints, Floats, float]]:
    """What moves as one: its channels that ever move (N,), their samples (T, N) degrees or cm, the step of its digits.

    One at a time, for a recording may be long.
    """
    steps = coarseness(recording)
    if isinstance(recording, Markers):
        for marker in range(len(recording.names)):
            yield np.array([marker]), CENTIMETRES * recording.positions[:, marker], float(np.linalg.norm(steps[marker]))
        return
    skeleton, scale = recording.skeleton, unit(recording.skeleton)
    moves = np.fmax.reduce(recording.q, initial=-np.inf) > np.fmin.reduce(recording.q, initial=np.inf)
    for joint in range(len(skeleton.names)):
        rows = skeleton.dofs_of(joint)
        for turns in (True, False):  # a root turns and travels
            some = rows[((skeleton.dof_kind[rows] == ROTATION) == turns) & moves[rows]]
            if len(some):
                yield some, recording.q[:, some] * scale[some], float(np.linalg.norm(steps[some]))


def repeats(values: Floats, coarse: float, fps: float) -> Repeats:
    """Runs of steps in which a part repeats, none at either end: it may be a pose before or after the motion.

    Parameters
    ----------
    values : (T, N) degrees or cm, NaN = missing.
    coarse : step of their digits, in the same unit.
    fps : Hz.
    """
    steps = np.diff(values, axis=0)
    same, far = (steps == 0.0).all(axis=1), np.sqrt(np.square(steps).sum(axis=1))
    moving = np.isfinite(far) & ~same
    start, stop = np.array(runs(same), dtype=np.int64).reshape(-1, 2).T
    inside = (start > 0) & (stop < len(far))
    start, stop = start[inside], stop[inside]
    honest = moving[1:] & moving[:-1]
    if repeats_throughout(same, moving) or not honest.any():
        start = stop = start[:0]
    if not len(start):
        return Repeats(start, stop, *np.empty((4, 0)))
    changes = np.sqrt(np.square(np.diff(steps, axis=0)).sum(axis=1))
    usual = max(float(median(changes[honest])), FINEST)
    fastest = AT_MOST * float(np.quantile(far[moving], FAST))

    def leaps(step: Ints, beside: Ints) -> Floats:
        there = (beside >= 0) & (beside < len(far))
        beside = np.where(there, beside, step)
        change = changes[np.minimum(np.minimum(step, beside), len(changes) - 1)]
        there &= moving[step] & moving[beside] & (far[step] > far[beside])
        return np.where(there & (change > np.maximum(ROUNDED * coarse, BEYOND * far[beside])), change / usual, 0.0)

    into, out = leaps(start - 1, start - 2), leaps(stop, stop + 1)
    before, after = start - (into > 0.0), stop + (out > 0.0)
    closes = np.linalg.norm(values[after] - values[before], axis=1) <= fastest * (after - before)
    rested = (np.maximum(into, out) * closes < LEAST_LEAPS) & (stop - start >= RESTS * fps)
    told = closes & (stop - start > (stop - start)[rested].max(initial=0))
    on = np.minimum(stop + 1, len(far) - 1)
    shown = told & moving[start - 1] & moving[stop] & moving[on]
    step, beside = (np.where(shown, one / usual, 0.0) for one in (far[stop], 0.5 * (far[start - 1] + far[on])))
    return Repeats(start, stop, into * told, out * told, step, beside)


def repeats_throughout(same: Bools, moving: Bools) -> bool:
    """True for a part that is drawn so or slower than the recording, by which of its steps (T - 1,) repeat and move."""
    return bool(len(runs(same)) > OFTEN * moving.sum())


def at_limit(values: Floats, start: int, stop: int) -> bool:
    """Whether what is still in some frames (T, N) is at a limit: where it is in others, too, or as far as it goes."""
    held = values[start]
    others = np.delete(values, slice(start, stop), axis=0)
    if (others == held).all(axis=1).any():
        return True
    far = (held >= np.nanmax(others, axis=0)) | (held <= np.nanmin(others, axis=0))
    return bool((far | (held == 0.0)).all())
