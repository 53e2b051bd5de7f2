"""Angles that leap for a while to others that mean the same rotation, or by half a turn about one axis, and back.

Of a rotation there are two triples of angles, and whole turns more of each. A solver that writes another of them for a
few frames turns nothing, but whoever edits, averages or scores the angles finds them half a turn away. Brought back to
those before and after they are the same pose. A file may leap so by its own rule: it writes angles from -180 to 180
degrees, the middle one from -90 to 90; what would break its rule elsewhere is left.

One angle alone that leaps by half a turn, and after a moment leaps back, is another pose, and no joint's. In noise
nothing else does so.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ...bodies.skeleton import ROTATION
from ..channels.branches import FLIP, HALF_TURN, nearest_triple, nearest_turn, twin
from ..channels.joints import root_rows, triples, unit
from ..noise.level import first_noise
from .held import named

WHOLE_TURN, RIGHT_ANGLE = 360.0, 90.0  # degrees
LONGEST = 1.0  # s; what lasts may as well be what the file means
# Frames and s, of half a turn: a single frame is an outlier, and in more time a body turns about.
SHORTEST_HALF, LONGEST_HALF = 2, 0.5
CALM = 90.0  # degrees, of all angles of a joint; after a longer step to the nearest triple nothing tells which is meant
ABOUT = 0.1  # s without a sample that a step may be long
BY_RULE, DEVIATIONS = 0.9, 3.0  # of the samples that keep a rule, and of a mean's noise that it is kept to
NOISY = 0.3  # degrees, of the usual angle; in what is less noisy a half turn is as likely the recording's own
# Steps on either side of a leap; times the usual one of them, and deviations of the noise, that it may miss half a turn
# by; degrees that it may at all, and that the steps next to it, and the joint's other angles, do not reach.
BESIDE, SWING, JITTER, MOST = 4, 3.0, 6.0, 45.0


@dataclass(frozen=True, eq=False)
class Unflipped:
    """A motion with its angles where they belong: `same` and `half` (T, D) samples that meant the same rotation, and
    that were half a turn away."""

    motion: Motion
    same: Bools
    half: Bools


def but_for_flips(repair: Callable[[Recording], Repaired[Recording]], recording: Recording) -> Repaired[Recording]:
    """Repair a recording with angles that flip for a while brought back, and say so.

    Parameters
    ----------
    repair : of a whole recording.
    recording : motion or markers; markers have no angles.
    """
    if isinstance(recording, Markers):
        return repair(recording)
    found = unflipped(recording)
    outcome: Repaired[Recording] = repair(found.motion)
    said: list[str] = [
        f"{int(flipped.sum())} samples {what}, and back; they were put back: {named(recording, flipped)}"
        for flipped, what in (
            (found.same, "leapt to other angles of the same rotation"),
            (found.half, "leapt by half a turn about one axis"),
        )
        if flipped.any()
    ]
    if not said:
        return outcome
    put_back = (found.same | found.half) & (outcome.origin == Origin.MEASURED)
    origin = np.where(put_back, Origin.REPAIRED, outcome.origin).astype(np.uint8)
    return replace(outcome, origin=origin, warnings=(*outcome.warnings, *said))


def unflipped(motion: Motion) -> Unflipped:
    """The motion with angles that flip for a while brought back.

    Parameters
    ----------
    motion : T frames, D channels.
    """
    skeleton = motion.skeleton
    turning = np.flatnonzero(skeleton.dof_kind == ROTATION)
    angles = motion.q * unit(skeleton)
    same, half = np.zeros(angles.shape, np.bool_), np.zeros(angles.shape, np.bool_)
    if not np.isfinite(angles[:, turning]).any():
        return Unflipped(motion, same, half)
    root, _ = root_rows(skeleton)
    least = 0.0 if (angles[:, turning] >= 0.0).mean() >= BY_RULE else -HALF_TURN
    balls = [*triples(skeleton), *([root] if len(root) else [])]
    for rows in [*balls, *(np.array([row]) for row in np.setdiff1d(turning, np.concatenate([root, *balls])))]:
        angles[:, rows], same[:, rows] = _one_branch(angles[:, rows], least, motion.fps)
    leaping = [row for row in np.setdiff1d(turning, root) if len(_odd_leaps(angles[:, row])) > 1]
    if leaping and np.median(noise := first_noise(angles[:, turning])) >= NOISY:
        for row in leaping:
            beside = (skeleton.dof_joint[turning] == skeleton.dof_joint[row]) & (turning != row)
            apart = (skeleton.dof_joint[turning] != skeleton.dof_joint[row]) & ~np.isin(turning, root)
            angles[:, row], half[:, row] = _without_half_turns(
                angles[:, row],
                float(noise[turning == row][0]),
                _longest_steps(angles[:, turning[beside]]),
                _longest_steps(angles[:, turning[apart]]),
                motion.fps,
            )
    changed = same | half
    if not changed.any():
        return Unflipped(motion, same, half)
    return Unflipped(motion.with_q(np.where(changed, angles / unit(skeleton), motion.q)), same, half)


def _one_branch(angles: Floats, least: float, fps: float) -> tuple[Floats, Bools]:
    """Angles (T, N) degrees of a joint with those that flip for a while brought back, and (T, N) which these are.

    N is 3, of axes at right angles, or 1; the file's angles go a whole turn from `least` on, if it keeps that rule.
    """
    found = np.zeros(angles.shape, np.bool_)
    known = np.flatnonzero(np.isfinite(angles).all(axis=1))
    whole = angles[known]
    shortest = FLIP if whole.shape[1] == 3 else HALF_TURN
    leaps = np.flatnonzero(np.abs(np.diff(whole, axis=0)).sum(axis=1) > shortest) + 1
    if len(leaps) < 2:
        return angles, found
    noise = first_noise(whole)
    branch, ways = _branches(whole, known, leaps, ABOUT * fps + 1, JITTER * float(noise.sum()))
    straight, back, flipped = angles.copy(), whole.copy(), np.zeros(len(whole), np.bool_)
    frames_of = np.bincount(branch, minlength=len(ways))
    begins = np.bincount(branch[np.flatnonzero(np.diff(branch, prepend=-1))], minlength=len(ways))
    for home in sorted(np.flatnonzero(begins > 1).tolist(), key=lambda one: -int(frames_of[one])):
        at = np.flatnonzero(branch == home)
        for before, after in pairwise(at.tolist()):
            if after == before + 1 or known[after] - known[before] > LONGEST * fps + 1:
                continue
            here = slice(before + 1, after)
            if any(ways[one].stretch != ways[home].stretch for one in np.unique(branch[here])):
                continue
            meant = _there(_straight(back[here], branch[here], ways), ways[home])
            if _by_rule(whole, whole[here], meant, least, noise):
                continue
            for k in range(before + 1, after - 1):  # what is known of frames between was written like the one before
                partly = slice(known[k] + 1, known[k + 1])
                straight[partly] = _there(_back(straight[partly], ways[branch[k]]), ways[home])
                found[partly] = np.isfinite(angles[partly])
            back[here], flipped[here], branch[here] = meant, True, home
    straight[known[flipped]] = back[flipped]
    found[known[flipped]] = True
    return straight, found


@dataclass(frozen=True)
class _Way:
    """How angles are written: of a triple the twin or not, and whole turns more; comparable within one stretch."""

    stretch: int
    twin: bool
    turns: tuple[int, ...]


def _branches(angles: Floats, frames: Ints, leaps: Ints, longest: float, jitter: float) -> tuple[Ints, list[_Way]]:
    """(T,) the way in which the angles (T, N) degrees of each frame are written, as a number into the list.

    Parameters
    ----------
    angles, frames : (T, N) and (T,), those that are known.
    leaps : frames to which all angles together step far.
    longest : frames that a leap may take.
    jitter : degrees that noise may add to a step.
    """
    way = _Way(0, twin=False, turns=(0,) * angles.shape[1])
    number = {way: 0}
    branch = np.zeros(len(angles), dtype=np.int64)
    for leap, stop in pairwise([*leaps.tolist(), len(angles)]):
        last = _back(angles[leap - 1], way)
        goes_on = _nearest(angles[leap], last)
        steps = np.abs(np.diff(angles[max(0, leap - BESIDE - 1) : leap + BESIDE + 1], axis=0)).sum(axis=1)
        calm = np.abs(goes_on - last).sum() < min(CALM, SWING * float(np.median(steps)) + jitter)
        if calm and frames[leap] - frames[leap - 1] <= longest:
            way = _way_between(angles[leap], goes_on, way.stretch)
        else:
            way = _Way(way.stretch + 1, twin=False, turns=(0,) * angles.shape[1])
        branch[leap:stop] = number.setdefault(way, len(number))
    return branch, list(number)


def _nearest(angles: Floats, meant: Floats) -> Floats:
    if len(angles) == 1:
        return nearest_turn(angles, meant)
    return np.asarray(nearest_triple(angles[None], meant)[0])


def _way_between(written: Floats, straight: Floats, stretch: int) -> _Way:
    """The way in which angles (N,) are written that mean others (N,)."""
    for turned in (False, True):
        turns = ((twin(straight[None])[0] if turned else straight) - written) / WHOLE_TURN
        if np.allclose(turns, np.round(turns), atol=1e-6):
            break
    return _Way(stretch, turned, tuple(round(turn) for turn in turns))


def _there(straight: Floats, way: _Way) -> Floats:
    """Angles (T, N) written in some way."""
    return (twin(straight) if way.twin else straight) - WHOLE_TURN * np.array(way.turns)


def _back(written: Floats, way: _Way) -> Floats:
    """Angles (N,) or (T, N) written in some way, as they would be without it."""
    turned = written + WHOLE_TURN * np.array(way.turns)
    if not way.twin:
        return turned
    outer = turned - HALF_TURN
    outer[..., 1] = HALF_TURN - turned[..., 1]
    return np.asarray(outer)


def _straight(written: Floats, branch: Ints, ways: list[_Way]) -> Floats:
    """Angles (T, N), each written in its own way (T,), as they would be without."""
    found = written.copy()
    for one in np.unique(branch):
        found[branch == one] = _back(written[branch == one], ways[one])
    return found


def _by_rule(angles: Floats, here: Floats, meant: Floats, least: float, noise: Floats) -> bool:
    """Whether a file whose angles are (T, N) writes those `here` (S, N) as it does since those `meant` (S, N) would
    break its rule; `least` is its least outer angle, `noise` (N,) degrees."""
    twins = here.shape[1] == 3 and not np.allclose(here[:, 1] % WHOLE_TURN, meant[:, 1] % WHOLE_TURN)
    for column, (written, own, other) in enumerate(zip(angles.T, here.T, meant.T, strict=True)):
        differs = ~np.isclose(own, other)
        if not differs.any() or (twins and column != 1):
            continue
        first, length = (-RIGHT_ANGLE, HALF_TURN) if twins else (least, WHOLE_TURN)
        kept = (first <= written) & (written <= first + length)
        beyond, without = (
            float(np.median(np.maximum(np.maximum(first - some, some - first - length), 0.0)))
            for some in (own[differs], other[differs])
        )
        tolerance = DEVIATIONS * noise[column] / np.sqrt(differs.sum())
        if kept.mean() >= BY_RULE and beyond <= without + tolerance:
            return True
    return False


def _odd_leaps(angle: Floats) -> Ints:
    """The steps of an angle (T,) degrees that are nearest to an odd number of half turns."""
    return np.flatnonzero(np.round(np.nan_to_num(np.diff(angle)) / HALF_TURN) % 2)


def _longest_steps(angles: Floats) -> Floats:
    """(T - 1,) the longest step of angles (T, N) to the next frame; what is missing takes none."""
    return np.asarray(np.nan_to_num(np.abs(np.diff(angles, axis=0))).max(axis=1, initial=0.0))


def _without_half_turns(angle: Floats, noise: float, beside: Floats, apart: Floats, fps: float) -> tuple[Floats, Bools]:
    """An angle (T,) degrees with half turns undone that do not last, and (T,) where these were.

    Parameters
    ----------
    angle : to be asked.
    noise : its standard deviation, degrees.
    beside : (T - 1,) the longest steps of the joint's other angles, which do not leap with it.
    apart : (T - 1,) those of other joints: where one of them leaps as far, a limb passes to another of its solver's
        poses.
    """
    found = np.zeros(angle.shape, np.bool_)
    steps = np.nan_to_num(np.diff(angle))
    halves, leaps = np.round(steps / HALF_TURN), _odd_leaps(angle)
    left, usual = np.abs(steps - HALF_TURN * halves), np.where(halves == 0, np.abs(steps), MOST)
    calm = np.pad(usual < MOST, 1, constant_values=True)
    sure = np.zeros(len(steps), np.bool_)
    for leap in leaps.tolist():
        swing = np.median(usual[max(0, leap - BESIDE) : leap + BESIDE + 1])
        quiet = calm[leap] and calm[leap + 2] and beside[leap] < MOST and apart[leap] < RIGHT_ANGLE
        sure[leap] = quiet and left[leap] < min(MOST, SWING * swing + JITTER * noise)
    back, last = angle.copy(), -1
    for start, stop in pairwise(leaps.tolist()):
        brief = SHORTEST_HALF <= stop - start <= LONGEST_HALF * fps
        if start > last and brief and sure[start] and sure[stop] and halves[start] + halves[stop] == 0:
            back[start + 1 : stop + 1] -= HALF_TURN * halves[start]
            found[start + 1 : stop + 1], last = True, stop
    return back, found
