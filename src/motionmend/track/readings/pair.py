"""Two readings of one body that one frame does not tell apart: the second is carried along until one is refuted.

In depth a person from behind looks much as from the front, and legs that pass each other as legs that part again. A
body that is read wrongly fits worse while it moves, and bends as no body in the library does. The second reading is
looked at every few frames only, begun where it was last, and scored against the one that is followed. A look takes two
frames' turns, so that none takes long: its pose is solved in the first, and its limbs looked for there in the second.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.performer import LANDMARKS, Performer, Pose, landmarks
from ...numerics.neighbors import Neighbors
from ..database import EVERYWHERE, strange
from ..state import Fit, Look, Question, Sight, TrackState

EVERY = 3  # frames from one look at the other reading to the next
PATIENCE = 3  # frames more that a look waits for one in which nothing else is searched for
LEAST, MOST = 3, 12  # looks before one of the readings is taken, and after which the first one is kept
FADES = 0.85  # of the odds at each look: a start has to settle first
SURE = 2.0  # odds (log) at which a reading is taken
IMAGE = 20.0  # odds for a reading that explains all of the pixels more
STRANGE = 4.0  # odds against a reading one radian (of every joint coordinate) farther from the library
LATER = 1.0  # s after which it is asked again of a body that bends strangely
RARE = 4.0  # log odds that what was only suspected is not so: one in fifty


@final
@dataclass(frozen=True, eq=False)
class Follow:
    """The tracker's step of a state.

    Attributes
    ----------
    sight : this frame. begin : state and the pose to begin at, to how the frame is explained.
    finish : of that frame, with its limbs looked for, and how well each joint coordinate (28,) is shown.
    feet : of that frame and two readings, by how much more of the feet the first one explains wrongly.
    """

    sight: Sight
    begin: Callable[[TrackState, Pose], Fit]
    finish: Callable[[Sight, Fit], tuple[Fit, Floats]]
    feet: Callable[[Sight, Performer, Pose, Pose], float] = lambda *_: 0.0


def due(question: Question, busy: bool) -> bool:
    """Whether the other reading is looked at in this frame; one in which much else was tried may be waited out."""
    return question.frames + 1 >= (0 if question.look else EVERY) + (PATIENCE if busy else 0)


def looked_at(
    question: Question,
    state: TrackState,
    pose: Pose,
    wrong: float,
    search: Neighbors,
    follow: Follow,
    *,
    beside: float = 0.0,
    bends: float = STRANGE,
    feet: float = 0.0,
    counted: Floats = EVERYWHERE,
    one: Callable[[Pose, Pose], bool],
) -> tuple[Question | None, Fit | None, float | None]:
    """Half a look at the other reading.

    Parameters
    ----------
    question : as of the frame before, and `due`. state : of this frame but for its pose.
    pose, wrong : of the reading that is followed: this frame's pose, the share of pixels that it explains wrongly.
    search : poses of the library. follow : the tracker's step.
    beside : odds (log) for the other reading by what else is known of this frame.
    bends : odds (log) against a reading one radian farther from the library.
    feet : odds (log) for a reading that explains all of the feet's pixels more.
    counted : (28,) how much strangeness counts in each joint coordinate, 0 to 1.
    one : whether two poses have become one reading.

    Returns
    -------
    The question, None when it is closed; the other reading, when that is to be followed from here; and the odds (log)
    for it that the look told, None after its first half.
    """
    look = question.look
    if look is None:
        twin = replace(state, trust=question.trust, wrong=question.wrong, before=None)
        begun = follow.begin(twin, question.moved(pose.translation))
        return replace(question, look=Look(follow.sight, begun, pose, state.trust, wrong, beside), frames=0), None, None
    other, trust = follow.finish(look.sight, look.begun)
    score = IMAGE * (look.wrong - other.wrong) + look.beside
    if feet > 0.0:
        score += feet * follow.feet(look.sight, state.performer, look.pose, other.pose)
    if len(search.samples):
        ours, theirs = strange(search, look.pose, look.trust, counted), strange(search, other.pose, trust, counted)
        score += bends * (ours - theirs)
    odds, looks = FADES * question.odds + score, question.looks + 1
    if one(look.pose, other.pose):
        return None, None, score
    seen = replace(
        question,
        pose=other.pose,
        place=look.pose.translation,
        trust=frozen(trust),
        wrong=other.wrong,
        look=None,
    )
    if looks >= LEAST and odds + question.prior > SURE:
        twin = replace(state, trust=seen.trust, wrong=seen.wrong, before=None)
        return None, follow.begin(twin, seen.moved(pose.translation)), score
    # What is usual may take a reading, but only images refute one.
    if looks >= MOST or (looks >= LEAST and odds + max(question.prior, 0.0) < -SURE):
        return None, None, score
    return replace(seen, odds=odds, looks=looks, frames=question.frames + 1), None, score


def either(question: Question | None, performer: Performer, pose: Pose) -> Floats:
    """(16,) m, the deviation of each joint between two readings; 0 once the question is closed.

    Half of how far apart they have it, either being as likely; less of what is only suspected, by how likely it is.
    """
    if question is None:
        return np.zeros(len(LANDMARKS))
    there = landmarks(performer, question.moved(pose.translation))
    other = 1.0 / (1.0 + np.exp(RARE - question.odds)) if question.suspected else 0.5
    return np.asarray(np.sqrt(other * (1.0 - other)) * np.linalg.norm(there - landmarks(performer, pose), axis=1))
