"""Footskate clean-up: standing feet stand still, knees do not pop, and nothing else is touched."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from bipeds import biped, walk
from motionmend.bodies.feet import contacts, foot_joints, skate_during
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import ROTATION, positions
from motionmend.denoise.footskate import plants as footplants
from motionmend.denoise.footskate.clean_up import clean_footskate
from motionmend.errors import MismatchError, UsageError
from motionmend.io import read


def leg_dofs(body):
    """The rotations from hip to ankle of both legs."""
    feet = foot_joints(body)
    joints = {*feet.hips, *feet.knees, *feet.ankles}
    return np.array([d for d, j in enumerate(body.dof_joint) if j in joints and body.dof_kind[d] == ROTATION])


def slow_noise(shape, fps, below, rng):
    """Noise of deviation 1 without what is faster than `below` Hz."""
    noise = gaussian_filter1d(rng.normal(size=shape), fps / (2 * np.pi * below), axis=0)
    return noise / noise.std()


def shaken(motion, rng, degrees=2.5):
    """The legs off by slow noise, as filters leave it behind."""
    dofs, q = leg_dofs(motion.skeleton), motion.q.copy()
    q[:, dofs] += np.radians(degrees) * slow_noise((motion.frames, len(dofs)), motion.fps, 1.5, rng)
    return motion.with_q(q)


def drifting(motion, rng, metres=0.06):
    """The root wandering, mostly level."""
    q = motion.q.copy()
    level = 1 - 0.8 * np.abs(motion.skeleton.up)
    q[:, :3] += metres * level * slow_noise((motion.frames, 3), motion.fps, 0.5, rng)
    return motion.with_q(q)


def feet_of(motion):
    """Places (T, P, 3) m of ankles and toes."""
    return positions(motion.skeleton, motion.q)[:, foot_joints(motion.skeleton).joints]


def knee_acceleration(motion):
    """The largest angular acceleration of a knee, rad/s²."""
    places, feet = positions(motion.skeleton, motion.q), foot_joints(motion.skeleton)
    largest = 0.0
    for hip, knee, ankle in zip(feet.hips, feet.knees, feet.ankles, strict=True):
        thigh, shank = places[:, hip] - places[:, knee], places[:, ankle] - places[:, knee]
        cosine = (thigh * shank).sum(axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        largest = max(largest, float(np.abs(np.diff(angle, 2)).max()) * motion.fps**2)
    return largest


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [shaken, drifting])
@pytest.mark.parametrize("clip", ["amc/07/07_01.amc", "amc/16/16_01.amc", "amc/05/05_02.amc", "bvh/12_01.bvh"])
def test_real_clips_stand_better_than_the_truth_and_knees_do_not_pop(data, clip, spoil, rng):
    """Judged by the clean clip's contacts. Feet may move by a few noises, the root hardly.

    Knees may accelerate half as much again as they did; 400 rad/s² is what they have in any landing.
    """
    truth = read(data / "mocap" / clip)
    spoiled = spoil(truth, rng)
    cleaned = clean_footskate(spoiled)
    body, fps = truth.skeleton, truth.fps
    standing = contacts(feet_of(truth), fps, body.up)
    before, after, best = (skate_during(feet_of(m), standing, fps, body.up) for m in (spoiled, cleaned.motion, truth))
    assert before > 1.3 * best
    assert after <= best
    assert cleaned.skate_after < 0.5 * cleaned.skate_before
    usual = max(knee_acceleration(spoiled), knee_acceleration(truth))
    assert knee_acceleration(cleaned.motion) <= max(1.5 * usual, 400.0)
    moved_root = positions(body, cleaned.motion.q)[:, 0] - positions(body, spoiled.q)[:, 0]
    assert np.linalg.norm(moved_root, axis=1).max() < 0.06
    assert np.median(cleaned.moved) < 0.1


@pytest.mark.slow
def test_a_clean_real_clip_is_hardly_changed(data):
    """What needs little gets little: half the frames of a clean walk move by less than 0.015 m."""
    for clip in ("07/07_01", "16/16_01", "09/09_01"):
        truth = read(data / "mocap" / "amc" / f"{clip}.amc")
        cleaned = clean_footskate(truth)
        assert np.median(cleaned.moved) < 0.015
        assert cleaned.moved.max() < 0.07


@pytest.mark.slow
@settings(max_examples=6)
@given(st.integers(0, 2**32 - 1), st.sampled_from([30.0, 60.0, 120.0]), st.sampled_from([1, 2]))
def test_a_shaken_walk_stands_still_and_its_steps_come_back(seed, fps, up):
    """With the true contacts the feet stand, and legs come nearer to the walk they were made from."""
    truth, stands = walk(3.0, fps, up=up)
    spoiled = shaken(truth, np.random.default_rng(seed), degrees=2.0)
    cleaned = clean_footskate(spoiled, contacts=stands)
    up_way = truth.skeleton.up
    assert skate_during(feet_of(spoiled), stands, fps, up_way) > 0.05
    assert skate_during(feet_of(cleaned.motion), stands, fps, up_way) < 0.05
    assert cleaned.skate_after == pytest.approx(skate_during(feet_of(cleaned.motion), stands, fps, up_way))


def test_only_legs_and_the_roots_place_change_and_only_near_contacts(rng):
    """Bit for bit: arms and root angles always, whole frames further from contacts than the blend."""
    truth, stands = walk(6.0)
    spoiled = shaken(truth, rng)
    window = np.zeros(truth.frames, dtype=bool)
    window[150:210] = True
    cleaned = clean_footskate(spoiled, contacts=stands & window[:, None], blend_s=0.25)
    away = np.ones(truth.frames, dtype=bool)
    away[150 - 15 : 210 + 15] = False
    assert cleaned.motion.q[away].tobytes() == spoiled.q[away].tobytes()
    assert (cleaned.moved[away] == 0).all()
    assert cleaned.moved[~away].max() > 0.005
    body = truth.skeleton
    toes = np.flatnonzero(np.isin(body.dof_joint, foot_joints(body).toes))
    others = np.setdiff1d(np.arange(len(body.dof_names)), [0, 1, 2, *leg_dofs(body), *toes])
    assert cleaned.motion.q[:, others].tobytes() == spoiled.q[:, others].tobytes()


def test_without_contacts_nothing_changes(rng):
    """And there is no skate to report."""
    spoiled = shaken(walk(2.0)[0], rng)
    cleaned = clean_footskate(spoiled, contacts=np.zeros((spoiled.frames, 4), dtype=bool))
    assert cleaned.motion.q.tobytes() == spoiled.q.tobytes()
    assert (cleaned.moved == 0).all()
    assert np.isnan(cleaned.skate_before)
    assert np.isnan(cleaned.skate_after)


def test_feet_that_stand_already_stay_where_they_are():
    """A walk without skate comes back to within a tenth of a millimetre at the feet."""
    truth, stands = walk(3.0)
    cleaned = clean_footskate(truth, contacts=stands)
    assert np.abs(feet_of(cleaned.motion) - feet_of(truth)).max() < 1e-4


def test_cleaning_commutes_with_walking_somewhere_else(rng):
    """The same motion started elsewhere is cleaned alike."""
    spoiled = shaken(walk(2.0)[0], rng)
    elsewhere = spoiled.q.copy()
    step = np.array([3.0, 0.5, -7.0])
    elsewhere[:, :3] += step
    here, there = clean_footskate(spoiled), clean_footskate(spoiled.with_q(elsewhere))
    np.testing.assert_array_equal(here.contacts, there.contacts)
    np.testing.assert_allclose(there.motion.q[:, :3] - step, here.motion.q[:, :3], atol=1e-6)
    np.testing.assert_allclose(there.motion.q[:, 3:], here.motion.q[:, 3:], atol=1e-5)


@pytest.mark.slow
def test_the_change_sets_in_without_a_jump(rng):
    """Around contacts the change of every joint's place goes on smoothly: no step larger than a foot's own noise."""
    truth, stands = walk(4.0, 120.0)
    spoiled = shaken(truth, rng)
    cleaned = clean_footskate(spoiled, contacts=stands)
    body = truth.skeleton
    change = positions(body, cleaned.motion.q) - positions(body, spoiled.q)
    jerkiest = np.linalg.norm(np.diff(change, axis=0), axis=2).max() * 120.0
    assert jerkiest < 1.2  # m/s; the noise itself moves feet at up to 0.6 m/s


def test_unknown_frames_stay_unknown(rng):
    """NaN in the legs or the root: the frame comes back as it was, its neighbours are still cleaned."""
    truth, stands = walk(3.0)
    q = shaken(truth, rng).q.copy()
    body = truth.skeleton
    knee, arm = body.dof_names.index("LeftLeg.rx"), body.dof_names.index("Arm.rz")
    q[40:50, knee] = np.nan
    q[90, 1] = np.nan
    q[100:120, arm] = np.nan
    cleaned = clean_footskate(truth.with_q(q), contacts=stands)
    np.testing.assert_array_equal(np.isnan(cleaned.motion.q), np.isnan(q))
    unknown = np.isnan(q[:, [knee, 1]]).any(axis=1)
    assert cleaned.motion.q[unknown].tobytes() == q[unknown].tobytes()
    assert np.isnan(cleaned.moved[unknown]).all()
    assert np.isfinite(cleaned.moved[~unknown]).all()
    assert not cleaned.contacts[unknown].any()
    assert cleaned.skate_after < 0.5 * cleaned.skate_before


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(data, rng):
    """Twice, on a real clip."""
    spoiled = shaken(read(data / "mocap" / "amc" / "07" / "07_01.amc"), rng)
    assert clean_footskate(spoiled).motion.q.tobytes() == clean_footskate(spoiled).motion.q.tobytes()


def test_a_foot_without_toes_is_held_by_its_ankle(rng):
    """Skeletons that end at the ankle: two points in all."""
    body = biped(("LeftUpLeg", "LeftLeg", "LeftFoot"))
    q = np.zeros((90, len(body.dof_names)))
    q[:, 1] = 0.88
    for name in ("LeftLeg.rx", "RightLeg.rx"):
        q[:, body.dof_names.index(name)] = 0.5
    for name in ("LeftUpLeg.rx", "RightUpLeg.rx"):
        q[:, body.dof_names.index(name)] = -0.25
    cleaned = clean_footskate(shaken(Motion(body, q, 30.0), rng))
    assert cleaned.points == ("LeftFoot", "RightFoot")
    assert cleaned.contacts.mean() > 0.9
    assert cleaned.skate_after < 0.2 * cleaned.skate_before


def test_a_foot_that_turns_on_the_spot_is_not_wrung():
    """Ball and ankle stand for long on both sides of a turn by 90 degrees: the ball is let go, the ankle held."""
    time = np.linspace(0, 4, 241)
    heading = np.radians(90) * np.clip((time - 1.5), 0, 1)
    ankle = np.zeros((241, 3))
    ball = 0.14 * np.stack((np.cos(heading), np.zeros(241), np.sin(heading)), axis=1)
    held = footplants._plants([ankle, ball], [np.ones(241, dtype=bool)] * 2, np.array([0.0, 1.0, 0.0]), 60.0)
    footplants._let_turn(held, [ankle, ball])
    both = np.isfinite(held[1][:, 0])
    planned, was = held[1][both] - held[0][both], ball[both]
    cosine = (planned * was).sum(axis=1) / np.linalg.norm(planned, axis=1) / np.linalg.norm(was, axis=1)
    assert np.isfinite(held[0]).all()
    assert (np.degrees(np.arccos(np.clip(cosine, -1, 1))) <= 40.0 + 1e-6).all()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.integers(1, 20))
def test_blending_keeps_what_is_known_and_ends_within_the_window(seed, window):
    """Known changes stay bit for bit, beyond the window there is none, and a constant change between is kept."""
    rng = np.random.default_rng(seed)
    known = np.repeat(rng.random(12) < 0.4, rng.integers(1, 9, size=12))
    usable = np.ones(len(known), dtype=bool)
    change = np.where(known[:, None], rng.normal(size=(len(known), 3)), 0.0)
    blended = footplants._blend(change, known, usable, window)
    assert blended[known].tobytes() == change[known].tobytes()
    reach = np.convolve(known, np.ones(2 * window + 1), mode="full")[window : window + len(known)] > 0
    assert (blended[~reach] == 0).all()
    ones = footplants._blend(known[:, None] * np.ones(3), known, usable, window)
    assert (ones >= 0).all()
    assert (ones <= 1 + 1e-12).all()


def test_what_does_not_fit_is_said():
    """One line, with what came."""
    motion, stands = walk(1.0)
    with pytest.raises(UsageError, match="above 0 s"):
        clean_footskate(motion, blend_s=0.0)
    with pytest.raises(MismatchError, match=r"LeftFoot, LeftToeBase, RightFoot, RightToeBase"):
        clean_footskate(motion, contacts=stands[:, :2])
    stump = biped(("LeftUpLeg", "LeftFoot"))
    with pytest.raises(MismatchError, match="hip and knee"):
        clean_footskate(Motion(stump, np.zeros((5, len(stump.dof_names))), 30.0))
