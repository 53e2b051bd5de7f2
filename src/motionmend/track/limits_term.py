"""Joints stay within their ranges."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats
from .terms import Share
from .view import Sums, View


@final
@dataclass(frozen=True, eq=False)
class LimitsTerm:
    """A square beyond each limit, nothing within.

    Attributes
    ----------
    limits : (34, 2) rad; only those of the joints count.
    weight : per rad².
    """

    limits: Floats
    weight: float
    name: str = "limits"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return float(self.weight * (self._beyond(view) ** 2).sum())

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Only degrees of freedom beyond a limit are touched."""
        beyond = self._beyond(view)
        out = 6 + np.flatnonzero(beyond)
        sums.normal[out, out] += self.weight
        sums.right[6:] -= self.weight * beyond
        return Share(float(self.weight * (beyond**2).sum()))

    def _beyond(self, view: View) -> Floats:
        low, high = self.limits[6:, 0], self.limits[6:, 1]
        return np.asarray(np.maximum(view.pose.joints - high, 0.0) - np.maximum(low - view.pose.joints, 0.0))
