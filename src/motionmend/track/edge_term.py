"""Observed depth edges lie on rendered ones (section 3.4.2)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..kernels import match
from .evidence import Evidence, edges_of
from .settings import TrackSettings
from .terms import Share, cost_of
from .view import Sums, View


@final
@dataclass(frozen=True, eq=False)
class EdgeTerm:
    """Each observed edge point draws the nearest rendered edge point in a window to itself."""

    evidence: Evidence
    settings: TrackSettings
    name: str = "edge"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return cost_of(self, view)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Equations 3.8 and 3.9."""
        seen, wish = self.evidence, self.settings
        if not len(seen.edge_pixels):
            return Share(0.0)
        target = edges_of(view.depth, view.points, np.zeros(view.depth.shape, np.bool_), wish.canny)
        found = np.empty(len(seen.edge_pixels), np.int64)
        none = np.empty(0, np.float32)
        match.nearest_in_window(
            seen.edge_pixels,
            seen.edge_samples,
            target,
            wish.edge_window // 2,
            wish.gate,
            seen.apart,
            none,
            seen.tones,
            0.0,
            found,
        )
        weight = wish.edge if wish.preset == "paper" else wish.edge * 250.0 / len(seen.edge_pixels)
        points, normals, bones = view.found(found)
        cost, inliers = match.gather(
            found,
            bones,
            points,
            normals,
            seen.edge_samples,
            False,
            0.0,
            wish.scale,
            weight,
            sums.hessian,
            sums.gradient,
        )
        return Share(cost, inliers, len(found))
