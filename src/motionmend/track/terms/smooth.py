"""The pose stays near the one expected (equation 3.14's last term)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ...arrays import Floats
from ...bodies.performer import DOFS, Pose
from ...kernels.bone_systems import drawn_to
from ...kernels.dense import turn_between
from .contract import Share, Term
from .view import Sums, View

FRAME = 0.035  # s from frame to frame for which weights are set: 30 Hz, and a time stamp that is a little late
LONGEST = 0.1  # s, of steps for which weights are eased: after longer ones limbs that little holds were lost


def eased(weight: float, elapsed: float) -> float:
    """The weight after a longer step: a body is as much farther from where it is expected, in proportion to time."""
    return weight * (FRAME / min(max(elapsed, FRAME), LONGEST)) ** 2


def difference(to: Pose, origin: Pose) -> Floats:
    """(34,) the increment that takes `origin` to `to`, as `advance` understands it."""
    turn = np.empty(3)
    turn_between(to.root.copy(), origin.root.copy(), turn)
    return np.concatenate((to.translation - origin.translation, turn, to.joints - origin.joints))


@final
@dataclass(frozen=True, eq=False)
class SmoothTerm:
    """A weighted sum of squares of what separates the pose from the expected one.

    Attributes
    ----------
    expected : the pose before, or what its motion leads to.
    weights : (34,) per m² and rad².
    """

    expected: Pose
    weights: Floats
    name: str = "smooth"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return float(self.weights @ difference(view.pose, self.expected) ** 2)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """A = weights, b = weights · (expected - pose): below equation 3.15."""
        away = np.empty(DOFS)
        return Share(drawn_to(view.pose.arrays, self.expected.arrays, self.weights, away, sums.normal, sums.right))


def about(terms: Sequence[Term], expected: Pose) -> list[Term]:
    """The same terms, smoothness being counted from another expected pose."""
    return [replace(term, expected=expected) if isinstance(term, SmoothTerm) else term for term in terms]
