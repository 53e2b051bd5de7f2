"""A few values kept in rising order, for their median."""

from ..arrays import Floats, Singles
from .compile import compiled


@compiled
def insert(values: Floats | Singles, known: int, value: float) -> None:
    """One more among the first `known` of values (N,), which rise: they are few, and nearly sorted as a rule."""
    at = known
    while at > 0 and values[at - 1] > value:
        values[at] = values[at - 1]
        at -= 1
    values[at] = value


@compiled
def middle(values: Floats | Singles, known: int) -> float:
    """The median of the first `known` of values (N,), which rise."""
    return float(0.5 * (values[(known - 1) // 2] + values[known // 2]))
