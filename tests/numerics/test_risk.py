"""The error of a smoother, read from the recording itself."""

import numpy as np
import pytest

from motionmend.numerics.risk import excess, share_of_second, stein_risk


def _smoothed(rng, half, frames=4000, period=60.0, noise=1.0):
    """A moving mean over 2 half + 1 frames of a noisy sine: recording, result, truth."""
    truth = 5 * np.sin(2 * np.pi * np.arange(frames)[:, None] / period + rng.uniform(0, 6, 6))
    recorded = truth + rng.normal(0, noise, truth.shape)
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    result = np.stack([np.convolve(c, kernel, mode="same") for c in recorded.T], axis=1)
    inside = slice(half, -half)
    return recorded[inside], result[inside], truth[inside], kernel[half]


@pytest.mark.parametrize("half", [1, 4, 10])
@pytest.mark.parametrize("noise", [0.3, 2.0])
def test_risk_is_the_mean_square_error(rng, half, noise):
    recorded, result, truth, own = _smoothed(rng, half, noise=noise)
    risk = stein_risk(recorded - result, np.array([[own]]), np.full(6, noise))
    error = np.square(result - truth).mean(axis=0)
    # A sine's bias is no normal variable: its median says up to twice its mean square.
    assert (risk > 0.7 * error - 0.1 * noise**2).all()
    assert (risk < 2.5 * error + 0.1 * noise**2).all()


def test_outliers_and_missing_samples_do_not_count(rng):
    recorded, result, _, own = _smoothed(rng, 4)
    clean = stein_risk(recorded - result, np.array([[own]]), np.ones(6))
    spoiled = recorded - result
    spoiled[rng.random(spoiled.shape) < 0.02] += 100.0
    spoiled[rng.random(spoiled.shape) < 0.1] = np.nan
    np.testing.assert_allclose(stein_risk(spoiled, np.array([[own]]), np.ones(6)), clean, atol=0.15)


def test_what_cannot_be_told_is_nan_and_adds_nothing():
    residual = np.ones((20, 3))
    residual[:, 0] = np.nan
    risk = stein_risk(residual, np.zeros((1, 1)), np.array([1.0, np.nan, 0.5]))
    np.testing.assert_array_equal(np.isnan(risk), [True, True, False])
    added = excess(risk, np.full((20, 3), 0.25), residual)
    np.testing.assert_array_equal(added[:2], [0.0, 0.0])
    assert added[2] == pytest.approx(risk[2] - 0.25)
    assert excess(np.array([0.1]), np.full((20, 1), 0.25), np.ones((20, 1)))[0] == 0.0


@pytest.mark.parametrize("alike", [-0.5, 0.0, 0.6])
@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 0.4), (0.5, 2.0)])
def test_no_other_share_of_the_second_of_two_estimates_errs_less(rng, alike, sizes):
    both = np.outer(sizes, sizes) * np.array([[1.0, alike], [alike, 1.0]])
    one, other = rng.multivariate_normal(np.zeros(2), both, 50_000).T
    share = share_of_second(*(np.array([np.square(each).mean()]) for each in (one, other, other - one)))[0]
    tried = [np.square(one + part * (other - one)).mean() for part in (share, *np.linspace(0.0, 1.0, 41))]
    assert tried[0] <= min(tried) * (1.0 + 1e-9)


def test_of_two_that_are_the_same_half_of_each_is_taken():
    assert share_of_second(np.array([1.0, 3.0]), np.array([1.0, 1.0]), np.zeros(2)).tolist() == [0.5, 0.5]
