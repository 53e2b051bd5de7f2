"""What no body does: joints beyond their ranges, forearms inside the trunk."""

from dataclasses import dataclass
from typing import final

from ...arrays import Floats
from ...bodies.performer import FIRST, Performer
from ...kernels.bone_systems import within
from ...kernels.inside import kept_out
from .contract import Share
from .view import BONES_MOVED, MOVED_FIRST, Sums, View

SOLID = 200.0  # per m² inside the trunk, beside 1 per rad² beyond a limit
SOLID_SCALE = 0.03  # m, of Geman and McClure's estimator: where the image says so, an arm that is wrong comes through
CLEAR = 1.3  # of its radius, by which the axis of a forearm that nothing is seen of stays out


@final
@dataclass(frozen=True, eq=False)
class LimitsTerm:
    """A square beyond each of a joint's limits, nothing within; and a robust one of how deep forearms are in the trunk.

    Inside the trunk an arm is out of sight and contradicts no image, while every pixel of the trunk draws at it.

    Attributes
    ----------
    clear : (L,) m, how far the axes of the forearms, `Performer.trunk_and_forearms`, stay out of the trunk.
    weight : per rad²; `SOLID` times that per m².
    """

    clear: Floats
    weight: float
    name: str = "limits"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return self.linearize(view, Sums(), 0).cost

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Only degrees of freedom beyond a limit are touched, and those that move a forearm against the trunk."""
        body = view.performer
        beyond = within(view.pose.joints, body.limits, self.weight, sums.normal, sums.right)
        deep = kept_out(
            view.solid_placed,
            view.twists,
            MOVED_FIRST,
            BONES_MOVED,
            body.solids.arrays,
            *body.trunk_and_forearms,
            self.clear,
            SOLID_SCALE**2,
            SOLID * self.weight,
            sums.normal,
            sums.right,
        )
        return Share(beyond + deep)


def limits_term(performer: Performer, weight: float, trust: Floats) -> LimitsTerm:
    """The term for a performer.

    Parameters
    ----------
    performer : the body.
    weight : per rad².
    trust : (28,) in [0, 1], how well each joint coordinate was shown. What is seen may touch the trunk, or be wider
        than it is taken for: it only has to keep its axis outside.
    """
    solids, (_, forearms) = performer.solids, performer.trunk_and_forearms
    unseen = 1.0 - trust[FIRST[solids.bone[forearms]]]  # by the elbows' coordinates
    return LimitsTerm(CLEAR * solids.size[forearms, 0] * unseen**4, weight)
