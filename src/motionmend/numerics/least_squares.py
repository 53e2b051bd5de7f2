"""Damped Gauss-Newton over a sum of terms (equations 3.14-3.16), and all that the solver knows at its end."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar, final

import numpy as np

from ..arrays import Floats

State = TypeVar("State")


@final
@dataclass(frozen=True, eq=False)
class System:
    """A sum of squares to second order about one state.

    Attributes
    ----------
    normal : (D, D), the sum of weighted Jᵀ J (A_total of equation 3.15).
    right : (D,), the sum of weighted Jᵀ b (b_total).
    costs : of each term, weighted.
    inliers : of each term that has matches.
    samples : all residuals that the sum counts, in full; what a covariance is scaled by.
    """

    normal: Floats
    right: Floats
    costs: Mapping[str, float] = field(default_factory=dict)
    inliers: Mapping[str, int] = field(default_factory=dict)
    samples: float = 0.0

    @property
    def cost(self) -> float:
        """The sum of all terms."""
        return float(sum(self.costs.values()))


@final
@dataclass(frozen=True, eq=False)
class Solution(Generic[State]):
    """Where Gauss-Newton ended.

    Attributes
    ----------
    state : the last one.
    system : linearised at the state before the last step.
    iterations : steps taken.
    converged : the last step was as short, or promised as little, as asked.
    """

    state: State
    system: System
    iterations: int
    converged: bool

    def covariance(self, variance: float) -> Floats:
        """(D, D): `variance` of a residual of weight one, times the inverse of the normal matrix."""
        return variance * inverse(self.system.normal)


def gauss_newton(
    linearize: Callable[[State, int], System],
    state: State,
    move: Callable[[State, Floats], State],
    iterations: int,
    damping: float = 0.0,
    tolerance: float = 0.0,
    longest: float = float("inf"),
    settled: float = 0.0,
) -> Solution[State]:
    """Step by step to a minimum of a sum of squares whose terms may be matched anew at every step.

    Parameters
    ----------
    linearize : of a state and the number of the step.
    state : to start from.
    move : a state and an increment (D,) to the next state.
    iterations : at most; at least one.
    damping : added to the diagonal, relative to it (Levenberg and Marquardt's).
    tolerance : a step whose largest component is shorter ends the search.
    longest : a step whose largest component would be longer is shortened to it.
    settled : so does a step that promises, to first order, to save a smaller share of the cost than this: the square
        of Newton's decrement beside the cost.
    """
    for taken in range(1, max(iterations, 1) + 1):
        system = linearize(state, taken - 1)
        step = solve(system.normal, system.right, damping)  # eq. 3.16
        size, promised = float(np.abs(step).max()), float(step @ system.right)
        if size > longest:
            step = step * (longest / size)
        state = move(state, step)
        if size < tolerance or promised < settled * system.cost:
            return Solution(state, system, taken, True)
    return Solution(state, system, taken, False)


def solve(normal: Floats, right: Floats, damping: float = 0.0) -> Floats:
    """`normal`⁻¹ `right`, damped; directions nothing is known of stay where they are.

    A symmetric, positive semi-definite (D, D) and (D,); damping is relative to the diagonal.
    """
    from ..kernels.dense import factor_and_solve

    diagonal = np.diagonal(normal)
    lifted, step = normal.copy(), right.copy()
    lifted.ravel()[:: len(lifted) + 1] += damping * diagonal + 1e-12 * max(float(diagonal.max()), 1e-300)
    if not factor_and_solve(lifted, step):
        step = np.linalg.pinv(normal, hermitian=True) @ right
    return step


def inverse(normal: Floats) -> Floats:
    """Inverse of a symmetric, positive semi-definite matrix; what is not known gets a very large variance."""
    from ..kernels.dense import inverted

    lifted, found = normal.copy(), np.empty(normal.shape)
    lifted.ravel()[:: len(lifted) + 1] += 1e-12 * max(float(normal.ravel()[:: len(normal) + 1].max()), 1e-300)
    if not inverted(lifted.copy(), found):
        found = np.asarray(np.linalg.inv(lifted), np.float64)
    return found
