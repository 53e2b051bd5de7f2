"""A stranger's body from the first frames of a recording."""

import numpy as np
import pytest

from drawn_people import CAMERA, PERSON, picture, random_joints, random_poses
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose
from motionmend.errors import MismatchError
from motionmend.track.database import PoseDatabase
from motionmend.track.measure.calibrate import stretch_of
from motionmend.track.measure.first_seconds import measure_person
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of

SHAPE = np.zeros(14)
SHAPE[[0, 1, 7, 8]] = 0.07, 0.03, 0.03, 0.03
TALL = PERSON.stretched(stretch_of(SHAPE))


@pytest.fixture(scope="module")
def model():
    joints = np.array([random_joints(np.random.default_rng(k)) for k in range(80)])
    return TrackerModel(PoseDatabase(joints, np.full(80, 79)))


def _moving(person, count, rng):
    ends = random_poses(2, 3)
    for k in range(count):
        share = 0.5 * k / count
        pose = Pose(ends[0].translation, ends[0].root, (1 - share) * ends[0].joints + share * ends[1].joints)
        yield pose, picture(pose, person=person, rng=rng, time=k / 30)


@pytest.mark.slow
def test_a_tall_person_is_measured_while_moving(model, rng):
    recording = list(_moving(TALL, 12, rng))
    settings = settings_of("default")
    done = measure_person(model, settings, [frame for _, frame in recording], pose=recording[0][0])
    limbs = [b for b, name in enumerate(TALL.bones) if name.endswith(("thigh", "shank", "upperarm", "forearm"))]
    before = PERSON.lengths[limbs].sum() / TALL.lengths[limbs].sum()
    after = done.performer.lengths[limbs].sum() / TALL.lengths[limbs].sum()
    assert before < 0.94
    assert abs(after - 1) < 0.04


def test_nobody_is_not_measured(model):
    empty = [DepthFrame(CAMERA, np.full((240, 320), np.nan, np.float32), None, k / 30) for k in range(3)]
    with pytest.raises(MismatchError, match="nobody"):
        measure_person(model, settings_of("default"), empty, pose=random_poses(1, 0)[0])


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.64, 0.8])
def test_a_child_of_whom_nothing_tells_the_size_is_measured(model, rng, size):
    """As where the detector, which has seen adults and older children, is sure of no joint."""
    child = PERSON.stretched(np.full((1, 3), size))
    recording = list(_moving(child, 12, rng))
    done = measure_person(model, settings_of("default"), [frame for _, frame in recording], pose=recording[0][0])
    assert done.measured
    assert abs(done.performer.lengths[1:].sum() / child.lengths[1:].sum() - 1) < 0.05
