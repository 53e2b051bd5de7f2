"""Laws of recordings that were rounded, and what a repair makes of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.joints import unit
from motionmend.denoise.noise.digits import coarseness, rounding, run_lengths
from motionmend.samples import markers
from performers import joints_model, markers_model, truth

SEEDS = st.integers(0, 10**6)


def _cloud(values):
    """(T, 3 M) cm as markers."""
    places = np.asarray(values).reshape(len(values), -1, 3) / 100.0
    return Markers([f"m{i}" for i in range(places.shape[1])], places, 60.0)


def _walk(rng, frames=200, columns=12):
    return 50.0 + np.cumsum(np.cumsum(rng.normal(0, 0.05, (frames, columns)), axis=0), axis=0)


def _rounded(motion, step):
    """To so many degrees, and cm."""
    scale = unit(motion.skeleton)
    return motion.with_q(np.round(motion.q * scale / step) * step / scale)


def _rounded_markers(recording, step):
    """To so many cm."""
    return recording.with_positions(np.round(100.0 * recording.positions / step) * step / 100.0)


@given(SEEDS, st.floats(0.05, 3.0), st.sampled_from([np.float64, np.float32]), st.integers(30, 300))
@settings(max_examples=40)
def test_the_step_of_what_was_rounded_is_found(seed, step, kind, frames):
    rng = np.random.default_rng(seed)
    values = _walk(rng, frames) + rng.normal(0, 0.5 * step, (frames, 12))
    values += (rng.random(values.shape) < 0.05) * rng.uniform(15, 55, values.shape)
    found = coarseness(_cloud((np.round(values / step) * step).astype(kind)))
    np.testing.assert_allclose(found, step, rtol=1e-2)


@given(SEEDS, st.integers(1, 300))
@settings(max_examples=40)
def test_what_was_not_rounded_has_no_step(seed, frames):
    recording = _cloud(_walk(np.random.default_rng(seed), frames))
    assert coarseness(recording).max() < 0.001
    assert rounding(recording, np.arange(4)) is None


def test_channels_at_rest_take_the_step_of_the_others(rng):
    values = np.round(_walk(rng) / 0.5) * 0.5
    values[:, 0], values[:, 4] = 7.0, np.where(np.arange(200) < 90, 7.0, 7.5)
    values[:, 7] = np.nan
    np.testing.assert_allclose(coarseness(_cloud(values)), 0.5, rtol=1e-6)


def test_degrees_and_centimetres_are_asked_apart():
    motion = _rounded(truth("walk"), 0.5)
    rotation = motion.skeleton.dof_kind == ROTATION
    moved = motion.with_q(np.where(rotation, motion.q, truth("walk").q))
    found = coarseness(moved)
    np.testing.assert_allclose(found[rotation], 0.5, rtol=1e-6)
    assert (found[~rotation] < 0.01).all()


def test_runs_are_as_long_as_they_are():
    values = np.array([[1.0, 1.0, 2.0, 2.0, 2.0, np.nan, np.nan, 2.0]]).T
    np.testing.assert_array_equal(run_lengths(values)[:, 0], [2, 2, 3, 3, 3, 1, 1, 1])


def test_what_repeats_tells_less(rng):
    values = np.round(_walk(rng) / 0.5) * 0.5
    values[100:160, :3] = 40.0
    open_ = rounding(_cloud(values), np.array([0, 3, -1]))
    assert open_ is not None
    found = open_(slice(90, 150))
    assert found.shape == (60, 9)
    assert (found[:, :6] >= 0.5**2 / 12.0 - 1e-9).all()
    assert found[20, 0] > 2.0 * 0.5**2 / 12.0
    assert (found[:, 6:] == 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("library", [True, False])
def test_a_rounded_recording_is_as_wrong_as_it_says_and_less_than_it_was(fps, step, library):
    clean = truth("walk", fps=fps, seconds=4.0)
    recorded = _rounded(clean, step)
    repair = joints_model().repair if library else repair_without_model
    found = repair(recorded, "adaptive")
    moving = (clean.skeleton.dof_kind == ROTATION) & (np.degrees(clean.q).std(axis=0) > 1.0)
    away = np.degrees(np.abs(found.recording.q - clean.q))[:, moving]
    std = np.degrees(found.std)[:, moving]
    before = np.degrees(np.abs(recorded.q - clean.q))[:, moving]
    assert np.mean(np.square(away)) < np.mean(np.square(before))
    assert 0.58 < np.mean(away < std) < 0.9
    assert np.mean(away < 1.96 * std) > 0.83


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_rounded_markers_are_as_wrong_as_they_say_and_less_than_they_were(library):
    clean = markers(truth("walk", seconds=4.0))
    recorded = _rounded_markers(clean, 0.5)
    found = (markers_model().repair if library else repair_without_model)(recorded, "adaptive")
    away = np.abs(found.recording.positions - clean.positions)
    assert np.mean(np.square(away)) < 0.7 * np.mean(np.square(recorded.positions - clean.positions))
    assert 0.58 < np.mean(away < found.std[..., None]) < 0.9
    assert np.mean(away < 1.96 * found.std[..., None]) > 0.83


@pytest.mark.slow
def test_what_was_rounded_and_moves_slowly_was_not_held():
    slow = truth("reach", fps=120.0, seconds=4.0)
    found = repair_without_model(_rounded(replace(slow, q=slow.q), 1.0), "adaptive")
    assert (found.origin == Origin.REPAIRED).mean() < 0.002
    assert not any("repeat" in said for said in found.warnings)
