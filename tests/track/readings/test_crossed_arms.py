"""Arms crossed before the chest: forearms that cross, taken for such that bend back where they meet, are put right."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import DOFS, LANDMARKS, Pose, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.track.database import PoseDatabase
from motionmend.track.model import TrackerModel
from motionmend.track.readings.left_right import FOREARMS, changed_over, may_cross
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step
from walkers import BODY, DT, as_sensed, walking

WRISTS = [LANDMARKS.index(name) for name in ("l_wrist", "r_wrist")]
# rad, of both arms: crossed before the chest, and what these were taken for
CROSSED = (-0.12, 0.01, -0.56, -0.02, -0.88, 1.10, 0.11, 0.19, -0.46, -0.14, 0.87, 0.89)
BENT_BACK = (-0.03, 0.04, 0.07, 0.99, -0.99, 1.29, 0.05, 0.20, 0.19, -1.46, 1.28, 1.62)


@cache
def arms(bent, share=1.0, sway=0.0):
    """Facing the camera, arms so far from hanging (0) to `bent` (1)."""
    pose = standing((sway, 0.05, 2.6))
    joints = pose.joints.copy()
    joints[FOREARMS.columns] += share * (np.array(bent) - joints[FOREARMS.columns])
    return Pose(pose.translation, pose.root, joints)


def test_forearms_bent_back_where_they_meet_may_cross_and_hanging_ones_may_not():
    assert may_cross(landmarks(BODY, arms(BENT_BACK)))
    assert not may_cross(landmarks(BODY, arms(CROSSED, 0.0)))
    assert not may_cross(landmarks(BODY, walking(1.0, np.array([0.0, 0.05, 3.0]), 30.0)))


@given(st.floats(0.9, 1.05))
def test_forearms_changed_over_end_nearer_to_where_the_others_did_and_nothing_else_moves(share):
    pose = arms(BENT_BACK, share)
    other = changed_over(BODY, pose, FOREARMS)
    was, now = landmarks(BODY, pose), landmarks(BODY, other)
    left = np.linalg.norm(now[WRISTS] - was[WRISTS[::-1]], axis=1)
    assert left.max() < 0.5 * np.linalg.norm(was[WRISTS[0]] - was[WRISTS[1]])
    np.testing.assert_array_equal(other.translation, pose.translation)
    np.testing.assert_array_equal(other.root, pose.root)
    rest = np.setdiff1d(np.arange(DOFS - 6), FOREARMS.columns)
    np.testing.assert_array_equal(other.joints[rest], pose.joints[rest])


@pytest.mark.slow
@pytest.mark.parametrize("right", [True, False])
def test_crossed_arms_are_put_right_within_a_second_and_right_ones_stay(right):
    library = np.array([arms(CROSSED, share).joints for share in np.linspace(0.0, 1.0, 30)])
    model, settings, state, gaps = TrackerModel(PoseDatabase(library, np.full(30, 29))), settings_of(), None, []
    for k in range(36):
        sway = 0.03 * np.sin(0.15 * k)
        pose = arms(CROSSED, 1.0, sway)
        depth = as_sensed(render(BODY, pose, KINECT).depth, KINECT, 0, k)
        frame = DepthFrame(KINECT, depth, None, k * DT)
        if state is None:
            state = start(model, settings, frame, BODY, pose if right else arms(BENT_BACK, 1.0, sway))
        state, said = step(model, settings, state, frame)
        gaps.append(np.linalg.norm((said.landmarks - landmarks(BODY, pose))[WRISTS], axis=1).max())
    assert (max(gaps) if right else max(gaps[-4:])) < 0.08
    assert right or gaps[0] > 0.15
