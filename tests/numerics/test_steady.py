"""What smoothers settle to, against recursions that run until they do."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.numerics.smoother import StateSpace, kalman_smoother
from motionmend.numerics.steady import settled_covariance, settled_sum

SEEDS = st.integers(0, 10**6)


def _rule(rng, size, least, most):
    """(N, N) whose largest eigenvalue has a size between two."""
    rule = rng.normal(size=(size, size))
    return rule * rng.uniform(least, most) / np.abs(np.linalg.eigvals(rule)).max()


def _covariance(rng, size):
    root = rng.normal(size=(size, size))
    return root @ root.T


def _system(seed):
    """A, G = Hᵀ R⁻¹ H, Q of up to five states, H and R; the states may grow a little but are all observed."""
    rng = np.random.default_rng(seed)
    states = int(rng.integers(1, 6))
    transition, process = _rule(rng, states, 0.3, 1.02), _covariance(rng, states) + 0.05 * np.eye(states)
    observation, noise_var = rng.normal(size=(states, states)) + 2.0 * np.eye(states), rng.uniform(0.1, 2.0, states)
    information = observation.T @ (observation / noise_var[:, None])
    return transition, information, process, observation, noise_var


@given(SEEDS)
@settings(max_examples=50, deadline=None)
def test_the_settled_covariance_stays_when_predicted_once_more(seed):
    transition, information, process, *_ = _system(seed)
    found = settled_covariance(transition, information, process)
    known = np.linalg.inv(np.linalg.inv(found) + information)
    np.testing.assert_allclose(transition @ known @ transition.T + process, found, rtol=1e-6, atol=1e-8)
    assert np.linalg.eigvalsh(found).min() > 0


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_it_is_what_the_filter_of_a_long_recording_has_in_its_middle(seed):
    transition, information, process, observation, noise_var = _system(seed)
    size = len(transition)
    model = StateSpace(transition, process, observation, np.zeros(size), np.eye(size))
    smoothed = kalman_smoother(model, np.zeros((400, size)), noise_var)
    predicted = settled_covariance(transition, information, process)
    known = np.linalg.inv(np.linalg.inv(predicted) + information)
    back = known @ transition.T @ np.linalg.inv(predicted)
    found = settled_sum(back, known - back @ predicted @ back.T)
    np.testing.assert_allclose(found, smoothed.covariances[smoothed.which[200]], rtol=1e-5, atol=1e-7)


@given(SEEDS)
@settings(max_examples=50, deadline=None)
def test_the_settled_sum_adds_all_powers(seed):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 6))
    rule, first = _rule(rng, size, 0.0, 0.95), _covariance(rng, size)
    total, term = np.zeros_like(first), first
    for _ in range(500):
        total, term = total + term, rule @ term @ rule.T
    np.testing.assert_allclose(settled_sum(rule, first), total, rtol=1e-6, atol=1e-8)
