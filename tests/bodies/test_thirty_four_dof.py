"""The performer: 34 degrees of freedom whose twists are what finite differences say, and people of other sizes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_body
from motionmend.bodies import anatomy
from motionmend.bodies import performer as bodies
from motionmend.errors import MismatchError

PERSON = anatomy.average()
SEEDS = st.integers(0, 2**32 - 1)


def any_pose(seed):
    rng = np.random.default_rng(seed)
    low, high = bodies.LIMITS[6:].T
    return bodies.Pose(
        rng.normal(size=3), bodies.rotation(rng.normal(size=3) * 2), rng.uniform(low, high) * rng.choice([1e-6, 0.3, 1])
    )


def test_there_are_15_bones_34_degrees_of_freedom_and_16_joints():
    assert len(bodies.BONES) == 15
    assert bodies.twists(PERSON, bodies.standing()).shape == (34, 6)
    assert bodies.landmarks(PERSON, bodies.standing()).shape == (16, 3)
    assert len(bodies.DOF_NAMES) == len(set(bodies.DOF_NAMES)) == 34
    assert all(bodies.MIRROR[bodies.MIRROR] == np.arange(15))
    for b, name in enumerate(bodies.BONES):
        assert bodies.BONES[bodies.MIRROR[b]] == (
            name.replace("l_", "r_", 1)
            if name.startswith("l_")
            else name.replace("r_", "l_", 1)
            if name.startswith("r_")
            else name
        )


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_frames_and_increments_are_their_twins(seed):
    pose = any_pose(seed)
    delta = np.random.default_rng(seed).normal(size=34)
    twin = naive_body.frames(PERSON.chain, pose.translation, pose.root, pose.joints)
    np.testing.assert_allclose(bodies.bone_frames(PERSON, pose), twin, rtol=0, atol=1e-12)
    moved = bodies.advance(PERSON, pose, delta)
    for one, other in zip(
        (moved.translation, moved.root, moved.joints),
        naive_body.advance(pose.translation, pose.root, pose.joints, delta),
        strict=True,
    ):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_twists_are_finite_differences(seed):
    pose = any_pose(seed)
    twin = naive_body.twists(PERSON.chain, pose.translation, pose.root, pose.joints)
    moving = bodies.twists(PERSON, pose)
    expected = np.where(PERSON.moves[:, :, None], moving, 0.0)
    np.testing.assert_allclose(twin, expected, rtol=0, atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_rotation_vectors_come_back(seed):
    rng = np.random.default_rng(seed)
    vector = rng.normal(size=(5, 3))
    vector *= (rng.uniform(0, 3.1, size=5) / np.linalg.norm(vector, axis=1))[:, None]
    np.testing.assert_allclose(bodies.rotation_vector(bodies.rotation(vector)), vector, rtol=0, atol=1e-7)


def test_many_increments_keep_the_root_a_rotation():
    pose, delta = bodies.standing(), np.full(34, 0.01)
    for _ in range(2000):
        pose = bodies.advance(PERSON, pose, delta * 0.1)
    np.testing.assert_allclose(pose.root @ pose.root.T, np.eye(3), rtol=0, atol=1e-12)


def test_who_stands_before_the_camera_is_upright_and_mirrored_left_and_right():
    place = dict(zip(bodies.LANDMARKS, bodies.landmarks(PERSON, bodies.standing()), strict=True))
    assert place["head"][1] < place["chest"][1] < place["pelvis"][1] < place["l_knee"][1] < place["l_ankle"][1]
    assert place["l_wrist"][0] > 0.1 > -0.1 > place["r_wrist"][0]
    for name, (x, y, z) in place.items():
        if name.startswith("l_"):
            np.testing.assert_allclose(place["r_" + name[2:]], (-x, y, z), rtol=0, atol=1e-9)


def test_bending_goes_the_way_bodies_bend():
    def after(name, angle):
        delta = np.zeros(34)
        delta[bodies.DOF_NAMES.index(name)] = angle
        pose = bodies.advance(PERSON, bodies.standing(), delta)
        return dict(zip(bodies.LANDMARKS, bodies.landmarks(PERSON, pose), strict=True))

    rest = after("pelvis.tx", 0.0)
    for side in "lr":
        assert after(f"{side}_forearm.x", 1.0)[f"{side}_wrist"][2] < rest[f"{side}_wrist"][2] - 0.1  # to the camera
        assert after(f"{side}_shank.x", 1.0)[f"{side}_ankle"][2] > rest[f"{side}_ankle"][2] + 0.1  # away from it
    assert after("chest.x", 0.5)["head"][2] < rest["head"][2] - 0.1  # a bow


def test_standing_is_within_limits():
    joints = bodies.standing().joints
    assert np.all(joints > bodies.LIMITS[6:, 0])
    assert np.all(joints < bodies.LIMITS[6:, 1])


def test_longer_and_wider_people():
    stretch = np.ones((15, 3))
    for side in "lr":
        stretch[bodies.BONES.index(f"{side}_thigh")] = (1.2, 1.1, 1.3)
    other = PERSON.stretched(stretch)
    thigh, shank = bodies.BONES.index("l_thigh"), bodies.BONES.index("l_shank")
    assert other.lengths[thigh] == pytest.approx(1.1 * PERSON.lengths[thigh])
    assert other.lengths[shank] == pytest.approx(PERSON.lengths[shank])
    cones = (PERSON.solids.bone == thigh) & (PERSON.solids.kind == 1)
    np.testing.assert_allclose(other.solids.size[cones] / PERSON.solids.size[cones], [[1.2, 1.1, 1.3]])
    rest = PERSON.solids.bone != thigh
    rest &= PERSON.solids.bone != bodies.BONES.index("r_thigh")
    np.testing.assert_allclose(other.solids.size[rest], PERSON.solids.size[rest], rtol=1e-12)
    same = other.stretched(1 / stretch)
    np.testing.assert_allclose(same.offsets, PERSON.offsets, rtol=1e-12)
    np.testing.assert_allclose(same.solids.size, PERSON.solids.size, rtol=1e-12)
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(MismatchError, match="above 0"):
            PERSON.stretched(bad)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.5, 2.0), SEEDS)
def test_a_body_twice_as_large_is_the_same_body_seen_from_twice_as_far(factor, seed):
    pose = any_pose(seed)
    large = PERSON.stretched(factor)
    further = bodies.Pose(pose.translation * factor, pose.root, pose.joints)
    np.testing.assert_allclose(
        bodies.landmarks(large, further), factor * bodies.landmarks(PERSON, pose), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(large.solids.size, factor * PERSON.solids.size, rtol=1e-12)


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(MismatchError, match="joints must be"):
        bodies.Pose(np.zeros(3), np.eye(3), np.zeros(27))
    with pytest.raises(MismatchError, match="offsets must be"):
        bodies.Performer(np.zeros((14, 3)), PERSON.landmark_place, PERSON.tip_place, PERSON.solids)
