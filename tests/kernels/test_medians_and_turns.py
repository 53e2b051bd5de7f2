"""Medians and the turns of groups of points, against their plain twins."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_denoise as naive
from motionmend.kernels.medians import geometric_medians, running_median, student_squares
from motionmend.kernels.turned import places_and_axes

SEEDS = st.integers(0, 10**6)


@given(SEEDS, st.integers(0, 8), st.integers(0, 30), st.integers(0, 3))
@settings(max_examples=80)
def test_running_medians_are_the_twin_s_to_the_bit(seed, half, more, digits):
    """With few digits many frames are alike."""
    span = 2 * half + 1
    values = np.round(np.random.default_rng(seed).normal(size=(span + more, 3)), digits)
    found = running_median(np.ascontiguousarray(values.T), span).T
    np.testing.assert_array_equal(found, naive.running_median(values, span))


@given(SEEDS, st.integers(1, 9))
@settings(max_examples=60)
def test_geometric_medians_are_the_twin_s(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(6, count, 3))
    points[rng.random((6, count)) < 0.3] = np.nan
    points[0, 1:] = points[0, :1]
    found = geometric_medians(points, 12, 1e-6)
    twin = np.array([naive.geometric_median(one, 12, 1e-6) for one in points])
    np.testing.assert_allclose(found, twin, rtol=0, atol=1e-9)


@given(SEEDS, st.integers(0, 20), st.integers(0, 4))
@settings(max_examples=60)
def test_squares_of_which_large_ones_count_less_are_the_twin_s(seed, count, channels):
    rng = np.random.default_rng(seed)
    square, scale = np.square(rng.normal(size=(count, channels))), rng.uniform(0.1, 2.0, channels)
    np.testing.assert_allclose(student_squares(square, scale, 3.0), naive.student_squares(square, scale, 3.0))


@given(SEEDS, st.integers(3, 7), st.booleans())
@settings(max_examples=80)
def test_places_and_turns_are_the_twin_s(seed, count, flat):
    """Points that lie in a plane are turned as surely as others, and none is mirrored."""
    rng = np.random.default_rng(seed)
    shape, weights = rng.normal(size=(count, 3)), rng.uniform(0.2, 1.0, count)
    shape[:, 2] *= 0.0 if flat else 1.0
    weights /= weights.sum()
    turns = np.linalg.qr(rng.normal(size=(5, 3, 3)))[0]
    turns[:, :, 0] *= np.sign(np.linalg.det(turns))[:, None]
    points = shape @ turns.transpose(0, 2, 1) + rng.normal(size=(5, 1, 3)) + 0.05 * rng.normal(size=(5, count, 3))
    place, axes = places_and_axes(points, weights, weights[:, None] * (shape - weights @ shape))
    for t in range(5):
        there, turn = naive.best_turn(points[t], weights, shape)
        np.testing.assert_allclose(place[t], there, rtol=0, atol=1e-12)
        np.testing.assert_allclose(axes[t], turn, rtol=0, atol=1e-6)
        np.testing.assert_allclose(np.linalg.det(axes[t]), 1.0, atol=1e-12)
        np.testing.assert_allclose(axes[t] @ axes[t].T, np.eye(3), atol=1e-12)


def test_points_that_lie_where_their_shape_does_are_not_turned():
    shape = np.array([[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [-0.1, -0.1, 0.3]])
    weights = np.full(3, 1.0 / 3.0)
    place, axes = places_and_axes(shape[None] + 5.0, weights, weights[:, None] * (shape - weights @ shape))
    np.testing.assert_allclose(place[0], shape.mean(axis=0) + 5.0)
    np.testing.assert_allclose(axes[0], np.eye(3), atol=1e-12)
