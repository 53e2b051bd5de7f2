"""When a pose explains so little of what is seen that it is none."""

import numpy as np

from ..bodies.performer import Pose
from .readings.facing import lies

LOST = 0.45  # share of the person's pixels explained wrongly that no tracked pose has
SURELY_LOST = 0.52  # the same, whatever is usual
UNPROVEN = 0.2  # share of pixels explained wrongly, up to which a body that was lost is found
LAID = 0.26  # the same of who lies


def is_lost(usual: float, wrong: float) -> bool:
    """Whether a pose explains so little, of itself and beside what is usual with this person, that it is none.

    Parameters
    ----------
    usual : share of pixels usually explained wrongly; NaN = not known.
    wrong : share that is now.
    """
    return wrong > min(max(LOST, 2.0 * (usual if np.isfinite(usual) else 0.0)), SURELY_LOST)


def is_unproven(usual: float, pose: Pose, wrong: float) -> bool:
    """Whether a pose of a body that was lost explains so much less than is usual that it is looked for on.

    Of who lies much is hidden by the body itself, and wrong poses explain nearly as much as the right one.

    Parameters
    ----------
    usual, wrong : as of `is_lost`.
    """
    return wrong > (max(LAID, usual) if lies(pose) else max(UNPROVEN, 1.5 * usual))
