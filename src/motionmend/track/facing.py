"""Front or back: the other reading of a body whose left and right may be changed over, followed until one is refuted.

In depth a person from behind looks much as from the front. One frame cannot always tell; a second can, for a body
read the wrong way round fits worse while it moves, bends as no body in the library does, and walks backwards.
Both readings are followed while that is open, the second one only every few frames, and scored against each other.
A body that goes on walking backwards is asked again.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias, final

import numpy as np

from ..arrays import Floats, frozen
from ..bodies.performer import DOFS, LANDMARKS, Performer, Pose, landmarks
from ..numerics.least_squares import Solution
from ..numerics.neighbors import Neighbors
from .first_pose import poses_to

if TYPE_CHECKING:
    from .tracker import TrackState

EVERY = 3  # frames from one look at the other reading to the next
LEAST, MOST = 3, 12  # looks before one of the readings is taken, and after which the first one is kept
FADES = 0.85  # of the odds at each look: a start has to settle first
SURE = 2.0  # odds (log) at which a reading is taken
IMAGE = 20.0  # odds for a reading that explains all of the pixels more
STRANGE = 4.0  # odds against a reading one radian (of every joint coordinate) farther from the library
FRONT = 1.5  # odds that somebody who was not seen before faces the camera
TURNED = 1.0  # odds against having turned about just now; they fade within a second out of sight
WALK = 0.2  # odds for a reading that walks forward with 1 m/s
FASTEST = 1.0  # m/s; faster tells no more
BACKWARDS = 0.4  # m walked backwards, after which the other reading is tried
STROLL = 0.3  # m/s; slower is swaying
AGAIN = 1.0  # m, more of it after a reading was confirmed
_SIDES = {"l_": "r_", "r_": "l_"}
OTHER_SIDE = np.array([LANDMARKS.index(_SIDES.get(name[:2], name[:2]) + name[2:]) for name in LANDMARKS])

Follow: TypeAlias = Callable[["TrackState", Pose], tuple[Solution[Pose], Floats, float]]
"""The tracker's step of a state, begun at a pose: solution, trust (28,), share of pixels explained wrongly."""


@final
@dataclass(frozen=True, eq=False)
class Facing:
    """What is known of front and back.

    Attributes
    ----------
    other : the other reading's pose in the frame it was last looked at; None when the question is closed.
    trust : (28,) of the other reading, as a state's. place : (3,) m, where the followed body's root was then.
    wrong : share of pixels it explained wrongly.
    odds : log, for the other reading. looks : taken so far. frames : since the last one.
    prior : log odds for it before anything was seen; they do not fade.
    backwards : m, how far the followed reading has walked backwards lately.
    """

    other: Pose | None = None
    trust: Floats = field(default_factory=lambda: frozen(np.ones(DOFS - 6)))
    place: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    wrong: float = float("nan")
    odds: float = 0.0
    looks: int = 0
    frames: int = 0
    backwards: float = 0.0
    prior: float = 0.0


def about_face(performer: Performer, pose: Pose) -> Pose:
    """The pose read the other way round: every left joint where the right one is, the trunk turned."""
    targets = landmarks(performer, pose)[OTHER_SIDE]
    return poses_to(performer, targets, np.ones(len(LANDMARKS)))[0][0]


def faces_otherwise(pose: Pose, other: Pose) -> bool:
    """Whether two poses differ by more than a right angle in where they face."""
    return float(pose.root[:, 2] @ other.root[:, 2]) < 0.0


def doubted(performer: Performer, pose: Pose, other: Pose | None, *, new: bool = False) -> Facing:
    """The question open: with a pose of the other reading, or with the same pose read the other way round.

    Who is `new`, never seen before, more likely faces the camera.
    """
    other = about_face(performer, pose) if other is None else other
    prior = _from_behind(pose) - _from_behind(other) if new else 0.0
    return Facing(other, place=pose.translation, prior=prior)


def _from_behind(pose: Pose) -> float:
    """Odds (log) against somebody new in this pose."""
    return FRONT if float(pose.root[:, 2] @ pose.translation) > 0.0 else 0.0


def either(facing: Facing, performer: Performer, pose: Pose) -> Floats:
    """(16,) m, half of how far apart the two readings have each joint; 0 once the question is closed."""
    if facing.other is None:
        return np.zeros(len(LANDMARKS))
    moved = facing.other.translation + pose.translation - facing.place
    there = landmarks(performer, Pose(moved, facing.other.root, facing.other.joints))
    return np.asarray(0.5 * np.linalg.norm(there - landmarks(performer, pose), axis=1))


def along(pose: Pose, velocity: Floats) -> float:
    """m/s at which a body moves to where it faces, along the ground (the camera level or nearly so)."""
    ahead = pose.root[[0, 2], 2]
    return float(velocity[[0, 2]] @ ahead) / max(float(np.linalg.norm(ahead)), 0.5)


def walked(facing: Facing, speed: float, elapsed: float) -> Facing:
    """How far the followed body walked backwards, with a frame in which it moved ahead with `speed` m/s."""
    back = max(-speed - STROLL, -FASTEST) * elapsed
    return replace(facing, backwards=max(facing.backwards + back, min(facing.backwards, 0.0)))


def weighed(
    facing: Facing,
    state: "TrackState",
    pose: Pose,
    wrong: float,
    speed: float,
    search: Neighbors,
    follow: Follow,
) -> tuple[Facing, tuple[Solution[Pose], float] | None]:
    """One more frame of the question.

    Parameters
    ----------
    facing : as of the frame before. state : of this frame but for its pose.
    pose, wrong, speed : of the reading that is followed: this frame's pose, the share of pixels that it explains
        wrongly, m/s ahead.
    search : poses of the library. follow : the tracker's step.

    Returns
    -------
    What is known now; and the solution of the other reading, with its share, when that is to be followed from here.
    """
    if facing.other is None:
        if facing.backwards < BACKWARDS:
            return facing, None
        facing = replace(doubted(state.performer, pose, None), frames=EVERY)
    assert facing.other is not None
    if facing.frames + 1 < EVERY:
        return replace(facing, frames=facing.frames + 1), None
    there, before = pose.translation, facing.other
    begun = Pose(before.translation + there - facing.place, before.root, before.joints)
    other, trust, share = follow(replace(state, trust=facing.trust, wrong=facing.wrong, before=None), begun)
    score = IMAGE * (wrong - share) - 2.0 * WALK * float(np.clip(speed, -FASTEST, FASTEST))
    if len(search.samples):
        score += STRANGE * (_strange(search, pose, state.trust) - _strange(search, other.state, trust))
    odds, looks = FADES * facing.odds + score, facing.looks + 1
    if not faces_otherwise(pose, other.state):
        return Facing(backwards=-AGAIN), None  # both have become one
    if looks >= LEAST and odds + facing.prior > SURE:
        return Facing(backwards=-AGAIN), (other, share)
    if looks >= MOST or (looks >= LEAST and odds + facing.prior < -SURE):
        return Facing(backwards=-AGAIN), None
    return Facing(other.state, frozen(trust), there, share, odds, looks, prior=facing.prior), None


def unlikeliness(search: Neighbors, pose: Pose, wrong: float, before: Pose | None, gone: float = np.inf) -> float:
    """How a reading ranks among those of a search: its share of pixels explained wrongly and, as in `weighed`, more.

    Read the wrong way round a body bends strangely, and may all the same explain a pixel more; most who are followed
    face the camera when they are first seen; and who was out of sight for a moment has seldom turned about.

    Parameters
    ----------
    search : poses of the library.
    pose, wrong : the reading, and the share of pixels that it explains wrongly.
    before : how the person was last seen; None for somebody new.
    gone : s, since then.
    """
    if before is None:
        against = _from_behind(pose)
    else:
        against = TURNED * float(np.exp(-gone)) if faces_otherwise(before, pose) else 0.0
    if len(search.samples):
        against += STRANGE * _strange(search, pose, np.ones(DOFS - 6))
    return wrong + against / IMAGE


def _strange(search: Neighbors, pose: Pose, trust: Floats) -> float:
    """rad, root mean square of how far what is seen of a pose is from the library's nearest; trust (28,) 0 to 1."""
    weights = np.maximum(trust, 0.02)
    _, distance = search.nearest(pose.joints, 5, weights)
    return float(np.sqrt((distance**2).mean() / weights.sum()))
