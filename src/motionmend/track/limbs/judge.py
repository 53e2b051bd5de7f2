"""How well a pose explains a frame, limb by limb: what is seen but not explained, what is claimed but not seen.

One picture of the performer beside the observed depth tells more than a residual: a lost arm leaves pixels of the
person that no bone explains, and its bone claims pixels through which the room behind is seen.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.camera import KINECT
from ...bodies.performer import BONES, Performer, Pose
from ...bodies.surface import render
from ..frame.observation import Observation

JUDGED = KINECT.fx / 4  # px, focal length of frames that tell enough: the Kinect's at 80 x 60
GATE = 0.12  # m: closer than this a pixel is explained; clothes and hands are not where the solids are


@final
@dataclass(frozen=True, eq=False)
class Verdict:
    """A pose against a frame. Shares are of pixels of a coarse raster.

    Attributes
    ----------
    cost : 0 to 1, mean over all pixels that the person or the model covers of how far apart they are, at most the gate.
    unexplained : share of the person's pixels with nothing of the model near them.
    unseen : share of the model's pixels where the person surely is not, or is clearly behind.
    visible : (15,) pixels of each bone.
    denied : (15,) how many of them are unseen.
    loose : (N, 3) m, the points that are unexplained.
    area : m^2, of these points as if facing the camera.
    """

    cost: float
    unexplained: float
    unseen: float
    visible: Floats
    denied: Floats
    loose: Floats
    area: float

    def __post_init__(self) -> None:
        for name in ("visible", "denied", "loose"):
            object.__setattr__(self, name, frozen(getattr(self, name)))


def judge(performer: Performer, pose: Pose, seen: Observation, gate: float = GATE) -> Verdict:
    """Compare a pose with a frame, both as coarse as `seen` is (`JUDGED` tells enough: `Observation.as_fine_as`).

    Parameters
    ----------
    performer, pose : the claim.
    seen : the person's depth and where the person surely is not.
    gate : m, farther apart along z is not explained.
    """
    from ...kernels import judging

    drawn = render(performer, pose, seen.camera)
    loose, counts = np.empty((seen.depth.size, 2), np.int64), np.empty(5, np.int64)
    visible, denied = np.zeros((2, len(BONES)))
    # Copies, for what is kept of a frame is read-only: kernels are compiled for one kind of arrays.
    off = judging.judged(
        seen.depth.copy(),
        seen.free.copy(),
        drawn.depth,
        drawn.solid,
        performer.solids.arrays.carriers,
        gate,
        loose,
        visible,
        denied,
        counts,
    )
    person, model, union, left, missing = (int(count) for count in counts)
    rows, columns = loose[:left].T
    z = seen.depth[rows, columns].astype(np.float64)
    return Verdict(
        cost=float(off / union) if union else 1.0,
        unexplained=left / max(person, 1),
        unseen=missing / max(model, 1),
        visible=visible,
        denied=denied,
        loose=seen.camera.unproject(np.column_stack([columns, rows]), z),
        area=float((z**2).sum() / (seen.camera.fx * seen.camera.fy)),
    )
