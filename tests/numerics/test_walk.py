"""Laws of the random walk's smoother, of its fit and of the noise level."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.errors import MismatchError, UsageError
from motionmend.numerics.smoother import StateSpace, kalman_smoother
from motionmend.numerics.walk import fit_random_walk, noise_level, smooth_random_walk

SEEDS = st.integers(0, 10**6)


def _walk(rng, frames, channels, step, noise):
    truth = np.cumsum(rng.normal(0, step, (frames, channels)), axis=0)
    return truth, truth + rng.normal(0, noise, (frames, channels))


def _case(seed):
    rng = np.random.default_rng(seed)
    observed = _walk(rng, 25, 4, 0.5, 1.0)[1] + 100.0
    observed[rng.random(observed.shape) < rng.choice([0.0, 0.4, 0.8])] = np.nan
    observed[[3, 11], :] = rng.normal(size=(2, 4))
    return rng, observed, rng.uniform(0.01, 3.0, 4)


@given(SEEDS, st.booleans())
@settings(max_examples=50)
def test_smoother_is_least_squares_over_all_states(seed, per_sample):
    rng, observed, step_var = _case(seed)
    noise_var = rng.uniform(0.01, 3.0, observed.shape if per_sample else 4)
    found = smooth_random_walk(observed, step_var, noise_var)
    spread = np.broadcast_to(noise_var, observed.shape)
    for c in range(4):
        mean, variance = naive.smooth_walk(observed[:, c], step_var[c], spread[:, c])
        np.testing.assert_allclose(found.mean[:, c], mean, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(found.variance[:, c], variance, rtol=1e-8)


@given(SEEDS)
@settings(max_examples=20)
def test_smoother_is_the_general_one_that_starts_at_the_first_sample(seed):
    _, observed, step_var = _case(seed)
    observed[0] = 1.0
    for c in range(4):
        one = np.ones((1, 1))
        model = StateSpace(one, one * step_var[c], one, np.ones(1), one * 0.7)  # the start stands for frame 0's sample
        later = observed[:, [c]].copy()
        later[0] = np.nan
        general = kalman_smoother(model, later, np.array([0.7]))
        found = smooth_random_walk(observed[:, [c]], step_var[[c]], np.array([0.7]))
        np.testing.assert_allclose(found.mean, general.mean, rtol=1e-8)
        np.testing.assert_allclose(found.variance, general.variance(one), rtol=1e-8)
        assert found.log_likelihood[0] == pytest.approx(general.log_likelihood, rel=1e-8)


def test_no_steps_give_the_mean_and_no_noise_the_samples():
    observed = np.array([[1.0], [4.0], [np.nan], [7.0]])
    still = smooth_random_walk(observed, np.zeros(1), np.ones(1))
    np.testing.assert_allclose(still.mean, 4.0)
    np.testing.assert_allclose(still.variance, 1 / 3)
    exact = smooth_random_walk(observed, np.ones(1), np.zeros(1))
    np.testing.assert_allclose(exact.mean, [[1.0], [4.0], [5.5], [7.0]])
    np.testing.assert_allclose(exact.variance, [[0.0], [0.0], [0.5], [0.0]])


def test_a_channel_without_samples_stays_open():
    found = smooth_random_walk(np.full((5, 1), np.nan), np.ones(1), np.ones(1))
    assert np.isnan(found.mean).all()
    assert np.isinf(found.variance).all()


@pytest.mark.slow
@pytest.mark.parametrize(("step", "noise"), [(1.0, 1.0), (0.2, 3.0), (2.0, 0.5)])
def test_fit_finds_the_variances_of_a_true_walk(rng, step, noise):
    _, observed = _walk(rng, 2000, 6, step, noise)
    observed[rng.random(observed.shape) < 0.1] = np.nan
    step_var, noise_var = fit_random_walk(observed)
    np.testing.assert_allclose(np.median(np.sqrt(step_var)), step, rtol=0.15)
    np.testing.assert_allclose(np.median(np.sqrt(noise_var)), noise, rtol=0.1 if noise >= step else 0.25)
    told, given_var = fit_random_walk(observed, np.full(6, noise**2))
    np.testing.assert_allclose(np.median(np.sqrt(told)), step, rtol=0.15)
    assert (given_var == noise**2).all()


@given(SEEDS, st.floats(-8, 8))
@settings(max_examples=20)
def test_fit_does_not_depend_on_the_unit_or_the_origin(seed, exponent):
    rng = np.random.default_rng(seed)
    _, observed = _walk(rng, 60, 3, 1.0, 1.0)
    unit = 10.0**exponent
    here, there = fit_random_walk(observed), fit_random_walk(unit * (observed + 5.0))
    np.testing.assert_allclose(there, np.array(here) * unit**2, rtol=1e-5)


def test_fit_of_channels_that_tell_nothing():
    observed = np.full((30, 3), np.nan)
    observed[:, 0] = 2.5
    observed[[4, 9, 20], 1] = [1.0, 2.0, 3.0]
    step_var, noise_var = fit_random_walk(observed)
    np.testing.assert_array_equal(step_var, [0.0, np.nan, np.nan])
    np.testing.assert_array_equal(noise_var, [0.0, np.nan, np.nan])


def test_smooth_motion_is_not_taken_for_noise(rng):
    motion = np.sin(np.arange(150) / 5.0)[:, None] * 20
    step_var, noise_var = fit_random_walk(motion + rng.normal(0, 0.1, motion.shape))
    assert np.sqrt(noise_var[0]) < 0.3
    assert np.sqrt(step_var[0]) > 1.0


@given(SEEDS, st.floats(0.1, 10.0))
@settings(max_examples=15)
def test_noise_level_of_noise_on_a_curve(seed, level):
    rng = np.random.default_rng(seed)
    time = np.arange(1500)[:, None]
    curve = 3.0 * np.sin(time / 12.0) + 0.01 * time
    found = noise_level(curve + level * rng.normal(size=(1500, 4)))
    np.testing.assert_allclose(found.mean(), level, rtol=0.1)


def test_noise_level_withstands_outliers_and_gaps(rng):
    values = rng.normal(size=(3000, 4))
    values[rng.random(values.shape) < 0.05] += 100.0
    values[rng.random(values.shape) < 0.05] = np.nan
    assert noise_level(values).mean() == pytest.approx(1.0, rel=0.3)


def test_noise_level_of_lines_and_of_too_little():
    values = np.full((40, 3), np.nan)
    values[:, 0] = 3.0
    values[:3, 1] = [1.0, 2.0, 3.0]
    found = noise_level(values)
    assert found[0] == 0.0
    assert np.isnan(found[1:]).all()


def test_refuses_what_makes_no_sense():
    with pytest.raises(MismatchError):
        smooth_random_walk(np.zeros((4, 2)), np.ones(2), np.ones(3))
    with pytest.raises(UsageError, match="below 0"):
        smooth_random_walk(np.zeros((4, 2)), np.ones(2), np.array([1.0, -1.0]))
    with pytest.raises(UsageError, match="steps"):
        smooth_random_walk(np.zeros((4, 2)), np.array([1.0, -1.0]), np.ones(2))
