"""Laws of Whittaker's smoother."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.numerics.whittaker import response, whittaker

SEEDS = st.integers(0, 10**6)


def _case(seed):
    rng = np.random.default_rng(seed)
    frames = int(rng.integers(5, 60))
    weights = rng.uniform(0, 1, frames) * (rng.random(frames) > 0.3)
    weights[[0, frames // 2]] = 1.0
    return rng, frames, weights, 10.0 ** rng.uniform(-1, 4)


@given(SEEDS)
@settings(max_examples=50)
def test_straight_lines_stay_and_are_drawn_across_gaps(seed):
    rng, frames, weights, smoothness = _case(seed)
    line = np.arange(frames)[:, None] * rng.normal(size=3) + rng.normal(size=3)
    gappy = np.where((weights > 0)[:, None], line, np.nan)
    np.testing.assert_allclose(whittaker(gappy, weights, smoothness), line, atol=1e-5)


def test_straight_lines_cross_gaps_of_thousands_of_frames():
    line = np.arange(3000.0)[:, None]
    weights = np.zeros(3000)
    weights[:5] = weights[-5:] = 1.0
    np.testing.assert_allclose(whittaker(line, weights, 1e4), line, atol=1e-6)


@given(SEEDS)
@settings(max_examples=50)
def test_it_is_the_minimum_of_its_cost(seed):
    rng, frames, weights, smoothness = _case(seed)
    y = rng.normal(size=(frames, 1))

    def cost(z):
        return (weights[:, None] * (y - z) ** 2).sum() + smoothness * (np.diff(z, 2, axis=0) ** 2).sum()

    z = whittaker(y, weights, smoothness)
    assert cost(z) <= cost(z + 1e-3 * rng.normal(size=z.shape)) + 1e-9


@given(SEEDS)
@settings(max_examples=30)
def test_it_commutes_with_turning_the_channels_and_adding_lines(seed):
    rng, frames, weights, smoothness = _case(seed)
    y = rng.normal(size=(frames, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    line = np.arange(frames)[:, None] * rng.normal(size=3)
    np.testing.assert_allclose(
        whittaker(y @ turn + line, weights, smoothness),
        whittaker(y, weights, smoothness) @ turn + line,
        atol=1e-5,
    )


def test_half_of_a_sine_at_the_cutoff_passes():
    frequency, frames = 0.05, 2000
    sine = np.sin(2 * np.pi * frequency * np.arange(frames))[:, None]
    smooth = whittaker(sine, np.ones(frames), (2 * np.sin(np.pi * frequency)) ** -4)
    assert np.abs(smooth[500:1500]).max() == pytest.approx(0.5, abs=0.01)


@given(st.floats(-2.0, 3.0))
@settings(max_examples=20, deadline=None)
def test_its_response_says_what_comes_of_a_sample_itself_and_of_noise(size):
    smoothness, one = 10.0**size, np.zeros((801, 1))
    one[400] = 1.0
    passed = whittaker(one, np.ones(801), smoothness)[:, 0]
    assert passed[400] == pytest.approx(response(smoothness).mean(), rel=1e-3)
    assert np.square(passed).sum() == pytest.approx(np.square(response(smoothness)).mean(), rel=1e-3)
