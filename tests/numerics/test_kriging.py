"""Laws of kriging with amplitudes found by restricted likelihood."""

import numpy as np
import pytest

from motionmend.numerics.kriging import krige, left_out, likeliest_amplitudes, matern32, matern52, squared_distances


def _smooth(rng, count=80, noise=0.05):
    time = np.sort(rng.uniform(0, 10, count))
    parts = np.array([matern52(np.abs(time[:, None] - time), 1.0), np.eye(count)])
    root = np.linalg.cholesky(parts[0] + 1e-9 * np.eye(count))
    return time, parts, root @ rng.normal(size=(count, 3)) + noise * rng.normal(size=(count, 3))


def test_without_noise_it_interpolates(rng):
    time, parts, values = _smooth(rng, noise=0.0)
    found = krige(parts[0] + 1e-8 * parts[1], parts[0], np.ones(len(time)), values)
    np.testing.assert_allclose(found.mean, values, atol=1e-4)
    assert found.variance.max() < 1e-5


def test_leaving_out_is_predicting_without(rng):
    _, parts, values = _smooth(rng, count=30)
    cov = parts[0] + 0.05**2 * parts[1] + 100.0
    groups = [np.arange(0, 30, 3), np.arange(1, 30, 3), np.arange(2, 30, 3)]
    found = left_out(cov, values, groups)
    for rows in groups:
        rest = np.setdiff1d(np.arange(30), rows)
        other = krige(cov[np.ix_(rest, rest)], cov[np.ix_(rows, rest)], cov.diagonal()[rows], values[rest])
        np.testing.assert_allclose(found.mean[rows], other.mean, atol=1e-6)
        np.testing.assert_allclose(found.variance[rows], other.variance, atol=1e-6)


def test_amplitudes_are_found_again_whatever_the_mean_and_the_unit(rng):
    _, parts, values = _smooth(rng, count=150, noise=0.1)
    base = np.full(parts.shape[1:], 1e4)
    found = likeliest_amplitudes(parts, base, values, np.array([0.3, 0.3]), 50)
    assert found[0] == pytest.approx(1.0, rel=0.7)
    assert found[1] == pytest.approx(0.01, rel=0.4)
    moved = likeliest_amplitudes(parts, base, values + np.array([10.0, -20.0, 5.0]), np.array([0.3, 0.3]), 50)
    np.testing.assert_allclose(moved, found, rtol=0.05)
    small = likeliest_amplitudes(parts, 1e-6 * base, 1e-3 * values, np.array([0.3e-6, 0.3e-6]), 50)
    np.testing.assert_allclose(small, 1e-6 * found, rtol=0.05)


def test_the_promised_deviation_holds(rng):
    time, parts, values = _smooth(rng, count=200, noise=0.1)
    cov = parts[0] + 0.01 * parts[1]
    found = left_out(cov, values, np.array_split(np.arange(200), 40))
    error = (found.mean - values) / np.sqrt(found.variance)[:, None]
    assert 0.8 < np.sqrt(np.square(error).mean()) < 1.25
    assert time[0] >= 0


def test_correlations_fall_from_one(rng):
    away = np.linspace(0, 5, 50)
    for one in (matern32(away, 0.7), matern52(away, 0.7)):
        assert one[0] == 1.0
        assert (np.diff(one) < 0).all()
    points = rng.normal(size=(20, 4))
    naive = np.square(points[:, None] - points).sum(axis=2)
    np.testing.assert_allclose(squared_distances(points, points), naive, atol=1e-9)
