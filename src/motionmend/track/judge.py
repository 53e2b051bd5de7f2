"""How well a pose explains a frame, limb by limb: what is seen but not explained, what is claimed but not seen.

One picture of the performer beside the observed depth tells more than a residual: a lost arm leaves pixels of the
person that no bone explains, and its bone claims pixels through which the room behind is seen.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bools, Floats, frozen
from ..bodies.performer import BONES, Performer, Pose
from ..bodies.surface import render
from .observation import Observation

GATE = 0.12  # m: closer than this a pixel is explained; clothes and hands are not where the solids are


@final
@dataclass(frozen=True, eq=False)
class Verdict:
    """A pose against a frame. Shares are of pixels of a coarse raster.

    Attributes
    ----------
    cost : 0 to 1, mean over all pixels that the person or the model covers of how far apart they are, at most the gate.
    residual : m, median distance along z where both are.
    unexplained : share of the person's pixels with nothing of the model near them.
    unseen : share of the model's pixels where the person surely is not, or is clearly behind.
    visible : (15,) pixels of each bone.
    denied : (15,) how many of them are unseen.
    loose : (N, 3) m, the points that are unexplained.
    area : m^2, of these points as if facing the camera.
    """

    cost: float
    residual: float
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
    """Compare a pose with a frame, both as coarse as `seen` is (80 x 60 pixels tell enough: `seen.every(4)`).

    Parameters
    ----------
    performer, pose : the claim.
    seen : the person's depth and where the person surely is not.
    gate : m, farther apart along z is not explained.
    """
    drawn = render(performer, pose, seen.camera)
    person, model = np.isfinite(seen.depth), np.isfinite(drawn.depth)
    both = person & model
    apart = np.zeros(person.shape, np.float64)
    apart[both] = seen.depth[both].astype(np.float64) - drawn.depth[both]
    near = both & (np.abs(apart) < gate)
    # At the outline of either a pixel of the raster may fall beside: a neighbour will do.
    only_seen = person & ~_beside(near) & ~near
    denied = (model & ~person & seen.free & ~_beside(person)) | (both & (apart > gate))
    union = int((person | (model & seen.free)).sum())
    off = (
        np.minimum(np.abs(apart[both]) / gate, 1.0).sum()
        + (person & ~model).sum()
        + (model & ~person & seen.free).sum()
    )
    bones = drawn.bones[model]
    rows, columns = np.nonzero(only_seen)
    z = seen.depth[rows, columns].astype(np.float64)
    loose = seen.camera.unproject(np.column_stack([columns, rows]), z)
    return Verdict(
        cost=float(off / union) if union else 1.0,
        residual=float(np.median(np.abs(apart[both]))) if both.any() else float("inf"),
        unexplained=float(only_seen.sum() / max(person.sum(), 1)),
        unseen=float(denied.sum() / max(model.sum(), 1)),
        visible=np.bincount(bones, minlength=len(BONES)).astype(np.float64),
        denied=np.bincount(drawn.bones[denied], minlength=len(BONES)).astype(np.float64),
        loose=loose,
        area=float((z**2).sum() / (seen.camera.fx * seen.camera.fy)),
    )


def _beside(mask: Bools) -> Bools:
    """Pixels with one of the mask among their four neighbours."""
    out = np.zeros_like(mask)
    out[1:] |= mask[:-1]
    out[:-1] |= mask[1:]
    out[:, 1:] |= mask[:, :-1]
    out[:, :-1] |= mask[:, 1:]
    return out
