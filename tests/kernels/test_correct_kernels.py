"""Kernels of correction against their plain twins."""

import numpy as np
import pytest

import naive_correct as naive
from motionmend.arrays import frozen
from motionmend.kernels import bones, factors
from motionmend.numerics.local_gp import fit_mixture, model_of, predict


@pytest.mark.parametrize("nearest", [1, 3, 9])
def test_mixture_is_the_mixture_of_models_solved_anew(nearest: int) -> None:
    rng = np.random.default_rng(nearest)
    inputs = [rng.normal(size=(60, 4)), rng.normal(size=(45, 6))]
    outputs = [np.sin(x[:, :3]) + 0.05 * rng.normal(size=(len(x), 3)) for x in inputs]
    mixed = fit_mixture(inputs, outputs, models=5, size=12, seed=1, rounds=8)
    queries = np.zeros((4, 2, 6))
    queries[:, 0, :4], queries[:, 1] = rng.normal(size=(4, 4)), rng.normal(size=(4, 6))
    mean, variance = predict(mixed, queries, nearest)
    for j in range(2):
        models = [model_of(mixed, j, q) for q in range(5) if mixed.counts[j, q]]
        for t in range(4):
            wanted, spread = naive.mixture_predict(*zip(*models, strict=True), queries[t, j], nearest)
            np.testing.assert_allclose(mean[t, j], wanted, rtol=1e-6, atol=1e-8)
            np.testing.assert_allclose(variance[t, j], spread, rtol=1e-5, atol=1e-7)


def test_a_joint_without_models_says_nothing() -> None:
    rng = np.random.default_rng(0)
    mixed = fit_mixture([np.empty((0, 2)), rng.normal(size=(9, 2))], [np.empty((0, 3)), rng.normal(size=(9, 3))], 2, 5)
    mean, variance = predict(mixed, np.zeros((1, 2, 2)))
    assert (mean[0, 0] == 0).all()
    assert np.isinf(variance[0, 0])
    assert np.isfinite(variance[0, 1])


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.0, 1 / 30, 0.4, 5.0])
def test_factors_go_ahead_as_the_matrix_exponential_says(seconds: float) -> None:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(8, 8))
    mean, cov, rates = rng.normal(size=8), root @ root.T, frozen([0.5, 1.0, 3.0, 8.0])
    loadings = frozen(rng.normal(size=(5, 3, 4)))
    moved, later = naive.factors_ahead(mean, cov, rates, seconds)
    whole = moved, later, loadings @ moved[:4], loadings @ later[:4, :4] @ loadings.swapaxes(1, 2)
    for got, wanted in zip(factors.forecast(loadings, mean, cov, rates, seconds), whole, strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-8, atol=1e-8)
    for got, wanted in zip(factors.ahead(mean, cov, rates, seconds), whole[:2], strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-8, atol=1e-8)


def test_what_is_seen_is_kalmans_update_and_a_group_left_out_was_never_seen() -> None:
    rng = np.random.default_rng(4)
    loadings, values = frozen(rng.normal(size=(5, 3, 4))), rng.normal(size=(5, 3))
    root = rng.normal(size=(8, 8))
    mean, cov = rng.normal(size=8), root @ root.T + np.eye(8)
    precision = np.array([4.0, 0.0, 9.0, 1.0, 25.0])
    after = factors.seen(loadings, mean, cov, values, precision)
    for got, wanted in zip(after, naive.factors_seen(loadings, mean, cov, values, precision), strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-7, atol=1e-7)
    there, covs = factors.expected(loadings, *after)
    noise = 1.0 / np.where(precision > 0, precision, 2.0)
    distance, volume = factors.left_out(values - there, covs, noise, precision)
    for j in range(5):
        others = np.where(np.arange(5) == j, 0.0, precision)
        belief = naive.factors_seen(loadings, mean, cov, values, others)
        far, size = naive.group_distance(loadings, *belief, values[j], j, noise[j])
        np.testing.assert_allclose([distance[j], volume[j]], [far, size], rtol=1e-4, atol=1e-4)


def test_bones_settle_as_their_twin_and_have_their_lengths() -> None:
    rng = np.random.default_rng(5)
    tree = np.array([[0, 1], [1, 2], [0, 3], [3, 4]])
    positions = rng.normal(size=(3, 5, 3))
    positions[1, 4] = np.nan
    lengths = rng.uniform(0.2, 0.6, (3, 4))
    lengths[2, 1] = np.nan
    mobility = rng.uniform(1.0, 5.0, (3, 5))
    got = bones.settle(positions, tree, lengths, mobility, 12)
    np.testing.assert_allclose(got, naive.settle(positions, tree, lengths, mobility, 12), rtol=1e-9, atol=1e-9)
    found = np.linalg.norm(got[:, tree[:, 1]] - got[:, tree[:, 0]], axis=2)
    free = ~np.isfinite(lengths) | ~np.isfinite(found)
    assert free.sum() == 2
    np.testing.assert_allclose(found[~free], lengths[~free], rtol=1e-9)
