"""A look at another reading: in two halves, when there is time for them, and of the frame in which it began."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.performer import standing
from motionmend.numerics.neighbors import Neighbors
from motionmend.track.readings.facing import about_face
from motionmend.track.readings.pair import EVERY, LEAST, PATIENCE, Follow, due, looked_at
from motionmend.track.state import Question, TrackState
from walkers import BODY, begun_at, finished

NOBODY = Neighbors(np.empty((0, 28)))


def looking(question, pose, ours, theirs, began=None):
    """One frame's half of a look that finds the other reading wrong by `theirs`."""
    state = TrackState(BODY, pose=pose, lost=False)

    def begin(twin, expected):
        if began is not None:
            began.append(expected)
        return begun_at(twin, expected, theirs)

    follow = Follow(None, begin, finished)
    return looked_at(question, state, pose, ours, NOBODY, follow, one=lambda *_: False)[:2]


@pytest.mark.slow
@given(busy=st.lists(st.booleans(), min_size=120, max_size=120))
def test_a_look_begins_when_it_is_time_and_waits_only_so_long_for_frames_with_nothing_else_to_do(busy):
    pose, halves = standing(), []
    question = Question(about_face(BODY, pose), pose.translation)
    for frame, much in enumerate(busy):
        if not due(question, much):
            question = question.waiting
            continue
        before = question.look
        question, _ = looking(question, pose, 0.2, 0.2)
        if question is None:
            break
        assert (question.look is None) == (before is not None)  # begun, or finished
        halves.append((frame, before is None))
    begins = np.array([frame for frame, first in halves if first])
    ends = np.array([frame for frame, first in halves if not first])
    assert np.diff([frame for frame, _ in halves]).min() >= 1  # no frame has both halves
    assert EVERY <= np.diff(begins).min() <= np.diff(begins).max() <= EVERY + 2 * PATIENCE
    assert (ends - begins[: len(ends)]).max() <= PATIENCE + 1
    for frame, first in halves[1:]:
        assert not busy[frame] or frame - (ends if first else begins)[-1] != 1


@pytest.mark.parametrize("later", [0.05, 0.9])
def test_the_verdict_is_of_the_frame_in_which_the_look_began(later):
    pose = standing()
    question = Question(about_face(BODY, pose), pose.translation)
    question, _ = looking(question, pose, 0.3, 0.2)
    question, _ = looking(question, pose, later, 0.2)  # how well the next frame is explained is no matter
    assert question.odds == pytest.approx(20.0 * (0.3 - 0.2))
    assert question.looks == 1


def test_a_reading_that_is_taken_is_solved_in_the_frame_in_which_it_is():
    pose, began = standing(), []
    question, taken = Question(about_face(BODY, pose), pose.translation), None
    step = np.array([0.1, 0.0, 0.05])
    places = [pose.translation + k * step for k in range(60)]
    for place in places:
        there = type(pose)(place, pose.root, pose.joints)
        question, taken = looking(question, there, 0.4, 0.2, began)
        if taken is not None:
            break
    assert taken is not None
    np.testing.assert_allclose(taken.pose.translation - began[0].translation, place - places[0], atol=1e-9)


def test_what_is_usual_refutes_no_reading_only_images_do():
    """Most who are new face the camera: a little in the images and that are not enough to close the question."""
    pose = standing()
    usual, looks = Question(about_face(BODY, pose), pose.translation, prior=-1.5), 0
    while usual is not None and looks < LEAST:
        for _ in range(2):
            usual, taken = looking(usual, pose, 0.20, 0.23)  # 0.6 a look: 1.5 after three, 3 with what is usual
        looks += 1
    assert taken is None
    assert usual is not None
    assert -2.0 < usual.odds < 2.0 * usual.prior / 3.0
