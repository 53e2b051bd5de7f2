"""Model and observed surface lie on each other (section 3.4.1)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats, Singles
from ..kernels import match
from .evidence import Evidence
from .settings import TrackSettings
from .terms import Share, cost_of
from .view import Sums, View

_NO_TONES = np.empty(0, np.float32)


@final
@dataclass(frozen=True, eq=False)
class SurfaceTerm:
    """Each rendered point draws to the nearest observed one in a window; also each observed point the model's.

    Attributes
    ----------
    evidence, settings : of the frame.
    before : (B, 4, 4) bones in the frame before, and its raster `before_tones`, `before_intrinsics`: where a rendered
        point had its colour. None without colour.
    """

    evidence: Evidence
    settings: TrackSettings
    before: tuple[Floats, Singles, Floats] | None = None
    name: str = "surface"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return cost_of(self, view)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Equations 3.4 to 3.7, with robust weights and along normals as the settings say."""
        seen, wish = self.evidence, self.settings
        half = wish.window // 2 + (max(0, 4 - 2 * iteration) if wish.two_way else 0)  # wide at first
        tones, color = self._tones(view)
        found = np.empty(len(view.pixels), np.int64)
        match.nearest_in_window(
            view.pixels, view.samples, seen.points, half, wish.gate, seen.apart, tones, seen.tones, color, found
        )
        hessian, gradient = sums.hessian, sums.gradient
        cost, inliers = match.gather(
            found,
            view.bones,
            view.samples,
            view.normals,
            seen.points.reshape(-1, 3),
            True,
            wish.along_normal,
            wish.scale,
            seen.weight,
            hessian,
            gradient,
        )
        total = len(found)
        if wish.two_way:
            found = np.empty(len(seen.pixels), np.int64)
            match.nearest_in_window(
                seen.pixels, seen.samples, view.points, half, wish.gate, seen.apart, _NO_TONES, seen.tones, 0.0, found
            )
            points, normals, bones = view.found(found)
            more, good = match.gather(
                found,
                bones,
                points,
                normals,
                seen.samples,
                False,
                wish.along_back,
                wish.scale,
                seen.weight,
                hessian,
                gradient,
            )
            cost, inliers, total = cost + more, inliers + good, total + len(found)
        return Share(cost, inliers, total)

    def _tones(self, view: View) -> tuple[Singles, float]:
        """The intensities the rendered points had in the frame before, and what they count."""
        if self.before is None or not self.evidence.tones.size:
            return _NO_TONES, 0.0
        placed, image, (fx, fy, cx, cy) = self.before
        turn = placed @ np.linalg.inv(view.placed)
        moved = turn[view.bones]
        point = np.einsum("nij,nj->ni", moved[:, :3, :3], view.samples.astype(np.float64)) + moved[:, :3, 3]
        with np.errstate(invalid="ignore", divide="ignore"):
            column = np.rint(fx * point[:, 0] / point[:, 2] + cx)
            row = np.rint(fy * point[:, 1] / point[:, 2] + cy)
        inside = (row >= 0) & (row < image.shape[0]) & (column >= 0) & (column < image.shape[1])
        tones = np.full(len(point), np.nan, np.float32)
        tones[inside] = image[row[inside].astype(np.int64), column[inside].astype(np.int64)]
        return tones, self.settings.color_weight
