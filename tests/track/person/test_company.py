"""Two people from the first frame on: one of them is followed, and the other is said to be there."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import motionmend as mm
from drawn_people import CAMERA, PERSON, in_room, picture, random_poses
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, landmarks, standing
from motionmend.cli.following import follow
from motionmend.cli.track import Follow
from motionmend.io.depth import read_depth
from motionmend.io.depth_folder import write_depth_folder
from motionmend.track.database import PoseDatabase
from motionmend.track.model import TrackerModel
from motionmend.track.person.company import is_accompanied, told_beforehand
from motionmend.track.person.foreground import find_person, remember, scene_of
from motionmend.track.person.pixels import person_of
from motionmend.track.person.standing import looked_at
from motionmend.track.settings import settings_of
from motionmend.track.starting.first_pose import pose_from_joints

FRAMES = 40
PLACES = (-0.45, 0.45)  # m to the right


def moving(x, t, still=False):
    """Somebody who lifts the arms now and then and takes a step, at frame `t`."""
    pose = standing((x + (0.0 if still else 0.05 * np.sin(0.3 * t)), 0.1, 3.0))
    joints = np.array(pose.joints)
    if not still:
        joints[np.abs(joints) > 0.5] += 0.5 * np.sin(0.25 * t)
    return Pose(pose.translation, pose.root, joints)


@cache
def two_people(room, still=False, places=PLACES):
    """For each frame: who is on the left alone, who is on the right, and what is measured of both."""
    rng, shown = np.random.default_rng(20121), []
    for t in range(FRAMES):
        left, right = (picture(moving(x, t, still and x > 0.0), rng=rng).depth for x in places)
        both = DepthFrame(CAMERA, np.fmin(left, right), None, t / 30)
        shown.append((left, right, in_room(both, rng=rng) if room else both))
    return shown


def beforehand(shown):
    """What a recording of such frames tells before anybody is followed."""
    frames = [frame for *_, frame in shown]
    return told_beforehand([frames[k] for k in looked_at(len(frames))])


@pytest.mark.parametrize("room", [False, True])
def test_of_two_people_one_is_somebody_else_from_the_start(room):
    shown = two_people(room)
    scene = beforehand(shown)
    left, right, frame = shown[0]
    others = np.isfinite(scene.others)
    shares = sorted((others & np.isfinite(own)).sum() / np.isfinite(own).sum() for own in (left, right))
    assert shares[0] < 0.02
    assert shares[1] > 0.95
    assert is_accompanied(scene, frame)
    assert not is_accompanied(replace(scene, others=None), frame)


@pytest.mark.parametrize("room", [False, True])
def test_who_moves_beside_the_person_is_never_theirs(room):
    shown = two_people(room)
    scene, last, whose = beforehand(shown), None, None
    for left, right, frame in shown:
        found = find_person(scene, frame, last)
        scene, last = remember(scene, frame, found), found.place
        seen = np.isfinite(found.depth)
        shares = [(seen & np.isfinite(own)).sum() / np.isfinite(own).sum() for own in (left, right)]
        whose = int(np.argmax(shares)) if whose is None else whose
        assert shares[whose] > 0.9
        assert shares[1 - whose] < 0.03
        assert is_accompanied(scene, frame)


@pytest.mark.parametrize("apart", [0.8, 1.0, 1.3])
def test_without_a_room_two_bodies_side_by_side_are_not_one(apart):
    """Nothing of a recording is known but its frames so far."""
    scene, last = None, None
    for left, right, frame in two_people(False, places=(-apart / 2, apart / 2)):
        scene = scene_of(frame) if scene is None else scene
        found, scene = person_of(scene, frame, last, 1)
        last = found.place
        seen = np.isfinite(found.depth)
        shares = sorted((seen & np.isfinite(own)).sum() / np.isfinite(own).sum() for own in (left, right))
        assert shares[0] < 0.03
        assert shares[1] > 0.9


def test_who_is_alone_has_no_company_and_stays_whole_behind_a_post(rng):
    shown = []
    for t in range(FRAMES):
        own = np.array(picture(moving(0.0, t), rng=rng).depth)
        own[:, 158:163] = np.nan  # 5 cm wide: it cuts them in two from head to feet
        shown.append((own, own, DepthFrame(CAMERA, own, None, t / 30)))
    assert beforehand(shown) is None
    scene = scene_of(shown[0][2])
    found, _ = person_of(scene, shown[0][2], None, 1)
    assert (np.isfinite(found.depth) & np.isfinite(shown[0][0])).sum() > 0.97 * np.isfinite(shown[0][0]).sum()
    assert told_beforehand([frame for *_, frame in shown[:2]]) is None


def test_nothing_is_told_of_no_frames():
    with pytest.raises(mm.MismatchError, match="came none"):
        told_beforehand([])


def test_a_dummy_that_never_sways_is_nobody():
    scene = beforehand(two_people(True, still=True))
    assert scene is None or scene.others is None


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1])
def test_who_is_pointed_at_is_followed_and_the_other_one_named(tmp_path, side):
    frames = [frame for *_, frame in two_people(True)]
    write_depth_folder(tmp_path / "take", frames, 30.0)
    poses = random_poses(40, 5)
    joints = np.concatenate([poses.joints, [moving(0.0, t).joints for t in range(FRAMES)]])
    model, settings = TrackerModel(PoseDatabase(joints, np.full(len(joints), len(joints) - 1))), settings_of()
    recording, truth = (
        read_depth(tmp_path / "take"),
        [landmarks(PERSON, moving(PLACES[side], t)) for t in range(FRAMES)],
    )
    found = follow(model, settings, recording, PERSON, truth[0])
    assert found.company.all()
    read = [recording.true_frame(k) for k in range(FRAMES)]
    scene = told_beforehand(read, truth[0].mean(axis=0))
    tracked = mm.track.follow(model, read, PERSON, pose_from_joints(PERSON, truth[0])[0], scene=scene)
    assert tracked.company.all()
    assert not tracked.moved.any()
    assert np.linalg.norm(tracked.joints - truth, axis=2).mean() < 0.05
    assert np.linalg.norm(found.postures.positions - truth, axis=2).mean() < 0.05
    task = Follow("default", settings.terms, 0.0)
    (said,) = (one for one in task.warnings(recording, found) if "somebody else" in one)
    assert "frames 0 to 39, too" in said
    alone = replace(found, company=np.zeros(FRAMES, np.bool_))
    assert not any("somebody else" in one for one in task.warnings(recording, alone))
