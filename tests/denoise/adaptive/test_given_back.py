"""Motion that a repair took for noise is given back, and noise is not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend import corrupt, repair_without_model
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise.adaptive.given_back import SWINGS, given_back, said_of_swings
from motionmend.samples import clip
from performers import joints_model

FPS, FRAMES, CHANNELS = 30.0, 200, 20


def swing(rng, frames, channels, fps=FPS, pace=5.0):
    """(T, C) of about `pace` Hz and variance one, each channel at its own phase."""
    wander = 1.0 + 0.03 * np.cumsum(rng.standard_normal((frames, channels)), axis=0) / np.sqrt(fps)
    turns = np.cumsum(pace * wander, axis=0) / fps + rng.random(channels)
    return np.sqrt(2.0) * np.sin(2.0 * np.pi * turns)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_noise_stays_away(seed):
    rng = np.random.default_rng(seed)
    noise = 3.0 * rng.standard_normal((FRAMES, CHANNELS))
    believed = rng.random(noise.shape) > 0.1
    back = given_back(np.where(believed, noise, np.nan), believed, np.zeros(noise.shape), np.ones(noise.shape), FPS)
    assert back is None or np.square(back.motion).mean() < 0.02 * 9.0


@pytest.mark.parametrize("noise", [0.3, 1.0, 2.0])
def test_what_swings_in_noise_comes_back_as_near_and_as_unsure_as_is_said(rng, noise):
    motion = 2.0 * swing(rng, FRAMES, CHANNELS)
    motion[:, CHANNELS // 2 :] = 0.0  # as of somebody whose arms alone tremble
    measured = motion + noise * rng.standard_normal(motion.shape)
    believed = np.ones(motion.shape, bool)
    back = given_back(measured, believed, np.zeros(motion.shape), np.ones(motion.shape), FPS)
    assert back is not None
    shaken, still = slice(0, CHANNELS // 2), slice(CHANNELS // 2, None)
    off = np.square(back.motion - motion)[:, shaken].mean(axis=0)
    assert off.mean() < 0.35 * min(4.0, noise**2) + 0.1
    assert off.mean() == pytest.approx(back.variance[:, shaken].mean(), rel=0.7, abs=0.15)
    level = np.sqrt(np.square(measured).mean(axis=0))
    np.testing.assert_allclose((back.quieter * level)[shaken], noise, rtol=0.35)
    np.testing.assert_allclose(back.about[shaken], 5.0, atol=0.7)
    assert np.square(back.motion[:, still]).mean() < 0.15 * noise**2


def test_noise_that_is_louder_for_a_while_stays_away(rng):
    """Of so few frames the strengths go together, and some band of any channel looks like motion."""
    louder = np.ones((FRAMES, CHANNELS))
    for channel in range(CHANNELS):
        first = rng.integers(0, FRAMES - 30)
        louder[first : first + 30, channel] = 15.0
    noise = louder * rng.standard_normal(louder.shape)
    asked = noise, np.ones(noise.shape, bool), np.zeros(noise.shape)
    back, taken_for_motion = given_back(*asked, louder, FPS), given_back(*asked, np.ones(noise.shape), FPS)
    assert back is None or np.square(back.motion).sum() < 0.01 * np.square(noise).sum()
    assert taken_for_motion is not None
    assert np.square(taken_for_motion.motion).sum() > 0.02 * np.square(noise).sum()


def test_few_frames_and_channels_hardly_seen_tell_nothing(rng):
    few = swing(rng, 15, 3)
    assert given_back(few, np.ones(few.shape, bool), np.zeros(few.shape), np.ones(few.shape), FPS) is None
    hardly = swing(rng, FRAMES, 3) + 0.1 * rng.standard_normal((FRAMES, 3))
    believed = np.zeros(hardly.shape, bool)
    believed[: FRAMES // 3] = True
    assert given_back(hardly, believed, np.zeros(hardly.shape), np.ones(hardly.shape), FPS) is None


def test_the_largest_swings_are_named_first():
    (said,) = said_of_swings(np.array([0.0, SWINGS, 3.0]), np.array([0.0, 5.0, 5.0]), ("a", "b", "c"))
    assert "5.0 Hz" in said
    assert said.index("c (3.0") < said.index("b (0.5")
    assert "a (" not in said
    assert said_of_swings(np.full(3, 0.9 * SWINGS), np.ones(3), ("a", "b", "c")) == ()


def off(truth, found):
    rotation = truth.skeleton.dof_kind == ROTATION
    return np.degrees(found.q - truth.q)[:, rotation]


@pytest.mark.slow
def test_a_library_of_people_who_do_not_tremble_takes_no_tremble_away_and_says_so():
    calm = clip("walk", seconds=5.0, fps=FPS, seed=9)
    rng = np.random.default_rng(3)
    joints = calm.skeleton.dof_kind == ROTATION
    joints[:6] = False
    trembling = np.where(joints, np.radians(2.0) * swing(rng, calm.frames, len(joints)), 0.0)
    truth = replace(calm, q=calm.q + trembling)
    spoilt = corrupt(truth, noise=np.radians(0.5), seed=2).recording
    found, alone = joints_model().repair(spoilt), repair_without_model(spoilt)
    error = off(truth, found.recording)
    assert np.square(error).mean() < 1.2 * np.square(off(truth, alone.recording)).mean()
    std = np.degrees(found.std)[:, truth.skeleton.dof_kind == ROTATION]
    assert (np.abs(error) < 2.0 * std).mean() > 0.85
    assert any("swings at about" in said for said in found.warnings)
    calmly = joints_model().repair(corrupt(calm, noise=np.radians(0.5), seed=2).recording)
    assert not any("swings at about" in said for said in calmly.warnings)
