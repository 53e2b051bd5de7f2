"""Positions as a skeleton: bones point as they did, whatever joints a sensor or a pose estimator has."""

import numpy as np
import pytest

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT25, MEDIAPIPE33, UIPRMD22, meanings
from motionmend.bodies.motion import Motion
from motionmend.bodies.posed_skeleton import motion_of
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import forward, positions, rest_positions
from motionmend.errors import MismatchError

COCO = tuple(f"{side}{part}" for side in "LR" for part in ("Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle"))
OPENPOSE = (
    *COCO,
    "Neck",
    "Head",
    "Nose",
    *(f"{side}{part}" for side in "LR" for part in ("BigToe", "SmallToe", "Heel")),
)
REST = {
    "pelvis": (0.0, 0.9, 0.0),
    "spine": (0.0, 1.1, 0.0),
    "chest": (0.0, 1.3, 0.0),
    "neck_base": (0.0, 1.45, 0.0),
    "neck": (0.0, 1.5, 0.0),
    "head": (0.0, 1.65, 0.0),
    "nose": (0.0, 1.65, 0.1),
    "shoulder": (0.2, 1.42, 0.0),
    "elbow": (0.22, 1.12, 0.0),
    "wrist": (0.24, 0.85, 0.05),
    "hip": (0.1, 0.88, 0.0),
    "knee": (0.1, 0.48, 0.02),
    "ankle": (0.1, 0.08, 0.0),
    "heel": (0.1, 0.02, -0.05),
    "foot": (0.1, 0.02, 0.15),
}


def moving(names: tuple[str, ...], frames: int = 40) -> Postures:
    """Somebody who swings arms and legs against each other while the trunk stands; every bone keeps its length."""
    phase = np.linspace(0, 2 * np.pi, frames)
    places = np.zeros((frames, len(names), 3))
    for k, (name, meaning) in enumerate(zip(names, meanings(names), strict=True)):
        side = {"l_": 1.0, "r_": -1.0}.get(meaning[:2], 0.0)
        part = meaning[2:] if side else meaning
        place = np.array(REST.get(part, REST["neck"] if side == 0.0 and "eye" not in name else REST["head"]))
        place[0] *= side if side else 1.0
        places[:, k] = place
        pivot = {"elbow": "shoulder", "wrist": "shoulder", "knee": "hip", "ankle": "hip", "heel": "hip", "foot": "hip"}
        at = pivot.get(part)
        if at:
            turned = 0.9 * side * np.sin(phase) * (1.0 if at == "hip" else -1.0)
            arm = place - np.array(REST[at]) * [side, 1, 1]
            places[:, k, 1] = REST[at][1] + np.cos(turned) * arm[1] - np.sin(turned) * arm[2]
            places[:, k, 2] = REST[at][2] + np.sin(turned) * arm[1] + np.cos(turned) * arm[2]
    return Postures(names, places, np.arange(frames) / 30)


def apart(postures: Postures) -> Floats:
    """(T, J) m from where the joints are to where the skeleton has them."""
    motion = motion_of(postures)
    at = [motion.skeleton.names.index(name) for name in postures.names]
    return np.linalg.norm(positions(motion.skeleton, motion.q)[:, at] - postures.positions, axis=2)


@pytest.mark.parametrize("names", [COCO, OPENPOSE, MEDIAPIPE33.names, KINECT25.names, UIPRMD22.names])
def test_limbs_move_by_themselves_whatever_joints_there_are(names: tuple[str, ...]) -> None:
    known = [k for k, meaning in enumerate(meanings(names)) if meaning.removeprefix("l_").removeprefix("r_") in REST]
    assert len(known) >= len(COCO)
    assert apart(moving(names))[:, known].max() < 0.01


@pytest.mark.parametrize("names", [OPENPOSE, KINECT25.names])
def test_who_sits_stands_at_rest(names: tuple[str, ...]) -> None:
    """So that a .bvh, which states no unit, is not taken for one in inches."""
    postures = moving(names)
    sat = np.repeat(postures.positions[:1], 5, axis=0)
    for k, meaning in enumerate(meanings(names)):
        if meaning[2:] in ("knee", "ankle", "heel", "foot"):
            sat[:, k] += [0.0, 0.4, 0.4]
    seated = Postures(names, sat, np.arange(5) / 30)
    skeleton = motion_of(seated).skeleton
    assert apart(seated).max() < 1e-4
    tall = np.ptp(rest_positions(skeleton)[:, 1])
    assert 1.3 < tall < 2.0


def test_the_trunk_has_the_shape_of_most_frames_not_of_the_first() -> None:
    postures = moving(KINECT25.names)
    shrugged = postures.positions.copy()
    arms = [k for k, name in enumerate(KINECT25.names) if name.startswith(("Shoulder", "Elbow", "Wrist"))]
    shrugged[0, arms, 1] += 0.15
    assert apart(postures.with_positions(shrugged))[1:, arms].max() < 0.01


def test_a_joint_that_is_never_there_is_left_out_and_said() -> None:
    places = moving(KINECT25.names).positions.copy()
    thumb = KINECT25.names.index("ThumbLeft")
    places[:, thumb] = np.nan
    motion = motion_of(moving(KINECT25.names).with_positions(places))
    assert set(motion.skeleton.names) == set(KINECT25.names) - {"ThumbLeft"}
    assert any("ThumbLeft" in one for one in motion.guesses)
    with pytest.raises(MismatchError):
        motion_of(moving(KINECT25.names).with_positions(np.full(places.shape, np.nan)))


def test_joints_that_are_never_all_there_at_once_make_a_skeleton() -> None:
    places = moving(KINECT25.names).positions.copy()
    places[:20, KINECT25.names.index("HandTipLeft")] = np.nan
    places[20:, KINECT25.names.index("HandTipRight")] = np.nan
    found = motion_of(moving(KINECT25.names).with_positions(places))
    assert set(found.skeleton.names) == set(KINECT25.names)
    open_ = {found.skeleton.dof_names[k].split(".")[0] for k in np.flatnonzero(np.isnan(found.q).any(axis=0))}
    assert open_ == {"HandLeft", "HandRight"}  # of a hand without its tip nothing tells how it is turned


def test_one_of_several_bones_that_is_missing_leaves_the_others() -> None:
    postures = moving(KINECT25.names)
    places = postures.positions.copy()
    places[5:10, KINECT25.names.index("ShoulderLeft")] = np.nan
    found = motion_of(postures.with_positions(places))
    gone = {found.skeleton.dof_names[k].split(".")[0] for k in np.flatnonzero(np.isnan(found.q).any(axis=0))}
    assert gone == {"ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft"}  # which turn by what carries them


def steps(motion: Motion, joint: str) -> Floats:
    """(T - 1,) rad by which a joint turns from frame to frame."""
    turned = forward(motion.skeleton, motion.q)[1][:, motion.skeleton.names.index(joint)]
    cosine = (np.trace(turned[:-1].swapaxes(1, 2) @ turned[1:], axis1=1, axis2=2) - 1.0) / 2.0
    return np.arccos(np.clip(cosine, -1.0, 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_thumb_that_is_thrown_about_does_not_spin_the_hand(seed: int) -> None:
    """As no sensor sees it; what carries the hand is seen well."""
    postures = moving(KINECT25.names, 90)
    places, rng = postures.positions.copy(), np.random.default_rng(seed)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        wrist, elbow = (places[:, KINECT25.names.index(f"{one}{side}")] for one in ("Wrist", "Elbow"))
        along = (wrist - elbow) / np.linalg.norm(wrist - elbow, axis=1, keepdims=True)
        for name, far in (("Hand", 0.07), ("HandTip", 0.15)):
            places[:, KINECT25.names.index(f"{name}{side}")] = wrist + far * along
        thumb = wrist + 0.05 * along + [0.03 * sign, 0.0, 0.0] + 0.03 * rng.normal(size=wrist.shape)
        places[:, KINECT25.names.index(f"Thumb{side}")] = thumb
    motion = motion_of(postures.with_positions(places))
    for joint in ("WristLeft", "WristRight", "HandLeft", "HandRight"):
        assert np.degrees(steps(motion, joint)).max() < 20.0


def test_a_shoulder_that_is_raised_does_not_take_the_arm_along() -> None:
    """A skeleton's shoulders are fast to its trunk; elbows and wrists are where they were seen all the same."""
    postures = moving(KINECT25.names)
    places = postures.positions.copy()
    at = {name: k for k, name in enumerate(KINECT25.names)}
    lift = 0.08 * (np.arange(len(places)) % 20 < 10)
    for one in ("ShoulderLeft", "ShoulderRight"):
        places[:, at[one], 1] += lift
        below = places[:, at[one.replace("Shoulder", "Elbow")]]
        arm = below - places[:, at[one]]
        arm *= 0.3 / np.linalg.norm(arm, axis=1, keepdims=True)
        shift = places[:, at[one]] + arm - below
        for part in ("Elbow", "Wrist", "Hand", "HandTip", "Thumb"):
            places[:, at[one.replace("Shoulder", part)]] += shift
    found = apart(postures.with_positions(places))
    assert found[:, [at["WristLeft"], at["WristRight"]]].mean() < 0.015
    assert found.mean() < 0.015
    said = motion_of(postures.with_positions(places)).guesses
    assert any(f"{100 * found.mean():.1f} cm from the positions" in one for one in said)


def test_frames_that_a_recording_lacks_are_said() -> None:
    postures = moving(KINECT25.names)
    times = postures.times + np.where(np.arange(postures.frames) < 20, 0.0, 3.0)
    gap = Postures(postures.names, postures.positions, times)
    assert any("1.30 s of motion where the recording takes 4.30 s" in one for one in motion_of(gap).guesses)
    assert not any("even times" in one for one in motion_of(postures).guesses)
