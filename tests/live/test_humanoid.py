"""Bones of an avatar: put together again they are the joints they came from."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25, UIPRMD22, meanings
from motionmend.live.axes import page_from_sensor, unity_from_sensor
from motionmend.live.humanoid import humanoid, quaternion
from motionmend.live.warm import standing

SETS = (KINECT20, KINECT25, AZURE32, UIPRMD22)
ABOVE = {
    "Spine": "Hips", "Chest": "Spine", "Neck": "Chest", "Head": "Neck",
    "LeftShoulder": "Chest", "LeftUpperArm": "LeftShoulder", "LeftLowerArm": "LeftUpperArm", "LeftHand": "LeftLowerArm",
    "RightShoulder": "Chest", "RightUpperArm": "RightShoulder", "RightLowerArm": "RightUpperArm",
    "RightHand": "RightLowerArm",
    "LeftUpperLeg": "Hips", "LeftLowerLeg": "LeftUpperLeg", "LeftFoot": "LeftLowerLeg",
    "RightUpperLeg": "Hips", "RightLowerLeg": "RightUpperLeg", "RightFoot": "RightLowerLeg",
}  # fmt: skip
STARTS = {
    "LeftUpperArm": "l_shoulder", "LeftLowerArm": "l_elbow", "LeftHand": "l_wrist", "RightLowerArm": "r_elbow",
    "LeftUpperLeg": "l_hip", "LeftLowerLeg": "l_knee", "LeftFoot": "l_ankle", "RightFoot": "r_ankle", "Hips": "pelvis",
}  # fmt: skip
ENDS = {
    "LeftUpperArm": ("l_elbow", [-1, 0, 0]), "RightLowerArm": ("r_wrist", [1, 0, 0]),
    "LeftUpperLeg": ("l_knee", [0, -1, 0]), "RightLowerLeg": ("r_ankle", [0, -1, 0]), "LeftFoot": ("l_foot", [0, 0, 1]),
}  # fmt: skip


def named(joint_set, joints):
    placed = joints @ unity_from_sensor(joint_set.key).T
    return {m: p for m, p in zip(meanings(joint_set.names), placed, strict=True) if m}


def world(bones):
    """World places and rotations by composing from the hips outward, as a receiver does."""
    places, turns = {}, {}
    for bone in bones:
        turn = Rotation.from_quat(bone.rotation)
        if bone.name == "Hips":
            places[bone.name], turns[bone.name] = bone.place, turn
        else:
            above = ABOVE[bone.name]
            places[bone.name] = places[above] + turns[above].apply(bone.place)
            turns[bone.name] = turns[above] * turn
    return places, turns


def shaken(joint_set, seed, by=0.15):
    joints = standing(joint_set)
    return joints + np.random.default_rng(seed).normal(0, by, joints.shape)


@settings(max_examples=25)
@given(st.sampled_from(SETS), st.integers(0, 10_000))
def test_bones_put_together_are_the_joints(joint_set, seed):
    joints = named(joint_set, shaken(joint_set, seed))
    places, turns = world(humanoid(joints))
    assert set(STARTS) <= set(places)
    for bone, start in STARTS.items():
        assert places[bone] == pytest.approx(joints[start], abs=1e-9)
    for bone, (end, direction) in ENDS.items():
        along = joints[end] - joints[STARTS.get(bone, end.replace("wrist", "elbow").replace("ankle", "knee"))]
        assert turns[bone].apply(direction) == pytest.approx(along / np.linalg.norm(along), abs=1e-9)


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-2, 2)] * 3))
def test_turning_and_moving_the_person_turns_and_moves_the_hips_alone(seed, spin, step):
    joints = named(KINECT25, shaken(KINECT25, seed, 0.05))
    turn = Rotation.from_rotvec(spin)
    there = {name: turn.apply(place) + step for name, place in joints.items()}
    for one, other in zip(humanoid(joints), humanoid(there), strict=True):
        assert one.name == other.name
        if one.name == "Hips":
            both = turn * Rotation.from_quat(one.rotation)
            assert (both * Rotation.from_quat(other.rotation).inv()).magnitude() == pytest.approx(0, abs=1e-6)
        else:
            assert abs(np.dot(one.rotation, other.rotation)) == pytest.approx(1, abs=1e-9)
            assert other.place == pytest.approx(one.place, abs=1e-9)


@pytest.mark.parametrize("joint_set", SETS, ids=lambda one: one.key)
def test_somebody_who_faces_the_sensor_looks_along_z_with_the_right_along_x(joint_set):
    joints = named(joint_set, standing(joint_set))
    assert joints["r_hip"][0] > joints["l_hip"][0]
    assert joints["head"][1] > joints["pelvis"][1]
    assert joints["l_foot"][2] > joints["l_ankle"][2]
    hips = next(bone for bone in humanoid(joints) if bone.name == "Hips")
    assert abs(hips.rotation[3]) == pytest.approx(1, abs=1e-6)
    assert np.linalg.det(unity_from_sensor(joint_set.key)) == pytest.approx(-1)
    assert np.linalg.det(page_from_sensor(joint_set.key)) == pytest.approx(1)


def test_a_bent_elbow_turns_the_upper_arm_about_itself():
    joints = named(KINECT25, standing(KINECT25))
    for side, sign in (("l", -1.0), ("r", 1.0)):  # arms to the sides, forearms forward: the hinge is upright
        shoulder = joints[f"{side}_shoulder"]
        joints[f"{side}_elbow"] = shoulder + np.array([0.3 * sign, 0, 0])
        joints[f"{side}_wrist"] = shoulder + np.array([0.3 * sign, 0, 0.25])
    _, turns = world(humanoid(joints))
    for bone in ("LeftUpperArm", "RightUpperArm"):
        assert (turns[bone] * turns["Chest"].inv()).magnitude() < 0.2
    for side in ("l", "r"):  # forearms up: the upper arm has turned by a quarter
        joints[f"{side}_wrist"] = joints[f"{side}_elbow"] + np.array([0, 0.25, 0])
    _, turns = world(humanoid(joints))
    for bone, sign in (("LeftUpperArm", -1.0), ("RightUpperArm", 1.0)):
        assert turns[bone].apply([sign, 0, 0]) == pytest.approx([sign, 0, 0], abs=1e-9)
        assert turns[bone].apply([0, 0, 1]) == pytest.approx([0, 1, 0], abs=1e-6)


def test_missing_joints_leave_their_bones_with_the_bone_above():
    joints = named(KINECT25, standing(KINECT25))
    for gone in ("l_wrist", "l_hand", "r_knee"):
        del joints[gone]
    bones = {bone.name: bone for bone in humanoid(joints)}
    assert "LeftHand" not in bones
    assert "RightFoot" not in bones
    assert bones["LeftLowerArm"].rotation == pytest.approx([0, 0, 0, 1])
    del joints["l_hip"]
    assert humanoid(joints) == []


@given(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_quaternions_are_those_of_their_matrices(q):
    turn = Rotation.from_quat(q)
    assert abs(np.dot(quaternion(turn.as_matrix()), turn.as_quat())) == pytest.approx(1, abs=1e-9)
