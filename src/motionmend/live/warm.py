"""The first frame's work before the first client comes."""

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Floats
from ..bodies.joint_sets import AZURE32, KINECT20, KINECT25, JointSet
from ..bodies.postures import TRACKED
from .axes import page_from_sensor
from .messages import Frame, Hello
from .session import answered, now, opened, rested

if TYPE_CHECKING:
    from ..correct import CorrectorModel

# Somebody who stands, arms down, 2.5 m from the sensor, in the page's axes (right, forward, up) from the sensor, m.
_STANDING = {
    "pelvis": (0.0, 0.0), "spine": (0.0, 0.2), "chest": (0.0, 0.35), "neck_base": (0.0, 0.5), "neck": (0.0, 0.55),
    "head": (0.0, 0.68), "head_top": (0.0, 0.8), "nose": (0.0, 0.7), "eye": (0.03, 0.72), "ear": (0.07, 0.7),
    "clavicle": (0.05, 0.48), "shoulder": (0.18, 0.45), "elbow": (0.22, 0.17), "wrist": (0.24, -0.08),
    "hand": (0.25, -0.16), "hand_tip": (0.25, -0.22), "thumb": (0.22, -0.15), "hip": (0.09, -0.02),
    "knee": (0.1, -0.43), "ankle": (0.1, -0.83), "heel": (0.1, -0.88), "foot": (0.12, -0.88), "toe_tip": (0.12, -0.9),
}  # fmt: skip


def warm(model: "CorrectorModel", look_ahead: float = 0.0, frames: int = 5) -> None:
    """Correct a few frames of somebody standing, for each sensor of the protocol; `look_ahead` as of `replied`."""
    for joint_set in (KINECT20, KINECT25, AZURE32):
        hello = Hello(joint_set.key, joint_set.names, 30.0)
        session, joints = opened(model, hello, look_ahead=look_ahead), standing(joint_set)
        for k in range(frames):
            state = np.full(len(joints), TRACKED, dtype=np.uint8)
            session, _ = answered(model, session, Frame(k, k / 30.0, joints, state, "msgpack"), now())
        rested(model, session)


def standing(joint_set: JointSet) -> Floats:
    """(J, 3) m: a person who stands before the sensor, in the axes of its joint set."""
    placed = []
    for meaning in joint_set.meanings:
        side, _, rest = meaning.partition("_")
        if side in ("l", "r"):  # the person's right is at the left of who looks at the face
            across, up = _STANDING[rest]
            across *= 1.0 if side == "l" else -1.0
        else:
            across, up = _STANDING.get(meaning, (0.0, 0.7))
        placed.append((across, 2.5 - 0.05 * (rest in ("foot", "toe_tip") or meaning == "nose"), up))
    return np.array(placed) @ page_from_sensor(joint_set.key)
