"""A whole recording corrected, by each of the methods there are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Bools, Floats, Ints
from ..bodies.joint_sets import mirrored
from ..bodies.postures import Postures
from ..kernels.sighting import LENGTH, SHARE
from ..numerics.local_gp import Mixture
from .classic import FILTERS, LEARNERS, Samples
from .energy import Weights
from .hindsight import judged_again, placed_again
from .joining import Joining, inward, outward
from .leaps import leaps_again, stirred
from .level import TOLD_ALREADY, level
from .limits import Hinges, hinges_of
from .normalise import Placement, bone_lengths, placed
from .noted import noted
from .online import blank, remembered, taken_in
from .paper import WEIGHTS, corrected_as_published, neighbour_inputs
from .settling import OFFSET, gently, settled_recording
from .sides import about_turn, confused_limbs, faces_away
from .sight import Sight, Watcher, acquainted, fresh, kinship, rows_of, size_of
from .spatial import Processes, shape_features
from .spikes import thrown_and_back
from .spine import joined_as_seen
from .still import repeated, unmeasured
from .thrown_about import put_back
from .trembling import calmed
from .watching import look

PAPER = ("paper", "exact", "adaptive")
METHODS = ("default", *PAPER, *FILTERS, *LEARNERS)
FIRM = 0.05  # m: joints no further from an axis do not tell a turn about it
_PLACE = "turn", "origin", "scale"
GLIMPSE = 300  # frames of a recording that are looked at twice
ENOUGH = 1.5  # log-odds at which sides are exchanged throughout; one frame needs twice as much


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What a recording is corrected with.

    Attributes
    ----------
    watcher : looks at frames.
    processes : the offsets.
    following : (J, J) how joints without a truth take their offset from their neighbours.
    samples : for the methods to compare with.
    limits : (J, 2) rad, how far joints bend; NaN = not known.
    fitted : the truth it was learned from was brought to the sensor by a rigid motion.
    """

    watcher: Watcher
    processes: Processes
    following: Floats
    samples: Samples
    limits: Floats
    fitted: bool

    def hinges(self, joining: Joining) -> Hinges:
        """The joints of a recording that have limits."""
        return hinges_of(self.limits, self.watcher.body, joining.to_model, joining.bones, len(joining.names))

    def offsets(self, posture: Floats, unsure: Floats, kin: float) -> tuple[Floats, Floats]:
        """Offsets (T, J, 3) from postures to corrected ones, in standard form, if the sensor is the one learned from;
        and the standard deviation (T, J) of what comes of as much of them as that is likely.

        Parameters
        ----------
        posture, unsure : (T, J, 3) and (T, J) the deviation of a coordinate, in standard form.
        kin : probability that the sensor is the one that was learned from. Another one's habits are not known: they are
            as large, in any direction.
        """
        offsets, variance = self.processes.predict(shape_features(posture, self.watcher.body))
        offsets = self.following @ offsets
        unknown = (1.0 - kin**2) * (offsets**2).mean(axis=2)
        return offsets, np.sqrt(variance + unsure**2 + unknown)


def by_default(knowledge: Knowledge, postures: Postures, online: bool) -> Postures:
    """Followed through failures, seen again from the end, moved by the learned offsets, settled."""
    again, since = repeated(postures.positions, postures.times)
    back = put_back(postures.positions, postures.times)
    thrown = thrown_and_back(back.positions, postures.times, mirrored(postures.names))
    given = np.where(thrown[..., None], np.nan, back.positions)
    calm = calmed(given, postures.times)
    calm = calm.only(_with_bones(knowledge.watcher, postures.names, calm.positions), given)
    postures = postures.with_positions(calm.positions)
    joining, sights = _watched_twice(knowledge.watcher, postures)
    failing = judged_again(sights)
    posture, unsure = placed_again(knowledge.watcher.factors, sights, failing)
    kin = float(np.mean([kinship(knowledge.watcher, one, joining.doubt) for one in sights]))
    offsets, std = knowledge.offsets(posture, unsure, kin)
    moved = posture + kin * _calmed(offsets, sights, postures.times)
    if knowledge.fitted:
        moved = _kept_in_place(posture, moved, sights, knowledge.processes.told)
    positions, std, reliable = outward(joining, postures.positions, sights, moved, std, failing)
    hinges, size = knowledge.hinges(joining), float(np.median([one.scale for one in sights]))
    settled = settled_recording(positions, postures.times, reliable, joining.bones, hinges, size)
    if online:
        shifts = inward(joining, sights, settled) - moved
        learned = moved + _learned_on_the_way(knowledge, postures, posture, shifts, 1.0 - failing, unsure)
        positions, _, _ = outward(joining, postures.positions, sights, learned, unsure, failing)
        settled = settled_recording(positions, postures.times, reliable, joining.bones, hinges, size)
    variance = np.where(back.thrown, back.deviation**2, 0.0) + calm.variance
    std, reliable = unmeasured(again, since, np.sqrt(std**2 + variance), np.where(back.thrown, 0.0, reliable))
    source = noted(joining, postures, settled, sights, kin, again)
    return replace(postures, positions=settled, std=std, reliability=reliable, source=source)


def by_paper(
    knowledge: Knowledge,
    mixture: Mixture,
    postures: Postures,
    method: str,
    online: bool,
    weights: Weights = WEIGHTS,
) -> Postures:
    """The paper's method, its energy descended ("paper") or solved ("exact"), or with weights that adapt ("adaptive").

    Parameters
    ----------
    knowledge : of the model.
    mixture : local Gaussian processes, of `learned_mixture`.
    postures : T frames.
    method : "paper", "exact" or "adaptive".
    online : learn from reliable frames on the way (algorithm 2).
    weights : of the terms of eq. 22.
    """
    joining, sights, standard, placement = _placed(knowledge.watcher, postures)
    rows = np.stack([one.rows for one in sights])
    result, std, reliable = corrected_as_published(
        mixture,
        knowledge.watcher.body,
        placement,
        rows,
        standard,
        postures,
        joining.to_model,
        method,
        online,
        weights=weights,
    )
    moved = standard + knowledge.following @ (result - standard)
    positions, deviation, trust = outward(joining, postures.positions, sights, moved, std, 1.0 - reliable)
    return replace(postures, positions=positions, std=deviation, reliability=trust)


def by_filter(postures: Postures, method: str) -> Postures:
    """The sensor's positions filtered; every joint is trusted."""
    present = np.isfinite(postures.positions).all(axis=2)
    positions = FILTERS[method](postures.positions, postures.times)
    trusted = np.asarray(present, dtype=np.float64)
    return replace(postures, positions=positions, std=np.zeros(trusted.shape), reliability=trusted)


def by_learner(knowledge: Knowledge, postures: Postures, method: str) -> Postures:
    """What a learner makes of each frame alone; every joint is trusted."""
    joining, sights, standard, _ = _placed(knowledge.watcher, postures)
    moved = standard + knowledge.following @ LEARNERS[method](knowledge.samples)(standard)
    zero = np.zeros(standard.shape[:2])
    positions, std, _ = outward(joining, postures.positions, sights, moved, zero, zero)
    trusted = np.asarray(np.isfinite(postures.positions).all(axis=2), dtype=np.float64)
    return replace(postures, positions=positions, std=std, reliability=trusted)


def _watched(
    watcher: Watcher, joining: Joining, sight: Sight, rows: Floats, postures: Postures, confused: Bools
) -> list[Sight]:
    """The frames looked at with the sides of joints (T, J) changed back that are known to be confused.

    What each knows of the factors, most of its size, is not kept: it is asked for by the next frame alone.
    """
    sights: list[Sight] = []
    nothing = sight.followed.belief
    again = leaps_again(rows, postures.times, watcher.body.mirror)
    for t, row in enumerate(rows):
        told = None if postures.state is None else joining.states(postures.state[t])
        if confused[t].any():
            row = np.where(confused[t][:, None], row[watcher.body.mirror], row)
            told = None if told is None else np.where(confused[t], told[watcher.body.mirror], told)
        sight = look(watcher, sight, row, told, float(postures.times[t]), again[t])
        sights.append(replace(sight, followed=replace(sight.followed, belief=nothing)))
    return sights


def _with_bones(watcher: Watcher, names: Sequence[str], positions: Floats) -> Bools:
    """(J,) joints of a recording (T, J, 3) none of whose bones is, in the median, too short to be anybody's: noise
    makes bones longer, failing draws joints in."""
    body, standard = watcher.body, watcher.standard
    joining, usual = joined_as_seen(names, positions, standard, body), standard.lengths
    rows = rows_of(joining.to_model, positions)
    found = np.ones(len(names), dtype=np.bool_)
    lengths = [one[np.isfinite(one)] for one in bone_lengths(rows, body).T]
    middle = np.array([np.median(one) if len(one) else np.nan for one in lengths])
    size = float(np.nanmedian(middle / usual)) if np.isfinite(middle).any() else 1.0
    off = size * usual - middle > size * (SHARE * usual + LENGTH)
    ends = joining.to_model[body.bones[off].ravel()]
    found[ends[ends >= 0]] = False
    return found


def _watched_twice(watcher: Watcher, postures: Postures) -> tuple[Joining, list[Sight]]:
    """The recording's frames looked at; a first look tells what is this person's own, by joints that went well, and
    whether sides were confused from the beginning."""
    joining = joined_as_seen(postures.names, postures.positions, watcher.standard, watcher.body)
    rows = rows_of(joining.to_model, postures.positions)
    stirs = np.asarray(stirred(rows[1:], rows[:-1]).any(axis=0))
    begun = replace(fresh(watcher), upright=level(rows, watcher.body), moved=stirs, lean=TOLD_ALREADY)
    glimpse = _watched(watcher, joining, begun, rows[:GLIMPSE], postures, np.zeros(rows.shape[:2], dtype=np.bool_))
    last = glimpse[-1]
    met = replace(begun.followed, own=last.followed.own, met=last.followed.met)
    came = int(np.argmax(np.isfinite(rows[:GLIMPSE]).any(axis=(1, 2))))
    known = float(postures.times[came])  # which side is which is asked of all frames, not of one
    begun = replace(begun, lengths=last.lengths, followed=met, seen=known)
    confused = _confused_at_first(glimpse, came, len(rows)) ^ _confused_throughout(watcher, glimpse)
    sights = _watched(watcher, joining, begun, rows, postures, confused)
    return joining, [replace(one, swapped=one.swapped ^ was) for one, was in zip(sights, confused, strict=True)]


def _confused_throughout(watcher: Watcher, sights: Sequence[Sight]) -> Bools:
    """(J,) joints whose sides are exchanged in most frames: changes were followed, what came first is asked of all."""
    body, standard, factors = watcher.body, watcher.standard, watcher.factors
    postures = np.concatenate([one.placement.inward(one.rows[None]) for one in sights])
    confused = np.zeros(len(body.names), dtype=np.bool_)
    if faces_away(factors, standard, body, postures, ENOUGH):
        confused[body.pairs] = True
        postures = about_turn(postures, body)
    return confused ^ confused_limbs(factors, standard, body, postures, ENOUGH)


def _confused_at_first(sights: Sequence[Sight], came: int, frames: int) -> Bools:
    """(T, J) joints whose sides were confused from the frame in which somebody came until they changed, or somebody
    else was there: by that frame itself, or as a later one showed.

    Parameters
    ----------
    came : the first frame with somebody.
    frames : T, of which the sights are the first.
    """
    changed = np.stack([one.swapped for one in sights])
    behind = np.zeros(changed.shape, dtype=np.bool_)  # until a later frame showed it, as long as nothing changed
    for t in range(len(sights) - 1, 0, -1):
        if not sights[t].other:
            behind[t - 1] = sights[t].righted | (behind[t] & (changed[t] == changed[t - 1]))
    confused = changed ^ behind
    alike = np.logical_and.accumulate(confused[came:] == confused[came], axis=0)
    others = [t for t, one in enumerate(sights) if one.other and t > came]
    found = np.zeros((frames, changed.shape[1]), dtype=np.bool_)
    found[: len(sights)] = confused[came]
    found[came : len(sights)] &= alike
    if others:
        found[others[0] :] = False
    else:
        found[len(sights) :] = confused[came] & alike[-1]
    return found


def _placed(watcher: Watcher, postures: Postures) -> tuple[Joining, list[Sight], Floats, Placement]:
    """The recording in standard form as the sensor gave it, all joints trusted, missing ones at their mean places."""
    joining = joined_as_seen(postures.names, postures.positions, watcher.standard, watcher.body)
    given = rows_of(joining.to_model, postures.positions)
    begun = acquainted(watcher, given, fresh(watcher))
    turn_up = np.eye(3) if begun.upright is None else begun.upright
    rows = given @ turn_up.T
    weights = np.asarray(np.isfinite(rows).all(axis=2), dtype=np.float64)
    scale = np.full(len(rows), size_of(watcher, begun.lengths))
    placement = placed(rows, weights, scale, watcher.standard, watcher.body)
    standard = placement.inward(rows)
    standard = np.where(np.isfinite(standard), standard, watcher.factors.mean)
    sights = [
        replace(
            begun,
            rows=row,
            placement=Placement(placement.turn[t : t + 1], placement.origin[t : t + 1], placement.scale[t : t + 1]),
        )
        for t, row in enumerate(rows)
    ]
    return joining, sights, standard, placement


def _calmed(offsets: Floats, sights: Sequence[Sight], times: Floats) -> Floats:
    """Offsets (T, J, 3) in standard form smoothed in the sensor's axes: neither one joint's noise nor a heading that
    trembles is a reason to move the others."""
    turn = np.stack([one.placement.turn[0] for one in sights])
    scale = np.array([one.scale for one in sights])[:, None, None]
    rows = np.stack([one.rows for one in sights])
    calm = gently(scale * offsets @ turn, rows, times, OFFSET)
    return np.asarray(calm @ turn.swapaxes(1, 2) / scale)


def _kept_in_place(posture: Floats, moved: Floats, sights: Sequence[Sight], told: Ints) -> Floats:
    """Corrected postures (T, J, 3) brought back by the one rigid motion by which a recording's offsets take the joints
    that were told (K,) away as a whole, all in standard form.

    The truth is brought to a sensor's axes by a rigid motion (`pairs.match`), so that pairs say nothing of where and
    how a sensor stands: what processes tell of it is chance. Turns are small and solved linearly; about an axis along
    which all joints lie none is made. Frames in which nobody is seen are not asked.
    """
    seen = np.array([np.isfinite(one.rows).any() for one in sights])
    place = Placement(*(np.concatenate([getattr(one.placement, name) for one in sights]) for name in _PLACE))
    there = place.outward(moved)
    away = (place.outward(posture) - there)[seen][:, told].reshape(-1, 3)
    points = there[seen][:, told].reshape(-1, 3)
    known = np.isfinite(points + away).all(axis=1)
    if not known.any():
        return moved
    points, away = points[known], away[known]
    middle, shift = points.mean(axis=0), away.mean(axis=0)
    arms = points - middle
    spread = arms.T @ arms / len(arms)
    inertia = np.trace(spread) * np.eye(3) - spread
    turn = np.linalg.solve(inertia + FIRM**2 * np.eye(3), np.cross(arms, away).mean(axis=0))
    rotation = Rotation.from_rotvec(turn).as_matrix()
    return place.inward((there - middle) @ rotation.T + middle + shift)


def _learned_on_the_way(
    knowledge: Knowledge, postures: Postures, posture: Floats, shifts: Floats, reliable: Floats, unsure: Floats
) -> Floats:
    """(T, J, 3) what was remembered at each frame from the frames before it."""
    inputs = neighbour_inputs(posture, knowledge.watcher.body)
    memory = blank(inputs.shape[1], inputs.shape[2])
    found = np.zeros(posture.shape)
    for t in range(len(posture)):
        found[t] = remembered(memory, inputs[t])
        certain = unsure[t] < 0.01
        memory = taken_in(memory, float(postures.times[t]), inputs[t], shifts[t], reliable[t], certain)
    return found
