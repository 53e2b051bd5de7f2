"""The covariance of moments of markers, against its plain twin."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_denoise as naive
from motionmend.kernels.kriged import moments_alike


@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 9), st.integers(0, 3))
@settings(max_examples=50)
def test_moments_are_as_alike_as_the_twin_has_them(seed, rows, columns, groups):
    rng = np.random.default_rng(seed)
    edges = np.cumsum(np.append(0, rng.integers(1, 4, groups) * 3))
    one, other = (rng.normal(size=(count, int(edges[-1]))) for count in (rows, columns))
    clip, clips = rng.integers(0, 3, rows), rng.integers(0, 3, columns)
    frame, frames = rng.integers(0, 50, rows), rng.integers(0, 50, columns)
    told = (edges, rng.uniform(0.5, 2.0, groups), *rng.random((4, groups)), rng.random(50))
    found = moments_alike(one, np.ascontiguousarray(other.T), clip, clips, frame, frames, *told, False)
    np.testing.assert_allclose(
        found, naive.moments_alike(one, other, clip, clips, frame, frames, *told), rtol=0, atol=1e-10
    )
    itself = moments_alike(one, np.ascontiguousarray(one.T), clip, clip, frame, frame, *told, True)
    np.testing.assert_array_equal(itself, itself.T)
    np.testing.assert_allclose(
        itself, naive.moments_alike(one, one, clip, clip, frame, frame, *told), rtol=0, atol=1e-10
    )
