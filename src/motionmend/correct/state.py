"""A client's correction between two frames, and what comes of a frame."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..kernels.bones import ACQUAINTED_SECONDS
from .joining import Joining
from .limits import Hinges
from .look_ahead import Waiting
from .online import Memory
from .settling import Body
from .sight import Sight
from .thrown_about import Courses
from .watching import Doubt

KIN_SECONDS = 10.0  # live, in which it is learned whether the sensor is the one that was learned from


@dataclass(frozen=True, eq=False)
class CorrectorState:
    """One client's correction between two frames.

    Attributes
    ----------
    joining : how the client's joints go with the model's.
    sight : what is known of the sensor's posture.
    shown : what was put out.
    offset : (J of model, 3) by which the last posture was moved, standard form; NaN = none.
    memory : what was learned on the way; None when nothing is to be.
    waiting : frames that were not given out yet; None when each is at once.
    hinges : of the client's joints, those that have limits.
    kin : probability that the sensor is the one that was learned from, by which offsets count.
    doubt : of the last frame, where no frames wait.
    courses : of the client's joints.
    heights : (K, J of model) along the spine, of the first frames in which they showed; None when nothing is asked.
    """

    joining: Joining
    sight: Sight
    shown: Body
    offset: Floats
    courses: Courses
    memory: Memory | None = None
    waiting: Waiting | None = None
    hinges: Hinges | None = None
    kin: float = 1.0
    doubt: Doubt | None = None
    heights: Floats | None = None

    def kin_after(self, now: float, time: float) -> float:
        """What `kin` becomes when a frame says `now`: the mean of what was said until bones are known, as a first frame
        that shakes says little, and then slowly something else, as what is put out moves with it."""
        passed = time - self.shown.time
        if not passed < np.inf:
            return now
        known = float(self.shown.lengths[1].max(initial=0.0))
        over = KIN_SECONDS if known >= ACQUAINTED_SECONDS else known + max(passed, 0.0)
        return self.kin + min(max(passed, 0.0) / max(over, 1e-9), 1.0) * (now - self.kin)


@dataclass(frozen=True, eq=False)
class Corrected:
    """One corrected frame of J joints.

    Attributes
    ----------
    positions : (J, 3) m, finite where anything is known.
    std : (J,) m, of a coordinate.
    reliability : (J,) in [0, 1], of what the sensor said.
    flags : words about the frame: "swapped", "refused", "held", "foreign" (another sensor than was learned from).
    """

    positions: Floats
    std: Floats
    reliability: Floats
    flags: tuple[str, ...]
