"""Laws of the Kalman filter and the Rauch-Tung-Striebel smoother."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.errors import MismatchError, UsageError
from motionmend.numerics.smoother import StateSpace, kalman_filter, kalman_smoother

SEEDS = st.integers(0, 10**6)


def _model(rng, states, values):
    def cov():
        root = rng.normal(size=(states, states))
        return root @ root.T + 0.05 * np.eye(states)

    transition = rng.normal(size=(states, states))
    transition *= rng.uniform(0.3, 1.02) / np.abs(np.linalg.eigvals(transition)).max()
    return StateSpace(transition, cov(), rng.normal(size=(values, states)), rng.normal(size=states), cov())


def _problem(seed, frames=12):
    rng = np.random.default_rng(seed)
    states, values = int(rng.integers(1, 5)), int(rng.integers(1, 5))
    model = _model(rng, states, values)
    observed = rng.normal(size=(frames, values))
    observed[rng.random(observed.shape) < rng.choice([0.0, 0.3, 0.8])] = np.nan
    noise_var = rng.uniform(0.05, 2.0, observed.shape if rng.random() < 0.5 else values)
    return model, observed, noise_var


def _covariances(estimate):
    return estimate.covariances[estimate.which]


@given(SEEDS)
@settings(max_examples=30)
def test_smoother_is_the_batch_solution(seed):
    model, observed, noise_var = _problem(seed)
    mean, cov, log_likelihood = naive.batch_smooth(model, observed, noise_var)
    found = kalman_smoother(model, observed, noise_var)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(_covariances(found), cov, rtol=1e-8, atol=1e-8)
    assert found.log_likelihood == pytest.approx(log_likelihood, rel=1e-8, abs=1e-8)


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=10)
def test_smoother_is_its_plain_twin_long_after_it_settled(seed):
    model, observed, noise_var = _problem(seed, frames=150)
    observed[40:100] = np.nan_to_num(observed[40:100])  # a long stretch with one pattern
    noise_var = np.broadcast_to(noise_var, observed.shape)[0]
    mean, cov = naive.kalman_smooth(model, observed, noise_var)
    found = kalman_smoother(model, observed, noise_var)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(_covariances(found), cov, rtol=1e-8, atol=1e-8)


@given(SEEDS)
@settings(max_examples=20)
def test_filter_is_the_smoother_of_what_came_so_far(seed):
    model, observed, noise_var = _problem(seed)
    noise_var = np.broadcast_to(noise_var, observed.shape)
    found = kalman_filter(model, observed, noise_var)
    for t in (0, 5, 11):
        so_far = kalman_smoother(model, observed[: t + 1], noise_var[: t + 1])
        np.testing.assert_allclose(found.mean[t], so_far.mean[-1], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(_covariances(found)[t], _covariances(so_far)[-1], rtol=1e-9, atol=1e-9)


@given(SEEDS)
@settings(max_examples=10)
def test_agrees_with_filterpy(seed):
    filterpy = pytest.importorskip("filterpy.kalman")
    model, observed, _ = _problem(seed)
    observed = np.nan_to_num(observed)
    observed[[3, 4]] = np.nan  # filterpy knows whole frames missing only
    noise_var = np.full(observed.shape[1], 0.3)
    peer = filterpy.KalmanFilter(dim_x=len(model.start_mean), dim_z=observed.shape[1])
    peer.F, peer.Q, peer.H = model.transition, model.process_cov, model.observation
    peer.R, peer.x, peer.P = np.diag(noise_var), model.start_mean.copy(), model.start_cov.copy()
    rows = [None if np.isnan(row).any() else row for row in observed]
    means, covariances, _, _ = peer.batch_filter(rows, update_first=True)
    ours = kalman_filter(model, observed, noise_var)
    np.testing.assert_allclose(ours.mean, means, atol=1e-8)
    np.testing.assert_allclose(_covariances(ours), covariances, atol=1e-8)
    means, covariances, _, _ = peer.rts_smoother(means, covariances)
    ours = kalman_smoother(model, observed, noise_var)
    np.testing.assert_allclose(ours.mean, means, atol=1e-7)
    np.testing.assert_allclose(_covariances(ours), covariances, atol=1e-7)


@given(SEEDS)
@settings(max_examples=20)
def test_units_of_states_and_values_do_not_matter(seed):
    model, observed, noise_var = _problem(seed)
    rng = np.random.default_rng(seed)
    of_state = 10.0 ** rng.uniform(-6, 6, len(model.start_mean))
    of_value = 10.0 ** rng.uniform(-6, 6, observed.shape[1])
    other = StateSpace(
        of_state[:, None] * model.transition / of_state,
        model.process_cov * np.outer(of_state, of_state),
        of_value[:, None] * model.observation / of_state,
        model.start_mean * of_state,
        model.start_cov * np.outer(of_state, of_state),
    )
    here = kalman_smoother(model, observed, noise_var)
    there = kalman_smoother(other, observed * of_value, noise_var * of_value**2)
    np.testing.assert_allclose(there.mean, here.mean * of_state, rtol=1e-7)
    np.testing.assert_allclose(
        there.variance(other.observation), here.variance(model.observation) * of_value**2, rtol=1e-7
    )


def test_a_settled_recursion_is_not_repeated(rng):
    model = _model(rng, 4, 3)
    observed = rng.normal(size=(3000, 3))
    observed[1000:1400, 1] = np.nan
    found = kalman_smoother(model, observed, np.ones(3))
    assert len(found.covariances) < 700


def test_a_second_order_model_with_hardly_any_noise_keeps_its_covariances_positive(rng):
    lag = np.array([[1.999, -0.9991], [1.0, 0.0]])
    model = StateSpace(lag, np.diag([1e-12, 0.0]), np.array([[1.0, 0.0]]), np.zeros(2), 1e4 * np.eye(2))
    observed = np.sin(np.arange(400) / 20.0)[:, None]
    observed[100:250] = np.nan
    found = kalman_smoother(model, observed, np.array([1e-10]))
    assert (np.linalg.eigvalsh(found.covariances) >= 0).all()
    assert np.isfinite(found.mean).all()


def test_nothing_observed_gives_the_prediction(rng):
    model = _model(rng, 3, 2)
    found = kalman_smoother(model, np.full((5, 2), np.nan), np.ones(2))
    expected = [np.linalg.matrix_power(model.transition, t) @ model.start_mean for t in range(5)]
    np.testing.assert_allclose(found.mean, expected, atol=1e-10)
    assert found.log_likelihood == 0.0


def test_infinite_noise_is_the_same_as_missing():
    model, observed, _ = _problem(7)
    noise_var = np.full(observed.shape, 0.4)
    noise_var[2:6, 0] = np.inf
    gappy = observed.copy()
    gappy[2:6, 0] = np.nan
    here, there = (
        kalman_smoother(model, observed, noise_var),
        kalman_smoother(model, gappy, np.full(observed.shape, 0.4)),
    )
    np.testing.assert_array_equal(here.mean, there.mean)
    assert here.log_likelihood == there.log_likelihood


def test_no_frames_no_states(rng):
    found = kalman_smoother(_model(rng, 3, 2), np.empty((0, 2)), np.ones(2))
    assert found.mean.shape == (0, 3)
    assert found.variance(np.ones((2, 3))).shape == (0, 2)


def test_variance_of_combinations(rng):
    model, observed, noise_var = _problem(3)
    found = kalman_smoother(model, observed, noise_var)
    rows = rng.normal(size=(4, len(model.start_mean)))
    expected = [np.diag(rows @ cov @ rows.T) for cov in _covariances(found)]
    np.testing.assert_allclose(found.variance(rows), expected)


def test_refuses_what_makes_no_sense(rng):
    model = _model(rng, 3, 2)
    with pytest.raises(UsageError, match="above 0"):
        kalman_smoother(model, np.zeros((4, 2)), np.array([1.0, 0.0]))
    with pytest.raises(MismatchError, match=r"\(frames, 2\)"):
        kalman_smoother(model, np.zeros((4, 3)), np.ones(3))
    with pytest.raises(MismatchError, match="noise"):
        kalman_smoother(model, np.zeros((4, 2)), np.ones(3))
    with pytest.raises(MismatchError, match="process_cov"):
        StateSpace(np.eye(2), np.eye(3), np.eye(2), np.zeros(2), np.eye(2))
    certain = StateSpace(np.eye(2), np.zeros((2, 2)), np.eye(2), np.zeros(2), np.diag([1.0, 0.0]))
    with pytest.raises(UsageError, match="without any doubt"):
        kalman_smoother(certain, np.zeros((4, 2)), np.ones(2))
