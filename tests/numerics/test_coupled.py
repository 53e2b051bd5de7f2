"""Laws of the coupled smoother: it solves the equations it states, and nothing else moves it."""

from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.kernels.banded import walk_certainty
from motionmend.numerics import coupled
from motionmend.numerics.coupled import couple, lone_step_variance, smooth_coupled

SEEDS = st.integers(0, 10**6)


def _covariance(rng, channels):
    """A covariance with a few strong directions, as bodies have them, in uneven units."""
    mixing = rng.normal(size=(channels, channels)) * np.exp(-np.arange(channels))
    unit = np.exp(rng.normal(0, 1, channels))
    return 1e-2 * np.multiply.outer(unit, unit) * (mixing @ mixing.T + 0.05 * np.eye(channels))


def _case(seed, frames=25, channels=4, missing=None, uneven=1.0):
    rng = np.random.default_rng(seed)
    covariance = _covariance(rng, channels)
    scale = np.exp(uneven * rng.normal(0, 0.7, (frames, channels)))
    weight = np.exp(rng.normal(0, uneven, (frames, channels)))
    missing = rng.choice([0.0, 0.1, 0.6]) if missing is None else missing
    weight[rng.random(weight.shape) < missing] = 0.0
    if missing and frames > 20:
        weight[8:15, 0] = 0.0  # a gap
    weight[[1, -2]] = np.maximum(weight[[1, -2]], 0.5)  # two samples hold the line of each channel
    observed = np.cumsum(np.cumsum(rng.normal(size=weight.shape), axis=0), axis=0)
    return observed, weight, covariance, scale


def _system(weight, covariance, scale):
    """(T C, T C) Hessian of the objective, dense, frames first."""
    frames, channels = weight.shape
    bends = np.kron(np.diff(np.eye(frames), n=2, axis=0), np.eye(channels)) / scale[2:].reshape(-1, 1)
    precision = np.kron(np.eye(frames - 2), np.linalg.inv(covariance))
    return np.diag(weight.ravel()) + bends.T @ precision @ bends


def _dense(observed, weight, covariance, scale):
    system = _system(weight, covariance, scale)
    return np.linalg.solve(system, (weight * observed).ravel()).reshape(observed.shape)


def _deviation(weight, covariance, scale):
    """(T, C) what the samples leave open of each value."""
    return np.sqrt(np.diag(np.linalg.inv(_system(weight, covariance, scale)))).reshape(weight.shape)


@contextmanager
def carried_on():
    """Steps until nothing is left to gain."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coupled, "TOLERANCE", 1e-6)
        patch.setattr(coupled, "MOST_STEPS", 2000)
        yield


def _objective(values, observed, weight, covariance, scale):
    bend = (values[:-2] - 2 * values[1:-1] + values[2:]) / scale[2:]
    return float((weight * np.square(values - observed)).sum() + (bend @ np.linalg.inv(covariance) * bend).sum())


@given(SEEDS)
@settings(max_examples=20)
def test_carried_on_it_is_the_dense_solution(seed):
    case = _case(seed)
    with carried_on():
        found, _ = smooth_coupled(*case)
    wanted = _dense(*case)
    deviation = _deviation(*case[1:])
    assert (np.abs(found - wanted) < 1e-3 * deviation + 1e-7 * np.abs(wanted)).all()


@given(SEEDS)
@settings(max_examples=20)
def test_it_stops_within_a_share_of_what_the_samples_leave_open(seed):
    case = _case(seed)
    found, steps = smooth_coupled(*case)
    system = _system(*case[1:])
    away = (found - _dense(*case)).ravel()
    assert steps < coupled.MOST_STEPS
    # the stop is judged through a preconditioner: allow it to be ten times too hopeful
    assert np.sqrt(away @ system @ away / away.size) < 10 * coupled.TOLERANCE


@given(SEEDS)
@settings(max_examples=20)
def test_what_stands_at_weight_0_has_no_influence(seed):
    observed, weight, covariance, scale = _case(seed, missing=0.3)
    other = np.where(weight > 0, observed, np.random.default_rng(seed).normal(0, 1e4, observed.shape))
    one, two = (smooth_coupled(y, weight, covariance, scale)[0] for y in (observed, other))
    np.testing.assert_array_equal(one, two)


@given(SEEDS)
@settings(max_examples=15)
def test_the_objective_never_rises_with_more_steps(seed):
    case = _case(seed)
    costs = []
    for most in range(8):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(coupled, "MOST_STEPS", most)
            found, steps = smooth_coupled(*case)
        assert steps <= most
        costs.append(_objective(found, *case))
    assert (np.diff(costs) <= 1e-9 * costs[0]).all()


@given(SEEDS)
@settings(max_examples=15)
def test_a_start_at_the_solution_takes_no_step_and_no_start_changes_the_end(seed):
    case = _case(seed)
    wanted = _dense(*case)
    found, steps = smooth_coupled(*case, start=wanted)
    assert steps == 0
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)
    with carried_on():
        far, _ = smooth_coupled(*case, start=wanted + np.random.default_rng(seed).normal(0, 30, wanted.shape))
        near, _ = smooth_coupled(*case)
    deviation = _deviation(*case[1:])
    assert (np.abs(far - near) < 2e-3 * deviation + 1e-7 * np.abs(wanted)).all()


@given(SEEDS)
@settings(max_examples=15)
def test_straight_lines_stay_as_they_are(seed):
    observed, weight, covariance, scale = _case(seed)
    rng = np.random.default_rng(seed)
    lines = rng.normal(0, 20, observed.shape[1]) + np.arange(len(observed))[:, None] * rng.normal(size=4)
    with carried_on():
        found, _ = smooth_coupled(lines, weight, covariance, scale)
    np.testing.assert_allclose(found, lines, rtol=1e-4, atol=1e-3)


@given(SEEDS)
@settings(max_examples=15)
def test_units_of_the_channels_do_not_matter(seed):
    """Degrees or radians: the scaled problem has the scaled answer."""
    observed, weight, covariance, scale = _case(seed, missing=0.1)
    unit = np.exp(np.random.default_rng(seed).normal(0, 2, observed.shape[1]))
    with carried_on():
        one, _ = smooth_coupled(observed, weight, covariance, scale)
        two, _ = smooth_coupled(observed * unit, weight / unit**2, covariance * np.multiply.outer(unit, unit), scale)
    deviation = _deviation(weight, covariance, scale)
    assert (np.abs(two / unit - one) < 1e-3 * deviation + 1e-6 * np.abs(one)).all()


def test_a_channel_that_goes_with_another_is_carried_through_its_gap(rng):
    """Steps of two channels alike: what the one does in the other's gap shows in both."""
    truth = np.cumsum(np.cumsum(rng.normal(0, 0.3, (60, 1)), axis=0), axis=0) * [1.0, 1.0]
    weight = np.full(truth.shape, 100.0)
    weight[20:35, 1] = 0.0
    alike = 0.09 * np.array([[1.0, 0.999], [0.999, 1.0]])
    together, _ = smooth_coupled(truth, weight, alike, np.ones(truth.shape))
    alone, _ = smooth_coupled(truth, weight, np.diag(np.diag(alike)), np.ones(truth.shape))
    away = [np.abs(found - truth)[20:35, 1].max() for found in (together, alone)]
    assert away[0] < 0.2 * away[1]


@given(SEEDS)
@settings(max_examples=20)
def test_coupling_takes_the_covariance_apart(seed):
    _, weight, covariance, _ = _case(seed)
    found = couple(weight, covariance)
    scaled = (found.vectors * found.values) @ found.vectors.T
    np.testing.assert_allclose(scaled * np.multiply.outer(found.unit, found.unit), covariance, rtol=1e-6, atol=1e-10)
    assert (found.values > 0).all()


@given(SEEDS)
@settings(max_examples=15)
def test_a_channel_never_seen_leaves_the_others_as_they_are(seed):
    observed, weight, covariance, scale = _case(seed)
    weight[:, 1] = 0.0
    others = [0, 2, 3]
    with carried_on():
        found, _ = smooth_coupled(observed, weight, covariance, scale)
    rest = observed[:, others], weight[:, others], covariance[np.ix_(others, others)], scale[:, others]
    wanted = _dense(*rest)
    deviation = _deviation(*rest[1:])
    assert np.isfinite(found).all()
    assert (np.abs(found[:, others] - wanted) < 1e-3 * deviation + 1e-6 * np.abs(wanted)).all()


def test_where_nothing_weighs_anything_the_start_stays(rng):
    start = rng.normal(size=(9, 4))
    nothing = np.zeros((9, 4))
    for begin, wanted in ((None, nothing), (np.cumsum(np.ones((9, 4)), axis=0), np.cumsum(np.ones((9, 4)), axis=0))):
        found, _ = smooth_coupled(start, nothing, _covariance(rng, 4), np.ones((9, 4)), begin)
        np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_a_covariance_without_full_rank_is_coupled_too(rng):
    one = rng.normal(size=(5, 2))
    found = couple(np.ones((9, 5)), one @ one.T)
    assert (found.values > 0).all()
    values, _ = smooth_coupled(rng.normal(size=(9, 5)), np.ones((9, 5)), one @ one.T, np.ones((9, 5)))
    assert np.isfinite(values).all()


@given(SEEDS, st.integers(5, 400))
@settings(max_examples=15)
def test_channels_that_go_alone_keep_their_own_step_variance(seed, frames):
    rng = np.random.default_rng(seed)
    steps = np.exp(rng.normal(-4, 2, 4))
    weight = np.broadcast_to(np.exp(rng.normal(0, 1, 4)), (frames, 4)).copy()
    np.testing.assert_allclose(lone_step_variance(weight, np.diag(steps)), steps, rtol=1e-6)


@given(SEEDS)
@settings(max_examples=15)
def test_going_together_never_raises_the_step_variance(seed):
    _, weight, covariance, _ = _case(seed, frames=60)
    found = lone_step_variance(weight, covariance)
    assert (found > 0).all()
    assert (found <= np.diag(covariance) * (1 + 1e-9)).all()


@given(SEEDS)
@settings(max_examples=15)
def test_a_walk_smoothed_alone_with_the_lone_variance_is_as_sure_as_with_the_others(seed):
    rng = np.random.default_rng(seed)
    covariance, vague = _covariance(rng, 4), np.full(4, 1e6)
    weight = np.broadcast_to(np.exp(rng.normal(0, 0.5, 4)), (60, 4)).copy()
    lone = np.broadcast_to(lone_step_variance(weight, covariance), (60, 4)).copy()
    alone, _ = walk_certainty(weight, lone, vague, vague)
    together = _deviation(weight, covariance, np.ones((60, 4)))
    np.testing.assert_allclose(np.sqrt(alone[30]), together[30], rtol=0.1)
