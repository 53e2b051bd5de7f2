"""The contract of a term of the objective (equation 3.14)."""

from dataclasses import dataclass
from typing import Protocol, final

from .view import Sums, View


@final
@dataclass(frozen=True)
class Share:
    """What a term says of one pose: its weighted cost, how many of its matches count, of how many."""

    cost: float
    inliers: int = 0
    samples: int = 0


class Term(Protocol):
    """One sum of squares, made for one frame."""

    @property
    def name(self) -> str:
        """As in `--terms`."""
        ...

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        ...

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Add the term to second order about a pose; `iteration` counts from 0."""
        ...


def cost_of(term: Term, view: View) -> float:
    """The cost of a term that finds its matches while it linearises."""
    return term.linearize(view, Sums(), 99).cost
