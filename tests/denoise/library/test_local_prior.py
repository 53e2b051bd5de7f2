"""Bases of the windows most like a recording."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.library import local_prior
from motionmend.denoise.library.local_prior import ENERGY, FEWER, SPARE, _few_window_bases

FRAMES, CHANNELS = 8, 25


def _windows(rng, count, kinds):
    """Windows of a few kinds of motion and some noise, and patterns (K, M, C) of most of the kinds."""
    patterns = np.linalg.qr(rng.normal(size=(FRAMES * CHANNELS, kinds)))[0].T
    size = 10.0 * 0.7 ** np.arange(kinds)
    flat = rng.normal(size=(count, kinds)) * size @ patterns + rng.normal(0, 1e-3, (count, FRAMES * CHANNELS))
    return 3.0 + flat.reshape(count, FRAMES, CHANNELS), patterns[: kinds - 2].reshape(-1, FRAMES, CHANNELS)


@given(st.integers(0, 10**6), st.integers(3, 12))
@settings(max_examples=15, deadline=None)
def test_bases_sought_near_known_patterns_are_those_of_all_inner_products(seed, kinds):
    """Also where the known patterns lack some that the windows have."""
    windows, alike = _windows(np.random.default_rng(seed), 300, kinds)
    assert FEWER * (len(alike) + SPARE) < min(300, FRAMES * CHANNELS)
    found = _few_window_bases(windows, alike)
    whole = _few_window_bases(windows, np.zeros((300, FRAMES, CHANNELS)))  # too many to be sought near
    assert found.count == whole.count
    assert found.energy >= ENERGY - 1e-6
    np.testing.assert_allclose(found.values, whole.values, rtol=1e-5)
    np.testing.assert_allclose(found.discarded, whole.discarded, rtol=1e-3, atol=1e-6)
    one, other = (bases.vectors.reshape(bases.count, -1) for bases in (found, whole))
    np.testing.assert_allclose(one @ one.T, np.eye(len(one)), atol=1e-9)
    np.testing.assert_allclose(np.linalg.svd(one @ other.T, compute_uv=False), 1.0, atol=1e-4)  # the same space


def test_patterns_that_hold_too_little_are_not_relied_on(monkeypatch, rng):
    windows = rng.normal(size=(300, FRAMES, CHANNELS))  # as much in every direction
    alike = rng.normal(size=(3, FRAMES, CHANNELS))
    found = _few_window_bases(windows, alike)
    monkeypatch.setattr(local_prior, "FEWER", np.inf)
    whole = _few_window_bases(windows, alike)
    assert found.count == whole.count > 100
    np.testing.assert_array_equal(found.values, whole.values)


@pytest.mark.parametrize("count", [2, 5])
def test_few_windows_have_fewer_bases(rng, count):
    found = _few_window_bases(rng.normal(size=(count, FRAMES, CHANNELS)), rng.normal(size=(50, FRAMES, CHANNELS)))
    assert 1 <= found.count < count
    assert np.isfinite(found.vectors).all()
