"""A camera that moves: floor and walls are followed, the person is told from them, and it is said."""

from dataclasses import replace

import numpy as np
import pytest

from drawn_people import HALF, PERSON, picture, random_poses
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, landmarks, rotation, standing
from motionmend.cli.following import follow
from motionmend.cli.track import Follow
from motionmend.evaluate.scenes import Plane, behind
from motionmend.evaluate.sensor import sensed
from motionmend.io.depth import read_depth
from motionmend.io.depth_folder import write_depth_folder
from motionmend.track.database import PoseDatabase
from motionmend.track.model import TrackerModel
from motionmend.track.person.foreground import find_person, remember, scene_of
from motionmend.track.person.moved_camera import camera_followed
from motionmend.track.person.room import slack
from motionmend.track.settings import settings_of

ROOM = np.array([[0.0, -1.0, 0.0, 1.02], [0.0, 0.0, -1.0, 4.4], [-1.0, 0.0, 0.0, 1.6]])
FRAMES = 45


def nods(t):
    """A camera held in the hand: its turn and its shift at frame `t`."""
    swing = np.sin(np.array([0.15, 0.11, 0.09]) * t)
    return rotation(np.radians([2.5, 2.0, 1.0]) * swing), np.array([0.02, 0.03, 0.04]) * swing


def is_bumped(t):
    """A camera that is pushed by five degrees once."""
    return rotation(np.radians([5.0 if t >= 20 else 0.0, 0.0, 0.0])), np.zeros(3)


def stands(t):
    return np.eye(3), np.zeros(3)


def swaying(t):
    pose = standing((0.0, 0.1, 2.9))
    joints = np.array(pose.joints)
    joints[np.abs(joints) > 0.5] += 0.2 * np.sin(0.3 * t)
    return Pose(pose.translation, pose.root, joints)


def filmed(way, frames=FRAMES, camera=HALF):
    """For each frame: the person's pose and the room's planes as the camera sees them, the person alone, and all."""
    for t in range(frames):
        turn, shift = way(t)
        pose = swaying(t)
        pose = Pose(turn @ pose.translation + shift, turn @ pose.root, pose.joints)
        normals = ROOM[:, :3] @ turn.T
        planes = np.column_stack([normals, ROOM[:, 3] - normals @ shift])
        own = picture(pose, camera).depth
        whole = behind(own, camera, [Plane(tuple(p[:3]), -p[3]) for p in planes])
        yield pose, planes, own, DepthFrame(camera, sensed(whole, camera, 3, t), None, t / 30)


@pytest.mark.parametrize("way", [nods, is_bumped, stands])
def test_floor_and_walls_are_followed_and_the_person_told_from_them(way):
    scene, last, moved = None, None, []
    for t, (_, _, own, frame) in enumerate(filmed(way)):
        scene = replace(scene_of(frame), vouched=True) if scene is None else camera_followed(scene, frame)
        moved.append(scene.moved == frame.time)
        found = find_person(scene, frame, last)
        scene, last = remember(scene, frame, found), found.place
        if way is is_bumped and 20 <= t < 36:
            continue  # where they are is looked for twice a second
        assert len(scene.planes) == len(ROOM)
        rows, columns = np.nonzero(np.isfinite(frame.depth) & np.isnan(own))
        points = HALF.unproject(np.column_stack([columns, rows]), frame.depth[rows, columns].astype(np.float64))
        heights = np.abs(points @ scene.planes[:, :3].T + scene.planes[:, 3])
        assert (heights < slack(points, scene.planes)).any(axis=1).mean() > 0.9
        with np.errstate(invalid="ignore"):
            there = np.abs(frame.depth - own) < 0.1  # what the sensor leaves of the person
        assert (np.isfinite(found.depth) & there).sum() > 0.9 * there.sum()
        assert (np.isfinite(found.depth) & np.isnan(own)).sum() < 0.05 * there.sum()
    assert any(moved) == (way is not stands)


def test_who_comes_so_near_that_no_floor_is_seen_moves_no_camera():
    (_, planes, _, frame), *_ = filmed(stands)
    scene = scene_of(frame)
    near = picture(standing((0.0, 0.0, 0.75)), HALF).depth
    whole = behind(near, HALF, [Plane(tuple(p[:3]), -p[3]) for p in planes[1:]])
    blocked = DepthFrame(HALF, sensed(whole, HALF, 3, 1), None, 1 / 30)
    later = camera_followed(scene, blocked)
    assert np.isnan(later.moved)
    np.testing.assert_array_equal(later.planes, scene.planes)
    nothing = replace(scene, planes=np.empty((0, 4)))
    assert camera_followed(nothing, frame) is nothing


@pytest.mark.slow
def test_joints_are_where_the_camera_sees_them_and_that_it_moves_is_said(tmp_path):
    shown = list(filmed(nods))
    write_depth_folder(tmp_path / "take", [frame for *_, frame in shown], 30.0)
    poses = random_poses(40, 5)
    joints = np.concatenate([poses.joints, [swaying(t).joints for t in range(FRAMES)]])
    model, settings = TrackerModel(PoseDatabase(joints, np.full(len(joints), len(joints) - 1))), settings_of()
    recording, truth = read_depth(tmp_path / "take"), np.array([landmarks(PERSON, pose) for pose, *_ in shown])
    found = follow(model, settings, recording, PERSON, truth[0])
    assert found.seen.all()
    assert np.linalg.norm(found.postures.positions - truth, axis=2).mean() < 0.03
    task = Follow("default", settings.terms, 0.0)
    assert any("the camera moves in frames" in one for one in task.warnings(recording, found))
    still = replace(found, moved=np.zeros(FRAMES, np.bool_))
    assert not any("the camera moves" in one for one in task.warnings(recording, still))
