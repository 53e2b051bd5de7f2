"""Left and right: legs and arms taken for each other are told by how they bend."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.performer import LANDMARKS, landmarks
from motionmend.numerics.neighbors import Neighbors
from motionmend.track.readings.left_right import (
    ARMS,
    BENT,
    LEGS,
    PAIRS,
    Sides,
    changed_over,
    of_pair,
    passed,
    sides_weighed,
    strange_legs,
)
from motionmend.track.readings.pair import LEAST, MOST, Follow, either
from motionmend.track.state import Question, TrackState
from walkers import BODY, DT, begun_at, followed, library, off, told, walk, walking

ALL = np.ones(28)
PLACE = np.array([0.0, 0.05, 3.0])


def test_legs_are_knees_and_ankles_and_arms_begin_at_the_shoulders():
    assert [LANDMARKS[k] for k in (*LEGS.left, *LEGS.right)] == ["l_knee", "l_ankle", "r_knee", "r_ankle"]
    assert [LANDMARKS[k][2:] for k in ARMS.left] == ["shoulder", "elbow", "wrist"]
    assert not set(LEGS.columns) & set(ARMS.columns)
    for pair in PAIRS:
        np.testing.assert_array_equal(np.flatnonzero(pair.counted), np.sort(pair.columns))


@pytest.mark.slow
@given(phase=st.floats(0.3, 1.2), heading=st.floats(-180.0, 180.0))
def test_legs_changed_over_are_where_the_others_were_and_the_rest_stays(phase, heading):
    pose = walking(phase, PLACE, heading)
    was, now = landmarks(BODY, pose), landmarks(BODY, changed_over(BODY, pose, LEGS))
    assert np.linalg.norm(now[LEGS.left] - was[LEGS.right], axis=1).max() < 0.14
    assert np.linalg.norm(now[LEGS.right] - was[LEGS.left], axis=1).max() < 0.14
    arms = np.concatenate((ARMS.left, ARMS.right))
    assert np.linalg.norm(now[arms] - was[arms], axis=1).max() < 0.12


@pytest.mark.slow
@given(phase=st.floats(0.0, 6.3), heading=st.floats(-180.0, 180.0))
def test_legs_changed_over_bend_as_no_library_has_them(phase, heading):
    search = library().database.search
    pose = walking(phase, PLACE, heading)
    assert strange_legs(search, changed_over(BODY, pose, LEGS), ALL) > strange_legs(search, pose, ALL)
    assert strange_legs(Neighbors(np.empty((0, 28))), pose, ALL) == 0.0


def test_only_what_belongs_to_the_pair_is_taken_over():
    pose, other = walking(0.8, PLACE, 20.0), walking(2.0, PLACE, 160.0)
    taken = of_pair(pose, other, LEGS)
    np.testing.assert_array_equal(taken.joints[LEGS.columns], other.joints[LEGS.columns])
    np.testing.assert_array_equal(taken.joints[ARMS.columns], pose.joints[ARMS.columns])
    np.testing.assert_array_equal(taken.root, pose.root)


def test_legs_pass_each_other_twice_in_a_stride_seen_from_the_side_and_never_from_ahead():
    side, ahead = walk(33, 90.0), walk(33, 0.0)
    counts = [
        np.diff(np.array([passed(now, before)[0] for before, now in pairwise(places)]).astype(int))
        for places in ([landmarks(BODY, pose) for pose in poses] for poses in (side, ahead))
    ]
    assert (counts[0] == 1).sum() == 2
    assert not counts[1].any()


@pytest.mark.slow
@pytest.mark.parametrize("heading", [75.0, -60.0])
def test_legs_that_were_changed_over_are_put_right_within_a_second(heading):
    poses = walk(48, heading)[8:]  # from where the legs are apart
    said = told(poses, changed_over(BODY, poses[0], LEGS))
    gaps = [off(one.pose, pose) for one, pose in zip(said, poses, strict=True)]
    assert gaps[1] > 0.05
    assert max(gaps[-4:]) < 0.05
    put_right = int(np.argmin(np.diff(gaps))) + 1
    assert "recovered" in said[put_right].flags


@pytest.mark.slow
@pytest.mark.parametrize("heading", [90.0, -90.0, 60.0, 0.0])
def test_legs_that_are_right_stay(heading):
    poses = walk(66, heading)
    found = followed(poses, poses[0])
    assert max(off(one, pose) for one, pose in zip(found, poses, strict=True)) < 0.06


@pytest.mark.parametrize(("ours", "theirs", "taken"), [(0.30, 0.15, True), (0.15, 0.30, False), (0.20, 0.20, False)])
def test_each_pair_is_asked_for_in_its_turn_and_again_after_a_second(ours, theirs, taken):
    pose = walking(np.pi / 2.0, PLACE, 0.0)
    state = TrackState(BODY, pose=pose, lost=False)
    search = Neighbors(np.repeat(pose.joints[None] + 1.5 * BENT, 5, axis=0))  # bent, and neither is stranger
    asked, looks, verdicts = [], 0, 0

    def finish(sight, begun):
        nonlocal looks
        looks += 1
        return begun, np.zeros(28)

    follow = Follow(None, lambda twin, expected: begun_at(twin, expected, theirs), finish)
    sides = Sides()
    for frame in range(300):
        before = sides
        sides, other = sides_weighed(sides, state, pose, ours, DT, search, follow)
        if sides.question is not None and before.question is None:
            asked.append((frame, sides.asked))
        verdicts += other is not None
    assert [pair for _, pair in asked[:2]] == [0, 1]
    for pair in (0, 1):
        frames = [frame for frame, which in asked if which == pair]
        assert np.diff(frames).min() >= 30
        assert len(frames) >= 3
    assert (verdicts > 0) == taken
    assert LEAST * (len(asked) - 1) <= looks <= MOST * len(asked)


def test_nothing_is_asked_of_who_bends_as_the_library_does():
    pose = walking(np.pi / 2.0, PLACE, 0.0)
    sides, state = Sides(), TrackState(BODY, pose=pose, lost=False)
    for _ in range(60):
        near = Neighbors(np.repeat(pose.joints[None] + 0.5 * BENT, 5, axis=0))
        sides, taken = sides_weighed(sides, state, pose, 0.3, DT, near, None)
        assert sides.question is None
        assert taken is None


def test_while_the_question_is_open_knees_and_ankles_are_less_sure_the_more_speaks_for_the_other_reading():
    pose = walking(np.pi / 2.0, PLACE, 80.0)
    other = changed_over(BODY, pose, LEGS)
    doubts = [
        either(Question(other, pose.translation, odds=odds, suspected=True), BODY, pose) for odds in (-3.0, 0.0, 1.9)
    ]
    knees = np.concatenate((LEGS.left, LEGS.right))
    assert (np.diff([doubt[knees] for doubt in doubts], axis=0) > 0.0).all()
    assert (
        doubts[0][knees].max()
        < 0.03
        < doubts[1][knees].max()
        < 0.5 * np.max(np.linalg.norm(landmarks(BODY, other) - landmarks(BODY, pose), axis=1))
    )
    assert not either(None, BODY, pose).any()
    half = 0.5 * np.linalg.norm(landmarks(BODY, other) - landmarks(BODY, pose), axis=1)
    np.testing.assert_allclose(either(Question(other, pose.translation, odds=-1.0), BODY, pose), half)
