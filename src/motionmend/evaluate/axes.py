"""A recording that lies in other axes than the truth, and the rigid motion that brings it there."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats
from ..bodies.rigid import rigid_fit

OTHER_DEG, OTHER_M = 15.0, 0.5  # a recording turned or moved by more lies in other axes


@final
@dataclass(frozen=True, eq=False)
class Carrying:
    """A rigid motion from the axes of a recording to those of the truth.

    Attributes
    ----------
    turn, shift : (3, 3) and (3,) m; a point p comes to `turn` p + `shift`.
    turned : by how much, degrees.
    carried : by how much points are moved on average, m; NaN where none is there.
    """

    turn: Floats
    shift: Floats
    turned: float
    carried: float

    @property
    def large(self) -> bool:
        """Whether the axes cannot be the same."""
        return not (self.turned < OTHER_DEG and self.carried < OTHER_M)

    @property
    def note(self) -> str:
        """What a reader of the numbers has to know."""
        return (
            f"the other was brought to the truth's axes by one rigid motion: turned by {self.turned:.3g} degrees, its "
            f"joints moved by {self.carried:.3g} m"
        )

    def of(self, points: Floats) -> Floats:
        """Points (..., 3) m in the truth's axes."""
        return np.asarray(points @ self.turn.T + self.shift)


def carrying(other: Floats, truth: Floats) -> Carrying:
    """The rigid motion, never a mirroring, that brings all points of all frames nearest to the truth's.

    Parameters
    ----------
    other, truth : (T, P, 3) m, NaN = missing.

    Raises
    ------
    MismatchError : fewer than three points in common.
    """
    turn, shift = rigid_fit(other.reshape(-1, 3), truth.reshape(-1, 3))
    cosine = np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)
    apart = np.linalg.norm(other @ turn.T + shift - other, axis=2)
    there = np.isfinite(apart)
    carried = float(apart[there].mean()) if there.any() else float("nan")
    return Carrying(turn, shift, float(np.degrees(np.arccos(cosine))), carried)
