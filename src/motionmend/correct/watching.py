"""One frame of a sensor looked at: brought to standard form, and followed through failures."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, frozen
from ..kernels import hops, proportions
from ..kernels import sighting as kernel
from ..kernels.following import Signs
from ..numerics import factors as process
from ..numerics.factors import Factors
from .follow import Followed, begin, follow
from .leaps import left_behind, stirred
from .level import tilt
from .normalise import Placement, upright
from .shaking import shaken, usual_jerk
from .sides import changed, confused_limbs, confused_until_now, faces_away, gone_along, trunk_turned
from .sight import NO_STATES, Sight, Watcher, fresh, unsteadiness

SPAN = 2.0  # m, between hands: sides of limbs, not of the trunk, are taken for each other as far apart
PATIENCE = 1.0  # s; after a longer break only the person's size is remembered
MOST_HOP = 1 / 3  # of the joints; when more hop, somebody else may be there


@dataclass(frozen=True, eq=False)
class _Frame:
    """A frame as it is read: (J, 3) m upright, NaN = missing; states or None; (J,) joints put on their other side."""

    rows: Floats
    states: Bytes | None
    swapped: Bools

    def exchanged(self, pairs: Ints) -> "_Frame":
        """With the members of the pairs (N, 2) in each other's place."""
        states = None if self.states is None else changed(self.states, pairs)
        return _Frame(changed(self.rows, pairs), states, self.swapped ^ np.isin(np.arange(len(self.rows)), pairs))


class _Stance(NamedTuple):
    """Where and how somebody stands.

    Attributes
    ----------
    usual : (B,) m, lengths of bones.
    size : of the person by that of the standard body.
    direction : (2,) where the trunk points from right to left.
    turn, origin, scale : (3, 3), (3,) and a number, the placement.
    standard : (J, 3) the posture in standard form.
    """

    usual: Floats
    size: float
    direction: Floats
    turn: Floats
    origin: Floats
    scale: float
    standard: Floats


def look(
    watcher: Watcher,
    sight: Sight,
    positions: Floats,
    states: Bytes | None,
    time: float,
    again: Bools | None = None,
) -> Sight:
    """One frame on.

    Parameters
    ----------
    positions : (J, 3) m of `believable`, in the sensor's axes by the model's joints, NaN = missing.
    states : (J,) or None; until one of a joint that is tracked or inferred comes they say nothing.
    time : s.
    again : (J,) joints that will leap again within a few seconds; None = what comes is not known.
    """
    body, known = watcher.body, watcher.factors
    speaks = sight.speaks or (states is not None and bool(states.any()))
    states = states if speaks else None
    sight, rows = _upright(watcher, sight, positions, time)
    before, seconds = _known_before(known, sight, time)
    away = time - sight.seen
    met_anew = away > PATIENCE
    if not met_anew:  # where a joint has just been thrown to says nothing
        reach = np.where(body.trunk, 0.0, SPAN)
        rows = np.where(kernel.strayed(rows, sight.rows, seconds, reach)[:, None], np.nan, rows)
    frame = _Frame(rows, states, np.zeros(len(rows), dtype=np.bool_))
    turned = trunk_turned(rows, sight.rows, sight.direction, away, body, sight.shaking.deviation)
    if np.count_nonzero(turned):
        frame = frame.exchanged(body.across[turned])
    stance = _stands(watcher, sight, before.failing, frame.rows)
    if met_anew:
        frame, stance = _sides_by_body(watcher, sight, before.failing, frame, stance)
    standard = stance.standard
    forecast, ahead = process.forecast(known, before.belief, seconds)
    sides, unsure = kernel.crossed(
        frame.rows, sight.rows, standard, *ahead, known.mean, before.own, known.noise, sight.swapped, body.mirror
    )
    if len(turned) and not met_anew and (turned != sight.swapped[body.across[:, 0]]).all():
        sides = gone_along(frame.rows, sight.rows, sides, body)
    righted = np.zeros(len(rows), dtype=np.bool_)
    if np.count_nonzero(sides):
        limbs = body.pairs[sides[body.pairs[:, 0]]]
        if _were_confused(watcher, sight, standard, sides, limbs, float(before.met[sides].max())):
            righted, before = sides, _anew(known, before, sides)
            forecast = before.belief
            ahead = process.expected(known, forecast)
        else:
            frame, standard = frame.exchanged(limbs), changed(standard, limbs)
    rows = frame.rows
    shaking = shaken(sight.shaking, rows, sight.rows, sight.earlier, seconds)
    lengths, raw, bone, best_bone, nobodys, told, repeated = kernel.signs(
        rows,
        sight.rows,
        sight.earlier,
        stance.size,
        proportions.likely(stance.usual, stance.size, watcher.standard.lengths, body.twins),
        body.bones,
        body.twins,
        unsteadiness(watcher, sight.spread),
        usual_jerk(watcher.detector.jerk, shaking, stance.size),
        NO_STATES if frame.states is None else frame.states,
    )
    stirs = stirred(rows, sight.rows)
    moved = sight.moved | stirs
    gone = back = np.zeros(len(rows), dtype=np.bool_)
    hop = hops.leaps(rows, sight.rows, sight.earlier, seconds + sight.stale, body.mirror) & ~righted
    if not met_anew and np.count_nonzero(hop):
        last = sight.placement.inward(sight.rows[None])[0]
        gone, back = left_behind(known, standard, last, hop, before.failing, body.mirror, again)
    signs = Signs(raw, bone, best_bone, told, repeated & moved, gone, back, body.bones, nobodys)
    followed = follow(known, watcher.detector, before, forecast, ahead, standard, seconds, signs)
    lengths, spread = proportions.counted(
        sight.lengths,
        frozen(sight.spread),
        lengths,
        followed.failing,
        body.bones,
        frozen(watcher.detector.bone_spread),
        seconds,
    )
    anyone = bool(np.count_nonzero(np.isfinite(rows)))
    return Sight(
        upright=sight.upright,
        time=time,
        seen=time if anyone else sight.seen,
        rows=rows,
        earlier=sight.rows,
        latest=rows if anyone else sight.latest,
        placement=Placement(stance.turn[None], stance.origin[None], np.array([stance.scale])),
        direction=stance.direction,
        lengths=lengths,
        spread=spread,
        followed=followed,
        swapped=frame.swapped,
        righted=righted,
        moved=moved,
        stale=0.0 if np.count_nonzero(stirs) else sight.stale + seconds,
        refused=unsure or bool(followed.failing.sum() > len(rows) - 3.0),
        other=sight.other,
        lean=sight.lean,
        speaks=speaks,
        shaking=shaking,
    )


def _upright(watcher: Watcher, sight: Sight, positions: Floats, time: float) -> tuple[Sight, Floats]:
    """The sight with where up is as this frame has it, and the positions upright.

    A fresh sight where somebody else is, or where what was known was seen aslant: all is asked anew.
    """
    body = watcher.body
    rows, turn_up, lean, other = positions, sight.upright, sight.lean, False
    if turn_up is None and len(body.upper) and len(body.lower):
        seen = np.isfinite(rows[body.upper]).any() and np.isfinite(rows[body.lower]).any()
        turn_up = upright(rows[None], body) if seen else None
    if turn_up is not None:
        rows = rows @ turn_up.T
        if not lean.told:
            lean = lean.with_frame(rows, body)
            by = tilt(lean.axes) if lean.told else np.eye(3)
            if by[1, 1] < 1.0:
                turn_up, rows, other = by @ turn_up, rows @ by.T, True
    other = other or bool(kernel.leapt(rows, sight.latest, time - sight.seen))
    return replace(fresh(watcher) if other else sight, upright=turn_up, lean=lean, other=other), rows


def _known_before(factors: Factors, sight: Sight, time: float) -> tuple[Followed, float]:
    """What is known of the posture before this frame, and for how many s; of somebody met anew what is their own."""
    before = sight.followed
    if sight.time is None or time - sight.seen > PATIENCE:
        return replace(begin(factors), own=before.own, met=before.met), 0.0
    if sight.seen != sight.time:  # who was out of sight did not fail
        before = replace(before, failing=begin(factors).failing)
    return before, max(time - sight.time, 0.0)


def _stands(watcher: Watcher, sight: Sight, failing: Floats, rows: Floats) -> _Stance:
    """Where somebody stands by (J, 3) upright positions, joints that were `failing` (J,) counting less."""
    body = watcher.body
    return _Stance(
        *kernel.place(
            rows,
            failing,
            sight.lengths,
            body.bones,
            body.across,
            body.trunk,
            watcher.standard.lengths,
            watcher.standard.trunk,
            sight.direction,
            sight.placement.turn[0],
            sight.placement.origin[0],
            sight.scale,
        )
    )


def _sides_by_body(
    watcher: Watcher, sight: Sight, failing: Floats, frame: _Frame, stance: _Stance
) -> tuple[_Frame, _Stance]:
    """Frame and stance of somebody met anew, with sides as bodies have them: there is no past that could tell."""
    body = watcher.body
    if faces_away(watcher.factors, watcher.standard, body, stance.standard[None]):
        frame = frame.exchanged(body.pairs)
        stance = _stands(watcher, sight, failing, frame.rows)
    hung = confused_limbs(watcher.factors, watcher.standard, body, stance.standard[None])
    if hung.any():
        limbs = body.pairs[hung[body.pairs[:, 0]]]
        frame, stance = frame.exchanged(limbs), stance._replace(standard=changed(stance.standard, limbs))
    return frame, stance


def _were_confused(watcher: Watcher, sight: Sight, standard: Floats, sides: Bools, limbs: Ints, seconds: float) -> bool:
    """Whether limbs that changed places were confused for so many seconds until now; who was just put right was not."""
    if (sides & sight.swapped).any():
        return False
    return confused_until_now(watcher.factors, watcher.standard, watcher.body, standard, limbs, seconds)


def _anew(factors: Factors, before: Followed, joints: Bools) -> Followed:
    """What was known of the posture, but for joints (J,) that were taken for others."""
    own = np.where(joints[:, None], 0.0, before.own)
    return replace(begin(factors), own=own, met=np.where(joints, 0.0, before.met))


@dataclass(frozen=True, eq=False)
class Doubt:
    """A frame in which joints hopped away: the next shows whether they came back or stay.

    Attributes
    ----------
    sight : before it.
    rows : (J, 3) m, what the sensor gave, in its own axes by the model's joints.
    states : (J,) or None.
    time : s.
    hopped : (J,) the joints that are not believed yet.
    """

    sight: Sight
    rows: Floats
    states: Bytes | None
    time: float
    hopped: Bools


def look_twice(
    watcher: Watcher, sight: Sight, doubt: Doubt | None, positions: Floats, states: Bytes | None, time: float
) -> tuple[Sight, Doubt | None]:
    """One frame on, as of `look`, where none is known that comes after: who hops away counts as not seen for a frame.

    Who is there still in the next did not come back: the frame of the hop is looked at again as it was.

    Parameters
    ----------
    doubt : of the frame before; None = of nothing.
    positions, states, time : as of `look`.

    Returns
    -------
    The sight after this frame, and what is doubted of it.
    """
    if doubt is not None and sight.upright is not None:
        up = positions @ sight.upright.T
        there, back = doubt.rows @ sight.upright.T, doubt.sight.rows
        nearer = np.square(up - there).sum(axis=1) < np.square(up - back).sum(axis=1)
        if (doubt.hopped & nearer).any():
            believed = np.where((doubt.hopped & ~nearer)[:, None], np.nan, doubt.rows)
            sight = look(watcher, doubt.sight, believed, doubt.states, doubt.time)
    seconds = np.inf if sight.time is None else time - sight.time
    if sight.upright is None or seconds > PATIENCE:
        return look(watcher, sight, positions, states, time), None
    rows = positions @ sight.upright.T
    hopped = hops.hopped(rows, sight.rows, sight.earlier, seconds, watcher.body.mirror)
    hopped &= sight.followed.failing < 0.5  # who fails is not believed anyway, and shakes
    if not hopped.any() or hopped.sum() > MOST_HOP * len(rows):
        return look(watcher, sight, positions, states, time), None
    seen = look(watcher, sight, np.where(hopped[:, None], np.nan, positions), states, time)
    if seen.other:
        return seen, None
    return seen, Doubt(sight, positions, states, time, hopped)
