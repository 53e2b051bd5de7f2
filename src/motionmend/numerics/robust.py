"""Robust estimators: how much a residual costs, pulls and counts (section 2.2.2, figure 2.3)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats

STUDENT_DEGREES = 3.0  # degrees of freedom of the Student-t estimator: heavy tails, finite variance


@dataclass(frozen=True)
class Estimator:
    """A robust estimator with scale p, in the unit of the residual r.

    Attributes
    ----------
    rho : `rho(r, p)`, the cost of a residual; close to r²/2 for small r.
    weight : `weight(r, p)` = rho'(r) / r, in [0, 1], never increasing in |r|.
    """

    rho: Callable[[Floats, float], Floats]
    weight: Callable[[Floats, float], Floats]

    def influence(self, r: Floats, p: float) -> Floats:
        """rho'(r): the pull of a residual on the solution; same shape as `r`."""
        return r * self.weight(r, p)


def _welsch_rho(r: Floats, p: float) -> Floats:
    return -0.5 * p * p * np.expm1(-np.square(r / p))  # eq. 2.9


def _welsch_weight(r: Floats, p: float) -> Floats:
    return np.exp(-np.square(r / p))  # eq. 2.15: w = phi(r) / r, phi = rho'


def _tukey_rho(r: Floats, p: float) -> Floats:
    inside = np.clip(1.0 - np.square(r / p), 0.0, None)
    return (p * p / 6.0) * (1.0 - inside**3)


def _tukey_weight(r: Floats, p: float) -> Floats:
    return np.square(np.clip(1.0 - np.square(r / p), 0.0, None))


def _huber_rho(r: Floats, p: float) -> Floats:
    size = np.abs(r)
    return np.where(size <= p, 0.5 * r * r, p * size - 0.5 * p * p)


def _huber_weight(r: Floats, p: float) -> Floats:
    return p / np.maximum(np.abs(r), p)


def _student_rho(r: Floats, p: float) -> Floats:
    spread = STUDENT_DEGREES * p * p
    return 0.5 * spread * np.log1p(r * r / spread)


def _student_weight(r: Floats, p: float) -> Floats:
    return 1.0 / (1.0 + r * r / (STUDENT_DEGREES * p * p))


def _square_rho(r: Floats, p: float) -> Floats:
    return 0.5 * r * r


def _square_weight(r: Floats, p: float) -> Floats:
    return np.ones_like(r)


ESTIMATORS: Mapping[str, Estimator] = {
    "welsch": Estimator(_welsch_rho, _welsch_weight),
    "tukey": Estimator(_tukey_rho, _tukey_weight),
    "huber": Estimator(_huber_rho, _huber_weight),
    "student": Estimator(_student_rho, _student_weight),
    "square": Estimator(_square_rho, _square_weight),
}


def spread(values: Floats) -> float:
    """Standard deviation of a sample as its median absolute deviation tells it (Gaussian bulk assumed).

    Parameters
    ----------
    values : any shape, any unit; NaN is left out. An empty sample has spread 0.
    """
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return 0.0
    return float(1.4826 * np.median(np.abs(finite - np.median(finite))))
