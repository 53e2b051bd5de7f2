"""Model and observed surface lie on each other (section 3.4.1)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Floats, Ints, Singles
from ...kernels import match
from ..frame.evidence import Evidence
from ..settings import TrackSettings
from .contract import Share, cost_of
from .view import Sums, View

SHOWN = 0.1  # m; farther than this from what was seen in the frame before, a point was hidden then
WIDER = 4  # px, by which the window is wider on either side at first
_NO_TONES = np.empty(0, np.float32)


@final
@dataclass(frozen=True, eq=False)
class SurfaceTerm:
    """Each rendered point draws to the nearest observed one in a window; also each observed point the model's.

    Attributes
    ----------
    evidence, settings : of the frame.
    before : (B, 4, 4) bones in the frame before, its intensities and depths (h, w) and intrinsics: where a rendered
        point had its colour. None without colour.
    """

    evidence: Evidence
    settings: TrackSettings
    before: tuple[Floats, Singles, Singles, Floats] | None = None
    name: str = "surface"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return cost_of(self, view)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Equations 3.4 to 3.7, with robust weights and along normals as the settings say."""
        seen, wish = self.evidence, self.settings
        half = wish.window // 2 + (max(0, WIDER - 2 * iteration) if wish.two_way else 0)  # wide at first
        tones, color = self._tones(view)
        cost, inliers = match.draw_to_seen(
            view.pixels,
            view.samples,
            view.normals,
            view.bones,
            seen.depth,
            seen.intrinsics,
            half,
            wish.gate,
            seen.apart,
            tones,
            seen.tones,
            color,
            wish.along_normal,
            wish.scale,
            seen.weight,
            sums.hessian,
            sums.gradient,
        )
        total = len(view.pixels)
        if wish.two_way:
            more, good = drawn_from(
                view, view.depth, (seen.pixels, seen.samples), seen, half, wish, wish.along_back, seen.weight, sums
            )
            cost, inliers, total = cost + more, inliers + good, total + len(seen.pixels)
        return Share(cost, inliers, total)

    def _tones(self, view: View) -> tuple[Singles, float]:
        """The intensities of the rendered points that were in sight in the frame before, and what they count."""
        if self.before is None or not self.evidence.tones.size:
            return _NO_TONES, 0.0
        placed, image, depth, (fx, fy, cx, cy) = self.before
        turn = placed @ np.linalg.inv(view.placed)
        moved = turn[view.bones]
        point = np.einsum("nij,nj->ni", moved[:, :3, :3], view.samples.astype(np.float64)) + moved[:, :3, 3]
        with np.errstate(invalid="ignore", divide="ignore"):
            column = np.rint(fx * point[:, 0] / point[:, 2] + cx)
            row = np.rint(fy * point[:, 1] / point[:, 2] + cy)
        inside = (row >= 0) & (row < image.shape[0]) & (column >= 0) & (column < image.shape[1])
        tones = np.full(len(point), np.nan, np.float32)
        at = row[inside].astype(np.int64), column[inside].astype(np.int64)
        tones[inside] = np.where(np.abs(depth[at] - point[inside, 2]) < SHOWN, image[at], np.nan)
        return tones, self.settings.color_weight


def drawn_from(
    view: View,
    model: Singles,
    points: tuple[Ints, Singles],
    seen: Evidence,
    half: int,
    wish: TrackSettings,
    along: float,
    weight: float,
    sums: Sums,
) -> tuple[float, int]:
    """Observed points draw the model's nearest ones to themselves.

    Parameters
    ----------
    view : the model, h x w px.
    model : (h, w) m, the view's depth, or NaN but for those of its pixels that count.
    points : rows and columns (N, 2) and places (N, 3) in m of what is observed.
    seen, wish : of the frame.
    half : px, the window is 2 half + 1 wide and high.
    along : share of a residual that counts along the model's normal only, 0 to 1.
    weight : of one point, per m².
    sums : added to.

    Returns
    -------
    The weighted cost, and how many matches count for at least half.
    """
    cost, inliers = match.draw_from_seen(
        *points,
        model,
        view.solid,
        seen.intrinsics,
        view.solid_placed,
        view.performer.solids.arrays,
        half,
        wish.gate,
        seen.apart,
        along,
        wish.scale,
        weight,
        sums.hessian,
        sums.gradient,
    )
    return cost, inliers
