"""The 41 markers of the CMU set on the performer, or on any body with CMU's bone names."""

from __future__ import annotations

import numpy as np

from ..arrays import Floats
from ..bodies.motion import Markers, Motion
from ..bodies.skeleton import Skeleton, forward
from ..errors import MismatchError
from .body import LEG_TILT, rotation

_STATURE = 1.75  # m, of the body whose surface the offsets describe
_LEGS = 0.491  # of stature: thigh and shank (Winter 2009, fig. 4.1)

# Marker, bone, where along it (0 its own joint, 1 its far end), offset from there in mm: x away from the middle of the
# body, y up, z forward, with the arms held out sideways, palms down, and the legs straight down.
_MIDDLE = (
    ("C7", "thorax", 1.0, (0, 100, -58)),
    ("T10", "thorax", 0.1, (0, 0, -92)),
    ("CLAV", "thorax", 1.0, (0, 55, 72)),
    ("STRN", "thorax", 0.0, (0, 30, 112)),
)
_BACK = ("RBAC", "thorax", 0.7, (-82, 50, -98))  # on the right only: it tells the sides apart
_SIDES = (
    ("FHD", "head", 0.9, (68, 20, 88)),
    ("BHD", "head", 0.9, (68, 30, -82)),
    ("SHO", "clavicle", 0.92, (0, 48, -4)),
    ("UPA", "humerus", 0.48, (0, 42, -26)),
    ("ELB", "humerus", 1.0, (0, 37, -22)),
    ("FRM", "radius", 0.75, (0, 28, -24)),
    ("WRA", "wrist", 1.0, (-8, 12, 34)),
    ("WRB", "wrist", 1.0, (-8, 12, -30)),
    ("FIN", "hand", 0.95, (0, 18, 6)),
    ("FWT", "root", 0.0, (118, 42, 118)),
    ("BWT", "root", 0.0, (46, 48, -98)),
    ("THI", "femur", 0.6, (78, 0, 18)),
    ("KNE", "femur", 1.0, (58, 0, 0)),
    ("SHN", "tibia", 0.55, (46, 0, 26)),
    ("ANK", "tibia", 1.0, (42, 0, -6)),
    ("HEE", "foot", 0.0, (0, -28, -74)),
    ("TOE", "foot", 0.96, (-6, 30, 0)),
    ("MT5", "foot", 0.72, (44, 2, 0)),
)
NAMES = (
    *("LFHD", "RFHD", "LBHD", "RBHD", "C7", "T10", "CLAV", "STRN", "RBAC"),
    *(f"{side}{name}" for side in "LR" for name in ("SHO", "UPA", "ELB", "FRM", "WRA", "WRB", "FIN")),
    *("LFWT", "RFWT", "LBWT", "RBWT"),
    *(f"{side}{name}" for side in "LR" for name in ("THI", "KNE", "SHN", "ANK", "HEE", "TOE", "MT5")),
)


def markers(motion: Motion) -> Markers:
    """Markers rigidly attached to the bones, with surface offsets that grow with the body.

    Parameters
    ----------
    motion : T frames of a body with CMU's bone names and rest pose (arms out, legs spread).

    Returns
    -------
    Markers
        (T, 41, 3) m at the motion's rate; a marker below a missing joint angle is missing.

    Raises
    ------
    MismatchError
        A skeleton that lacks one of the bones.
    """
    skeleton = motion.skeleton
    joints = {name: j for j, name in enumerate(skeleton.names)}
    place = _placement()
    lacking = sorted({bone for bone, _, _ in place.values()} - set(joints))
    if lacking:
        raise MismatchError(f"markers need a body with CMU's bone names, this one lacks {', '.join(lacking)}")
    at, turned = forward(skeleton, motion.q)
    size = _size(skeleton, joints)
    positions = np.empty((motion.frames, len(NAMES), 3))
    for m, name in enumerate(NAMES):
        bone, along, offset = place[name]
        j = joints[bone]
        local = along * _vector(skeleton, j) + size * _upright(bone) @ offset
        positions[:, m] = at[:, j] + turned[:, j] @ local
    return Markers(NAMES, positions, motion.fps, up=skeleton.up)


def _placement() -> dict[str, tuple[str, float, Floats]]:
    """Marker to bone, share of its length, and offset (3,) in m."""
    place = {name: (bone, along, np.array(mm) / 1000.0) for name, bone, along, mm in (*_MIDDLE, _BACK)}
    for name, bone, along, mm in _SIDES:
        for side, mirror in (("L", 1), ("R", -1)):
            paired = bone if bone in ("root", "head") else f"{side.lower()}{bone}"
            place[f"{side}{name}"] = (paired, along, np.array(mm) * (mirror, 1, 1) / 1000.0)
    return place


def _vector(skeleton: Skeleton, joint: int) -> Floats:
    """(3,) m, from a joint to its bone's far end: the furthest joint that hangs on it."""
    below = skeleton.offsets[skeleton.parents == joint]
    return np.asarray(below[np.argmax(np.linalg.norm(below, axis=1))])


def _size(skeleton: Skeleton, joints: dict[str, int]) -> float:
    """How large the body is, by its legs, against the one the offsets are for."""
    legs = sum(float(np.linalg.norm(skeleton.offsets[joints[name]])) for name in ("ltibia", "lfoot"))
    return legs / (_LEGS * _STATURE)


def _upright(bone: str) -> Floats:
    """(3, 3) from the table's straight legs to the rest pose's spread ones."""
    if bone[1:] in ("femur", "tibia", "foot"):
        return rotation(2, LEG_TILT if bone[0] == "l" else -LEG_TILT)
    return np.eye(3)
