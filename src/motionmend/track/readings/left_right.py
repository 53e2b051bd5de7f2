"""Left or right: legs, shoulders with the arms, or forearms that cross, that were taken for each other.

Seen from the side legs that pass each other look, for a few frames, as if they parted again. A leg taken for the other
one is followed on with the hips turned to it, and explains the image nearly as well as the right one would: knees and
feet are where legs are. Shoulders of a body that turns are mistaken for each other in the same way, and forearms that
cross for such that bend back where they meet. But so twisted a body bends as nobody's does, and goes on doing so. So
where they were near each other in the image, and now and then besides, the reading with left and right changed over is
carried along (`pair`) until one of them is refuted.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ...arrays import Bools, Floats, Ints, frozen
from ...bodies.performer import BONES, DOFS, FIRST, LANDMARKS, Performer, Pose, landmarks
from ...numerics.neighbors import Neighbors
from ..database import strange
from ..limbs.other_poses import LIMBS, Limb
from ..starting.first_pose import poses_to
from ..starting.reach import reach
from ..state import Fit, Question, Sides, TrackState
from .hypotheses import ONE, apart
from .pair import IMAGE, LATER, STRANGE, Follow, due, looked_at

NEAR, APART = 0.12, 0.20  # m, across the line of sight, and in space
SOON = 0.1  # s, after which it is looked at again whether arms that may cross are bent as nobody's
CROSSING = 1.4  # times a forearm's length, up to which each wrist is from the other elbow where forearms may cross
TOUCHING = 0.12  # m between wrists, nearer than which it is one which is which
BENT = 0.2  # rad from the library's poses, up to which people bend so, and the other reading bends no less
_CHEST = BONES.index("chest")


@final
@dataclass(frozen=True, eq=False)
class Pair:
    """What may be changed over.

    Attributes
    ----------
    left, right : landmarks, from the trunk outward.
    columns : (n,) of the 28 joint coordinates. counted : (28,) 1 for those by which it is told, 0 for the others.
    alone : whether nothing but these coordinates moves for it.
    """

    left: Ints
    right: Ints
    columns: Ints
    counted: Floats
    alone: bool = False


def _pair(left: Limb, right: Limb, *, begins: bool, trunk: tuple[int, ...]) -> Pair:
    first, second = (
        frozen([limb.begin, *limb.landmarks] if begins else limb.landmarks, np.int64) for limb in (left, right)
    )
    columns = frozen([*trunk, *left.columns, *right.columns], np.int64)
    return Pair(first, second, columns, frozen(np.isin(np.arange(DOFS - 6), columns), np.float64))


LEGS = _pair(*LIMBS[2:], begins=False, trunk=())
ARMS = _pair(*LIMBS[:2], begins=True, trunk=tuple(range(FIRST[_CHEST], FIRST[_CHEST + 1])))
# The wrists alone, elbows staying: forearms that cross, taken for such that bend back where they meet.
FOREARMS = replace(
    _pair(*LIMBS[:2], begins=False, trunk=()), left=LIMBS[0].landmarks[1:], right=LIMBS[1].landmarks[1:], alone=True
)
PAIRS = (LEGS, ARMS, FOREARMS)
_CROSSED = PAIRS.index(FOREARMS)
_ELBOWS, _WRISTS = np.array([limb.landmarks for limb in LIMBS[:2]]).T
_LEFT, _RIGHT = (np.concatenate([getattr(pair, side) for pair in PAIRS]) for side in ("left", "right"))
_BEGIN = np.cumsum([0, *(len(pair.left) for pair in PAIRS[:-1])])  # of each pair in them


def changed_over(performer: Performer, pose: Pose, pair: Pair) -> Pose:
    """The pose with the joints of either side where those of the other are, all else staying where it can."""
    targets = landmarks(performer, pose)
    targets[np.concatenate((pair.left, pair.right))] = targets[np.concatenate((pair.right, pair.left))]
    if pair.alone:
        return reach(performer, pose, targets, free=np.isin(np.arange(DOFS), 6 + pair.columns))[0]
    return poses_to(performer, targets, np.ones(len(LANDMARKS)))[0][0]


def of_pair(pose: Pose, other: Pose, pair: Pair) -> Pose:
    """The pose bent as the other one where the pair is."""
    joints = pose.joints.copy()
    joints[pair.columns] = other.joints[pair.columns]
    return Pose(pose.translation, pose.root, joints)


def strange_legs(search: Neighbors, pose: Pose, trust: Floats) -> float:
    """Share of the person's pixels that it weighs as much as, how far legs are bent from how the library's are.

    Parameters
    ----------
    search : poses of the library. pose : whose legs. trust : (28,) how well each joint coordinate is shown, 0 to 1.
    """
    return STRANGE / IMAGE * strange(search, pose, trust, LEGS.counted) if len(search.samples) else 0.0


def passed(now: Floats, before: Floats) -> Bools:
    """(3,) whether joints of the two sides of each of `PAIRS` are near each other in the image, or changed over in it.

    Parameters
    ----------
    now, before : (16, 3) m, landmarks in this frame and the one before, in camera axes.
    """
    gap, then = _across(now), _across(before)
    crossed = (np.linalg.norm(gap, axis=1) < NEAR) | ((gap * then).sum(axis=1) < 0.0)
    return np.logical_or.reduceat(crossed, _BEGIN)


def sides_weighed(
    sides: Sides,
    state: TrackState,
    pose: Pose,
    wrong: float,
    elapsed: float,
    search: Neighbors,
    follow: Follow,
    *,
    busy: bool = False,
) -> tuple[Sides, Fit | None]:
    """One more frame of the question.

    Parameters
    ----------
    sides : as of the frame before. state : of this frame but for its pose, which is that of the frame before.
    pose, wrong : of the reading that is followed: this frame's pose, and the share of pixels that it explains wrongly.
    elapsed : s since the frame before.
    search : poses of the library. follow : the tracker's step. busy : this frame was searched for something else.

    Returns
    -------
    What is known now; and the fit of the other reading, when that is to be followed from here.
    """
    if not len(search.samples):
        return sides, None  # what tells is how people bend
    assert state.pose is not None
    performer, question = state.performer, sides.question
    place, before = landmarks(performer, pose), landmarks(performer, state.pose)
    wait = tuple(
        0.0 if crossed and k != _CROSSED else max(left - elapsed, 0.0)
        for k, (left, crossed) in enumerate(zip(sides.wait, passed(place, before).tolist(), strict=True))
    )
    sides = replace(sides, wait=wait)
    if question is None:
        ready = [k for k, left in enumerate(wait) if left <= 0.0 and (k != _CROSSED or may_cross(place))]
        if not ready:
            return sides, None
        # Forearms cross but for a moment; the others have theirs after.
        first = _CROSSED if _CROSSED in ready else ready[0]
        asked, crossing = PAIRS[first], first == _CROSSED
        alike = not crossing and np.linalg.norm(place[asked.left] - place[asked.right], axis=1).max() < APART
        usual = alike or strange(search, pose, state.trust, asked.counted) < BENT
        pause = SOON if usual and crossing else LATER
        later = tuple(pause if k == first else left for k, left in enumerate(wait))
        if usual:
            return replace(sides, wait=later), None
        question = Question(changed_over(performer, pose, asked), pose.translation, suspected=True)
        return Sides(question, first, later), None
    if not due(question, busy):
        return replace(sides, question=question.waiting), None

    def one(pose: Pose, other: Pose) -> bool:
        return apart(performer, pose, other) < ONE

    counted = PAIRS[sides.asked].counted
    question, taken, _ = looked_at(question, state, pose, wrong, search, follow, counted=counted, one=one)
    return replace(sides, question=question), taken


def may_cross(place: Floats) -> bool:
    """Whether each forearm could as well end at the other wrist, of landmarks (16, 3) m."""
    elbows, wrists = place[_ELBOWS], place[_WRISTS]
    across = np.linalg.norm(elbows - wrists[::-1], axis=1)
    apart = np.linalg.norm(wrists[0] - wrists[1])
    return bool(apart > TOUCHING and (across < CROSSING * np.linalg.norm(elbows - wrists, axis=1)).all())


def _across(place: Floats) -> Floats:
    """(n, 2) m from the right joints of all `PAIRS` to the left ones, across the line of sight."""
    beside = place[:, :2] / place[:, 2:] * float(place[:, 2].mean())
    return np.asarray(beside[_LEFT] - beside[_RIGHT])
