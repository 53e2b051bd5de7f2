"""Smooth pieces keep their ends, and drift is smooth and of the size asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.samples.curves import bump, drift, quintic, step, through

STATES = st.tuples(*[st.floats(-5, 5)] * 3)


def slope_and_curve(values: np.ndarray, dt: float) -> tuple[float, float]:
    """First and second derivative in the middle of five equidistant values."""
    a, b, c, d, e = values
    return (a - 8 * b + 8 * d - e) / (12 * dt), (-a + 16 * b - 30 * c + 16 * d - e) / (12 * dt**2)


@given(STATES, STATES, st.floats(0.1, 2.0))
def test_a_quintic_meets_both_states(begin, end, duration):
    begin, end = np.array(begin), np.array(end)
    h = 1e-3 * duration
    for at, state in ((0.0, begin), (duration, end)):
        around = quintic(at + h * np.arange(-2, 3), duration, begin, end)
        slope, curve = slope_and_curve(around, h)
        scale = 1 + np.abs(begin).max() + np.abs(end).max()
        assert around[2] == pytest.approx(state[0], abs=1e-9 * scale)
        assert slope == pytest.approx(state[1], abs=1e-4 * scale / duration)
        assert curve == pytest.approx(state[2], abs=1e-2 * scale / duration**2)


@given(st.lists(st.floats(-2, 2), min_size=3, max_size=6))
def test_a_path_goes_through_its_states_without_corners(values):
    times = np.arange(len(values), dtype=float)
    states = np.zeros((len(values), 3))
    states[:, 0] = values
    t = np.linspace(-0.5, len(values) - 0.5, 2001)
    path = through(t, times, states)
    np.testing.assert_allclose(through(times, times, states), values, atol=1e-12)
    assert np.all(path[t < 0] == values[0])
    np.testing.assert_allclose(path[t > times[-1]], values[-1], atol=1e-12)
    jerk = np.diff(path, 3) / (t[1] - t[0]) ** 3
    assert np.abs(jerk).max() <= 60.5 * (np.abs(np.diff(values)).max() + 1e-6)  # the least-jerk path's own most


def test_a_step_rests_at_both_ends_and_is_symmetric():
    x = np.linspace(0, 1, 101)
    assert step(-1.0) == 0
    assert step(2.0) == 1
    np.testing.assert_allclose(step(x) + step(1 - x), 1.0)
    assert np.all(np.diff(step(x)) >= 0)
    assert step(1e-3) < 1e-8


def test_a_bump_is_one_between_its_flanks():
    np.testing.assert_allclose(bump(np.array([0.0, 1.0, 1.5, 2.0, 4.0]), 0.0, 1.0, 2.0, 4.0), [0, 1, 1, 1, 0])


def test_drift_is_smooth_and_of_its_size(rng):
    t = np.arange(0, 2000, 0.1)
    curve = drift(rng, t, 1.0, 0.5, 2)
    assert curve.shape == (len(t), 2)
    assert curve.std() == pytest.approx(0.42, abs=0.06)  # a spline is a little smaller between its knots
    assert np.abs(np.diff(curve, 2, axis=0)).max() < 0.15
