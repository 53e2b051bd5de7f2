"""Laws of the bends at any rate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.library.exemplars import Library
from motionmend.errors import MismatchError

RATES = np.array([15.0, 30.0, 60.0, 120.0])


def _library(seed: int, channels: int = 5, rates: np.ndarray = RATES) -> Library:
    rng = np.random.default_rng(seed)
    bends = np.stack([np.cov(rng.normal(size=(channels, 40)) * 3.0 / rate, bias=True) for rate in rates])
    return Library(rates, np.full(len(rates), 40), bends, np.empty((0, 4, channels)), bends[0], rates[0])


@given(st.integers(0, 10**6), st.floats(1.0, 2000.0))
@settings(max_examples=60)
def test_a_curvature_is_a_covariance(seed, fps):
    found = _library(seed).curvature(fps)
    np.testing.assert_array_equal(found, found.T)
    values = np.linalg.eigvalsh(found)
    assert values[0] >= -1e-12 * values[-1]
    assert (np.diag(found) > 0).all()


@given(st.integers(0, 10**6), st.sampled_from(range(4)))
def test_at_a_stored_rate_it_is_what_was_stored(seed, k):
    library = _library(seed)
    np.testing.assert_allclose(library.curvature(RATES[k]), library.bends[k], rtol=1e-9)


@given(st.integers(0, 10**6), st.floats(10.0, 400.0))
@settings(max_examples=60)
def test_it_has_no_jumps(seed, fps):
    library = _library(seed)
    near, far = library.curvature(fps), library.curvature(fps * (1 + 1e-7))
    np.testing.assert_allclose(near, far, atol=1e-5 * np.abs(near).max())


@given(st.integers(0, 10**6), st.floats(121.0, 5000.0))
def test_beyond_the_rates_deviations_fall_between_noise_and_constant_acceleration(seed, fps):
    library = _library(seed)
    ratio = np.sqrt(np.diag(library.curvature(fps)) / np.diag(library.bends[-1]))
    assert (ratio <= 1 + 1e-12).all()
    assert (ratio >= (fps / 120.0) ** -2.0 * (1 - 1e-12)).all()


def test_a_parabola_bends_as_it_should_at_any_rate():
    acceleration = 50.0
    bends = (acceleration / RATES**2)[:, None, None] ** 2 * np.ones((1, 2, 2))
    library = Library(RATES, np.full(4, 9), bends, np.empty((0, 4, 2)), bends[0], 30.0)
    for fps in (7.0, 24.0, 59.94, 100.0, 1000.0):
        np.testing.assert_allclose(library.curvature(fps), (acceleration / fps**2) ** 2, rtol=1e-9)


def test_a_channel_at_rest_stays_at_rest():
    library = _library(1)
    bends = library.bends.copy()
    bends[:, 2] = bends[:, :, 2] = 0.0
    found = Library(RATES, library.counts, bends, library.exemplars, library.typical, library.rate).curvature(43.0)
    assert (found[2] == 0).all()
    assert (np.diag(found)[[0, 1, 3, 4]] > 0).all()


def test_one_rate_goes_on_as_constant_acceleration():
    library = _library(3, rates=np.array([15.0]))
    np.testing.assert_allclose(library.curvature(30.0), library.bends[0] / 16.0, rtol=1e-9)


def test_arrays_make_the_same_library_again():
    library = _library(4)
    again = Library.from_arrays(library.to_arrays())
    assert again.exemplars.dtype == np.float32
    np.testing.assert_array_equal(again.bends, library.bends)
    np.testing.assert_array_equal(again.rates, library.rates)


def test_what_does_not_fit_together_is_refused():
    with pytest.raises(MismatchError, match="bends"):
        Library(RATES, np.zeros(4), np.zeros((3, 2, 2)), np.empty((0, 4, 2)), np.eye(2), 30.0)
    with pytest.raises(MismatchError, match="rising"):
        Library(RATES[::-1], np.zeros(4), np.zeros((4, 2, 2)), np.empty((0, 4, 2)), np.eye(2), 30.0)
    with pytest.raises(MismatchError, match="not known"):
        Library(np.empty(0), np.empty(0), np.empty((0, 2, 2)), np.empty((0, 4, 2)), np.eye(2), 30.0).curvature(30.0)
