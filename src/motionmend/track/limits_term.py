"""Joints stay within their ranges."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats
from ..kernels.bone_systems import within
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
        return Share(within(view.pose.joints, self.limits, self.weight, sums.normal, sums.right))

    def _beyond(self, view: View) -> Floats:
        joints, limits = view.pose.joints, self.limits[6:]
        return np.asarray(joints - np.minimum(np.maximum(joints, limits[:, 0]), limits[:, 1]))
