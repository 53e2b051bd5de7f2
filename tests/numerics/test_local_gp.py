"""Laws of Gaussian processes, one by one and in a local mixture."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import cho_solve
from scipy.optimize import check_grad

from motionmend.kernels.learning import extend
from motionmend.numerics.local_gp import (
    Hyper,
    budget,
    clusters,
    covariance,
    divergences,
    factor,
    fit_hyper,
    fit_mixture,
    log_likelihood,
    model_of,
    predict,
    with_places,
)
from motionmend.numerics.online_gp import learned

HYPER = Hyper(1.0, 0.3, 2.0, 0.01)


def samples(seed: int, count: int = 30, wide: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, (count, wide))
    return x, np.column_stack([np.sin(2 * x[:, 0]), x[:, 1] ** 2, x.sum(axis=1)]) + 0.02 * rng.normal(size=(count, 3))


def one_model(x: np.ndarray, y: np.ndarray, hyper: Hyper, query: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    lower = factor(x, hyper)
    cross = covariance(query, x, hyper)
    mean = cross @ cho_solve((lower, True), y)
    known = np.linalg.solve(lower, cross.T)
    return mean, hyper.signal + hyper.bias - (known**2).sum(axis=0)


@given(st.integers(0, 1000))
@settings(max_examples=15)
def test_the_gradient_is_that_of_finite_differences(seed: int) -> None:
    x, y = samples(seed, 12)
    at = np.random.default_rng(seed).uniform(-2.0, 1.0, 4)
    off = check_grad(lambda p: log_likelihood(x, y, p)[0], lambda p: log_likelihood(x, y, p)[1], at, epsilon=1e-6)
    assert off < 1e-3 * (1.0 + np.linalg.norm(log_likelihood(x, y, at)[1]))


def test_the_search_climbs_the_likelihood_and_finds_the_noise() -> None:
    x, y = samples(3, 120)
    found = fit_hyper(x, y)
    assert log_likelihood(x, y, np.log(found))[0] > log_likelihood(x, y, np.log(HYPER))[0]
    assert 0.01 < np.sqrt(found.noise) < 0.04  # 0.02 was put in


@given(st.integers(0, 1000))
@settings(max_examples=15)
def test_it_interpolates_as_noise_goes_to_nothing(seed: int) -> None:
    x, y = samples(seed, 15)
    errors = [np.abs(one_model(x, y, HYPER._replace(noise=noise), x)[0] - y).max() for noise in (1e-1, 1e-4, 1e-9)]
    assert errors[2] < 1e-3
    assert errors[2] < errors[0]


@given(st.integers(0, 1000))
@settings(max_examples=15)
def test_variance_grows_away_from_the_samples(seed: int) -> None:
    x, y = samples(seed)
    away = np.random.default_rng(seed).normal(size=3)
    away /= np.linalg.norm(away)
    steps = x.mean(axis=0) + np.array([1.8, 3.0, 5.0, 30.0])[:, None] * away
    variance = one_model(x, y, HYPER, steps)[1]
    assert (np.diff(variance) >= -1e-9).all()
    assert variance[0] < 0.95 * variance[-1]


def test_the_order_of_samples_does_not_matter() -> None:
    x, y = samples(5)
    order = np.random.default_rng(1).permutation(len(x))
    query = samples(6, 8)[0]
    for one, other in zip(one_model(x, y, HYPER, query), one_model(x[order], y[order], HYPER, query), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-8)


@given(st.integers(0, 1000), st.integers(0, 12))
@settings(max_examples=15)
def test_extending_the_factor_is_refitting(seed: int, first: int) -> None:
    x, _ = samples(seed, 20)
    lower = np.zeros((len(x), len(x)))
    if first:
        lower[:first, :first] = factor(x[:first], HYPER)
    for k in range(first, len(x)):
        extend(x, lower, np.array(HYPER), k)
    np.testing.assert_allclose(lower, factor(x, HYPER), atol=1e-8)


def test_offline_and_updates_are_one_refit() -> None:
    x, y = samples(7, 24)
    mixed = fit_mixture([x[:20]], [y[:20]], models=1, size=20, room=4)
    _, _, hyper = model_of(mixed, 0, 0)
    for k in range(20, 24):
        mixed = learned(mixed, x[None, k], y[None, k], np.array([True]), hyper, similar=0.0)
    assert mixed.counts[0, 0] == 24
    query = samples(8, 6)[0]
    mean, variance = predict(mixed, query[:, None], 1)
    wanted, spread = one_model(x, y, hyper, query)
    np.testing.assert_allclose(mean[:, 0], wanted, atol=1e-7)
    np.testing.assert_allclose(variance[:, 0], spread, atol=1e-7)
    np.testing.assert_allclose(mixed.factors[0, 0], factor(mixed.inputs[0, 0], hyper), atol=1e-8)


def test_what_is_unlike_everything_opens_a_model_and_memory_never_grows() -> None:
    x, y = samples(9, 20)
    mixed = with_places(fit_mixture([x], [y], models=2, size=10), 3, 2)
    used = int((mixed.counts > 0).sum())
    shapes = {name: getattr(mixed, name).shape for name in mixed.__dataclass_fields__}
    for k in range(60):
        there = np.full(3, 10.0 + 7.0 * k)
        mixed = learned(mixed, there[None], y[None, k % 20], np.array([True]), HYPER)
    assert {name: getattr(mixed, name).shape for name in mixed.__dataclass_fields__} == shapes
    assert used == 2
    assert (mixed.counts > 0).all()
    assert np.isfinite(predict(mixed, x[:, None])[0]).all()


def test_divergence_is_that_of_the_two_predictions() -> None:
    x, y = samples(10, 12)
    lower = factor(x, HYPER)
    precision = cho_solve((lower, True), np.eye(12))
    got = divergences(precision, precision @ y, HYPER.noise)
    for k in range(12):
        rest = np.arange(12) != k
        mean, variance = one_model(x, y, HYPER, x[k : k + 1])
        other, wide = one_model(x[rest], y[rest], HYPER, x[k : k + 1])
        p, q = variance[0] + HYPER.noise, wide[0] + HYPER.noise
        wanted = 0.5 * (3 * (p / q - 1 - np.log(p / q)) + ((mean - other) ** 2).sum() / q)
        np.testing.assert_allclose(got[k], wanted, rtol=1e-5, atol=1e-8)


def test_what_others_say_already_goes_first() -> None:
    x, y = samples(11, 20)
    doubled, outputs = np.vstack([x, x[:8]]), np.vstack([y, y[:8]])
    kept = budget(doubled, outputs, HYPER, 20)
    assert len(kept) == 20
    assert all((k in kept) != (k + 20 in kept) for k in range(8))


def test_a_third_of_samples_that_follow_each_other_can_go() -> None:
    times = np.linspace(0.0, 6.0, 150)
    x = np.column_stack([np.sin(times), np.cos(times), np.sin(2 * times)])
    y = np.column_stack([x[:, 0] ** 2, x[:, 1], x[:, 2] * x[:, 0]])
    kept = budget(x, y, HYPER._replace(noise=1e-4), 97)
    query = np.column_stack([np.sin(times + 0.02), np.cos(times + 0.02), np.sin(2 * times + 0.04)])
    whole = one_model(x, y, HYPER._replace(noise=1e-4), query)[0]
    part = one_model(x[kept], y[kept], HYPER._replace(noise=1e-4), query)[0]
    assert np.abs(whole - part).mean() < 0.01 * np.abs(y).mean()


@pytest.mark.parametrize("count", [1, 4, 40])
def test_clusters_hold_every_sample_once(count: int) -> None:
    x = samples(12, 33)[0]
    found = clusters(x, count, np.random.default_rng(0))
    assert len(found) <= min(count, 33)
    np.testing.assert_array_equal(np.sort(np.concatenate(found)), np.arange(33))
