"""The lagged products against their plain twins, which do build the trajectory matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.kernels import lagged

SHAPES = st.tuples(st.integers(3, 40), st.integers(1, 5), st.integers(2, 12), st.integers(1, 4), st.integers(0, 10**6))


def _case(shape):
    frames, channels, window, stride, seed = shape
    window = min(window, frames)
    rng = np.random.default_rng(seed)
    series = np.cumsum(rng.normal(size=(frames, channels)), axis=0)
    bases = rng.normal(size=(3, window, channels))
    starts = np.unique(np.append(np.arange(0, frames - window + 1, stride), frames - window))
    return series, window, bases, starts


@given(SHAPES)
@settings(max_examples=60)
def test_lag_products_equal_those_of_the_trajectory_matrix(shape):
    series, window, _, _ = _case(shape)
    rows = naive.trajectory_matrix(series, window)
    np.testing.assert_allclose(lagged.lag_products([series], window), rows.T @ rows, rtol=1e-9, atol=1e-9)


@given(SHAPES)
@settings(max_examples=60)
def test_projection_and_overlap_add_equal_their_twins(shape):
    series, _, bases, starts = _case(shape)
    coefficients = lagged.project(series, bases, starts)
    np.testing.assert_allclose(coefficients, naive.project(series, bases, starts), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        lagged.overlap_add(coefficients, bases, starts, len(series)),
        naive.overlap_add(coefficients, bases, starts, len(series)),
        rtol=1e-9,
        atol=1e-9,
    )


@given(SHAPES)
@settings(max_examples=40)
def test_overlap_add_is_the_transpose_of_projection(shape):
    series, _, bases, starts = _case(shape)
    coefficients = np.random.default_rng(shape[-1] + 1).normal(size=(len(starts), len(bases)))
    left = (lagged.project(series, bases, starts) * coefficients).sum()
    right = (series * lagged.overlap_add(coefficients, bases, starts, len(series))).sum()
    assert left == pytest.approx(right, rel=1e-9, abs=1e-8)


@given(SHAPES)
@settings(max_examples=40)
def test_coverage_counts_the_windows_of_each_frame(shape):
    series, window, _, starts = _case(shape)
    frames = len(series)
    held = [sum(s <= t < s + window for s in starts) for t in range(frames)]
    np.testing.assert_array_equal(lagged.coverage(starts, window, frames), held)


def test_blocks_do_not_change_the_result(monkeypatch, rng):
    series = rng.normal(size=(200, 4))
    bases = rng.normal(size=(5, 10, 4))
    starts = np.arange(191)
    whole = lagged.project(series, bases, starts), lagged.lag_products([series], 10)
    monkeypatch.setattr(lagged, "BLOCK_BYTES", 2000)
    np.testing.assert_allclose(lagged.project(series, bases, starts), whole[0], rtol=1e-12)
    np.testing.assert_allclose(lagged.lag_products([series], 10), whole[1], rtol=1e-10, atol=1e-10)
