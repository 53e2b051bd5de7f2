"""How likely a body is followed wrongly, whatever is usual with it, and how far its joints may then be off.

A body read the wrong way round, or twisted, may explain an image as well as was usual from the first frame on: no limb
of it is denied, its joints lie on the surface, and all of them were said to be sure. Two numbers tell it all the same,
in any frame: the share of pixels explained wrongly, and how far the body bends from how the library's do.
"""

import numpy as np

from ..arrays import Floats, frozen
from ..bodies.performer import LANDMARKS, Pose
from ..numerics.neighbors import Neighbors
from .database import EVERYWHERE, strange

BY_IMAGE, BY_BEND, BEFORE = 24.0, 20.0, -14.5  # log odds of a share of pixels, of a radian, and before anything is seen
HELD = 0.5  # s, over about which they are the mean: who bends strangely for a moment does not so for long
FLAT = 0.5  # of these odds: frames that follow each other err alike
OFF = 0.10  # m, deviation of a limb's joint of a body that surely is followed wrongly
# Of a body read wrongly the trunk is where it is seen: left and right of it change over, and limbs.
_SHARE = frozen([0.4 if name in ("pelvis", "chest", "neck", "head") else 1.0 for name in LANDMARKS])


def odds_misread(search: Neighbors, pose: Pose, wrong: float, trust: Floats = EVERYWHERE) -> float:
    """Log odds that a body is followed wrongly; minus infinity where nothing is known of how people bend.

    Parameters
    ----------
    search : poses of the library. pose : followed. wrong : share of pixels that it explains wrongly.
    trust : (28,) how well each joint coordinate is shown, 0 to 1.
    """
    if not len(search.samples):
        return -float("inf")
    return BY_IMAGE * wrong + BY_BEND * strange(search, pose, trust) + BEFORE


def held(odds: float, now: float, elapsed: float) -> float:
    """Running mean of the log odds, with a frame more.

    Parameters
    ----------
    odds : as of the frame before; NaN = of none. now : of this frame. elapsed : s, since the frame before.
    """
    if not np.isfinite(odds) or not np.isfinite(now):
        return now
    return odds + (now - odds) * (1.0 - float(np.exp(-elapsed / HELD)))


def misread(odds: float) -> Floats:
    """(16,) m, the deviation of each joint by the log odds that the body is followed wrongly."""
    return np.asarray(OFF / (1.0 + np.exp(-FLAT * odds)) * _SHARE)
