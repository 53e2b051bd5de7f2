"""Smoothing by a Gaussian through Fourier transforms, against SciPy's sum over the frames."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from motionmend.numerics.gaussian import gaussian_smooth


@given(st.integers(0, 10**6), st.integers(1, 400), st.floats(0.3, 150.0))
@settings(max_examples=60)
def test_it_is_scipy_s(seed, frames, width):
    values = np.random.default_rng(seed).normal(size=(frames, 3)) * np.array([1.0, 1e-3, 1e6])
    found = gaussian_smooth(values, width)
    assert found.flags.c_contiguous
    size = np.abs(values).max(axis=0)
    twin = gaussian_filter1d(values, width, axis=0, mode="nearest")
    np.testing.assert_allclose(found / size, twin / size, rtol=0, atol=1e-13)


def test_what_is_alike_throughout_stays_so_and_single_precision_too():
    alike = np.full((50, 2), 3.5)
    np.testing.assert_allclose(gaussian_smooth(alike, 7.0), alike, rtol=1e-14)
    single = gaussian_smooth(alike.astype(np.float32), 7.0)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, alike, rtol=1e-6)
