"""What the feet tell of front and back."""

from dataclasses import replace

import numpy as np
import pytest

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, FIRST, LANDMARKS, Pose, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.other_poses import coarse_of
from motionmend.track.readings.facing import about_face
from motionmend.track.readings.feet import feet_against
from motionmend.track.settings import settings_of
from walkers import BODY, as_sensed, walking

ANKLE = LANDMARKS.index("l_ankle")


def coarse(pose):
    frame = DepthFrame(KINECT, as_sensed(render(BODY, pose, KINECT).depth, KINECT, 0, 0), None, 0.0)
    seen = Observation(KINECT, frame.depth, ~np.isfinite(frame.depth), 0.0)
    return coarse_of(evidence_of(seen, settings_of()))


def cut(frame, row):
    """The frame with nothing of the person from a row on: as where the floor was taken away, feet and all."""
    below = np.arange(len(frame.seen))[:, None] >= row
    seen = np.where(below, np.nan, frame.seen).astype(np.float32)
    return replace(frame, seen=seen, free=frame.free | below)


@pytest.mark.parametrize("heading", [0.0, 60.0, 120.0, 180.0, -90.0])
def test_feet_of_who_is_read_the_wrong_way_round_are_not_where_something_is_seen(heading):
    pose = walking(0.5, (0, 0, 3), heading)
    other, frame = about_face(BODY, pose), coarse(pose)
    assert feet_against(BODY, other, pose, frame) > 0.03
    assert feet_against(BODY, pose, other, frame) == pytest.approx(-feet_against(BODY, other, pose, frame))


@pytest.mark.parametrize("heading", [0.0, 60.0, 120.0, 180.0, -90.0])
def test_feet_that_were_taken_away_with_the_floor_do_not_turn_anybody(heading):
    """Toes that point where nothing is left would speak against who faces the camera."""
    pose = walking(0.5, (0, 0, 3), heading)
    frame = coarse(pose)
    lowest = max(row for row in range(len(frame.seen)) if np.isfinite(frame.seen[row]).any())
    _, fy, _, cy = frame.intrinsics
    _, y, z = landmarks(BODY, pose)[ANKLE]
    gone = cut(frame, int(cy + fy * y / z) + 1)
    assert int(cy + fy * y / z) + 1 <= lowest
    whole = feet_against(BODY, pose, about_face(BODY, pose), frame)
    left = feet_against(BODY, pose, about_face(BODY, pose), gone)
    assert whole < left < 0.02


def test_feet_out_of_sight_tell_nothing():
    pose = walking(0.5, (0, 0, 3), 40.0)
    frame = coarse(pose)
    assert feet_against(BODY, pose, about_face(BODY, pose), cut(frame, int(0.6 * len(frame.seen)))) == 0.0


def test_feet_that_are_guessed_before_the_trunk_are_not_told_by_it():
    """Seen by the trunk alone, somebody was held back to front by how it fits where the feet were believed to be."""
    pose = standing((0.0, 0.0, 3.0))
    frame = coarse(pose)
    frame = cut(frame, len(frame.seen) // 2)
    joints = np.array(pose.joints)
    joints[[FIRST[BONES.index(f"{side}_thigh")] for side in "lr"]] -= 1.5  # legs straight at the camera
    guessed = Pose(pose.translation, pose.root, joints)
    x, y, z = landmarks(BODY, guessed)[ANKLE]
    fx, fy, cx, cy = frame.intrinsics
    assert z < 2.2
    assert np.isfinite(frame.seen[int(cy + fy * (y - 0.2) / z), int(cx + fx * x / z)])
    assert feet_against(BODY, guessed, pose, frame) == 0.0
