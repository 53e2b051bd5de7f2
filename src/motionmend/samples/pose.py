"""A performance, described in the body's own terms, and the joint angles that show it."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..bodies.skeleton import Skeleton
from .arms import Arms, arm_angles
from .body import Build, rotation
from .legs import Feet, leg_angles

SPINE = ("lowerback", "upperback", "thorax")
NECK = ("lowerneck", "upperneck", "head")


@dataclass(frozen=True, eq=False)
class Trunk:
    """Pelvis, back and neck over T frames.

    Attributes
    ----------
    root : (T, 3) m.
    heading, tilt, roll : (T,) rad, of the pelvis: about the vertical (to the left positive), forward, left side up.
    spine, neck : (T, 3) rad, forward, to the left about the long axis, to the right; the three joints of each share it.
    """

    root: Floats
    heading: Floats
    tilt: Floats
    roll: Floats
    spine: Floats
    neck: Floats


@dataclass(frozen=True, eq=False)
class Performance:
    """What a body does over T frames."""

    trunk: Trunk
    feet: Feet
    arms: Arms


def joint_angles(skeleton: Skeleton, b: Build, acted: Performance) -> Floats:
    """(T, D) rad and m: the performance on the skeleton of `body.skeleton`."""
    trunk = acted.trunk
    angles = {f"root.t{c}": trunk.root[:, i] for i, c in enumerate("xyz")}
    angles |= dict(zip(("root.rz", "root.ry", "root.rx"), _pelvis(trunk), strict=True))
    for joints, bent in ((SPINE, trunk.spine), (NECK, trunk.neck)):
        for joint in joints:
            angles |= {f"{joint}.r{c}": bent[:, i] / 3 for i, c in enumerate("xyz")}
    angles |= leg_angles(b, trunk.root, pelvis_frame(trunk), acted.feet)
    angles |= arm_angles(acted.arms)
    return np.stack([angles[name] for name in skeleton.dof_names], axis=1)


def pelvis_frame(trunk: Trunk) -> Floats:
    """(T, 3, 3) pelvis to world."""
    rz, ry, rx = _pelvis(trunk)
    return np.asarray(rotation(2, rz) @ rotation(1, ry) @ rotation(0, rx))


def thorax_frame(b: Build, trunk: Trunk) -> tuple[Floats, Floats]:
    """Far end of the thorax (T, 3) m and its axes (T, 3, 3), thorax to world."""
    place, frame = trunk.root, pelvis_frame(trunk)
    x, y, z = trunk.spine.T / 3
    bent = rotation(2, z) @ rotation(1, y) @ rotation(0, x)
    for _ in SPINE:
        frame = frame @ bent
        place = place + frame @ np.array([0.0, b.back, 0.0])
    return place, frame


def _pelvis(trunk: Trunk) -> tuple[Floats, Floats, Floats]:
    """Root rz, ry, rx without the jump of Euler angles near a heading of a quarter turn.

    At a quarter turn rz and rx turn about one axis and a roll cannot be told: it fades there. Elsewhere, to first
    order, rx = tilt + rz sin(heading) leaves the tilt as it is wanted.
    """
    aside = trunk.roll * np.cos(trunk.heading)
    return aside, trunk.heading, trunk.tilt + aside * np.sin(trunk.heading)
