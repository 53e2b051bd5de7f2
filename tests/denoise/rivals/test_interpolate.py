"""Laws of the gap fillers that look at one channel only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.rivals.interpolate import linear, spline

FILLERS = {"linear": linear, "spline": spline}
SEEDS = st.integers(0, 10**6)


def _gappy(rng, values, share=0.15, longest=25):
    gappy = values.copy()
    while np.isnan(gappy).mean() < share:
        channel, length = rng.integers(values.shape[1]), rng.integers(1, longest)
        start = rng.integers(1, len(values) - length - 1)
        gappy[start : start + length, channel] = np.nan
    gappy[[0, -1]] = values[[0, -1]]
    return gappy


@pytest.mark.slow
@pytest.mark.parametrize("name", FILLERS)
@given(seed=SEEDS)
@settings(max_examples=20)
def test_measured_samples_stay_bit_for_bit(name, seed):
    rng = np.random.default_rng(seed)
    values = _gappy(rng, rng.normal(size=(80, 4)))
    found = FILLERS[name](values, 30.0)
    measured = np.isfinite(values)
    np.testing.assert_array_equal(found.values[measured], values[measured])
    assert np.isfinite(found.values).all()


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=20)
def test_linear_is_what_numpy_interpolates(seed):
    rng = np.random.default_rng(seed)
    values = _gappy(rng, rng.normal(size=(60, 3)))
    frames = np.arange(60)
    for c in range(3):
        known = np.isfinite(values[:, c])
        expected = np.interp(frames, frames[known], values[known, c])
        np.testing.assert_allclose(linear(values, 30.0).values[:, c], expected, atol=1e-12)


def test_spline_follows_cubics_through_any_gap():
    time = np.linspace(-1, 1, 80)[:, None]
    curve = time**3 - 0.5 * time**2 + 2
    gappy = curve.copy()
    gappy[20:50] = np.nan
    np.testing.assert_allclose(spline(gappy, 30.0).values, curve, atol=1e-10)


@pytest.mark.parametrize("name", FILLERS)
def test_gaps_at_the_ends_stay_open(name):
    values = np.arange(40.0)[:, None] * np.ones(3)
    values[:5, 0] = values[-7:, 1] = values[:, 2] = np.nan
    found = FILLERS[name](values, 30.0)
    np.testing.assert_array_equal(np.isnan(found.values), np.isnan(values))
    assert not found.filled.any()


@pytest.mark.parametrize("name", FILLERS)
def test_std_is_the_error_of_gaps_as_long(name, rng):
    truth = np.cumsum(np.cumsum(rng.normal(0, 0.05, (3000, 6)), axis=0), axis=0)
    truth -= np.linspace(0, 1, 3000)[:, None] * truth[-1]
    values = _gappy(rng, truth + rng.normal(0, 0.1, truth.shape), longest=40)
    found = FILLERS[name](values, 60.0)
    z = ((found.values - truth) / found.std)[found.filled]
    assert 0.5 < np.sqrt(np.square(z).mean()) < 1.4
    assert found.std[np.isfinite(values)].mean() == pytest.approx(0.1, rel=0.1)


def test_std_of_a_walk_is_that_of_a_brownian_bridge(rng):
    truth = np.cumsum(rng.normal(size=(6000, 8)), axis=0)
    values = truth.copy()
    values[3000:3015] = np.nan
    share = np.arange(1, 16) / 16
    bridge = np.sqrt(16 * share * (1 - share))
    found = linear(values, 30.0).std[3000:3015]
    np.testing.assert_allclose(found.mean(axis=1), bridge, rtol=0.15)


def test_std_of_a_gap_too_long_to_try_grows_on(rng):
    values = np.cumsum(rng.normal(size=(200, 1)), axis=0)
    values[40:160] = np.nan
    found = linear(values, 30.0)
    assert np.isfinite(found.std).all()
    short = values.copy()
    short[45:155] = np.linspace(values[39], values[160], 110) + rng.normal(size=(110, 1))
    assert found.std[100, 0] > linear(short, 30.0).std[42, 0]
