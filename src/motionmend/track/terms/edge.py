"""Observed depth edges lie on rendered ones (section 3.4.2)."""

from dataclasses import dataclass
from typing import final

from ..frame.evidence import Evidence, edges_of
from ..settings import TrackSettings
from .contract import Share, cost_of
from .surface import drawn_from
from .view import Sums, View

STANDARD = 250.0  # edge points, about as many as a body 3 m away has


@final
@dataclass(frozen=True, eq=False)
class EdgeTerm:
    """Each observed edge point draws the nearest rendered edge point in a window to itself."""

    evidence: Evidence
    settings: TrackSettings
    name: str = "edge"

    @property
    def weight(self) -> float:
        """Of one edge point: where weights are `evened` all together count as much as `STANDARD`."""
        wish = self.settings
        return wish.edge * STANDARD / max(len(self.evidence.edge_pixels), 1) if wish.evened else wish.edge

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return cost_of(self, view)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Equations 3.8 and 3.9."""
        seen, wish = self.evidence, self.settings
        if not len(seen.edge_pixels):
            return Share(0.0)
        edges = edges_of(view.depth, wish.canny)
        count = len(seen.edge_pixels)
        half, points = wish.edge_window // 2, (seen.edge_pixels, seen.edge_samples)
        cost, inliers = drawn_from(view, edges, points, seen, half, wish, 0.0, self.weight, sums)
        return Share(cost, inliers, count)
