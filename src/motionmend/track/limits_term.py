"""Joints stay within their ranges."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats
from ..bodies.performer import DOFS
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
        sums.normal.ravel()[6 * (DOFS + 1) :: DOFS + 1] += self.weight * (beyond != 0.0)
        sums.right[6:] -= self.weight * beyond
        return Share(float(self.weight * (beyond @ beyond)))

    def _beyond(self, view: View) -> Floats:
        joints, limits = view.pose.joints, self.limits[6:]
        return np.asarray(joints - np.minimum(np.maximum(joints, limits[:, 0]), limits[:, 1]))
