"""One frame of a sensor looked at: brought to standard form, and followed through failures."""

from dataclasses import dataclass, replace
from math import exp
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints
from ..kernels import hops, proportions
from ..kernels import sighting as kernel
from ..numerics import factors as process
from ..numerics.factors import Factors
from .anatomy import Anatomy
from .follow import Followed, begin, follow
from .leaps import left_behind, stirred
from .level import TOLD_ALREADY, UNASKED, Lean, level, tilt
from .normalise import Placement, Standard, bone_lengths, upright
from .reliability import Detector
from .sides import changed, confused_limbs, confused_until_now, faces_away, gone_along, trunk_turned

FAR = 100.0  # m; what is farther is no person
POINT = 1e-3  # m; joints that are all within this are no person either
SPAN = 2.0  # m, between hands: sides of limbs, not of the trunk, are taken for each other as far apart
PATIENCE = 1.0  # s; after a longer break only the person's size is remembered
RANGE = 2.0  # times what is usual; bones vary by so much in some recordings of the sensor that was learned from
MOST_HOP = 1 / 3  # of the joints; when more hop, somebody else may be there
NO_STATES = np.zeros(0, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Watcher:
    """What is needed to look at frames: the model's joint set and standard body, and what was learned of failures."""

    body: Anatomy
    standard: Standard
    factors: Factors
    detector: Detector


@dataclass(frozen=True, eq=False)
class Sight:
    """What is known after a frame, in the model's joints.

    Attributes
    ----------
    upright : (3, 3) rotation of the sensor's axes that brings its up to y; None before a person was seen.
    time : s, of the frame; None before the first.
    seen : s, of the last frame in which somebody was; -inf before that.
    rows : (J, 3) m, the frame's positions upright, NaN = missing.
    earlier : (J, 3) m, those of the frame before.
    latest : (J, 3) m, those of the last frame in which somebody was.
    placement : of this frame alone.
    direction : (2,) where the trunk points from right to left.
    lengths : (2, B) trusted lengths summed in m, and how many.
    spread : (B,) by how much the logarithm of each bone's length varies.
    followed : in standard form.
    swapped : (J,) joints whose sides were changed back.
    righted : (J,) joints whose sides, as this frame shows, were confused until now.
    moved : (J,) joints that the sensor ever had elsewhere than a frame before, or will in this recording: what never
        moves has not stopped.
    stale : s, for which the sensor has said this posture, all joints alike: a slow one says each several times.
    refused : the frame says so little that it was not judged.
    other : somebody else is where a moment ago somebody was; or who was there was seen aslant until now.
    lean : what was seen of how far the sensor is tilted.
    """

    upright: Floats | None
    time: float | None
    seen: float
    rows: Floats
    earlier: Floats
    latest: Floats
    placement: Placement
    direction: Floats
    lengths: Floats
    spread: Floats
    followed: Followed
    swapped: Bools
    righted: Bools
    moved: Bools
    stale: float
    refused: bool
    other: bool = False
    lean: Lean = UNASKED

    @property
    def scale(self) -> float:
        """Size of the person by that of the standard body."""
        return float(self.placement.scale[0])


def fresh(watcher: Watcher) -> Sight:
    """Before the first frame."""
    joints, bones = len(watcher.body.names), len(watcher.body.bones)
    return Sight(
        None,
        None,
        -np.inf,
        np.full((joints, 3), np.nan),
        np.full((joints, 3), np.nan),
        np.full((joints, 3), np.nan),
        Placement(np.eye(3)[None], np.zeros((1, 3)), np.ones(1)),
        np.zeros(2),
        np.zeros((2, bones)),
        watcher.detector.bone_spread,
        begin(watcher.factors),
        np.zeros(joints, dtype=np.bool_),
        np.zeros(joints, dtype=np.bool_),
        np.zeros(joints, dtype=np.bool_),
        0.0,
        False,
    )


def acquainted(watcher: Watcher, rows: Floats, sight: Sight) -> Sight:
    """The sight before a recording's first frame when all of the recording is at hand: its size is known at once.

    Parameters
    ----------
    rows : (T, J, 3) m in the sensor's axes.
    """
    turn = level(rows, watcher.body)
    lengths = bone_lengths(rows, watcher.body)
    known = np.zeros((2, lengths.shape[1]))
    for b in range(lengths.shape[1]):
        some = lengths[np.isfinite(lengths[:, b]), b]
        if len(some):
            known[:, b] = 100.0 * np.median(some), 100.0
    return replace(sight, upright=turn, lengths=known, lean=TOLD_ALREADY)


def accustomed(watcher: Watcher, rows: Floats) -> Watcher:
    """The watcher used to how unsteady this recording's bones are throughout, when that is more than it was taught.

    Parameters
    ----------
    rows : (T, J, 3) m by the model's joints, NaN = missing.
    """
    vary = np.array(watcher.detector.bone_spread)
    for b, off in enumerate(np.log(np.maximum(bone_lengths(rows, watcher.body), 1e-6)).T):
        known = off[np.isfinite(off)]
        if len(known):
            vary[b] = np.median(np.abs(known - np.median(known))) / proportions.MIDDLE
    return replace(watcher, detector=replace(watcher.detector, bone_spread=unsteadiness(watcher, vary)))


def unsteadiness(watcher: Watcher, spread: Floats) -> Floats:
    """(B,) deviation of the logarithm of each bone's length that is usual here, by what it is in this recording (B,).

    Most joints do not fail, so the median bone shows the sensor's own restlessness; that of one limb that is drawn in
    does not count. Recordings of one sensor differ as well, and that is no reason to overlook failures. The joints'
    second differences are not asked: who moves briskly would teach that failures are usual.
    """
    wider: Floats = proportions.unsteadiness(spread, watcher.detector.bone_spread, RANGE)
    return wider


def size_of(watcher: Watcher, lengths: Floats) -> float:
    """The person's size by that of the standard body; 1 when no bone is known.

    Parameters
    ----------
    lengths : (2, B) sums and counts.
    """
    usual = np.array(watcher.standard.lengths)
    return float(proportions.usual_lengths(lengths, watcher.standard.lengths, usual)) or 1.0


def kinship(watcher: Watcher, sight: Sight, other_kind: bool = False) -> float:
    """The probability that what is seen comes from the sensor that was learned from: bones tell.

    Parameters
    ----------
    other_kind : its joints are those of another kind of sensor, so that nothing speaks for it beforehand.
    """
    body = watcher.body
    kin = float(proportions.kinship(sight.lengths, watcher.standard.lengths, body.twins, body.parts))
    return kin / (kin + (1.0 - kin) * exp(proportions.TRUSTED)) if other_kind else kin


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
    states : (J,) or None.
    time : s.
    again : (J,) joints that will leap again within a few seconds; None = what comes is not known.
    """
    body = watcher.body
    rows, turn_up = positions, sight.upright
    if turn_up is None and len(body.upper) and len(body.lower):
        seen = np.isfinite(rows[body.upper]).any() and np.isfinite(rows[body.lower]).any()
        turn_up = upright(rows[None], body) if seen else None
    lean, levelled = sight.lean, False
    if turn_up is not None:
        rows = rows @ turn_up.T
        if not lean.told:
            lean = lean.with_frame(rows, body)
            by = tilt(lean.axes) if lean.told else np.eye(3)
            levelled = bool(by[1, 1] < 1.0)
            if levelled:  # what was known was seen aslant: all is asked anew
                turn_up, rows = by @ turn_up, rows @ by.T
                sight = replace(fresh(watcher), upright=turn_up)
    other = levelled or bool(kernel.leapt(rows, sight.latest, time - sight.seen))
    if other:
        sight = replace(fresh(watcher), upright=turn_up)
    seconds, away = 0.0 if sight.time is None else max(time - sight.time, 0.0), time - sight.seen
    before = sight.followed
    if away > PATIENCE:
        before, seconds = replace(begin(watcher.factors), own=before.own, met=before.met), 0.0
    elif sight.time is not None and sight.seen != sight.time:  # who was out of sight did not fail
        before = replace(before, failing=begin(watcher.factors).failing)
    if away <= PATIENCE:  # where a joint has just been thrown to says nothing
        reach = np.where(body.trunk, 0.0, SPAN)
        rows = np.where(kernel.strayed(rows, sight.rows, seconds, reach)[:, None], np.nan, rows)
    turned = trunk_turned(rows, sight.direction, away, body)
    none = np.zeros(len(rows), dtype=np.bool_)
    swapped, righted = none, none
    if np.count_nonzero(turned):
        rows, states = changed_sides(rows, states, body.across[turned])
        swapped = np.isin(np.arange(len(rows)), body.across[turned])
    usual, size, direction, *placed, standard = _place(watcher, sight, before.failing, rows)
    if away > PATIENCE:
        if faces_away(watcher.factors, watcher.standard, body, standard[None]):
            rows, states = changed_sides(rows, states, body.pairs)
            swapped = np.isin(np.arange(len(rows)), body.pairs)
            usual, size, direction, *placed, standard = _place(watcher, sight, before.failing, rows)
        hung = confused_limbs(watcher.factors, watcher.standard, body, standard[None])
        if hung.any():
            limbs = body.pairs[hung[body.pairs[:, 0]]]
            rows, states = changed_sides(rows, states, limbs)
            standard, swapped = changed(standard, limbs), swapped ^ hung
    known = watcher.factors
    forecast, ahead = process.forecast(known, before.belief, seconds)
    sides, unsure = kernel.crossed(
        rows, sight.rows, standard, *ahead, known.mean, before.own, known.noise, sight.swapped, body.mirror
    )
    if len(turned) and away <= PATIENCE and (turned != sight.swapped[body.across[:, 0]]).all():
        sides = gone_along(rows, sight.rows, sides, body)
    if np.count_nonzero(sides):
        limbs = body.pairs[sides[body.pairs[:, 0]]]
        met = float(before.met[sides].max())
        if not (sides & sight.swapped).any() and confused_until_now(
            known, watcher.standard, body, standard, limbs, met
        ):
            righted = sides
            before = _anew(watcher, before, righted)
            forecast = before.belief
            ahead = process.expected(known, forecast)
        else:
            rows, states = changed_sides(rows, states, limbs)
            standard = changed(standard, limbs)
            swapped = swapped ^ sides
    lengths, raw, bone, best_bone, nobodys, told, repeated = kernel.signs(
        rows,
        sight.rows,
        sight.earlier,
        size,
        proportions.likely(usual, size, watcher.standard.lengths, body.twins),
        body.bones,
        body.twins,
        unsteadiness(watcher, sight.spread),
        watcher.detector.jerk,
        NO_STATES if states is None else states,
    )
    leaps = none, none
    stirs = stirred(rows, sight.rows)
    moved = sight.moved | stirs
    hop = hops.leaps(rows, sight.rows, sight.earlier, seconds + sight.stale, body.mirror) & ~righted
    if away <= PATIENCE and np.count_nonzero(hop):
        last = sight.placement.inward(sight.rows[None])[0]
        leaps = left_behind(known, standard, last, hop, before.failing, body.mirror, again)
    signs = raw, bone, best_bone, told, repeated & moved, *leaps, body.bones, nobodys
    followed = follow(known, watcher.detector, before, forecast, ahead, standard, seconds, *signs)
    lengths, spread = proportions.counted(
        sight.lengths, sight.spread, lengths, followed.failing, body.bones, watcher.detector.bone_spread, seconds
    )
    anyone = bool(np.count_nonzero(np.isfinite(rows)))
    return Sight(
        turn_up,
        time,
        time if anyone else sight.seen,
        rows,
        sight.rows,
        rows if anyone else sight.latest,
        Placement(placed[0][None], placed[1][None], np.array([placed[2]])),
        direction,
        lengths,
        spread,
        followed,
        swapped,
        righted,
        moved,
        0.0 if np.count_nonzero(stirs) else sight.stale + seconds,
        unsure or bool(followed.failing.sum() > len(rows) - 3.0),
        other,
        lean,
    )


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


def _place(watcher: Watcher, sight: Sight, failing: Floats, rows: Floats) -> Any:
    """Where the person stands: usual lengths, size, direction, turn, origin, scale, and standard form (J, 3)."""
    body = watcher.body
    return kernel.place(
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


def _anew(watcher: Watcher, before: Followed, joints: Bools) -> Followed:
    """What was known of the posture, but for joints (J,) that were taken for others."""
    own = np.where(joints[:, None], 0.0, before.own)
    return replace(begin(watcher.factors), own=own, met=np.where(joints, 0.0, before.met))


def believable(positions: Floats) -> Floats:
    """Positions (..., J, 3) in m, all NaN where no person can be.

    That is what is not finite, far away, or at the sensor itself, where some recordings put what they miss; and
    whole postures in one point.
    """
    frames = np.array(positions, dtype=np.float64).reshape(-1, *positions.shape[-2:])
    return np.asarray(kernel.believable(frames, FAR, POINT)).reshape(positions.shape)


def received(to_model: Ints, positions: Floats, states: Bytes | None) -> tuple[Floats, Floats, Bytes | None]:
    """A frame as it came in: what of it is `believable`, and that and the states by the model's joints.

    Parameters
    ----------
    to_model : (J of model,) the recording's joint of each of the model's, -1 = none.
    positions : (J, 3) m.
    states : (J,) or None.
    """
    codes = NO_STATES if states is None else np.array(states, dtype=np.uint8)
    given, rows, told = kernel.received(np.array(positions, dtype=np.float64), codes, to_model, FAR, POINT)
    return given, rows, None if states is None else told


def changed_sides(rows: Floats, states: Bytes | None, pairs: Ints) -> tuple[Floats, Bytes | None]:
    """Positions and states with the members of the pairs in each other's place."""
    return changed(rows, pairs), None if states is None else changed(states, pairs)


def rows_of(to_model: Ints, values: Floats) -> Floats:
    """(..., J, 3) values by the model's joints, NaN for joints that the recording lacks."""
    return np.where((to_model >= 0)[:, None], values[..., to_model, :], np.nan)
