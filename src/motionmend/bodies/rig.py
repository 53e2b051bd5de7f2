"""How a skeleton carries the performer: which of its joints turn as the performer's bones do, and where they lie."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats, Ints, frozen
from ..errors import MismatchError
from .motion import Motion
from .performer import BONES
from .roles import Roles, roles
from .skeleton import ROTATION, Skeleton, forward, rest_positions


@final
@dataclass(frozen=True, eq=False)
class Rig:
    """How a skeleton carries the performer.

    Attributes
    ----------
    joints : (15,) the skeleton's joint that turns as each bone of the performer does.
    rests : (15, 3, 3) world from bone while the skeleton is at rest.
    roles : the parts of the skeleton.
    """

    joints: Ints
    rests: Floats
    roles: Roles


def rig_of(skeleton: Skeleton) -> Rig:
    """How a skeleton carries the performer: which joints turn its bones, and how the bones lie in them.

    Raises
    ------
    MismatchError : the skeleton's parts are not to be told, or its hips and shoulders lie in one point at rest.
    """
    part = roles(skeleton)
    rest = rest_positions(skeleton)
    hips = rest[list(part.feet.hips)]
    shoulders = np.array([rest[arm.shoulder] for arm in part.arms])
    up = skeleton.up / np.linalg.norm(skeleton.up)
    across = hips[0] - hips[1] + shoulders[0] - shoulders[1]
    across = across - (across @ up) * up
    if np.linalg.norm(across) < 1e-6:
        raise MismatchError(
            "a performer needs hips and shoulders apart from each other; at rest this skeleton has none"
        )
    left = across / np.linalg.norm(across)
    ahead = np.cross(left, up)
    trunk = np.stack((left, up, ahead), axis=1)
    joints = dict.fromkeys(BONES, part.pelvis)
    rests = dict.fromkeys(BONES, trunk)
    joints["chest"] = part.spine[-1] if part.spine else part.pelvis
    joints["head"] = part.head
    for index, (side, arm) in enumerate(zip("lr", part.arms, strict=True)):
        joints[f"{side}_clavicle"] = arm.clavicle if arm.clavicle >= 0 else joints["chest"]
        joints[f"{side}_upperarm"], joints[f"{side}_forearm"] = arm.shoulder, arm.elbow
        wanted = -_flexion(skeleton, arm.elbow, rest[arm.elbow] - rest[arm.shoulder], ahead + 0.5 * up)
        rests[f"{side}_upperarm"] = _limb(rest[arm.elbow] - rest[arm.shoulder], wanted)
        rests[f"{side}_forearm"] = _limb(rest[arm.wrist] - rest[arm.elbow], wanted)
        hip, knee, ankle = (chain[index] for chain in (part.feet.hips, part.feet.knees, part.feet.ankles))
        joints[f"{side}_thigh"], joints[f"{side}_shank"], joints[f"{side}_foot"] = hip, knee, ankle
        wanted = _flexion(skeleton, knee, rest[knee] - rest[hip], -ahead)
        rests[f"{side}_thigh"] = _limb(rest[knee] - rest[hip], wanted)
        rests[f"{side}_shank"] = rests[f"{side}_foot"] = _limb(rest[ankle] - rest[knee], wanted)
    return Rig(
        frozen([joints[bone] for bone in BONES], np.int64), frozen(np.array([rests[bone] for bone in BONES])), part
    )


def _limb(along: Floats, across: Floats) -> Floats:
    """Axes of a bone that lies along `along` and bends about `across`: y backwards along it, x across."""
    if np.linalg.norm(along) < 1e-6:
        raise MismatchError("a performer needs arms and legs; this skeleton has one of no length")
    y = -along / np.linalg.norm(along)
    x = across - (across @ y) * y
    x /= np.linalg.norm(x)
    return np.stack((x, y, np.cross(x, y)), axis=1)


def _flexion(skeleton: Skeleton, joint: int, along: Floats, towards: Floats) -> Floats:
    """The axis about which the lower half of a limb turns towards `towards`: the joint's own where it has but one."""
    expected = np.cross(along, towards)
    if np.linalg.norm(expected) < 0.1 * np.linalg.norm(along):
        expected = np.cross(along, skeleton.up + 0.3 * towards)
    rows = [d for d in skeleton.dofs_of(joint) if skeleton.dof_kind[d] == ROTATION]
    if len(rows) != 1:
        return np.asarray(expected)
    axis = skeleton.dof_axis[rows[0]]
    if abs(axis @ along) > 0.7 * np.linalg.norm(along):
        return np.asarray(expected)  # a twist, not a hinge
    return np.asarray(axis * np.sign(axis @ expected if abs(axis @ expected) > 1e-9 else 1.0))


def landmark_positions(part: Roles, position: Floats, head: Floats) -> Floats:
    """(T, 16, 3) m, the joints of `LANDMARKS` from all joints (T, J, 3) and the head's axes (T, 3, 3)."""
    end = position[:, list(part.head_end)].mean(axis=1)
    if len(part.head_end) > 1:  # eyes and the like: the head's end is as high, above its joint
        rise = np.einsum("ti,ti->t", end - position[:, part.head], head[:, :, 1])
        end = position[:, part.head] + rise[:, None] * head[:, :, 1]
    arms = [joint for arm in part.arms for joint in (arm.shoulder, arm.elbow, arm.wrist)]
    legs = [chain[side] for side in (0, 1) for chain in (part.feet.hips, part.feet.knees, part.feet.ankles)]
    first = position[:, [part.pelvis, part.chest, part.head]]
    return np.asarray(np.concatenate((first, end[:, None], position[:, arms + legs]), axis=1))


def toe_tip(part: Roles, side: int) -> int:
    """The tip of the toes, or what comes nearest to it; -1 where the foot has no length."""
    return part.feet.ends[side] if part.feet.ends[side] >= 0 else part.feet.toes[side]


def motion_landmarks(motion: Motion) -> Floats:
    """(T, 16, 3) m, where the joints of `LANDMARKS` lie in a motion; NaN in frames with missing angles above them."""
    rig = rig_of(motion.skeleton)
    position, turned = forward(motion.skeleton, motion.q)
    head = BONES.index("head")
    return landmark_positions(rig.roles, position, turned[:, rig.joints[head]] @ rig.rests[head])
