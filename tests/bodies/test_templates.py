"""The performer of other people's skeletons, its poses from their motions, and the way back."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend
from motionmend import samples
from motionmend.bodies import anatomy
from motionmend.bodies import performer as bodies
from motionmend.bodies.handback import motion_of, performer_frames
from motionmend.bodies.motion import Motion
from motionmend.bodies.rig import motion_landmarks, rig_of
from motionmend.bodies.roles import roles
from motionmend.bodies.skeleton import Skeleton, forward
from motionmend.bodies.templates import performer_of, poses_of, skeleton_of
from motionmend.errors import MismatchError

SEEDS = st.integers(0, 2**32 - 1)


def some_poses(seed, count=6, wildness=0.4):
    rng = np.random.default_rng(seed)
    low, high = bodies.LIMITS[6:].T
    joints = np.clip(wildness * rng.normal(size=(count, 28)), 0.9 * low, 0.9 * high)
    return bodies.Poses(rng.normal(size=(count, 3)), bodies.rotation(rng.normal(size=(count, 3))), joints)


def landmarks_of(poses, person):
    return np.array([bodies.landmarks(person, poses[t]) for t in range(len(poses))])


@settings(max_examples=8, deadline=None)
@given(st.floats(1.2, 2.1), st.floats(0.85, 1.15))
def test_the_performers_own_skeleton_gives_the_performer_back(stature, leggy):
    stretch = np.ones((15, 3))
    stretch[9:15, 1] = leggy
    person = anatomy.average(stature).stretched(stretch)
    again = performer_of(skeleton_of(person))
    np.testing.assert_allclose(again.offsets, person.offsets, rtol=0, atol=1e-12)
    np.testing.assert_allclose(again.landmark_place, person.landmark_place, rtol=0, atol=1e-12)
    np.testing.assert_allclose(again.tip_place[1:], person.tip_place[1:], rtol=0, atol=1e-12)


@settings(max_examples=5, deadline=None)
@given(SEEDS)
def test_poses_go_to_a_skeleton_and_come_back(seed):
    person = anatomy.average()
    poses = some_poses(seed)
    there = motion_of(poses, person, skeleton_of(person), 30.0)
    np.testing.assert_allclose(motion_landmarks(there), landmarks_of(poses, person), rtol=0, atol=0.02)
    back = poses_of(there, person)
    assert np.median(back.error) < 0.003
    assert np.median(np.linalg.norm(landmarks_of(back.poses, person) - landmarks_of(poses, person), axis=2)) < 0.005


@settings(max_examples=6, deadline=None)
@given(SEEDS, SEEDS)
def test_retargeting_commutes_with_standing_elsewhere(seed, other):
    person, rng = anatomy.average(), np.random.default_rng(other)
    turn, shift = bodies.rotation(rng.normal(size=3)), rng.normal(size=3)
    poses = some_poses(seed)
    moved = landmarks_of(poses.moved(turn, shift), person)
    np.testing.assert_allclose(moved, landmarks_of(poses, person) @ turn.T + shift, rtol=0, atol=1e-12)


@pytest.mark.parametrize("action", ["walk", "reach", "jump"])
def test_a_cmu_body_of_62_degrees_of_freedom(action):
    clip = samples.clip(action, seconds=1.0, fps=15.0, seed=3, height=1.7)
    person = performer_of(clip.skeleton)
    made = poses_of(clip, person)
    assert made.error.shape == (clip.frames, 16)
    assert made.error.mean() < 0.01
    assert np.percentile(made.error, 99) < 0.04
    np.testing.assert_allclose(
        np.linalg.norm(landmarks_of(made.poses, person) - motion_landmarks(clip), axis=2), made.error, atol=1e-9
    )
    back = motion_of(made.poses, person, clip.skeleton, clip.fps)
    assert back.skeleton is clip.skeleton
    assert np.linalg.norm(motion_landmarks(back) - motion_landmarks(clip), axis=2).mean() < 0.015


def test_joints_lie_where_cmu_bones_begin_and_end():
    clip = samples.clip("walk", seconds=0.2, fps=30.0)
    names, (position, _) = clip.skeleton.names, forward(clip.skeleton, clip.q)
    place = dict(zip(bodies.LANDMARKS, motion_landmarks(clip).transpose(1, 0, 2), strict=True))
    starts = {"pelvis": "root", "chest": "lowerneck", "neck": "head", "head": "head_end"}
    for side in "lr":
        for joint, bone in zip(
            ("shoulder", "elbow", "wrist", "hip", "knee", "ankle"),
            ("humerus", "radius", "hand", "femur", "tibia", "foot"),
            strict=True,
        ):
            starts[f"{side}_{joint}"] = side + bone
    for joint, bone in starts.items():  # the end of a bone is where the next one starts
        np.testing.assert_array_equal(place[joint], position[:, names.index(bone)], err_msg=joint)


def test_a_frame_with_missing_angles_keeps_the_last_pose_and_says_so():
    clip = samples.clip("walk", seconds=0.5, fps=20.0)
    q = clip.q.copy()
    q[4, 30] = np.nan
    made = poses_of(replace(clip, q=q), performer_of(clip.skeleton))
    assert np.isnan(made.error[4]).all()
    assert np.isfinite(np.delete(made.error, 4, axis=0)).all()
    np.testing.assert_array_equal(made.poses.joints[4], made.poses.joints[3])


def test_a_frame_nobody_was_seen_in_stays_missing():
    person, poses = anatomy.average(), some_poses(1)
    translation = poses.translation.copy()
    translation[2] = np.nan
    gone = bodies.Poses(translation, poses.root, poses.joints)
    motion = motion_of(gone, person, skeleton_of(person), 30.0)
    assert np.isnan(motion.q[2]).all()
    assert np.isfinite(np.delete(motion.q, 2, axis=0)).all()
    assert np.isnan(performer_frames(gone, person)[2]).all()


def test_a_stiff_trunk_turns_with_the_pelvis_whichever_shoulder_is_raised():
    person = anatomy.average()
    whole = skeleton_of(person)
    bends = ~np.isin(whole.dof_joint, [whole.names.index(n) for n in ("Spine", "LeftShoulder", "RightShoulder")])
    stiff = replace(
        whole,
        dof_names=tuple(np.array(whole.dof_names)[bends]),
        **{name: getattr(whole, name)[bends] for name in ("dof_joint", "dof_axis", "dof_kind", "limits")},
    )
    joints = np.zeros((2, 28))
    for row, side, sign in ((0, "l", 1.0), (1, "r", -1.0)):
        joints[row, bodies.FIRST[bodies.BONES.index(f"{side}_clavicle")]] = sign * 0.4
    poses = bodies.Poses(np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)), joints)
    left, right = motion_of(poses, person, stiff, 30.0).q[:, 3:6]
    np.testing.assert_allclose(np.abs(left), np.abs(right), atol=1e-3)


def renamed(skeleton, names):
    """The same tree under other names."""
    fresh = tuple(names.get(name, name) for name in skeleton.names)
    return Skeleton(
        fresh,
        skeleton.parents,
        skeleton.offsets,
        skeleton.dof_names,
        skeleton.dof_joint,
        skeleton.dof_axis,
        skeleton.dof_kind,
        skeleton.limits,
        skeleton.up,
    )


SPELLINGS = {
    "smpl": {"Arm": "{}_Shoulder", "ForeArm": "{}_Elbow", "Hand": "{}_Wrist", "Shoulder": "{}_Collar"},
    "unreal": {"Arm": "upperarm_{}", "ForeArm": "lowerarm_{}", "Hand": "hand_{}", "Shoulder": "clavicle_{}"},
    "poser": {"Arm": "{}Shldr", "ForeArm": "{}ForeArm", "Hand": "{}Hand", "Shoulder": "{}Collar"},
}


@pytest.mark.parametrize("style", SPELLINGS)
def test_other_spellings_name_the_same_parts(style):
    plain = skeleton_of(anatomy.average())
    letters = {"smpl": ("L", "R")}.get(style, ("l", "r"))
    names = {
        f"{side}{part}": spelt.format(letter)
        for part, spelt in SPELLINGS[style].items()
        for side, letter in zip(("Left", "Right"), letters, strict=True)
    }
    assert roles(renamed(plain, names)) == roles(plain)


def test_a_body_without_names_is_known_by_its_shape():
    clip = samples.clip("walk", seconds=0.2, fps=30.0)
    nameless = renamed(clip.skeleton, {name: f"joint{j}" for j, name in enumerate(clip.skeleton.names)})
    found, meant = roles(nameless), roles(clip.skeleton)
    assert found.guesses
    assert (found.pelvis, found.feet.hips, found.feet.knees) == (meant.pelvis, meant.feet.hips, meant.feet.knees)
    for one, other in zip(found.arms, meant.arms, strict=True):
        assert one.shoulder == other.shoulder
        assert one.elbow == other.elbow


def test_what_is_no_body_is_refused():
    person = skeleton_of(anatomy.average())
    keep = [j for j, name in enumerate(person.names) if "Arm" not in name and "Hand" not in name]
    rows = np.isin(person.dof_joint, keep)
    armless = Skeleton(
        tuple(person.names[j] for j in keep),
        [keep.index(person.parents[j]) if person.parents[j] >= 0 else -1 for j in keep],
        person.offsets[keep],
        tuple(np.array(person.dof_names)[rows]),
        [keep.index(j) for j in person.dof_joint[rows]],
        person.dof_axis[rows],
        person.dof_kind[rows],
        person.limits[rows],
    )
    with pytest.raises(MismatchError, match=r"arm|shoulder"):
        performer_of(armless)
    missing = Motion(person, np.full((3, 34), np.nan), 30.0)
    with pytest.raises(MismatchError, match="without missing"):
        poses_of(missing, anatomy.average())


@pytest.mark.slow
@pytest.mark.parametrize("file", ["amc/02/02_06.amc", "amc/05/05_02.amc", "bvh/10_04.bvh", "bvh/60_10_salsa.bvh"])
def test_real_recordings(data, file):
    whole = motionmend.read(data / "mocap" / file)
    clip = whole.with_q(whole.q[:: max(1, whole.frames // 25)])
    person = performer_of(clip.skeleton)
    made = poses_of(clip, person)
    assert np.median(made.error) < 0.005
    assert made.error.mean() < 0.012
    assert np.percentile(made.error, 95) < 0.035
    back = motion_of(made.poses, person, clip.skeleton, clip.fps)
    assert np.median(np.linalg.norm(motion_landmarks(back) - motion_landmarks(clip), axis=2)) < 0.01
    axes = rig_of(clip.skeleton).rests
    np.testing.assert_allclose(axes @ np.swapaxes(axes, 1, 2), np.broadcast_to(np.eye(3), axes.shape), atol=1e-9)


def test_poses_survive_a_bvh_file(tmp_path):
    person, poses = anatomy.average(1.65), some_poses(5, wildness=0.3)
    motionmend.write(tmp_path / "poses.bvh", motion_of(poses, person, skeleton_of(person), 30.0))
    read = motionmend.read(tmp_path / "poses.bvh")
    np.testing.assert_allclose(motion_landmarks(read), landmarks_of(poses, person), rtol=0, atol=2e-3)
