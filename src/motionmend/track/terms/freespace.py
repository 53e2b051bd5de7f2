"""The body is not where nobody is seen."""

from dataclasses import dataclass
from typing import final

from ...bodies.performer import Pose
from ...kernels import match
from ..frame.evidence import Evidence
from ..settings import TrackSettings
from .contract import Share, cost_of
from .view import Sums, View

REACH = 0.5  # m, a point is drawn from so far and no farther


@final
@dataclass(frozen=True, eq=False)
class FreespaceTerm:
    """Rendered points on free pixels are drawn sideways to the nearest pixel that may hold them."""

    evidence: Evidence
    settings: TrackSettings
    name: str = "freespace"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return cost_of(self, view)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """One residual per rendered point outside: in the image's plane, scaled to metres at the point's depth."""
        seen = self.evidence
        fx, fy, _, _ = seen.intrinsics
        cost, outside = match.push_out(
            view.pixels,
            view.bones,
            view.samples,
            seen.free,
            far_at(view.pose, seen),
            fx,
            fy,
            self.settings.free_scale,
            self.settings.freespace * seen.weight,
            sums.hessian,
            sums.gradient,
        )
        return Share(cost, 0, outside)


def far_at(pose: Pose, evidence: Evidence) -> int:
    """px, how far a rendered point is drawn."""
    return round(REACH * evidence.camera.fx / max(float(pose.translation[2]), 0.3))
