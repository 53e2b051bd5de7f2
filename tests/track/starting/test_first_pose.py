"""First poses: from joints, from five of them, and from nothing but the image."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drawn_people import HALF, PERSON, picture, random_joints, random_poses, turned
from motionmend.bodies.performer import LANDMARKS, LIMITS, OTHER_SIDE, Pose, landmarks, rotation, standing
from motionmend.errors import MismatchError
from motionmend.track.detect.joints import Detection
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.judge import judge
from motionmend.track.starting.first_pose import candidates, five_of, lying, mirrored, pose_from_joints, poses_to
from motionmend.track.starting.reach import fitted, reach

SEEDS = st.integers(0, 10**6)
L_WRIST, L_ELBOW = LANDMARKS.index("l_wrist"), LANDMARKS.index("l_elbow")


def _seen(pose, step=2):
    depth = picture(pose, HALF).depth
    return Observation(HALF, depth, np.isnan(depth), 0.0).every(step)


def _distance(one, other):
    return np.linalg.norm(landmarks(PERSON, one) - landmarks(PERSON, other), axis=1)


@given(SEEDS, st.floats(-3.1, 3.1))
@settings(max_examples=12)
def test_all_joints_given_are_reached(seed, heading):
    wanted = landmarks(PERSON, turned(random_poses(1, seed)[0], heading))
    pose, left = pose_from_joints(PERSON, wanted)
    assert left < 0.02
    assert np.linalg.norm(landmarks(PERSON, pose) - wanted, axis=1).max() < 0.08
    assert np.all((pose.joints >= LIMITS[6:, 0] - 1e-9) & (pose.joints <= LIMITS[6:, 1] + 1e-9))


@given(SEEDS)
@settings(max_examples=8)
def test_reach_goes_with_the_world(seed):
    """Turned and moved targets and beginning give the turned and moved pose."""
    rng = np.random.default_rng(seed)
    begin, target = standing((0.0, 0.0, 3.0)), landmarks(PERSON, random_poses(1, seed)[0])
    turn, shift = rotation(rng.normal(0, 0.5, 3)), rng.normal(0, 0.3, 3)
    one, left = reach(PERSON, begin, target, rounds=6)
    moved = Pose(turn @ begin.translation + shift, turn @ begin.root, begin.joints)
    other, again = reach(PERSON, moved, target @ turn.T + shift, rounds=6)
    assert abs(left - again) < 1e-3
    np.testing.assert_allclose(landmarks(PERSON, other), landmarks(PERSON, one) @ turn.T + shift, atol=5e-3)


def test_only_what_is_free_moves():
    begin = standing()
    target = np.full((16, 3), np.nan)
    target[L_WRIST] = landmarks(PERSON, begin)[L_WRIST] + (0.15, -0.2, -0.2)
    free = np.zeros(34, bool)
    arm = [i for i, moved in enumerate(PERSON.moves[PERSON.landmark_bone[L_WRIST]]) if moved and i >= 11]
    free[arm] = True
    pose, left = reach(PERSON, begin, target, free=free)
    assert left < 0.03
    np.testing.assert_array_equal(pose.translation, begin.translation)
    np.testing.assert_array_equal(pose.root, begin.root)
    others = [i for i in range(6, 34) if i not in arm]
    np.testing.assert_array_equal(pose.joints[np.array(others) - 6], begin.joints[np.array(others) - 6])


def test_five_joints_are_reached_and_one_heading_is_right():
    errors = []
    for pose in random_poses(6, 31):
        wanted = five_of(landmarks(PERSON, pose))
        ways = poses_to(PERSON, wanted, np.ones(16))
        assert min(left for _, left in ways) < 0.03
        errors.append(min(_distance(way, pose).mean() for way, _ in ways))
    assert np.median(errors) < 0.12


def test_too_few_joints_are_refused():
    joints = np.full((16, 3), np.nan)
    joints[:2] = 1.0
    with pytest.raises(MismatchError, match="three"):
        pose_from_joints(PERSON, joints)
    with pytest.raises(MismatchError, match="16"):
        pose_from_joints(PERSON, joints[:5])


@given(SEEDS)
@settings(max_examples=10)
def test_rigid_fits_are_exact_where_they_can_be(seed):
    rng = np.random.default_rng(seed)
    bodies = rng.normal(size=(3, 16, 3))
    turn, shift = rotation(rng.normal(size=3)), rng.normal(size=3)
    turns, shifts, left = fitted(bodies, bodies[1] @ turn.T + shift, rng.uniform(0.1, 1.0, 16))
    np.testing.assert_allclose(turns[1], turn, atol=1e-9)
    np.testing.assert_allclose(shifts[1], shift, atol=1e-9)
    assert left[1] < 1e-9 < left[0]
    np.testing.assert_allclose(np.linalg.det(turns), 1.0)


@given(SEEDS)
@settings(max_examples=10)
def test_mirrored_poses_mirror_the_body(seed):
    joints = random_joints(np.random.default_rng(seed))
    one = landmarks(PERSON, Pose(np.zeros(3), np.eye(3), joints))
    other = landmarks(PERSON, Pose(np.zeros(3), np.eye(3), mirrored(joints)))
    np.testing.assert_allclose(other, one[OTHER_SIDE] * (-1.0, 1.0, 1.0), atol=1e-9)
    np.testing.assert_array_equal(mirrored(mirrored(joints)), joints)


def test_the_true_pose_is_judged_far_better_than_one_beside_it():
    for pose in random_poses(4, 8):
        seen = _seen(pose)
        right = judge(PERSON, pose, seen)
        assert right.cost < 0.1
        assert right.area < 0.005
        assert right.denied.sum() < 0.05 * right.visible.sum()
        away = Pose(pose.translation + np.array([0.6, 0.0, 0.0]), pose.root, pose.joints)
        wrong = judge(PERSON, away, seen)
        assert wrong.cost > 0.5
        assert wrong.unexplained > 0.5
        assert wrong.unseen > 0.5


def test_a_raised_arm_that_the_pose_has_hanging_is_unexplained():
    still = standing()
    target = np.array(landmarks(PERSON, still))
    target[L_WRIST], target[L_ELBOW] = target[L_ELBOW - 1] + (0.53, -0.1, 0.0), np.nan
    raised, _ = reach(PERSON, still, target)
    verdict = judge(PERSON, still, _seen(raised))
    left, right = (PERSON.bones.index(f"{side}_forearm") for side in "lr")
    assert verdict.denied[left] > 0.2 * verdict.visible[left]
    assert verdict.denied[right] < 0.1 * max(verdict.visible[right], 1.0)
    assert verdict.area > 0.01
    wrist = landmarks(PERSON, raised)[L_WRIST]
    assert np.linalg.norm(verdict.loose - wrist, axis=1).min() < 0.12


def _detection(joints, rng, noise=0.03):
    joints = joints + rng.normal(0, noise, joints.shape)
    places = np.stack([joints, np.full_like(joints, np.nan), np.full_like(joints, np.nan)], axis=1)
    sure = np.full(16, 0.9)
    return Detection(joints, sure, places, np.stack([sure, 0 * sure, 0 * sure], axis=1), 0.5)


def test_the_right_reading_of_left_and_right_is_among_the_candidates(rng):
    for k, pose in enumerate(random_poses(4, 77)):
        pose = turned(pose, np.pi * (k % 2))
        detection = _detection(landmarks(PERSON, pose), rng)
        for read in (detection, detection.mirrored):  # whichever way the forest read it
            found = candidates(PERSON, read, _seen(pose))
            assert min(_distance(one.pose, pose).mean() for one in found) < 0.08
            assert [one.cost for one in found] == sorted(one.cost for one in found)


def test_without_any_joint_the_candidates_stand_where_the_person_is():
    pose = standing((0.4, 0.1, 2.7))
    nothing = Detection(np.full((16, 3), np.nan), np.zeros(16), np.full((16, 3, 3), np.nan), np.zeros((16, 3)), 0.5)
    found = candidates(PERSON, nothing, _seen(pose))
    assert len(found) == 8
    assert np.linalg.norm(found[0].pose.translation - pose.translation) < 0.4


@pytest.mark.parametrize("aslant", [-0.7, 0.5, 2.4])
@pytest.mark.parametrize("about", [0.0, 1.6, 3.1])
def test_who_lies_aslant_lies_so_in_a_candidate(aslant, about):
    """Head nearer or farther than the feet, on the back, the side or the belly; nothing was detected."""
    upright = standing((0.1, 0.2, 2.7))
    turn = rotation(np.array([0.0, aslant, 0.0])) @ rotation(np.array([0.0, 0.0, np.pi / 2]))
    pose = Pose(upright.translation, turn @ rotation(np.array([0.0, about, 0.0])) @ upright.root, upright.joints)
    found = lying(PERSON, _seen(pose))
    assert min(_distance(one.pose, pose).mean() for one in found) < 0.3
    assert {one.source for one in found} == {"lying", "lying the other way"}
    assert min(_distance(one, pose).mean() for one in random_poses(20, 5)) > 0.4  # who stands there is nowhere near


def test_who_stands_is_not_laid_down():
    assert not any(lying(PERSON, _seen(pose)) for pose in random_poses(20, 55))
