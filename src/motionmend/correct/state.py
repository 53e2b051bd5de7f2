"""A client's correction between two frames, and what comes of a frame."""

from dataclasses import dataclass

from ..arrays import Floats
from .joining import Joining
from .limits import Hinges
from .look_ahead import Waiting
from .online import Memory
from .settling import Body
from .watching import Sight


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
    """

    joining: Joining
    sight: Sight
    shown: Body
    offset: Floats
    memory: Memory | None = None
    waiting: Waiting | None = None
    hinges: Hinges | None = None


@dataclass(frozen=True, eq=False)
class Corrected:
    """One corrected frame of J joints.

    Attributes
    ----------
    positions : (J, 3) m, finite where anything is known.
    std : (J,) m, of a coordinate.
    reliability : (J,) in [0, 1], of what the sensor said.
    flags : words about the frame: "swapped", "refused", "held".
    """

    positions: Floats
    std: Floats
    reliability: Floats
    flags: tuple[str, ...]
