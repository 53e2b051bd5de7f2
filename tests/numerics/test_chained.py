"""Laws of systems tied to the line between their neighbours."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.numerics.chained import chained

SEEDS = st.integers(0, 10**6)


def case(seed):
    rng = np.random.default_rng(seed)
    count, size = int(rng.integers(1, 9)), int(rng.integers(1, 5))
    root = rng.normal(size=(count, size, size))
    normal = root @ root.swapaxes(1, 2) + 0.1 * np.eye(size)
    right, bent = rng.normal(size=(2, count, size))
    return normal, right, bent, 10.0 ** rng.uniform(-2, 2, (count, size)), rng.uniform(0.2, 0.8, count)


def cost(steps, normal, right, bent, stiffness, share):
    own = sum(x @ n @ x - 2.0 * r @ x for x, n, r in zip(steps, normal, right, strict=True))
    tied = 0.0
    for t in range(1, len(steps) - 1):
        line = (1.0 - share[t]) * steps[t - 1] + share[t] * steps[t + 1]
        tied += stiffness[t] @ (bent[t] + steps[t] - line) ** 2
    return own + tied


@given(SEEDS)
@settings(max_examples=50)
def test_nothing_near_costs_less_but_for_the_damping(seed):
    given_ = case(seed)
    steps = chained(*given_)
    # Damping adds `LIFT` of a diagonal: undone by giving it what it takes.
    damped = given_[0] + 1e-3 * given_[0] * np.eye(given_[0].shape[1])
    least, rng = cost(steps, damped, *given_[1:]), np.random.default_rng(seed)
    for _ in range(20):
        aside = steps + 10.0 ** rng.uniform(-3, 0) * rng.normal(size=steps.shape)
        assert cost(aside, damped, *given_[1:]) >= least - 1e-6 * (1.0 + abs(least))


@given(SEEDS)
@settings(max_examples=30)
def test_without_stiffness_every_moment_goes_its_own_way(seed):
    normal, right, bent, stiffness, share = case(seed)
    alone = chained(normal, right, bent, 0.0 * stiffness, share)
    for n, r, x in zip(normal, right, alone, strict=True):
        np.testing.assert_allclose((n + 1e-3 * n * np.eye(len(r))) @ x, r, atol=1e-6)


@given(SEEDS)
@settings(max_examples=30)
def test_stiff_as_a_rod_they_lie_on_a_line(seed):
    normal, right, bent, _, share = case(seed)
    share[:] = 0.5
    steps = chained(normal, right, bent, np.full(bent.shape, 1e7), share)
    off = bent[1:-1] + steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])
    assert np.abs(off).max(initial=0.0) < 1e-3


def test_what_nothing_is_known_of_stays():
    normal, right = np.zeros((5, 3, 3)), np.zeros((5, 3))
    np.testing.assert_array_equal(chained(normal, right, right, right, np.full(5, 0.5)), right)
