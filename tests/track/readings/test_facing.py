"""Front and back: two readings of one body, and what a second of walking says of them."""

from dataclasses import replace

import numpy as np
import pytest

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import LANDMARKS, Pose, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.numerics.neighbors import Neighbors
from motionmend.track.readings.facing import (
    BENT,
    Facing,
    about_face,
    along,
    changed_about,
    changed_over,
    doubted,
    faces_otherwise,
    known_of,
    turned_about,
    unlikeliness,
    walked,
    weighed,
)
from motionmend.track.readings.pair import FADES, MOST, Follow
from motionmend.track.settings import settings_of
from motionmend.track.state import TrackState
from motionmend.track.tracker import start, step
from walkers import BODY, DT, as_sensed, begun_at, finished, followed, library, off, walk, walking

LEFT_RIGHT = [LANDMARKS.index({"l_": "r_", "r_": "l_"}.get(n[:2], n[:2]) + n[2:]) for n in LANDMARKS]


@pytest.mark.parametrize("heading", [-40.0, 30.0, 150.0])
def test_the_other_reading_has_left_where_right_was(heading):
    pose = walking(0.7, (0.1, 0.0, 2.8), heading)
    other = about_face(BODY, pose)
    assert faces_otherwise(pose, other)
    gap = np.linalg.norm(landmarks(BODY, other) - landmarks(BODY, pose)[LEFT_RIGHT], axis=1)
    assert gap.mean() < 0.08
    assert not faces_otherwise(pose, about_face(BODY, other))


@pytest.mark.slow
@pytest.mark.parametrize("heading", [40.0, -35.0])
def test_who_was_read_the_wrong_way_round_is_turned_within_a_second_of_walking(heading):
    poses = walk(32, heading)
    wrong = about_face(BODY, poses[0])
    found = followed(poses, wrong, facing=doubted(BODY, wrong, None))
    assert faces_otherwise(found[1], poses[1])
    assert all(not faces_otherwise(a, b) for a, b in zip(found[-3:], poses[-3:], strict=True))
    assert off(found[-1], poses[-1]) < 0.08 < 0.15 < off(found[1], poses[1])


@pytest.mark.slow
def test_who_walks_backwards_for_long_is_asked_again_although_the_question_was_closed():
    poses = walk(45, 30.0)
    found = followed(poses, about_face(BODY, poses[0]))
    assert faces_otherwise(found[3], poses[3])
    assert not faces_otherwise(found[-1], poses[-1])


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1.1, -1.1])
def test_a_right_reading_stays_even_of_somebody_who_walks_backwards(speed):
    poses = walk(32, 35.0, speed)
    found = followed(poses, poses[0], facing=doubted(BODY, poses[0], None))
    assert not any(faces_otherwise(a, b) for a, b in zip(found, poses, strict=True))
    assert off(found[-1], poses[-1]) < 0.08


def test_while_both_readings_stand_the_deviation_is_half_of_how_far_they_are_apart():
    poses = walk(32, 35.0)
    model, settings = library(), settings_of()
    state, before = None, None
    for k, pose in enumerate(poses):
        frame = DepthFrame(KINECT, as_sensed(render(BODY, pose, KINECT).depth, KINECT, 0, k), None, k * DT)
        if state is None:
            state = replace(start(model, settings, frame, BODY, poses[0]), facing=doubted(BODY, poses[0], None))
        state, estimate = step(model, settings, state, frame)
        if state.facing.question is None:
            break
        question = state.facing.question
        other = question.pose
        there = Pose(estimate.pose.translation + other.translation - question.place, other.root, other.joints)
        half = 0.5 * np.linalg.norm(landmarks(BODY, there) - estimate.landmarks, axis=1)
        assert (estimate.std >= half - 1e-9).all()
        assert (estimate.std >= estimate.settled).all()
        before = estimate
    arms = [LANDMARKS.index(name) for name in ("l_wrist", "r_wrist", "l_elbow", "r_elbow")]
    assert before is not None
    assert (before.std[arms] > 0.1).all()
    assert k < 31  # settled: from here the deviation is that of one reading
    share = 1.0 / (1.0 + np.exp(-0.4 * state.facing.odds))  # what was told by little leaves doubt
    assert 0.0 < share < 0.2
    across = np.linalg.norm(estimate.landmarks - estimate.landmarks[LEFT_RIGHT], axis=1) / np.sqrt(3.0)
    left = np.sqrt(share * (1.0 - share)) * across
    np.testing.assert_allclose(estimate.std, np.hypot(estimate.settled, left))
    assert estimate.std[arms].max() < 0.1


def test_steps_backwards_add_up_and_swaying_does_not():
    facing = Facing()
    for k in range(60):
        facing = walked(facing, 0.25 * (-1.0) ** k, DT)
    assert facing.backwards == 0.0
    for _ in range(30):
        facing = walked(facing, -1.0, DT)
    assert facing.backwards == pytest.approx(0.7)
    for _ in range(60):
        facing = walked(facing, 1.0, DT)
    assert facing.backwards == 0.0


def test_speed_is_counted_to_where_the_body_faces():
    pose = standing()
    assert along(pose, np.array([0.3, 0.4, -1.0])) == pytest.approx(1.0)
    assert along(about_face(BODY, pose), np.array([0.0, 0.0, -1.0])) == pytest.approx(-1.0, abs=0.05)


@pytest.mark.parametrize(("ours", "theirs", "turns"), [(0.30, 0.18, True), (0.18, 0.30, False), (0.20, 0.20, False)])
def test_of_two_readings_the_one_that_explains_more_is_left(ours, theirs, turns):
    pose = standing()
    other = about_face(BODY, pose)
    calls = []

    def begin(twin, expected):
        calls.append(expected)
        return begun_at(twin, expected, theirs)

    facing, state = doubted(BODY, pose, other), TrackState(BODY, pose=pose, lost=False)
    taken, frames = None, 0
    while facing.question is not None and taken is None:
        facing, taken = weighed(
            facing, state, pose, ours, 0.0, Neighbors(np.empty((0, 28))), Follow(None, begin, finished)
        )
        frames += 1
        assert frames < 60
    assert (taken is not None) == turns
    looks = len(calls) - turns  # the reading that is taken is solved once more, in the frame in which it is
    assert looks == (MOST if ours == theirs else looks) <= MOST
    assert frames >= 2 * len(calls)  # not looked at in every frame
    if taken is not None:
        assert taken.wrong == theirs
        assert faces_otherwise(taken.pose, pose)


@pytest.mark.parametrize(("new", "ahead", "turns"), [(False, True, True), (True, True, False), (True, False, True)])
def test_a_little_that_speaks_for_the_back_of_somebody_new_is_not_enough(new, ahead, turns):
    pose = standing((0.0, 0.1, 3.0)) if ahead else about_face(BODY, standing((0.0, 0.1, 3.0)))
    follow = Follow(None, lambda twin, expected: begun_at(twin, expected, 0.18), finished)
    facing, taken = doubted(BODY, pose, None, new=new), None
    state = TrackState(BODY, pose=pose, lost=False)
    while facing.question is not None and taken is None:
        facing, taken = weighed(facing, state, pose, 0.2, 0.0, Neighbors(np.empty((0, 28))), follow)
    assert (taken is not None) == turns


def test_of_two_readings_that_explain_as_much_the_one_that_bends_as_people_do_ranks_first():
    search = library().database.search
    pose = walking(0.8, np.array([0.0, 0.05, 3.0]), 0.0)
    other = about_face(BODY, pose)
    assert unlikeliness(search, pose, 0.2, pose) < unlikeliness(search, other, 0.2, pose)
    assert unlikeliness(search, pose, 0.5, pose) > unlikeliness(
        search, other, 0.2, pose
    )  # what is seen counts for more


def test_who_was_not_seen_before_is_taken_to_face_the_camera():
    none = Neighbors(np.empty((0, 28)))
    ahead, away = standing((0.0, 0.1, 3.0)), walking(0.0, np.array([0.0, 0.1, 3.0]), 180.0)
    assert faces_otherwise(ahead, away)
    assert unlikeliness(none, ahead, 0.2, None) == 0.2 < unlikeliness(none, away, 0.2, None)
    assert unlikeliness(none, away, 0.2, ahead) == 0.2


def test_who_was_out_of_sight_for_a_moment_has_not_turned_about():
    none = Neighbors(np.empty((0, 28)))
    ahead, away = standing((0.0, 0.1, 3.0)), walking(0.0, np.array([0.0, 0.1, 3.0]), 180.0)
    for pose, other in ((ahead, away), (away, ahead)):
        ranks = [unlikeliness(none, other, 0.2, pose, gone) for gone in (0.1, 1.0, 3.0, 60.0)]
        assert ranks == sorted(ranks, reverse=True)
        assert ranks[0] > 0.2 == unlikeliness(none, pose, 0.2, pose, 0.1)
        assert ranks[-1] == pytest.approx(0.2)


@pytest.mark.parametrize(("bent", "asked"), [(0.5 * BENT, False), (1.5 * BENT, True)])
def test_who_bends_as_nobody_does_is_asked_now_and_then_though_nobody_walks_backwards(bent, asked):
    pose = standing((0.0, 0.1, 3.0))
    search = Neighbors(np.repeat(pose.joints[None] + bent, 5, axis=0))
    state, facing, opened = TrackState(BODY, pose=pose, lost=False), Facing(), []
    follow = Follow(None, lambda twin, expected: begun_at(twin, expected, 0.5), finished)  # explains less
    for frame in range(120):
        before = facing.question
        facing, taken = weighed(walked(facing, 0.0, DT), state, pose, 0.2, 0.0, search, follow)
        assert taken is None
        if facing.question is not None and before is None:
            assert facing.question.suspected
            opened.append(frame)
    assert bool(opened) == asked
    if asked:
        assert 3 <= len(opened) <= 4
        assert np.diff(opened).min() >= 30


def answered(theirs, facing=None, bent=0.0):
    """What is known of a body that explains a fifth of the pixels wrongly once it was asked against `theirs`."""
    pose = standing((0.0, 0.1, 3.0))
    search = Neighbors(np.repeat(pose.joints[None] + bent, 5, axis=0)) if bent else Neighbors(np.empty((0, 28)))
    state, taken, asked = TrackState(BODY, pose=pose, lost=False), None, False
    facing = doubted(BODY, pose, None) if facing is None else facing
    follow = Follow(None, lambda twin, expected: begun_at(twin, expected, theirs), finished)
    for _ in range(80):
        facing, taken = weighed(walked(facing, 0.0, DT), state, pose, 0.2, 0.0, search, follow)
        asked |= facing.question is not None
        if taken is not None or (asked and facing.question is None):
            break
    return facing, taken


def test_a_question_that_nothing_answered_leaves_doubt_and_one_that_was_answered_clearly_none():
    open_still, clear = answered(0.2)[0], answered(0.9)[0]
    assert open_still.question is None is clear.question
    assert changed_about(open_still) == pytest.approx(0.5, abs=0.05)
    assert changed_about(clear) < 0.001
    assert changed_about(Facing()) == 0.0  # it was given
    shares = [changed_about(answered(theirs)[0]) for theirs in (0.2, 0.25, 0.3, 0.4)]
    assert shares == sorted(shares, reverse=True)


def test_doubt_of_front_and_back_is_about_joints_that_have_a_fellow():
    place = landmarks(BODY, standing((0.0, 0.1, 3.0)))
    std = np.full(16, 0.02)
    np.testing.assert_array_equal(changed_over(std, place, 0.0), std)
    wide = changed_over(np.stack([std, std]), np.stack([place, place]), np.array([0.1, 0.4]))
    paired = np.array([i for i, other in enumerate(LEFT_RIGHT) if i != other])
    np.testing.assert_array_equal(wide[:, np.setdiff1d(np.arange(16), paired)], 0.02)
    across = np.linalg.norm(place - place[LEFT_RIGHT], axis=1)[paired]
    share = np.array([[0.1], [0.4]])
    np.testing.assert_allclose(wide[:, paired] ** 2, 0.02**2 + share * (1.0 - share) * across**2 / 3.0)


@pytest.mark.parametrize(("before", "turns"), [(-2.0, True), (-30.0, False)])
def test_who_was_surely_read_before_is_not_turned_about_by_little(before, turns):
    facing, taken = answered(0.15, Facing(odds=before), bent=1.5 * BENT)
    assert (taken is not None) == turns
    if not turns:
        assert answered(0.02, Facing(odds=before), bent=1.5 * BENT)[1] is not None  # but by much
    else:
        assert facing.odds < 0.0  # of the one that is followed now


def test_who_is_found_again_at_once_has_seldom_turned_about_by_what_was_told_before():
    pose = standing((0.0, 0.1, 3.0))
    sure = Facing(odds=-40.0)
    assert known_of(sure, pose, pose, 0.0) == -known_of(sure, pose, about_face(BODY, pose), 0.0) < -1.0
    assert known_of(turned_about(sure), pose, pose, 0.0) > 1.0
    assert 0.0 > known_of(Facing(odds=-1.0), pose, pose, 0.0) > known_of(sure, pose, pose, 0.0)
    assert abs(known_of(sure, pose, pose, 60.0)) < 1e-9
    assert known_of(doubted(BODY, pose, None), pose, pose, 0.0) == 0.0  # nothing was told yet


def test_who_was_never_in_question_and_is_found_facing_the_other_way_is_not_doubted_for_ever():
    """What looks tell of somebody who seems to have turned about counts from then on."""
    facing = turned_about(Facing())
    assert np.isfinite(facing.odds)
    assert changed_about(facing) == 0.5
    for _ in range(20):
        facing = replace(facing, odds=FADES * facing.odds - 3.0)
    assert changed_about(facing) < 0.05
