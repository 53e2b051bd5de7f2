"""What the feet tell of two readings of one body: read the wrong way round, they are not where something is seen.

Only what is seen counts. Where a foot should be and nothing is, it may have been taken away with the floor.
"""

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.performer import LANDMARKS, Performer, Pose, landmarks
from ..limbs.other_poses import Coarse, cast_parts

ABOUT = 0.30  # m about each ankle, in which a foot is
MOST = 0.06  # m, a difference in depth that is as wrong as can be
BESIDE = 0.6  # of that counts a pixel beside the body: trousers are wider than legs
FEW = 30.0  # pixels, of which as many tell half
ANKLES = [LANDMARKS.index(name) for name in ("l_ankle", "r_ankle")]


def feet_against(performer: Performer, pose: Pose, other: Pose, coarse: Coarse) -> float:
    """By how much larger a share of the feet's pixels a pose explains wrongly than another; 0 where no feet are seen.

    Parameters
    ----------
    performer, pose, other : the two readings. coarse : the frame.
    """
    ankles = np.concatenate([landmarks(performer, one)[ANKLES] for one in (pose, other)])
    feet = _near(ankles, coarse)
    more = _wrong(performer, pose, feet, coarse) - _wrong(performer, other, feet, coarse)
    return more / (float(feet.sum()) + FEW)


def _near(ankles: Floats, coarse: Coarse) -> Bools:
    """What may be a foot: of who shows the trunk alone the feet are guessed, before or behind it as often as not."""
    fx, fy, cx, cy = coarse.intrinsics
    rows, columns = np.indices(coarse.seen.shape)
    near = np.zeros(coarse.seen.shape, np.bool_)
    for x, y, z in ankles:
        if z > 0.0:
            away = ((columns - cx) / fx - x / z) ** 2 + ((rows - cy) / fy - y / z) ** 2
            with np.errstate(invalid="ignore"):
                near |= (away < (ABOUT / z) ** 2) & (np.abs(coarse.seen - z) < ABOUT)
    return near


def _wrong(performer: Performer, pose: Pose, feet: Bools, coarse: Coarse) -> float:
    depth = cast_parts(performer, pose, coarse)[0][feet]
    drawn = np.isfinite(depth)
    off = np.minimum(np.abs(depth[drawn] - coarse.seen[feet][drawn]), MOST).sum() / MOST
    return float(off + BESIDE * (~drawn).sum())
