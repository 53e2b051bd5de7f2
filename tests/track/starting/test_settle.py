"""Limbs that are far from where they are seen: found at a start, offered while tracking, both arms told apart."""

import numpy as np
import pytest

from drawn_people import CAMERA, PERSON, picture, random_joints, random_poses
from motionmend.bodies.performer import LANDMARKS, LIMITS, Pose, landmarks, standing
from motionmend.track.detect.joints import Detection, fit_detector
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.judge import judge
from motionmend.track.limbs.offers import limb_offers
from motionmend.track.limbs.other_poses import LIMBS, coarse_of, disagreement, with_limb
from motionmend.track.settings import settings_of
from motionmend.track.starting.first_pose import Candidate
from motionmend.track.starting.settle import limb_hints, settle, settled_readings

NOTHING = Detection(np.full((16, 3), np.nan), np.zeros(16), np.full((16, 3, 3), np.nan), np.zeros((16, 3)), 0.5)
L_WRIST = LANDMARKS.index("l_wrist")


@pytest.fixture(scope="module")
def shapes():
    joints = np.array([random_joints(np.random.default_rng(k)) for k in range(60)])
    return tuple(joints[:, limb.columns] for limb in LIMBS)


def _frame(pose):
    depth = picture(pose).depth
    seen = Observation(CAMERA, depth, np.isnan(depth), 0.0)
    return seen, coarse_of(evidence_of(seen, settings_of("default")))


def _refine(coarse):
    return lambda pose: (pose, disagreement(PERSON, pose, coarse))


def _gap(one, other):
    return np.linalg.norm(landmarks(PERSON, one) - landmarks(PERSON, other), axis=1)


def test_arms_that_hang_in_the_pose_but_not_in_the_frame_are_found(shapes):
    left = []
    for truth in random_poses(6, 61):
        arms = [limb for limb in LIMBS if limb.name.endswith("arm")]
        begin = truth
        for limb in arms:
            begin = with_limb(begin, limb, standing().joints[limb.columns])
        _, coarse = _frame(truth)
        refine = _refine(coarse)
        pose, cost = settle(PERSON, begin, refine(begin)[1], coarse, shapes, refine)
        assert cost <= refine(begin)[1]
        assert cost == disagreement(PERSON, pose, coarse)
        left.append(_gap(pose, truth).mean() / _gap(begin, truth).mean())
        assert np.all((pose.joints >= LIMITS[6:, 0] - 1e-9) & (pose.joints <= LIMITS[6:, 1] + 1e-9))
    assert np.median(left) < 0.5  # an arm behind the body may be anywhere behind it


def test_the_same_frame_gives_the_same_pose_and_a_pose_that_fits_stays(shapes):
    truth = random_poses(1, 62)[0]
    _, coarse = _frame(truth)
    refine = _refine(coarse)
    begin = with_limb(truth, LIMBS[0], standing().joints[LIMBS[0].columns])
    one, other = (settle(PERSON, begin, refine(begin)[1], coarse, shapes, refine) for _ in range(2))
    np.testing.assert_array_equal(one[0].joints, other[0].joints)
    kept, cost = settle(PERSON, truth, refine(truth)[1], coarse, shapes, refine)
    assert cost <= refine(truth)[1]
    assert _gap(kept, truth).max() < 0.12


def test_arms_taken_for_each_other_are_swapped_back(shapes):
    from motionmend.track.starting.first_pose import mirrored

    truth = random_poses(1, 63)[0]
    _, coarse = _frame(truth)
    refine = _refine(coarse)
    swapped = truth
    for limb in LIMBS[:2]:
        swapped = with_limb(swapped, limb, mirrored(truth.joints)[limb.columns])
    pose, _ = settle(PERSON, swapped, refine(swapped)[1], coarse, shapes, refine)
    assert _gap(pose, truth).mean() < 0.5 * _gap(swapped, truth).mean()


def test_hints_lead_to_detected_wrists_of_either_side_and_to_unexplained_points():
    truth = random_poses(1, 64)[0]
    begin = with_limb(truth, LIMBS[0], standing().joints[LIMBS[0].columns])
    goal = landmarks(PERSON, truth)[L_WRIST]
    for side in ("l", "r"):
        places, strength = np.array(NOTHING.places), np.array(NOTHING.strength)
        places[LANDMARKS.index(f"{side}_wrist"), 0], strength[LANDMARKS.index(f"{side}_wrist"), 0] = goal, 0.9
        found = Detection(places[:, 0], strength[:, 0], places, strength, 0.5)
        hints = limb_hints(PERSON, begin, found, None)
        near = [np.linalg.norm(landmarks(PERSON, with_limb(begin, LIMBS[0], h))[L_WRIST] - goal) for h in hints[0]]
        assert min(near) < 0.08
    seen, _ = _frame(truth)
    none = limb_hints(PERSON, begin, None, None)
    assert [len(h) for h in none] == [0, 0, 0, 0]
    by_points = limb_hints(PERSON, begin, NOTHING, judge(PERSON, begin, seen.every(4)))
    assert len(by_points[0]) <= 1


def test_of_two_readings_the_one_that_fits_after_settling_is_taken(shapes):
    truth = random_poses(1, 65)[0]
    seen, coarse = _frame(truth)
    refine = _refine(coarse)
    near = with_limb(truth, LIMBS[1], standing().joints[LIMBS[1].columns])
    away = Pose(truth.translation + np.array([0.25, 0.0, 0.1]), truth.root, standing().joints)
    tried = [Candidate(away, 0.1, "back"), Candidate(near, 0.2, "front")]
    best = settled_readings(PERSON, tried, seen.every(4), coarse, shapes, refine)[0]
    assert best is not None
    assert best.source == "front"
    assert _gap(best.pose, truth).mean() < 0.08
    assert settled_readings(PERSON, [], seen.every(4), coarse, shapes, refine) == []


@pytest.mark.slow
def test_offers_are_made_only_for_what_the_frame_does_not_show(shapes):
    detector = fit_detector(random_poses(120, 1), [PERSON], seed=0, count=80, trees=1)
    target = np.array(standing((0.0, 0.1, 3.0)).joints)
    truth = Pose(np.array([0.0, 0.1, 3.0]), standing().root, target)
    arm = LIMBS[0]
    raised = with_limb(truth, arm, np.clip(0.3 * target[arm.columns], *LIMITS[6 + arm.columns].T))
    assert _gap(raised, truth)[L_WRIST] > 0.25
    seen, coarse = _frame(raised)
    assert limb_offers(detector, PERSON, raised, seen, coarse, shapes) == []
    poses = limb_offers(detector, PERSON, truth, seen, coarse, shapes)
    assert 0 < len(poses) <= 3
    best = min(poses, key=lambda pose: disagreement(PERSON, pose, coarse))
    assert disagreement(PERSON, best, coarse) < disagreement(PERSON, truth, coarse)
    assert _gap(best, raised)[L_WRIST] < 0.6 * _gap(truth, raised)[L_WRIST]
