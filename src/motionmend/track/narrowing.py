"""The best of many poses looked for closer and closer: the cross-entropy method (Rubinstein 1999)."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Floats


def narrowed(
    cost: Callable[[Floats], Floats],
    some: Floats,
    costs: Floats,
    limits: Floats,
    spreads: Sequence[float],
    kept: int,
    drawn: int,
    rng: np.random.Generator,
) -> tuple[Floats, float]:
    """The cheapest of some values and of those drawn about the best of them, with its cost; never a worse one.

    Parameters
    ----------
    cost : (C, n) values to their costs (C,).
    some, costs : (C, n) values to begin with, and what they cost.
    limits : (n, 2) least and most of each value.
    spreads : standard deviation of what is drawn in each round, in the values' unit.
    kept, drawn : how many of the best are kept in each round, and how many are drawn about them.
    rng : that draws.
    """
    low, high = limits.T
    for spread in spreads:
        best = np.argsort(costs, kind="stable")[:kept]
        some, costs = some[best], costs[best]
        fresh = some[rng.integers(len(some), size=drawn)] + spread * rng.normal(size=(drawn, some.shape[1]))
        fresh = np.clip(fresh, low, high)
        some, costs = np.concatenate((some, fresh)), np.concatenate((costs, cost(fresh)))
    first = int(np.argmin(costs))
    return some[first], float(costs[first])
