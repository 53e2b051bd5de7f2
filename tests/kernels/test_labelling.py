"""Paths of two labels, against the plain twin that tries them all."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_labels as naive
from motionmend.kernels.labelling import likeliest_path, log_densities

LAW = 3.0, -2.551, float(np.log(1e-4))  # Student's t, and what is neither motion nor swap


@given(st.integers(0, 10**6), st.integers(1, 7), st.floats(0.0, 1.0))
@settings(max_examples=60)
def test_the_likeliest_path_is_that_of_the_twin(seed, count, hidden):
    rng = np.random.default_rng(seed)
    begin = 10 * np.arange(count)[:, None] + rng.integers(0, 4, (count, 2))
    frame = np.stack([begin, begin + rng.integers(0, 5, (count, 2))])
    frame[:, rng.random((count, 2)) < hidden] = -1
    moving = rng.random((2, count, 2)) < 0.8
    place, velocity = rng.normal(0, 0.02, (2, 2, count, 2, 3))
    told = (
        *(frame, place, velocity * moving[..., None], moving),
        *(rng.normal(0, 4, count), rng.uniform(-6, -1, count), -2.0, rng.random(count) < 0.2),
        *(np.array([1.0, 4.0, 15.0]), np.sort(rng.uniform(0.001, 0.05, (3, 3))), rng.uniform(0, 0.3, (3, 3)), 0.03),
        *(LAW, 200, 500.0),
    )
    score, swapped = likeliest_path(*told)
    expected, path = naive.likeliest_path(*told)
    np.testing.assert_allclose(score, expected, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(swapped, path)


@given(st.integers(0, 10**6))
@settings(max_examples=30)
def test_steps_are_as_likely_as_the_twin_has_them(seed):
    rng = np.random.default_rng(seed)
    error, way = np.abs(rng.normal(0, 0.05, (2, 9)))
    sides, frames = rng.integers(0, 3, 9), rng.integers(1, 40, 9)
    told = np.array([1.0, 4.0, 15.0]), np.sort(rng.uniform(0.001, 0.05, (3, 3))), rng.uniform(0, 0.3, (3, 3)), 0.03
    density, lost = log_densities(error, way, sides, frames, *told, LAW)
    steps = zip(error, way, sides, frames, strict=True)
    np.testing.assert_allclose(density, [naive.log_density(*step, *told, LAW) for step in steps], rtol=0, atol=1e-9)
    assert (lost <= 0.0).all()


def test_labels_that_nothing_shows_are_right_as_they_are():
    nothing = np.full((2, 3, 2), -1), *np.zeros((2, 2, 3, 2, 3)), np.zeros((2, 3, 2), dtype=bool)
    law = np.array([1.0]), np.full((3, 1), np.inf), np.zeros((3, 1)), np.inf, LAW
    score, swapped = likeliest_path(*nothing, np.zeros(3), np.full(3, -12.0), -4.0, np.zeros(3, bool), *law, 24, 60.0)
    assert score == 0.0
    assert not swapped.any()
