"""Front or back: the other reading of a body whose left and right may be changed over, followed until one is refuted.

In depth a person from behind looks much as from the front. One frame cannot always tell; a second can (`pair`), for
a body read the wrong way round also walks backwards. One that goes on doing so, or bends strangely, is asked again.
"""

from dataclasses import replace

import numpy as np

from ...arrays import Floats
from ...bodies.performer import DOFS, LANDMARKS, OTHER_SIDE, Performer, Pose, landmarks
from ...numerics.neighbors import Neighbors
from ..database import strange
from ..starting.first_pose import poses_to
from ..state import Facing, Fit, Question, TrackState
from .pair import EVERY, FADES, IMAGE, LATER, STRANGE, Follow, due, looked_at

FRONT = 1.5  # odds that somebody who was not seen before faces the camera
UPRIGHT = 0.5  # of a body's long axis up or down, below which it lies
TURNED = 1.0  # odds against having turned about just now; they fade within a second out of sight
WALK = 0.2  # odds for a reading that walks forward with 1 m/s
FASTEST = 1.0  # m/s; faster tells no more
BACKWARDS = 0.4  # m walked backwards, after which the other reading is tried
BENDS = 2.0  # odds against a reading one radian farther from the library: beside feet it tells less
FEET = 35.0  # odds for a reading that explains all of the feet's pixels more
CONFIRMED = 1.0  # odds for a reading that was asked for once
STROLL = 0.3  # m/s; slower is swaying
AGAIN = 1.0  # m, more of it after a reading was confirmed
FLAT = 0.4  # of what looks tell: frames that follow each other err alike
NEVER = -10.0  # log odds for the other reading where it was never in question, once it is
TURNABLE = 2.0  # log odds at most that who was seen a moment ago has turned about, or has not
BENT = 0.25  # rad from the library's poses, up to which people bend so


def about_face(performer: Performer, pose: Pose) -> Pose:
    """The pose read the other way round: every left joint where the right one is, the trunk turned."""
    targets = landmarks(performer, pose)[OTHER_SIDE]
    return poses_to(performer, targets, np.ones(len(LANDMARKS)))[0][0]


def faces_otherwise(pose: Pose, other: Pose) -> bool:
    """Whether two poses differ by more than a right angle in where they face."""
    return float(pose.root[:, 2] @ other.root[:, 2]) < 0.0


def doubted(performer: Performer, pose: Pose, other: Pose | None, *, new: bool = False, known: float = 0.0) -> Facing:
    """The question open: with a pose of the other reading, or with the same pose read the other way round.

    Who is `new`, never seen before, more likely faces the camera; of who was seen before, odds (log) may be `known`.
    """
    other = about_face(performer, pose) if other is None else other
    prior = _from_behind(pose) - _from_behind(other) if new else known
    return Facing(Question(other, pose.translation, prior=prior), odds=0.0, prior=prior)


def believed(facing: Facing) -> float:
    """Log odds for the other reading, by all that is known of it."""
    return facing.prior + FLAT * facing.odds


def turned_about(facing: Facing) -> Facing:
    """What is known of the readings when the other one is followed."""
    return replace(facing, odds=-max(facing.odds, NEVER), prior=-facing.prior)


def known_of(facing: Facing, last: Pose, pose: Pose, gone: float) -> float:
    """Odds (log) for the other reading of a body that is found again, by what was told before.

    Parameters
    ----------
    facing, last : as it was last seen. pose : as it is found. gone : s, since then.
    """
    if facing.question is not None:
        return 0.0
    odds = float(np.clip(believed(facing), -TURNABLE, TURNABLE)) * float(np.exp(-gone))
    return -odds if faces_otherwise(last, pose) else odds


def changed_about(facing: Facing) -> float:
    """How likely front and back are changed over, 0 to 0.5; half while that is asked of a body that was just found."""
    if facing.unread:
        return 0.5
    return float(1.0 / (1.0 + np.exp(-min(believed(facing), 0.0))))


def changed_over(std: Floats, place: Floats, share: Floats | float) -> Floats:
    """Deviations (..., 16) m of one coordinate, wider by how likely each joint is where its fellow is said to be.

    Parameters
    ----------
    std, place : (..., 16) m and (..., 16, 3) m, of the joints if they are read the right way round.
    share : (...) how likely front and back are changed over, 0 to 0.5.
    """
    across = ((place - place[..., OTHER_SIDE, :]) ** 2).mean(axis=-1)  # of one coordinate
    share = np.asarray(share)[..., None]
    return np.asarray(np.hypot(std, np.sqrt(share * (1.0 - share) * across)))


def _from_behind(pose: Pose) -> float:
    """Odds (log) against somebody new in this pose; who lies may lie either way."""
    return FRONT if not lies(pose) and float(pose.root[:, 2] @ pose.translation) > 0.0 else 0.0


def lies(pose: Pose) -> bool:
    """Whether the trunk is nearer to level than to upright, the camera level or nearly so."""
    return abs(float(pose.root[1, 1])) < UPRIGHT


def along(pose: Pose, velocity: Floats) -> float:
    """m/s at which a body moves to where it faces, along the ground (the camera level or nearly so)."""
    ahead = pose.root[[0, 2], 2]
    return float(velocity[[0, 2]] @ ahead) / max(float(np.linalg.norm(ahead)), 0.5)


def walked(facing: Facing, speed: float, elapsed: float) -> Facing:
    """How far the followed body walked backwards, with a frame in which it moved ahead with `speed` m/s."""
    back = max(-speed - STROLL, -FASTEST) * elapsed
    backwards = max(facing.backwards + back, min(facing.backwards, 0.0))
    return replace(facing, backwards=backwards, wait=max(facing.wait - elapsed, 0.0))


def weighed(
    facing: Facing,
    state: TrackState,
    pose: Pose,
    wrong: float,
    speed: float,
    search: Neighbors,
    follow: Follow,
    *,
    busy: bool = False,
) -> tuple[Facing, Fit | None]:
    """One more frame of the question.

    Parameters
    ----------
    facing : as of the frame before. state : of this frame but for its pose.
    pose, wrong, speed : of the reading that is followed: this frame's pose, the share of pixels that it explains
        wrongly, m/s ahead.
    search : poses of the library. follow : the tracker's step. busy : this frame was searched for something else.

    Returns
    -------
    What is known now; and the fit of the other reading, when that is to be followed from here.
    """
    question = facing.question
    if question is None:
        suspected = facing.backwards < BACKWARDS
        if suspected:
            if facing.wait > 0.0 or not len(search.samples):
                return facing, None
            if strange(search, pose, state.trust) < BENT:
                return replace(facing, wait=LATER), None
        facing = replace(facing, odds=max(facing.odds, NEVER))
        # Who was surely read by images is not turned about by little.
        prior = min(FLAT * facing.odds, -CONFIRMED) if suspected else 0.0
        other = about_face(state.performer, pose)
        question = Question(other, pose.translation, frames=EVERY, suspected=suspected, prior=prior)
    if not due(question, busy):
        return replace(facing, question=question.waiting), None
    ahead = -2.0 * WALK * float(np.clip(speed, -FASTEST, FASTEST))
    question, taken, told = looked_at(
        question, state, pose, wrong, search, follow, beside=ahead, bends=BENDS, feet=FEET, one=_face_alike
    )
    facing = replace(facing, question=question, odds=facing.odds if told is None else FADES * facing.odds + told)
    if question is None:
        facing = replace(facing, backwards=-AGAIN, wait=LATER)
    return (facing if taken is None else turned_about(facing)), taken


def _face_alike(pose: Pose, other: Pose) -> bool:
    return not faces_otherwise(pose, other)


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
        against += STRANGE * strange(search, pose, np.ones(DOFS - 6))
    return wrong + against / IMAGE
