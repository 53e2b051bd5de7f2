"""Gauss-Newton, the nearest samples and local principal components: laws first."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.numerics.least_squares import System, gauss_newton, inverse, solve
from motionmend.numerics.local_pca import local_pca, moments
from motionmend.numerics.neighbors import Neighbors


def linear(jacobian, wanted):
    """A linear problem as a system about x."""
    return lambda x, _: System(jacobian.T @ jacobian, jacobian.T @ (wanted - jacobian @ x), {"only": 0.0}, {}, 0.0)


def test_a_linear_problem_takes_one_step_and_another_to_know_it(rng):
    jacobian, wanted = rng.normal(size=(50, 7)), rng.normal(size=50)
    found = gauss_newton(linear(jacobian, wanted), np.zeros(7), np.add, 10, tolerance=1e-9)
    np.testing.assert_allclose(found.state, np.linalg.lstsq(jacobian, wanted, rcond=None)[0], atol=1e-10)
    assert found.converged
    assert found.iterations == 2
    np.testing.assert_allclose(found.covariance(4.0), 4.0 * np.linalg.inv(jacobian.T @ jacobian), rtol=1e-6)


def test_damping_and_the_longest_step_shorten_steps(rng):
    jacobian, wanted = rng.normal(size=(50, 7)), 10 * rng.normal(size=50)
    free = gauss_newton(linear(jacobian, wanted), np.zeros(7), np.add, 1).state
    damped = gauss_newton(linear(jacobian, wanted), np.zeros(7), np.add, 1, damping=1.0).state
    short = gauss_newton(linear(jacobian, wanted), np.zeros(7), np.add, 1, longest=0.01)
    assert np.linalg.norm(damped) < 0.9 * np.linalg.norm(free)
    assert np.abs(short.state).max() == pytest.approx(0.01)
    assert not short.converged


def test_a_step_that_promises_little_is_the_last(rng):
    jacobian, wanted = rng.normal(size=(50, 7)), 5.0 + rng.normal(size=50)
    best = np.linalg.lstsq(jacobian, wanted, rcond=None)[0]

    def half_steps(x, _):  # a linear problem whose matrix is doubled: each step halves what is left
        left = wanted - jacobian @ x
        return System(2.0 * jacobian.T @ jacobian, jacobian.T @ left, {"only": float(left @ left)})

    lengths = {}
    for share in (1e-2, 1e-4, 1e-6):
        found = gauss_newton(half_steps, np.zeros(7), np.add, 50, settled=share)
        assert found.converged
        last = float(found.system.right @ np.linalg.solve(found.system.normal, found.system.right))
        assert last < share * found.system.cost
        lengths[share] = found.iterations
        assert np.linalg.norm(found.state - best) == pytest.approx(np.linalg.norm(best) / 2**found.iterations, rel=1e-6)
    assert lengths[1e-2] < lengths[1e-4] < lengths[1e-6]
    assert gauss_newton(half_steps, np.zeros(7), np.add, 12).iterations == 12


def test_what_nothing_is_known_of_stays(rng):
    jacobian = np.zeros((20, 4))
    jacobian[:, :3] = rng.normal(size=(20, 3))
    step = solve(jacobian.T @ jacobian, jacobian.T @ rng.normal(size=20))
    assert step[3] == 0.0
    assert inverse(jacobian.T @ jacobian)[3, 3] > 1e6


@given(seed=st.integers(0, 10_000), k=st.integers(1, 40), weighted=st.booleans())
def test_neighbours_are_the_nearest_in_order(seed, k, weighted):
    rng = np.random.default_rng(seed)
    samples = rng.integers(0, 4, (30, 3)).astype(np.float32)  # many ties
    query = rng.integers(0, 4, 3).astype(np.float64)
    weights = rng.integers(1, 3, 3).astype(np.float64) if weighted else None
    index, distance = Neighbors(samples).nearest(query, k, weights)
    wanted = np.sqrt(((samples - query) ** 2) @ (np.ones(3) if weights is None else weights))
    order = np.lexsort((np.arange(30), wanted))[:k]
    np.testing.assert_array_equal(index, order)
    np.testing.assert_allclose(distance, wanted[order], rtol=1e-5)


def test_local_components_hold_the_energy_and_explain_what_is_linear(rng):
    plane = rng.normal(size=(2, 10))
    samples = 3.0 + rng.normal(size=(200, 2)) @ plane
    model = local_pca(samples, 0.999)
    assert model.basis.shape == (10, 2)
    np.testing.assert_allclose((samples - model.mean) @ model.rest(), 0.0, atol=1e-9)
    np.testing.assert_allclose(model.rest() @ model.rest(), model.rest(), atol=1e-9)
    noisy = samples + 0.5 * rng.normal(size=samples.shape)
    for energy in (0.5, 0.8, 0.95):
        kept = local_pca(noisy, energy)
        share = np.cumsum(kept.variances) / kept.variances.sum()
        e = kept.basis.shape[1]
        assert share[e - 1] >= energy
        assert e == 1 or share[e - 2] < energy
    for got, wanted in zip(moments(noisy, np.full(200, 2.0)), moments(noisy), strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-12)
    covariance = np.cov(noisy.T) + 0.3**2 * np.eye(10)
    np.testing.assert_allclose(inverse(covariance), np.linalg.inv(covariance), rtol=1e-6, atol=1e-9)


def test_one_sample_is_its_own_model():
    model = local_pca(np.ones((1, 5)))
    np.testing.assert_array_equal(model.mean, np.ones(5))
    assert model.basis.shape == (5, 0)
    np.testing.assert_array_equal(model.rest(), np.eye(5))
