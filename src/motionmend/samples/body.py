"""The synthetic performer's skeleton: CMU names and axes, proportions from published anthropometry.

Source: D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed., 2009, fig. 4.1 (after Drillis and
Contini, 1966): segment lengths as fractions of stature. Spacing of the hip joint centres: Bell, Pedersen and Brand,
J. Biomech. 23 (1990) 617-621. Bone names, DOFs and axes follow the .asf files of the CMU Graphics Lab database.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..arrays import Floats
from ..bodies.skeleton import ROTATION, TRANSLATION, Skeleton
from ..errors import UsageError

LEG_TILT = np.radians(20.0)  # the legs of the rest pose are spread by this much, outward
ARM_AXIS = (180.0, -30.0, -90.0)  # degrees; Euler angles of the left arm's axes, mirrored for the right
SIDES = ("l", "r")


@dataclass(frozen=True)
class Build:
    """Lengths in metres of a person of the given stature."""

    height: float
    thigh: float
    shank: float
    ankle_height: float
    heel: float  # behind the ankle, along the floor
    ball: float  # of the foot (the joint of the toes) before the ankle, along the floor
    ball_height: float
    toes: float
    hip: tuple[float, float, float]  # left hip joint from the root
    back: float  # each of lowerback, upperback, thorax
    neck: float  # each of lowerneck, upperneck, head
    clavicle: tuple[float, float]  # sideways, up
    upper_arm: float
    forearm: float  # radius (two thirds) and wrist (one third)
    hand: float  # as long again as the fingers
    thumb: float

    @property
    def leg(self) -> float:
        """Hip to sole, standing, m."""
        return self.thigh + self.shank + self.ankle_height

    @property
    def standing(self) -> float:
        """Height of the root above the floor with straight legs, m."""
        return self.leg - self.hip[1]


def build(height: float) -> Build:
    """The lengths of a person of `height` metres."""
    h = height
    return Build(
        height=h,
        thigh=0.245 * h,
        shank=0.246 * h,
        ankle_height=0.039 * h,
        heel=0.039 * h,
        ball=0.075 * h,
        ball_height=0.012 * h,
        toes=0.038 * h,
        hip=(0.049 * h, -0.035 * h, 0.012 * h),
        back=0.0665 * h,
        neck=0.052 * h,
        clavicle=(0.1295 * h, 0.0515 * h),
        upper_arm=0.186 * h,
        forearm=0.146 * h,
        hand=0.054 * h,
        thumb=0.042 * h,
    )


def rotation(axis: int, angle: Floats | float) -> Floats:
    """(..., 3, 3) rotations about axis 0, 1 or 2 by `angle` (...) in radians."""
    angle = np.asarray(angle, dtype=np.float64)
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((*angle.shape, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[..., axis, axis] = 1.0
    matrix[..., i, i] = matrix[..., j, j] = c
    matrix[..., j, i], matrix[..., i, j] = s, -s
    return matrix


def axes(degrees: tuple[float, float, float]) -> Floats:
    """(3, 3) the axes of a bone: the .asf `axis` x y z in degrees, turned about x first."""
    x, y, z = np.radians(degrees)
    return np.asarray(rotation(2, z) @ rotation(1, y) @ rotation(0, x))


def arm_axes(side: int) -> Floats:
    """(3, 3) axes of the humerus and radius, side 0 left, 1 right."""
    mirror = 1 if side == 0 else -1
    return axes((ARM_AXIS[0], mirror * ARM_AXIS[1], mirror * ARM_AXIS[2]))


@dataclass(frozen=True)
class _Bone:
    name: str
    parent: str  # the bone it hangs on, at that bone's far end
    vector: tuple[float, float, float]  # m, from its own joint to its far end, at rest
    axis: Floats
    dofs: str = ""
    limits: tuple[tuple[float, float], ...] = ()  # degrees, in the order of `dofs`


@lru_cache(maxsize=64)
def skeleton(height: float = 1.75) -> Skeleton:
    """The performer: 62 DOFs with CMU's names, y up, facing z, arms out and legs spread by 20 degrees at rest.

    Parameters
    ----------
    height : stature, m, 1 to 2.5.

    Returns
    -------
    Skeleton

    Raises
    ------
    UsageError
        A stature outside 1 to 2.5 m.
    """
    if not 1.0 <= height <= 2.5:
        raise UsageError(f"height must be a stature between 1 and 2.5 m, came {height}")
    bones = _bones(build(height))
    leaves = {b.name for b in bones} - {b.parent for b in bones}
    names, parents, offsets = ["root"], [-1], [(0.0, 0.0, 0.0)]
    vectors = {"root": (0.0, 0.0, 0.0)}
    rows = [("root", c, np.eye(3)["xyz".index(c[1])], "t" in c, (-np.inf, np.inf)) for c in ("tx", "ty", "tz")]
    rows += [("root", c, np.eye(3)["xyz".index(c[1])], False, (-np.inf, np.inf)) for c in ("rz", "ry", "rx")]
    for bone in bones:
        names.append(bone.name)
        parents.append(names.index(bone.parent))
        offsets.append(vectors[bone.parent])
        vectors[bone.name] = bone.vector
        letters = zip(bone.dofs, bone.limits, strict=True)
        for letter, limit in reversed(list(letters)):  # rz first: the .asf turns about x before y before z
            rows.append((bone.name, f"r{letter}", bone.axis[:, "xyz".index(letter)], False, limit))
        if bone.name in leaves:
            names.append(f"{bone.name}_end")
            parents.append(len(names) - 2)
            offsets.append(bone.vector)
    return Skeleton(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.array(offsets),
        dof_names=tuple(f"{joint}.{channel}" for joint, channel, *_ in rows),
        dof_joint=np.array([names.index(joint) for joint, *_ in rows]),
        dof_axis=np.array([axis for _, _, axis, _, _ in rows]),
        dof_kind=np.array([TRANSLATION if moves else ROTATION for *_, moves, _ in rows]),
        limits=np.array([limit if c.startswith("t") else np.radians(limit) for _, c, _, _, limit in rows]),
    )


def _bones(b: Build) -> list[_Bone]:
    """Every bone in CMU's order; limits after the ranges of motion of the AAOS, in the frame of the rest pose."""
    flat = np.eye(3)
    spine = ((-25.0, 45.0), (-30.0, 30.0), (-30.0, 30.0))
    neck = ((-40.0, 45.0), (-45.0, 45.0), (-40.0, 40.0))
    legs = [bone for s in range(2) for bone in _leg(b, s)]
    trunk = [
        _Bone("lowerback", "root", (0, b.back, 0), flat, "xyz", spine),
        _Bone("upperback", "lowerback", (0, b.back, 0), flat, "xyz", spine),
        _Bone("thorax", "upperback", (0, b.back, 0), flat, "xyz", spine),
        _Bone("lowerneck", "thorax", (0, 0.985 * b.neck, 0.17 * b.neck), flat, "xyz", neck),
        _Bone("upperneck", "lowerneck", (0, b.neck, 0), flat, "xyz", neck),
        _Bone("head", "upperneck", (0, b.neck, 0), flat, "xyz", neck),
    ]
    return [*legs, *trunk, *(bone for s in range(2) for bone in _arm(b, s))]


def _leg(b: Build, side: int) -> list[_Bone]:
    s, x = SIDES[side], 1 - 2 * side
    tilt = rotation(2, x * LEG_TILT)
    foot_axes = axes((-90.0, 0.0, float(np.degrees(x * LEG_TILT))))

    def spread(y: float, z: float) -> tuple[float, float, float]:
        vx, vy, vz = tilt @ np.array([0.0, y, z])
        return (float(vx), float(vy), float(vz))

    aside = (-55.0, 30.0) if side == 0 else (-30.0, 55.0)
    drop = b.ball_height - b.ankle_height
    return [
        _Bone(f"{s}hipjoint", "root", (x * b.hip[0], b.hip[1], b.hip[2]), np.eye(3)),
        _Bone(
            f"{s}femur",
            f"{s}hipjoint",
            spread(-b.thigh, 0.0),
            tilt,
            "xyz",
            ((-130.0, 40.0), (-50.0, 50.0), aside),
        ),
        _Bone(f"{s}tibia", f"{s}femur", spread(-b.shank, 0.0), tilt, "x", ((-2.0, 150.0),)),
        _Bone(f"{s}foot", f"{s}tibia", spread(drop, b.ball), foot_axes, "xz", ((-55.0, 70.0), (-45.0, 45.0))),
        _Bone(f"{s}toes", f"{s}foot", spread(0.0, b.toes), foot_axes, "x", ((-75.0, 45.0),)),
    ]


def _arm(b: Build, side: int) -> list[_Bone]:
    s, x = SIDES[side], 1 - 2 * side
    arm, wrist = arm_axes(side), axes((0.0, x * 90.0, x * 90.0))
    thumb = axes((-90.0, x * 45.0, 0.0))
    slant = b.thumb * np.sqrt(0.5)
    return [
        _Bone(
            f"{s}clavicle",
            "thorax",
            (x * b.clavicle[0], b.clavicle[1], 0),
            np.eye(3),
            "yz",
            ((-30.0, 30.0), (-30.0, 30.0)),
        ),
        _Bone(
            f"{s}humerus",
            f"{s}clavicle",
            (x * b.upper_arm, 0, 0),
            arm,
            "xyz",
            ((-140.0, 140.0), (-85.0, 85.0), (-140.0, 140.0)),
        ),
        _Bone(f"{s}radius", f"{s}humerus", (x * b.forearm * 2 / 3, 0, 0), arm, "x", ((-5.0, 155.0),)),
        _Bone(f"{s}wrist", f"{s}radius", (x * b.forearm / 3, 0, 0), wrist, "y", ((-180.0, 90.0),)),
        _Bone(f"{s}hand", f"{s}wrist", (x * b.hand, 0, 0), wrist, "xz", ((-90.0, 90.0), (-45.0, 45.0))),
        _Bone(f"{s}fingers", f"{s}hand", (x * b.hand, 0, 0), wrist, "x", ((-10.0, 95.0),)),
        _Bone(f"{s}thumb", f"{s}wrist", (x * slant, 0, slant), thumb, "xz", ((-50.0, 50.0), (-60.0, 60.0))),
    ]
