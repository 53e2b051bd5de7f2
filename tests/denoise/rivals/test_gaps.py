"""Laws of the marker gap fillers that learn from the recording."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.rivals.interpolate import linear
from motionmend.denoise.rivals.marker_gaps import LEAST_FRAMES, fill_kalman_lowdim, fill_pca
from motionmend.errors import MismatchError
from motionmend.io import read

FILLERS = {"pca": fill_pca, "kalman": fill_kalman_lowdim}
SEEDS = st.integers(0, 10**6)


def _body(rng, frames=400, markers=10, noise=0.0005):
    """Markers that sway with four smooth patterns while the body walks away; metres."""
    rest = rng.uniform(-0.2, 0.2, (markers, 3))
    sway = rng.normal(0, 0.05, (4, markers, 3))
    time = np.arange(frames)[:, None]
    phase = np.sin(time / rng.uniform(8, 40, 4) + rng.uniform(0, 6, 4))
    walk = np.stack([0.01 * time[:, 0], 0.1 * np.sin(time[:, 0] / 30), np.zeros(frames)], axis=1)
    truth = rest + np.tensordot(phase, sway, 1) + walk[:, None]
    return truth + rng.normal(0, noise, truth.shape)


def _gappy(rng, positions, gaps=6, longest=60, markers=None):
    gappy = positions.copy()
    for _ in range(gaps):
        marker = rng.integers(positions.shape[1] if markers is None else markers)
        length = rng.integers(5, longest)
        start = rng.integers(0, len(positions) - length)
        gappy[start : start + length, marker] = np.nan
    return gappy


@pytest.mark.parametrize("name", FILLERS)
@given(seed=SEEDS)
@settings(max_examples=8)
def test_measured_samples_stay_bit_for_bit(name, seed):
    rng = np.random.default_rng(seed)
    gappy = _gappy(rng, _body(rng, frames=150))
    gappy[10:20, 3, 1] = np.nan  # one coordinate alone
    found = FILLERS[name](gappy)
    measured = np.isfinite(gappy)
    np.testing.assert_array_equal(found.values[measured], gappy[measured])
    whole = measured.all(axis=2)
    assert found.values.shape == gappy.shape
    assert found.std.shape == found.filled.shape == whole.shape
    np.testing.assert_array_equal(found.filled, np.isfinite(found.values).all(axis=2) & ~whole)
    np.testing.assert_array_equal(np.isfinite(found.std), np.isfinite(found.values).all(axis=2))


@pytest.mark.parametrize("name", FILLERS)
def test_a_body_of_few_patterns_is_found_again_and_std_says_how_well(name, rng):
    truth = _body(rng)
    gappy = _gappy(rng, truth, markers=3)
    found = FILLERS[name](gappy)
    assert found.filled.any()
    error = np.sqrt(np.square(found.values - truth).mean(axis=2))[found.filled]
    flat = linear(gappy.reshape(len(gappy), -1), 120.0).values.reshape(gappy.shape)
    assert np.sqrt(np.square(error).mean()) < 0.003
    assert np.square(error).mean() < 0.1 * np.nanmean(np.square(flat - truth)[found.filled])
    assert 0.3 < np.sqrt(np.square(error / found.std[found.filled]).mean()) < 2.0
    # Noise is read off differences, which a fast sway raises somewhat.
    assert np.median(found.std[~found.filled]) < 0.002


@pytest.mark.slow
@pytest.mark.parametrize("name", FILLERS)
@given(seed=SEEDS)
@settings(max_examples=4)
def test_cleaning_commutes_with_walking_somewhere_else(name, seed):
    rng = np.random.default_rng(seed)
    gappy = _gappy(rng, _body(rng, frames=200), markers=5)
    path = np.cumsum(rng.normal(0, 0.02, (200, 1, 3)), axis=0)
    here, there = FILLERS[name](gappy), FILLERS[name](gappy + path)
    np.testing.assert_allclose(there.values, here.values + path, atol=2e-5)


def test_every_marker_may_have_gaps(rng):
    truth = _body(rng, frames=1000, markers=40)
    gappy = _gappy(rng, truth, gaps=80, longest=40)
    for marker in range(40):
        gappy[20 * marker : 20 * marker + 10, marker] = np.nan
    found = fill_pca(gappy)
    assert found.filled.sum() > 1000
    error = np.sqrt(np.square(found.values - truth).mean(axis=2))[found.filled]
    moved = np.sqrt(np.square(truth - truth.mean(axis=1, keepdims=True)).mean(axis=0).mean())
    assert np.median(error) < 0.1 * moved
    assert 0.3 < np.sqrt(np.square(error / found.std[found.filled]).mean()) < 2.0


@pytest.mark.parametrize("name", FILLERS)
def test_what_nothing_teaches_stays_open(name, rng):
    never = _body(rng, frames=100)
    never[:, 2] = np.nan
    found = FILLERS[name](never)
    assert np.isnan(found.values[:, 2]).all()
    assert not found.filled.any()
    rarely = _body(rng, frames=100)
    rarely[LEAST_FRAMES - 1 :, 2] = np.nan
    assert not FILLERS[name](rarely).filled.any()
    dark = np.full((30, 4, 3), np.nan)
    assert np.isnan(FILLERS[name](dark).values).all()


def test_a_frame_without_any_marker_stays_open(rng):
    gappy = _body(rng)
    gappy[200:210] = np.nan
    found = fill_pca(gappy)
    assert np.isnan(found.values[200:210]).all()
    assert np.isnan(found.std[200:210]).all()


@pytest.mark.parametrize("name", FILLERS)
def test_a_whole_recording_comes_back(name, rng):
    whole = _body(rng)
    found = FILLERS[name](whole)
    assert found.values.tobytes() == whole.tobytes()
    assert not found.filled.any()


@pytest.mark.parametrize("name", FILLERS)
def test_refuses_channels(name):
    with pytest.raises(MismatchError, match=r"\(frames, markers, 3\)"):
        FILLERS[name](np.zeros((10, 6)))


def test_gaps_in_a_real_walk_and_punch(data):
    for file, limit in (("cmu_02_01.c3d", 0.005), ("cmu_02_05.c3d", 0.005)):
        truth = read(data / "mocap" / "c3d" / file).positions[:, :41]
        rng = np.random.default_rng(3)
        gappy = _gappy(rng, truth, gaps=4, longest=120, markers=20)
        found = fill_pca(gappy)
        removed = np.isfinite(truth).all(axis=2) & ~np.isfinite(gappy).all(axis=2)
        assert found.filled[removed].all()
        error = np.linalg.norm(found.values - truth, axis=2)[removed]
        assert error.mean() < limit
        assert np.sqrt(np.square(error).mean() / 3) < 2 * found.std[removed].mean()


@pytest.mark.parametrize("name", FILLERS)
@pytest.mark.parametrize("shape", [(0, 4, 3), (30, 0, 3), (1, 4, 3)])
def test_nothing_in_nothing_out(name, shape):
    assert FILLERS[name](np.zeros(shape)).values.shape == shape
