"""What later frames say of earlier ones: a recording followed back from where it has come to.

A limb that went out of sight is often taken up wrongly, and found again only some frames later; in those frames
the pose is known to be wrong as soon as it leaps. Followed back from there it is seldom wrong in the same ones, for
what comes out of hiding in one direction goes into it in the other. So there are two accounts of every frame, and
for each limb and the trunk that one is taken which explains the images better, changing between the two where they
are near each other: the likeliest sequence (Viterbi 1967). Where they hardly differ they are mixed, as two filters
are joined to smooth (Fraser and Potter 1969); elsewhere they are not, for two poses of a limb have no mean. From there
all frames are solved together (`together`).

`tracker.step` stays causal. This is for recordings: frames wait until `WINDOW + AHEAD` of them are there.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from time import perf_counter
from typing import TypeVar, final

import numpy as np

from ...arrays import Bools, Floats, frozen
from ...bodies.performer import DOFS, LANDMARKS, Performer, Pose, landmarks
from ...numerics.least_squares import Solution
from ..limbs.certainty import astray, bare_of, certainty_of, shown_and_denied, trust_of
from ..limbs.other_poses import LIMBS, coarse_of, disagreements, with_limb
from ..lost import is_lost
from ..misread import held, misread, odds_misread
from ..model import TrackerModel
from ..outcome import Estimate
from ..readings.left_right import strange_legs
from ..readings.pair import either
from ..settings import TrackSettings
from ..state import Facing, Sides, TrackState
from ..terms.objective import PAUSE, expected_pose, terms_of
from ..terms.smooth import difference
from ..terms.solve import solve_pose
from .together import between_turns, solved_together

WINDOW, AHEAD = 90, 15  # frames told of at a time, and how many after them are waited for
NEAR = 0.06  # m; two poses of a limb that are closer are one
SWITCH = 0.1  # share of the person's pixels that a metre between two accounts weighs where one is left for the other
GAIN = 0.02  # of the same, in sum, by which what was written must explain better for the way back to go on from it
FADES = 0.9  # of what earlier frames gained, in each frame
BESIDE = 3  # frames after those told of that are solved together with them
EASED = 2  # frames to either side of one over which the choice between two near accounts is spread
STRAIGHT = 0.03  # m, by which joints of mixed poses may miss the mixture of the joints
TRUNK = len(LIMBS)
_LEGS = slice(2, 4)  # of `PARTS`
_IDENTITY = np.eye(3)
One = TypeVar("One")

_OF_LIMBS = tuple(
    frozen([limb.begin, *limb.landmarks] if limb.name.endswith("arm") else limb.landmarks, np.int64) for limb in LIMBS
)
PARTS = (*_OF_LIMBS, frozen(np.setdiff1d(np.arange(len(LANDMARKS)), np.concatenate(_OF_LIMBS)), np.int64))
"""The landmarks of each of `LIMBS`, with the shoulders, which arms' bones carry; and of the trunk, all others."""
CHOICES = frozen(list(product((False, True), repeat=TRUNK + 1)), np.bool_)  # (32, 5) True = as on the way back
_PART_OF = frozen(
    [next((k for k, limb in enumerate(LIMBS) if column in limb.columns), TRUNK) for column in range(DOFS - 6)], np.int64
)
_PARTS = tuple(part.tolist() for part in PARTS)
_PART_OF_LANDMARK = frozen(
    [next(k for k, part in enumerate(_PARTS) if i in part) for i in range(len(LANDMARKS))], np.int64
)
_CHANGED = (CHOICES[:, None] != CHOICES[None]).astype(np.float64)


@final
@dataclass(frozen=True, eq=False)
class Moment:
    """One frame, as it was followed.

    Attributes
    ----------
    state : after it. estimate : of it.
    """

    state: TrackState
    estimate: Estimate

    @property
    def tracked(self) -> bool:
        """Whether the body was followed in this frame."""
        return "tracked" in self.estimate.flags


def moment(state: TrackState, estimate: Estimate) -> Moment:
    """What `tracker.step` gave, without what nobody asks for again: the room, what is looked at, another pose."""
    question = state.facing.question
    facing = state.facing if question is None else Facing(replace(question, look=None))
    kept = replace(state, scene=None, before=None, hypothesis=None, girth=None, facing=facing, sides=Sides())
    return Moment(kept, estimate)


@final
@dataclass(frozen=True, eq=False)
class Back:
    """One frame, as the way back has it.

    Attributes
    ----------
    solution : its pose. wrong : share of the person's pixels that it explains wrongly.
    held : (16,) joints of which nothing is seen. hidden : (16,) s until they are. doubt : (16,) m, see `astray`.
    readings : (16,) m, half of how far apart front and back have them, if that was open where the way back began.
    apart : (5,) m from the pose first written, of each of `PARTS`.
    costs : (2, 5) share explained wrongly by the pose first written, alone and with each limb of the other; and
        the same of the way back's. Where they have the legs apart, with what is strange about them.
    """

    solution: Solution[Pose]
    wrong: float
    held: Bools
    hidden: Floats
    doubt: Floats
    readings: Floats
    apart: Floats
    costs: Floats

    @property
    def pose(self) -> Pose:
        return self.solution.state


def revised(model: TrackerModel, settings: TrackSettings, moments: Iterable[Moment]) -> Iterator[Estimate]:
    """The estimate of every frame, in order, set right by up to `WINDOW + AHEAD` frames that come after it.

    Parameters
    ----------
    model, settings : as for `tracker.step`; without `settings.hindsight` estimates come as they are, at once.
    moments : of one recording, in order. No more than `WINDOW + AHEAD` of them are kept.
    """
    if not settings.hindsight:
        yield from (one.estimate for one in moments)
        return
    for some, count in stretches(moments):
        yield from looked_back(model, settings, some, count)


def stretches(moments: Iterable[One]) -> Iterator[tuple[list[One], int]]:
    """Frames as they are looked back at: up to `WINDOW + AHEAD` in order, and of how many of them it is told.

    The next stretch begins with the first frame that was not told of. Of the last one all are.
    """
    waiting: list[One] = []
    for one in moments:
        waiting.append(one)
        if len(waiting) == WINDOW + AHEAD:
            yield waiting, WINDOW
            waiting = waiting[WINDOW:]
    if waiting:
        yield waiting, len(waiting)


def looked_back(
    model: TrackerModel, settings: TrackSettings, moments: Sequence[Moment], count: int
) -> tuple[Estimate, ...]:
    """The estimates of the first `count` of some frames, as they look from the last one.

    Parameters
    ----------
    model, settings : as for `tracker.step`.
    moments : frames in order; one at least.
    count : how many of them are told of; the others are what comes after.

    Returns
    -------
    Where a limb or the body is taken from the way back, its deviations and `held` are the way back's; poses are those
    of all frames solved together, and frames that have a joint `NEAR` or more from where it was first are flagged
    `revised`. Frames that were lost and are not on the way back are tracked. `seconds` has the time under `hindsight`;
    what is said of the solver stays that of `tracker.step`.
    """
    begin = perf_counter()
    body = moments[-1].state.performer
    backs = way_back(model, settings, moments)
    moments, backs = moments[: count + BESIDE], backs[: count + BESIDE]
    shares = eased(moments, backs, likeliest(moments, backs))
    told = [
        one.estimate if back is None or not share.any() else _joined(body, one, back, share, turned)
        for one, back, share, turned in zip(moments, backs, shares, _roots(moments, backs, shares), strict=True)
    ]
    followed = [one.pose if "tracked" in one.flags else None for one in told]
    settled = solved_together(model, settings, body, [one.state for one in moments], followed)
    share = (perf_counter() - begin) / count
    return tuple(
        replace(one if pose is None else _settled(body, first, one, pose), seconds={**one.seconds, "hindsight": share})
        for first, one, pose in zip(moments[:count], told, settled, strict=False)
    )


def way_back(model: TrackerModel, settings: TrackSettings, moments: Sequence[Moment]) -> list[Back | None]:
    """Frames followed from the last one to the first, without any search.

    Where the pose first written explains the frames better, in sum, the way back goes on from it: a limb's, or all.

    Parameters
    ----------
    model, settings : as for `tracker.step`.
    moments : frames in order.

    Returns
    -------
    For each frame what was found there; None where there is nobody, nothing to come from, or the body was lost.
    """
    body = moments[-1].state.performer
    backs: list[Back | None] = [None] * len(moments)
    at: TrackState | None = None
    gained = np.zeros(TRUNK + 1)
    for t in range(len(moments) - 1, -1, -1):
        here = moments[t]
        found = None if at is None else _stepped(model, settings, at, here)
        if found is None:
            at, gained = (_from(here, body) if here.tracked else None), np.zeros(TRUNK + 1)
            continue
        at, back = found
        backs[t] = back
        if not here.tracked:
            gained[:] = 0.0
            continue
        # Against the whole pose first written, and against its limbs on the body as the way back has it.
        better = back.costs[1, 0] - np.append(back.costs[1, 1:], back.costs[0, 0])
        gained = np.maximum(FADES * gained + better, 0.0)
        gained[:TRUNK][back.apart[:TRUNK] < NEAR] = 0.0
        most = int(np.argmax(gained))
        if back.apart.max() < NEAR:
            gained[:] = 0.0
        elif gained[most] > GAIN:
            at, gained = _resumed(at, _from(here, body), most), np.zeros(TRUNK + 1)
    return backs


def likeliest(moments: Sequence[Moment], backs: Sequence[Back | None]) -> Bools:
    """(T, 5) which of `PARTS` are taken from the way back, so that all frames together are explained best.

    A pixel that two limbs dispute is counted for each by itself. To change between the accounts costs what they are
    apart there, in either frame.
    """
    costs, apart = np.zeros((len(moments), len(CHOICES))), np.zeros((len(moments), TRUNK + 1))
    for t, (one, back) in enumerate(zip(moments, backs, strict=True)):
        if back is None:
            costs[t, CHOICES.any(axis=1)] = np.inf
        elif not one.tracked:
            costs[t, ~CHOICES.all(axis=1)] = np.inf
        else:
            apart[t] = back.apart
            first, other = back.costs[:, :1], back.costs[:, 1:] - back.costs[:, :1]
            limbs, trunk = CHOICES[:, :TRUNK], CHOICES[:, TRUNK]
            costs[t] = np.where(trunk, first[1] + ~limbs @ other[1], first[0] + limbs @ other[0])
    sums, origin = costs[0], np.zeros((len(moments), len(CHOICES)), np.int64)
    for t in range(1, len(moments)):
        ways = sums[:, None] + SWITCH * (_CHANGED @ np.minimum(apart[t - 1], apart[t]))
        origin[t] = np.argmin(ways, axis=0)
        sums = ways[origin[t], np.arange(len(CHOICES))] + costs[t]
    best = [int(np.argmin(sums))]
    for t in range(len(moments) - 1, 0, -1):
        best.append(int(origin[t, best[-1]]))
    return np.asarray(CHOICES[best[::-1]])


def eased(moments: Sequence[Moment], backs: Sequence[Back | None], chosen: Bools) -> Floats:
    """(T, 5) how much of each of `PARTS` is taken from the way back, 0 to 1.

    Where the accounts are near each other the choice is by little, and may change with every frame's noise: there it is
    the mean over `EASED` frames to either side that are near, too.

    Parameters
    ----------
    moments, backs : the accounts. chosen : (T, 5) what `likeliest` says.
    """
    shares = chosen.astype(np.float64)
    near = np.zeros(chosen.shape, bool)
    for t, (one, back) in enumerate(zip(moments, backs, strict=True)):
        if back is not None and one.tracked:
            near[t] = back.apart < NEAR
    for t, part in np.argwhere(near).tolist():
        first, last = t, t + 1
        while first > max(t - EASED, 0) and near[first - 1, part]:
            first -= 1
        while last < min(t + EASED + 1, len(near)) and near[last, part]:
            last += 1
        shares[t, part] = chosen[first:last, part].mean()
    return shares


def _from(here: Moment, body: Performer) -> TrackState:
    """What the way back goes on from where it is what was first written; time runs the other way."""
    state = here.state
    return replace(state, performer=body, velocity=frozen(-state.velocity))


def _stepped(
    model: TrackerModel, settings: TrackSettings, at: TrackState, here: Moment
) -> tuple[TrackState, Back] | None:
    """One frame further back; None where that leads to nobody."""
    evidence, elapsed = here.state.evidence, at.time - here.state.time
    if evidence is None or not 0.0 < elapsed < PAUSE:
        return None
    assert at.pose is not None
    body, coarse = at.performer, coarse_of(evidence)
    expected = expected_pose(at, settings, elapsed, coarse)
    terms = terms_of(model, settings, at, evidence, expected, elapsed)
    solution = solve_pose(body, evidence, terms, expected, settings)
    pose = solution.state
    first = here.estimate.pose if here.tracked else None
    costs, apart = np.full((2, TRUNK + 1), np.nan), np.zeros(TRUNK + 1)
    if first is None:
        wrong = float(disagreements(body, [pose], coarse)[0])
    else:
        ways = [_with(one, other) for one, other in ((first, pose), (pose, first))]
        costs = disagreements(body, [*ways[0], *ways[1]], coarse).reshape(2, -1)
        wrong = float(costs[1, 0])
        gap = np.linalg.norm(here.estimate.landmarks - landmarks(body, pose), axis=1).tolist()
        apart = np.array([0.5 * sum(sorted(gap[i] for i in part)[-2:]) for part in _PARTS])
        if apart[_LEGS].max() > NEAR:
            known = np.maximum(here.state.trust, at.trust)
            of_legs = [[strange_legs(model.database.search, some[k], known) for k in (0, 3, 4)] for some in ways]
            costs += np.array(of_legs)[:, [0, 0, 0, 1, 2]]  # with an arm of the other the legs are the same
    if is_lost(here.state.wrong, wrong):
        return None
    shown, denied, unknown = shown_and_denied(body, pose, coarse, evidence.weight)
    trust, seen = trust_of(shown)
    hidden = np.where(seen, 0.0, at.hidden + elapsed)
    bare = bare_of(at.bare, shown, denied, unknown, elapsed)
    odds = held(at.misread, odds_misread(model.database.search, pose, wrong, trust), elapsed)
    velocity = difference(pose, at.pose) / elapsed
    velocity[6:] *= np.minimum(1.0, 0.2 + trust)
    after = replace(
        here.state,
        performer=body,
        pose=pose,
        velocity=frozen(velocity),
        trust=frozen(trust),
        hidden=frozen(hidden),
        facing=at.facing,
        misread=odds,
        bare=frozen(bare),
    )
    doubt = np.hypot(astray(shown, denied, bare, wrong, here.state.wrong), misread(odds))
    readings = either(at.facing.question, body, pose)
    return after, Back(solution, wrong, ~seen, hidden, doubt, readings, apart, costs)


def _with(pose: Pose, other: Pose) -> list[Pose]:
    """The pose, and with each limb of the other."""
    return [pose, *(with_limb(pose, limb, other.joints[limb.columns]) for limb in LIMBS)]


def _resumed(at: TrackState, first: TrackState, part: int) -> TrackState:
    """The way back with one limb as first written, or, for the trunk, all of that."""
    if part == TRUNK:
        return first
    assert at.pose is not None
    assert first.pose is not None
    limb = LIMBS[part]
    moved, shown = np.isin(np.arange(DOFS), 6 + limb.columns), np.isin(np.arange(DOFS - 6), limb.columns)
    return replace(
        at,
        pose=with_limb(at.pose, limb, first.pose.joints[limb.columns]),
        velocity=frozen(np.where(moved, first.velocity, at.velocity)),
        trust=frozen(np.where(shown, first.trust, at.trust)),
    )


def _roots(moments: Sequence[Moment], backs: Sequence[Back | None], shares: Floats) -> Floats:
    """(T, 3, 3) the roots turned so far as on the way back; all at once, for one alone costs as much."""
    first = np.array([_IDENTITY if one.estimate.pose is None else one.estimate.pose.root for one in moments])
    other = np.array([root if back is None else back.pose.root for back, root in zip(backs, first, strict=True)])
    return between_turns(first, other, shares[:, TRUNK, None])


def _joined(body: Performer, one: Moment, back: Back, share: Floats, turned: Floats) -> Estimate:
    """The estimate with so much of each of `PARTS` as on the way back, the root turned (3, 3) as it is then."""
    said, parts = one.estimate, share > 0.5
    taken = np.zeros(len(LANDMARKS), bool)
    for part in np.flatnonzero(parts):
        taken[PARTS[part]] = True
    std = said.settled
    if parts.any():
        hidden = np.minimum(back.hidden, one.state.hidden)  # it is known from either side
        _, std = certainty_of(body, back.solution, hidden, back.doubt, back.wrong)
    assert std is not None
    if not one.tracked:
        return replace(
            said,
            pose=back.pose,
            landmarks=landmarks(body, back.pose),
            std=np.maximum(std, back.readings),
            settled=std,
            flags=("tracked", "revised", *(("held",) if back.held.any() else ())),
            held=back.held,
            wrong=back.wrong,
        )
    assert said.pose is not None
    assert said.settled is not None
    there = landmarks(body, back.pose)
    pose, place = _mixed(body, (said.pose, said.landmarks), (back.pose, there), share, turned)
    held = np.where(taken, back.held, said.held)
    settled = np.where(taken, std, said.settled)
    # Of what nothing is seen either may be right, and other poses may be that the way back has not looked at.
    between = 0.5 * np.linalg.norm(there - said.landmarks, axis=1)
    settled = np.where(held, np.maximum(np.maximum(settled, between), np.where(said.held, said.settled, 0.0)), settled)
    # Front and back are still in doubt, unless the other reading was taken.
    about = parts[TRUNK] and float(back.pose.root[:, 2] @ said.pose.root[:, 2]) < 0.0
    doubtful = (said.std > said.settled) & (not about)
    flags = tuple(flag for flag in said.flags if flag != "held")
    if (np.linalg.norm(place - said.landmarks, axis=1) > NEAR).any():
        flags += ("revised",)
    flags += ("held",) if held.any() else ()
    return replace(
        said,
        pose=pose,
        landmarks=place,
        std=np.where(doubtful, np.maximum(said.std, settled), settled),
        settled=settled,
        flags=flags,
        held=held,
    )


def _settled(body: Performer, first: Moment, said: Estimate, pose: Pose) -> Estimate:
    """The estimate with the pose that all frames together have."""
    place = landmarks(body, pose)
    flags = tuple(flag for flag in said.flags if flag != "revised")
    if not first.tracked or (np.linalg.norm(place - first.estimate.landmarks, axis=1) > NEAR).any():
        held = flags.index("held") if "held" in flags else len(flags)
        flags = (*flags[:held], "revised", *flags[held:])
    return replace(said, pose=pose, landmarks=place, flags=flags)


def _mixed(
    body: Performer, one: tuple[Pose, Floats], another: tuple[Pose, Floats], share: Floats, turned: Floats
) -> tuple[Pose, Floats]:
    """A pose that has so much of each of `PARTS` of another one; all three with their joints (16, 3) m.

    Joint coordinates far apart may have joints at one place: where the mixture is not where theirs is, each part is
    wholly of one pose.
    """
    (first, here), (other, there) = one, another
    pose = _between(first, other, share, turned)
    place = landmarks(body, pose)
    if ((share == 0.0) | (share == 1.0)).all():
        return pose, place
    meant = here + share[_PART_OF_LANDMARK, None] * (there - here)
    if np.linalg.norm(place - meant, axis=1).max() > STRAIGHT:
        whole = share > 0.5
        pose = _between(first, other, whole.astype(np.float64), other.root if whole[TRUNK] else first.root)
        place = landmarks(body, pose)
    return pose, place


def _between(first: Pose, other: Pose, share: Floats, turned: Floats) -> Pose:
    """Place and joint coordinates so far from one pose to the other as (5,) shares say, with the root (3, 3)."""
    moved = first.translation + share[TRUNK] * (other.translation - first.translation)
    return Pose(moved, turned, first.joints + share[_PART_OF] * (other.joints - first.joints))
