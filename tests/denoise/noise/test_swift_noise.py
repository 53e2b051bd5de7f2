"""Laws of noise that goes with speed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.channels.joints import joints_of
from motionmend.denoise.library.local_prior import Prior
from motionmend.denoise.noise import passing as passing_noise
from motionmend.denoise.noise.own_bends import first_bends
from motionmend.denoise.noise.passing import loudness
from motionmend.denoise.noise.swift import speeds
from performers import FPS, channels_of, rms, truth

SEEDS = st.integers(0, 10**6)


def _swings(rng, fps, seconds=8.0, channels=30):
    """Swings that come and go, of every size, and how fast they are: (T, C) degrees, degrees a second."""
    t = np.arange(round(seconds * fps))[:, None] / fps
    size, period = rng.uniform(1.0, 60.0, channels), rng.uniform(1.0, 3.0, channels)
    at = rng.uniform(0.0, seconds, channels)
    values = size * np.exp(-0.5 * np.square((t - at) / 2.0)) * np.sin(2 * np.pi * t / period)
    return values, np.abs(np.gradient(values, axis=0)) * fps


@pytest.mark.slow
@given(SEEDS, st.sampled_from([30.0, 60.0, 120.0]), st.sampled_from([0.0, 0.02]))
@settings(max_examples=20)
def test_noise_that_goes_with_speed_is_followed(seed, fps, share):
    rng = np.random.default_rng(seed)
    values, speed = _swings(rng, fps)
    true = np.hypot(0.5, 0.03 * speed)
    outliers = (rng.random(values.shape) < share) * rng.choice([-1.0, 1.0], values.shape) * 40.0
    found = loudness(values + true * rng.normal(size=values.shape) + outliers, fps)
    fast, slow = true > 1.5, true < 0.6
    told = np.median(found[fast]) / np.median(found[slow])
    # outliers make slow moments look noisier too
    assert (0.3 if share else 0.45) < told / (np.median(true[fast]) / np.median(true[slow])) < 1.3


@pytest.mark.slow
@given(SEEDS, st.sampled_from([30.0, 120.0]), st.sampled_from([0.5, 1.0, 3.0]), st.sampled_from([0.0, 0.1]))
@settings(max_examples=20)
def test_noise_that_stays_does_not_go_with_speed(seed, fps, noise, share):
    rng = np.random.default_rng(seed)
    values, speed = _swings(rng, fps)
    outliers = (rng.random(values.shape) < share) * rng.choice([-1.0, 1.0], values.shape) * 40.0
    found = loudness(values + noise * rng.normal(size=values.shape) + outliers, fps)
    fast = speed > np.quantile(speed, 0.9)
    assert 0.85 < np.median(found[fast]) / np.median(found[~fast]) < 1.2


@pytest.mark.parametrize("action", ["walk", "run", "jump"])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_what_moves_fast_is_no_noise_for_that(action, noise, monkeypatch, rng):
    values = channels_of(truth(action))
    noisy = values + noise * rng.normal(size=values.shape)
    found = loudness(noisy, FPS)
    monkeypatch.setattr(passing_noise, "goes_with_speed", lambda level, *_: np.zeros(level.shape))
    np.testing.assert_allclose(found, loudness(noisy, FPS), rtol=0.2)


@given(SEEDS)
@settings(max_examples=10)
def test_of_several_speeds_the_one_counts_that_noise_goes_with(seed):
    """Of the third angle of each joint, which hardly moves, the noise is that of the other two."""
    rng, fps = np.random.default_rng(seed), 60.0
    values, speed = _swings(rng, fps)
    joints = np.arange(30) // 3
    still = np.arange(30) % 3 == 2
    values, speed = np.where(still, 0.02 * values, values), np.where(still, 0.02 * speed, speed)
    all_of_joint = np.sqrt(np.square(speed).reshape(-1, 10, 3).sum(axis=2)).repeat(3, axis=1)
    true = np.hypot(0.5, 0.03 * all_of_joint)
    found = loudness(values + true * rng.normal(size=values.shape), fps, joints=joints)
    fast, slow = still & (true > 1.5), still & (true < 0.6)
    assert np.median(found[fast]) > 1.7 * np.median(found[slow])


def test_markers_may_be_noisier_the_faster_they_move_about_the_body(rng):
    """All travel at 2 m/s; only what swings is noisier while it does."""
    fps = 120.0
    values, _ = _swings(rng, fps, channels=36)
    values[:, :18] *= 0.01
    own = (
        np.sqrt(np.square(np.gradient(values, axis=0)).reshape(len(values), -1, 3).sum(axis=2)).repeat(3, axis=1) * fps
    )
    true = np.hypot(0.1, 0.005 * own)
    travel = 200.0 / fps * np.arange(len(values))[:, None] * (np.arange(36) % 3 == 0)
    found = loudness(values + travel + true * rng.normal(size=values.shape), fps, together=3)
    fast, slow = true > 0.3, true < 0.12
    assert np.median(found[fast]) > 1.8 * np.median(found[slow])


@given(SEEDS)
@settings(max_examples=10)
def test_lone_outliers_and_gaps_are_no_speed(seed):
    rng = np.random.default_rng(seed)
    values, speed = _swings(rng, 120.0)
    spoilt = np.where(rng.random(values.shape) < 0.02, values + 50.0, values)
    spoilt[rng.random(values.shape) < 0.02] = np.nan
    (found,) = speeds(spoilt, np.zeros(values.shape), 120.0, 1, None)
    assert np.quantile(np.abs(found - speed), 0.99) < 0.2 * speed.max()


def test_joints_are_told_apart_and_a_roots_turns_from_its_moves():
    skeleton = truth().skeleton
    columns = np.append(np.arange(len(skeleton.dof_joint)), [-1, -1])
    joints = joints_of(skeleton, columns)
    alike = joints[:, None] == joints
    for one, other in np.argwhere(alike):
        if one != other:
            assert one < len(columns) - 2
            assert skeleton.dof_joint[one] == skeleton.dof_joint[other]
            assert skeleton.dof_kind[one] == skeleton.dof_kind[other]


def test_a_repair_errs_less_for_following_speed(monkeypatch):
    errors = []
    for follow in (True, False):
        if not follow:
            monkeypatch.setattr(passing_noise, "goes_with_speed", lambda level, *_: np.zeros(level.shape))
        rng = np.random.default_rng(3)
        values, speed = _swings(rng, FPS, channels=len(channels_of(truth())[0]))
        noisy = values + (0.4 + 0.03 * speed) * rng.normal(size=values.shape)
        errors.append(rms(_without_library(noisy) - values))
    assert errors[0] < 0.9 * errors[1]


def _without_library(noisy):
    return mend_channels(noisy, Prior(first_bends(noisy, FPS), None), FPS).found.values
