"""Markers that hardly move: how little, told by the slow changes of all frames through noise that hides it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from motionmend.bodies.motion import Markers
from motionmend.denoise import repair_without_model
from motionmend.denoise.noise.barely_moving import FEWEST, PIECE, most_bends
from motionmend.evaluate import corrupt
from motionmend.samples import clip, markers

SEEDS = st.integers(0, 10**6)


def walks(bend, frames, seed, noise=1.0):
    """(T, 3) twice summed steps of deviation `bend` with noise on them."""
    rng = np.random.default_rng(seed)
    steps = bend * rng.standard_normal((frames, 3))
    return np.cumsum(np.cumsum(steps, axis=0), axis=0) + noise * rng.standard_normal((frames, 3))


@given(SEEDS, st.sampled_from([1e-4, 1e-3, 1e-2, 1e-1]), st.sampled_from([400, 1500]))
@settings(max_examples=25, deadline=None)
def test_it_is_a_bound_and_no_loose_one(seed, bend, frames):
    found = np.sqrt(most_bends(walks(bend, frames, seed)))
    if np.isfinite(found).all():
        assert (found > 0.6 * bend).all()
        assert (found < 3.0 * bend + 20.0 * (3.0 / frames) ** 2).all()  # less nobody can tell in so many frames


def test_it_is_seldom_unknown():
    known = [np.isfinite(most_bends(walks(1e-3, 600, seed))).all() for seed in range(60)]
    assert np.mean(known) > 0.9


@given(SEEDS, st.floats(0.01, 100.0), st.floats(-1e3, 1e3), st.floats(-1.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_neither_place_nor_speed_matter_and_scale_is_squared(seed, scale, place, speed):
    values = walks(1e-3, 300, seed)
    moved = scale * values + place + speed * np.arange(300.0)[:, None]
    np.testing.assert_allclose(most_bends(moved), scale**2 * most_bends(values), rtol=1e-3)


@given(SEEDS, st.sampled_from([1.5, 3.0, 12.0]))
@settings(max_examples=25, deadline=None)
def test_a_swing_is_no_walk_of_small_steps(seed, times):
    """Half as far as the noise to either side, some times in the recording: then nobody may call it still."""
    rng = np.random.default_rng(seed)
    swing = np.sin(2.0 * np.pi * (times * np.linspace(0.0, 1.0, 600)[:, None] + rng.random(3)))
    found = most_bends(swing + rng.standard_normal((600, 3)))
    true = np.var(np.diff(np.sin(2.0 * np.pi * times * np.linspace(0.0, 1.0, 600)), n=2))
    assert (found > 0.1 * true).all()


def test_few_frames_open_samples_and_constants_tell_nothing():
    values = walks(1e-3, 300, 1)
    assert np.isinf(most_bends(values[: FEWEST - 1])).all()
    assert np.isinf(most_bends(np.where(np.arange(300)[:, None] == 7, np.nan, values))).all()
    assert np.isinf(most_bends(np.zeros((300, 3)))).all()
    assert np.isinf(most_bends(np.full((100, 3), [0.1, -0.43, 1.1]))).all()  # their deviation is not quite zero


def test_long_recordings_are_looked_at_in_pieces():
    found = np.sqrt(most_bends(walks(1e-4, 2 * PIECE + 100, 3)))
    assert (found > 0.9e-4).all()
    assert (found < 2e-4).all()


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.005, 0.02])
def test_who_stands_is_smoothed_like_one_who_stands(noise):
    """Filters that people use, fitted to each marker, left 0.55 to 0.7 of what was left before."""
    stand = markers(clip("walk", seconds=1.0, fps=100.0, seed=4))
    rng = np.random.default_rng(5)
    sway = gaussian_filter1d(rng.standard_normal((600, 1, 3)), 60.0, axis=0)
    clean = Markers(stand.names[::3], stand.positions[:1, ::3] + 0.002 * sway / sway.std(), 100.0, up=stand.up)
    bad = corrupt(clean, noise=noise, outliers=0.02, seed=2).recording
    left = {
        method: np.sqrt(np.mean(np.square(repair_without_model(bad, method).recording.positions - clean.positions)))
        for method in ("adaptive", "kalman")
    }
    clean_of_outliers = corrupt(clean, noise=noise, seed=2).recording
    kalman = repair_without_model(clean_of_outliers, "kalman").recording.positions
    assert left["adaptive"] < 1.25 * np.sqrt(np.mean(np.square(kalman - clean.positions)))
    assert left["adaptive"] < left["kalman"]
