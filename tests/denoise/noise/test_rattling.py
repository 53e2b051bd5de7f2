"""A single channel that rattles for a moment is told from motion, from lone outliers and from common noise."""

import numpy as np
import pytest

import motionmend as mm
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise.channels.joints import joints_of
from motionmend.denoise.noise.rattling import but_for_poses, rattles
from motionmend.denoise.outliers.as_pose import of_one_limb

FPS, FRAMES, CHANNELS = 120.0, 400, 30


@pytest.fixture
def measured():
    """(T, C) degrees: swings with a little noise."""
    rng = np.random.default_rng(4)
    time = np.arange(FRAMES)[:, None] / FPS
    swing = 30.0 * np.sin(2.0 * np.pi * rng.uniform(1.0, 4.0, CHANNELS) * time + rng.uniform(0.0, 6.0, CHANNELS))
    return swing + 0.3 * rng.standard_normal(swing.shape)


def test_where_and_how_loud(measured):
    measured[100:130, 7] += 15.0 * np.random.default_rng(1).standard_normal(30)
    found = rattles(measured, FPS)
    assert (found[102:128, 7] > 0).all()
    assert np.median(found[102:128, 7]) == pytest.approx(15.0, rel=0.4)
    assert not np.delete(found, 7, axis=1).any()
    assert not found[:94, 7].any()
    assert not found[135:, 7].any()


def test_a_marker_rattles_as_a_whole(measured):
    measured[100:130, 7] += 15.0 * np.random.default_rng(1).standard_normal(30)
    found = rattles(measured, FPS, 3)
    assert (found[102:128, 6:9] > 0).all()
    assert not np.delete(found, [6, 7, 8], axis=1).any()


def test_none_in_motion_lone_outliers_slips_and_common_noise(measured):
    assert not rattles(measured, FPS).any()
    rng = np.random.default_rng(5)
    lone = measured + 40.0 * (rng.random(measured.shape) < 0.02)
    assert (rattles(lone, FPS) > 0).mean() < 0.002
    slipped = measured.copy()
    slipped[100:130, 7] += 40.0
    assert not rattles(slipped, FPS).any()
    assert not rattles(measured + 5.0 * rng.standard_normal(measured.shape), FPS).any()


@pytest.mark.slow
def test_a_joint_that_rattles_is_repaired():
    clean = mm.samples.clip("walk", seconds=4, fps=120.0, seed=3)
    rng = np.random.default_rng(0)
    bad = clean.q + np.radians(0.3) * rng.standard_normal(clean.q.shape) * (np.ptp(clean.q, axis=0) > 1e-3)
    knee = next(c for c, name in enumerate(clean.channels) if "tibia" in name or "knee" in name.lower())
    bad[200:236, knee] += np.radians(18.0) * rng.standard_normal(36)
    repaired = mm.repair_without_model(clean.with_q(bad), "adaptive")
    off = np.degrees(repaired.recording.q - clean.q)[202:234, knee]
    assert np.sqrt(np.square(off).mean()) < 4.0  # before: as it was, 17
    assert (repaired.origin[202:234, knee] == mm.Origin.REPAIRED).all()
    assert (np.abs(off) < 2.5 * np.degrees(repaired.std[202:234, knee])).mean() > 0.8


def test_bursts_in_many_channels_of_a_short_clip_are_all_found(measured):
    short, rng = measured[:120].copy(), np.random.default_rng(3)
    bursts = {channel: int(rng.integers(5, 85)) for channel in range(0, CHANNELS, 3)}
    for channel, first in bursts.items():
        short[first : first + 30, channel] += 20.0 * rng.standard_normal(30)
    found = rattles(short, FPS) > 0
    for channel, first in bursts.items():
        assert found[first + 3 : first + 27, channel].all()
    assert not found[:, [channel for channel in range(CHANNELS) if channel not in bursts]].any()


def test_a_channel_that_rattles_for_most_of_a_short_clip_is_told_by_the_others(measured):
    short = measured[:120].copy()
    short[20:100, 7] += 20.0 * np.random.default_rng(2).standard_normal(80)
    found = rattles(short, FPS) > 0
    assert found[24:96, 7].all()
    assert not np.delete(found, 7, axis=1).any()


def test_lone_outliers_near_each_other_are_no_rattle(measured):
    measured[[100, 103, 106, 109]] += 40.0
    assert (rattles(measured, FPS) > 0).any(axis=0).mean() < 0.1  # only of the fastest swings, which are no parabolas


def rattling_limb(seed):
    """A spoilt walk of 240 frames, (T, C) degrees; what rattles in it, and the two channels that do."""
    clip = mm.samples.clip("walk", seconds=2, fps=FPS, seed=seed)
    rng = np.random.default_rng(seed)
    q = np.degrees(clip.q)
    rows = np.flatnonzero((clip.skeleton.dof_kind == ROTATION) & (np.ptp(q, axis=0) > 5.0))
    one, other = rows[0], next(r for r in rows[::-1] if clip.skeleton.dof_joint[r] != clip.skeleton.dof_joint[rows[0]])
    shaken = np.zeros(q.shape)
    for channel in (one, other):
        q[100:130, channel] += 20.0 * rng.standard_normal(30)
        shaken[100:130, channel] = 20.0
    return clip.skeleton, q, shaken, one, other


def test_what_passes_for_a_pose_in_a_frame_or_two_by_chance_is_none():
    skeleton, q, shaken, one, other = rattling_limb(1)
    vouched = np.zeros(q.shape, dtype=bool)
    vouched[115, one] = True
    never = lambda measured, rejected, values: np.zeros(rejected.shape, dtype=bool)  # noqa: E731
    columns = np.arange(q.shape[1])
    limb = of_one_limb(skeleton, columns)
    kept = but_for_poses(shaken, q, vouched, never, joints_of(skeleton, columns), limb)
    np.testing.assert_array_equal(kept, shaken)
    vouched[104:126, one] = True  # most of the time: there only the angles rattle
    kept = but_for_poses(shaken, q, vouched, never, joints_of(skeleton, columns), limb)
    assert not kept[:, one].any()
    assert kept[:, other].any() != limb[one, other]


def test_what_another_joint_of_the_limb_undoes_is_left():
    skeleton, q, shaken, _, other = rattling_limb(2)
    columns = np.arange(q.shape[1])
    limb = of_one_limb(skeleton, columns)
    undoes = next(c for c in np.flatnonzero(limb[other]) if skeleton.dof_joint[c] != skeleton.dof_joint[other])
    alone = np.where(columns == other, shaken, 0.0)
    never = lambda measured, rejected, values: np.zeros(rejected.shape, dtype=bool)  # noqa: E731
    nowhere = np.zeros(q.shape, dtype=bool)
    calm = q.copy()
    calm[100:130] = q[99]
    calm[100:130, other] = q[100:130, other]
    assert but_for_poses(alone, calm, nowhere, never, joints_of(skeleton, columns), limb)[:, other].any()
    calm[100:130, undoes] -= calm[100:130, other] * 1.5
    assert not but_for_poses(alone, calm, nowhere, never, joints_of(skeleton, columns), limb).any()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 4, 6])
def test_short_clips_full_of_bursts_come_out_better_than_smoothed(seed):
    clean = mm.samples.clip("walk", seconds=1.5, fps=FPS, seed=seed)
    rng = np.random.default_rng(seed)
    moving = np.flatnonzero((np.ptp(clean.q, axis=0) > 0.02) & (clean.skeleton.dof_kind == ROTATION))
    bad = clean.q + np.radians(0.3) * rng.standard_normal(clean.q.shape) * (np.ptp(clean.q, axis=0) > 1e-3)
    for channel in rng.permutation(moving)[: len(moving) // 2]:
        first, length = rng.integers(0, 130), rng.integers(15, 48)
        some = bad[first : first + length, channel]
        some += np.radians(rng.uniform(8.0, 30.0)) * rng.standard_normal(len(some))
    spoilt = clean.with_q(bad)

    def error(method):
        away = mm.repair_without_model(spoilt, method).recording.q[:, moving] - clean.q[:, moving]
        return float(np.sqrt(np.square(away).mean()))

    assert error("adaptive") < 0.9 * error("kalman")
