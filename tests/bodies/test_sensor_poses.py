"""The performer and the joints of sensors, both ways."""

import numpy as np
import pytest

from motionmend.bodies import anatomy
from motionmend.bodies import performer as bodies
from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25
from motionmend.bodies.postures import Postures
from motionmend.bodies.sensor_poses import joints_of_poses, performer_of_joints, poses_of_joints
from motionmend.errors import MismatchError


def moving(frames=12, seed=0):
    """A performer waving all limbs a little, turning right round meanwhile."""
    rng = np.random.default_rng(seed)
    phase, size = rng.uniform(0, 6.28, 28), rng.uniform(0.05, 0.35, 28)
    at = bodies.standing((0.1, 0.9, -0.3), np.eye(3))
    swing = np.clip(
        at.joints + size * np.sin(np.linspace(0, 3, frames)[:, None] + phase), *(0.95 * bodies.LIMITS[6:].T)
    )
    turn = bodies.rotation(np.linspace(0, 2 * np.pi, frames)[:, None] * np.array([0.0, 1.0, 0.0]))
    return bodies.Poses(np.tile(at.translation, (frames, 1)), turn, swing)


@pytest.mark.slow
@pytest.mark.parametrize("joint_set", [KINECT20, KINECT25, AZURE32], ids=lambda one: one.key)
def test_poses_become_a_sensors_joints_and_come_back(joint_set):
    person, poses = anatomy.average(1.8), moving()
    times = np.arange(len(poses)) / 30
    postures = joints_of_poses(poses, person, joint_set.names, times)
    assert postures.names == joint_set.names
    back = poses_of_joints(postures, person)
    assert np.nanmax(back.error) < 0.02
    assert np.nanmean(back.error) < 0.004
    for t in range(len(poses)):
        away = np.linalg.norm(bodies.landmarks(person, back.poses[t]) - bodies.landmarks(person, poses[t]), axis=1)
        limbs = [j for j, name in enumerate(bodies.LANDMARKS) if "_" in name]
        assert away[limbs].max() < 0.03


def test_lengths_come_from_the_joints():
    stretch = np.ones((15, 3))
    stretch[[bodies.BONES.index(f"{side}_thigh") for side in "lr"], 1] = 1.12
    person = anatomy.average(1.6).stretched(stretch)
    postures = joints_of_poses(moving(), person, KINECT20.names, np.arange(12) / 30)
    found = performer_of_joints(postures)
    for bone in ("l_thigh", "r_shank", "l_upperarm", "r_forearm"):
        b = bodies.BONES.index(bone)
        assert found.lengths[b] == pytest.approx(person.lengths[b], rel=0.01)


def test_frames_without_joints_stay_empty_and_others_are_found_again():
    person, poses = anatomy.average(), moving()
    positions = joints_of_poses(poses, person, KINECT20.names, np.arange(12) / 30).positions.copy()
    positions[3:6] = np.nan
    back = poses_of_joints(Postures(KINECT20.names, positions, np.arange(12) / 30), person)
    assert np.isnan(back.poses.translation[3:6]).all()
    assert np.isnan(back.error[3:6]).all()
    assert np.nanmean(back.error[6:]) < 0.01


def test_joints_without_limbs_are_refused():
    postures = Postures(("Head", "HipCenter"), np.zeros((2, 2, 3)), np.arange(2))
    with pytest.raises(MismatchError, match="upperarm"):
        performer_of_joints(postures)


def test_a_real_sensors_skeleton(data):
    from motionmend.io.sensor import read_postures

    folder = data / "kinect" / "gaitkinect"
    files = sorted(folder.rglob("*.skl")) if folder.is_dir() else []
    if not files:
        pytest.skip("no Kinect tables in MOTIONMEND_DATA")
    read = read_postures(files[0])
    some = slice(0, read.frames, max(1, read.frames // 30))
    postures = Postures(read.names, read.positions[some], read.times[some])
    made = poses_of_joints(postures, performer_of_joints(postures))
    assert np.nanmedian(made.error) < 0.06
