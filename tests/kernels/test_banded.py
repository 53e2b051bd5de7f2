"""Pentadiagonal systems of second-order walks against dense matrices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
import naive_denoise
from motionmend.kernels.banded import bend_back, bend_forward, solve_walks, step_along, walk_certainty, walk_factors

SIZES = st.tuples(st.integers(1, 14), st.integers(1, 3), st.integers(0, 10**6))


def _system(size):
    frames, walks, seed = size
    rng = np.random.default_rng(seed)
    weight = np.exp(rng.normal(0, 2, (frames, walks)))
    return weight, np.exp(rng.normal(0, 2, (frames, walks))), rng.normal(size=(frames, walks))


@given(SIZES)
@settings(max_examples=60)
def test_the_factors_make_the_system(size):
    weight, stiffness, _ = _system(size)
    diagonal, first, second = walk_factors(weight, stiffness)
    for n in range(weight.shape[1]):
        lower = np.eye(len(weight)) + np.diag(first[1:, n], -1)
        if len(weight) > 2:
            lower += np.diag(second[2:, n], -2)
        whole = lower @ np.diag(diagonal[:, n]) @ lower.T
        wanted = naive.walk_system(weight[:, n], stiffness[:, n])
        np.testing.assert_allclose(whole, wanted, rtol=1e-9, atol=1e-9 * wanted.max())


@given(SIZES)
@settings(max_examples=60)
def test_solutions_are_the_dense_ones(size):
    weight, stiffness, right = _system(size)
    found = solve_walks(*walk_factors(weight, stiffness), right)
    for n in range(weight.shape[1]):
        dense = np.linalg.solve(naive.walk_system(weight[:, n], stiffness[:, n]), right[:, n])
        np.testing.assert_allclose(found[:, n], dense, rtol=1e-7, atol=1e-7 * np.abs(dense).max())


def test_two_samples_hold_a_walk_that_has_no_others(rng):
    """Any line costs nothing: with two samples and no more the answer is the line through them."""
    weight = np.zeros((12, 1))
    weight[[2, 7], 0] = 3.0
    line = 4.0 + 0.7 * np.arange(12.0)[:, None]
    found = solve_walks(*walk_factors(weight, np.full((12, 1), 5.0)), weight * line)
    np.testing.assert_allclose(found, line, rtol=1e-6)


@pytest.mark.parametrize("stiffness", [1e7, 1e9, 1e12])
def test_a_walk_that_hardly_any_sample_holds_keeps_its_pivots(rng, stiffness):
    """As far as rounding goes nothing is left of them; below zero they would turn the smoother back."""
    weight, stiff = np.full((400, 3), 1e-9), stiffness * np.exp(rng.normal(0, 1, (400, 3)))
    diagonal, first, second = walk_factors(weight, stiff)
    assert (diagonal > 0).all()
    assert np.isfinite(solve_walks(diagonal, first, second, np.ones((400, 3)))).all()


def test_the_right_hand_side_stays_as_it_was(rng):
    weight, stiffness, right = _system((9, 2, 3))
    before = right.copy()
    solve_walks(*walk_factors(weight, stiffness), right)
    np.testing.assert_array_equal(right, before)


def _samples(seed, frames):
    rng = np.random.default_rng(seed)
    weight = np.exp(rng.normal(0, 1, (frames, 3)))
    weight[rng.random(weight.shape) < rng.choice([0.0, 0.4, 0.9])] = 0.0
    return rng, weight, np.exp(rng.normal(0, 1, weight.shape)), np.exp(rng.normal(0, 1, (2, 3)))


@given(st.integers(0, 10**6), st.integers(1, 16))
@settings(max_examples=60)
def test_certainty_is_that_of_all_samples_at_once(seed, frames):
    _, weight, step_var, (place_var, speed_var) = _samples(seed, frames)
    variance, doubt = walk_certainty(weight, step_var, place_var, speed_var)
    for c in range(3):
        dense = naive.walk_certainty(weight[:, c], step_var[:, c], place_var[c], speed_var[c])
        np.testing.assert_allclose(variance[:, c], dense[0], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(doubt[:, c], np.clip(dense[1], 1e-3, 1.0), rtol=1e-6, atol=1e-9)


@given(st.integers(0, 10**6), st.integers(2, 16))
@settings(max_examples=40)
def test_one_more_sample_never_makes_less_sure(seed, frames):
    rng, weight, step_var, (place_var, speed_var) = _samples(seed, frames)
    more = weight.copy()
    more[rng.integers(frames)] += 1.0
    few, many = (walk_certainty(w, step_var, place_var, speed_var) for w in (weight, more))
    for less_seen, more_seen in zip(few, many, strict=True):
        assert (more_seen <= less_seen * (1 + 1e-9)).all()


def test_a_walk_never_seen_is_as_unsure_as_its_prior():
    variance, doubt = walk_certainty(np.zeros((6, 1)), np.full((6, 1), 0.5), np.array([4.0]), np.array([0.0]))
    t = np.arange(6)
    wanted = [4.0 + 0.5 * sum((u - s + 1) ** 2 for s in range(1, u + 1)) for u in t]
    np.testing.assert_allclose(variance[:, 0], wanted, rtol=1e-12)
    assert (doubt == 1.0).all()


def test_certainty_far_from_its_ends_does_not_feel_a_vague_start():
    """Vague beginnings are large numbers: what they cost in precision must not show."""
    weight, step_var = np.ones((200, 1)), np.full((200, 1), 1e-4)
    vague = walk_certainty(weight, step_var, np.array([1e6]), np.array([1e6]))[0]
    known = walk_certainty(weight, step_var, np.array([1.0]), np.array([1.0]))[0]
    assert vague[100, 0] == pytest.approx(known[100, 0], rel=1e-4)
    assert (vague > 0).all()


@given(seed=st.integers(0, 10**6), free=st.floats(1e4, 1e8), sure=st.floats(10.0, 1e6))
def test_sure_samples_beside_free_steps_are_sure(seed, free, sure):
    """Between a clean sample and one that is nowhere near, all precision of their difference may be lost."""
    rng, weight, step_var, (place_var, speed_var) = _samples(seed, 30)
    weight, step_var = sure * weight, np.where(rng.random(step_var.shape) < 0.3, free, step_var / sure)
    variance, doubt = walk_certainty(weight, step_var, place_var, speed_var)
    assert (variance > 0.0).all()
    seen = weight > 0.0
    assert (variance[seen] * weight[seen] <= 1.0 + 1e-9).all()
    alone = np.where(seen[1:-1] & (step_var[1:-1] == free) & (step_var[2:] == free), weight[1:-1] * variance[1:-1], 1.0)
    assert (alone > 0.1).all()  # hardly anything else tells of it
    assert ((doubt > 0.0) & (doubt <= 1.0)).all()


@given(SIZES)
@settings(max_examples=40)
def test_bends_forward_and_back_are_those_of_the_plain_twins(size):
    weight, scale, x = _system((size[0] + 2, *size[1:]))
    bend = bend_forward(x, scale)
    np.testing.assert_allclose(bend, naive_denoise.bend_forward(x, scale), rtol=1e-12, atol=1e-12)
    back = bend_back(x, weight, bend, scale)
    wanted = naive_denoise.bend_back(x, weight, bend, scale)
    np.testing.assert_allclose(back, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())
    for n in range(x.shape[1]):  # together they are the system that the factors solve
        system = naive.walk_system(weight[:, n], np.square(scale[:, n]))
        np.testing.assert_allclose(back[:, n], system @ x[:, n], rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.slow
@given(SIZES, st.floats(-3, 3))
@settings(max_examples=40)
def test_a_step_goes_along_the_direction_and_changes_nothing_else(size, length):
    direction, turned, x = _system(size)
    residual = x[::-1].copy()
    wanted = naive_denoise.step_along(x, residual, direction, turned, length)
    kept = direction.copy(), turned.copy()
    step_along(x, residual, direction, turned, length)
    np.testing.assert_allclose(x, wanted[0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(residual, wanted[1], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal((direction, turned), kept)
