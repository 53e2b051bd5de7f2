"""From joint positions to the bones of Unity's humanoid: orientations about a T-pose that looks along +z.

All here is in Unity's axes (left-handed, x right, y up, z forward). In the T-pose every bone is turned like the world,
the left arm points along -x, the right along +x, legs along -y, feet along +z. Where a joint is missing its bone keeps
the orientation of the bone above.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from ..arrays import Floats

STRAIGHT: Final = 0.15  # sine of the bend below which a limb does not tell how it is turned about itself
BENT: Final = 0.45  # ... and above which it does

# Bone: the bone above, the meaning of its start, the meaning of its end, the direction from start to end in the T-pose.
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_LEFT, _DOWN = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
_LIMBS: Final[tuple[tuple[str, str, str, str, tuple[float, float, float]], ...]] = (
    ("LeftShoulder", "Chest", "l_clavicle", "l_shoulder", _LEFT),
    ("LeftUpperArm", "LeftShoulder", "l_shoulder", "l_elbow", _LEFT),
    ("LeftLowerArm", "LeftUpperArm", "l_elbow", "l_wrist", _LEFT),
    ("LeftHand", "LeftLowerArm", "l_wrist", "l_hand", _LEFT),
    ("RightShoulder", "Chest", "r_clavicle", "r_shoulder", _X),
    ("RightUpperArm", "RightShoulder", "r_shoulder", "r_elbow", _X),
    ("RightLowerArm", "RightUpperArm", "r_elbow", "r_wrist", _X),
    ("RightHand", "RightLowerArm", "r_wrist", "r_hand", _X),
    ("LeftUpperLeg", "Hips", "l_hip", "l_knee", _DOWN),
    ("LeftLowerLeg", "LeftUpperLeg", "l_knee", "l_ankle", _DOWN),
    ("LeftFoot", "LeftLowerLeg", "l_ankle", "l_foot", _Z),
    ("RightUpperLeg", "Hips", "r_hip", "r_knee", _DOWN),
    ("RightLowerLeg", "RightUpperLeg", "r_knee", "r_ankle", _DOWN),
    ("RightFoot", "RightLowerLeg", "r_ankle", "r_foot", _Z),
)
# Upper bone of a hinge: the end of the lower bone, and the axis of the T-pose about which the lower bone bends.
_HINGES: Final[Mapping[str, tuple[str, tuple[float, float, float]]]] = {
    "LeftUpperArm": ("l_wrist", _Y),
    "RightUpperArm": ("r_wrist", (0.0, -1.0, 0.0)),
    "LeftUpperLeg": ("l_ankle", _X),
    "RightUpperLeg": ("r_ankle", _X),
}


@final
@dataclass(frozen=True, eq=False)
class Bone:
    """A bone as Unity has it: place (3,) m relative to the bone above, rotation (4,) as quaternion x, y, z, w."""

    name: str
    place: Floats
    rotation: Floats


def humanoid(joints: Mapping[str, Floats]) -> list[Bone]:
    """The bones that these joints tell of, parents first.

    Parameters
    ----------
    joints : by meaning (keys of `joint_sets.TREE`), place (3,) m in Unity's axes; only those that are there.

    Returns
    -------
    Hips and what hangs from it; empty where pelvis, hips or shoulders are missing.
    """
    if not {"pelvis", "l_hip", "r_hip", "l_shoulder", "r_shoulder"} <= joints.keys():
        return []
    world = _trunk(joints)
    above = {"Hips": "", "Spine": "Hips", "Chest": "Spine", "Neck": "Chest", "Head": "Neck"}
    places = {
        "Hips": joints["pelvis"],
        "Spine": joints.get("spine", joints["pelvis"]),
        "Chest": joints.get("chest", joints.get("spine", joints["pelvis"])),
        "Neck": _neck(joints),
        "Head": joints.get("neck", _neck(joints)) if "head_top" not in joints else joints.get("head", _neck(joints)),
    }
    for name, parent, start, end, direction in _LIMBS:
        if start not in joints:
            if name.endswith("Shoulder"):  # a set without collar bones: the shoulder goes with the chest
                world[name], above[name], places[name] = world["Chest"], parent, places["Neck"]
            continue
        if parent not in world:
            continue
        above[name], places[name], world[name] = parent, joints[start], world[parent]
        if end in joints:
            world[name] = _toward(world[parent], direction, joints[end] - joints[start])
            if name in _HINGES:
                world[name] = _hinged(world[name], name, joints, start, end)
    return [_bone(name, above[name], world, places) for name in world]


def _trunk(joints: Mapping[str, Floats]) -> dict[str, Floats]:
    """World rotations (3, 3) of hips, spine, chest, neck and head."""
    neck = _neck(joints)
    hips = joints["r_hip"] - joints["l_hip"]
    shoulders = joints["r_shoulder"] - joints["l_shoulder"]
    middle = joints.get("spine", (joints["pelvis"] + neck) / 2)
    low, high = middle - joints["pelvis"], neck - middle
    world = {
        "Hips": _frame(hips, low),
        "Spine": _frame(_unit(hips) + _unit(shoulders), low + high),
        "Chest": _frame(shoulders, high),
    }
    head = joints.get("head", joints.get("head_top"))
    world["Neck"] = world["Chest"] if head is None else _toward(world["Chest"], _Y, head - neck)
    world["Head"] = world["Neck"]
    if {"l_ear", "r_ear", "nose"} <= joints.keys():
        ears = joints["r_ear"] - joints["l_ear"]
        forward = joints["nose"] - (joints["r_ear"] + joints["l_ear"]) / 2
        world["Head"] = _frame(ears, np.cross(forward, ears))
    return world


def _neck(joints: Mapping[str, Floats]) -> Floats:
    between = (joints["l_shoulder"] + joints["r_shoulder"]) / 2
    return joints.get("neck_base", joints.get("neck", between))


def _hinged(turn: Floats, bone: str, joints: Mapping[str, Floats], start: str, end: str) -> Floats:
    """The upper bone of a bent hinge, turned about itself so that the lower bone bends about the hinge's axis.

    The straighter the limb, the less it tells: in between, the turn of the bone above is gone over to.
    """
    far, axis = _HINGES[bone]
    if far not in joints:
        return turn
    upper, lower = _unit(joints[end] - joints[start]), _unit(joints[far] - joints[end])
    normal = np.cross(upper, lower)
    bend = float(np.linalg.norm(normal))
    share = min(1.0, max(0.0, (bend - STRAIGHT) / (BENT - STRAIGHT)))
    if share == 0.0:
        return turn
    now = turn @ np.array(axis)
    wanted = np.arctan2(np.dot(np.cross(now, normal), upper), np.dot(now, normal))
    return np.asarray(_about(upper, share * share * (3.0 - 2.0 * share) * wanted) @ turn)


def _bone(name: str, parent: str, world: Mapping[str, Floats], places: Mapping[str, Floats]) -> Bone:
    if not parent:
        return Bone(name, places[name], quaternion(world[name]))
    up = world[parent].T
    return Bone(name, up @ (places[name] - places[parent]), quaternion(up @ world[name]))


def _frame(right: Floats, up: Floats) -> Floats:
    """(3, 3) rotation whose x axis is nearest `right` among those square to `up`."""
    y = _unit(up)
    x = _unit(right - y * np.dot(y, right))
    return np.column_stack([x, y, np.cross(x, y)])


def _toward(turn: Floats, direction: tuple[float, float, float], wanted: Floats) -> Floats:
    """`turn` and the least rotation after it that brings the T-pose's `direction` to `wanted`."""
    now, goal = turn @ np.array(direction), _unit(wanted)
    if not goal.any():
        return turn
    axis = np.cross(now, goal)
    sine, cosine = float(np.linalg.norm(axis)), float(np.dot(now, goal))
    if sine < 1e-9:
        if cosine > 0:
            return turn
        axis = turn @ np.array(_Y if abs(direction[1]) < 0.5 else _X)  # straight back: any square axis will do
        return np.asarray(_about(_unit(axis), np.pi) @ turn)
    return np.asarray(_about(axis / sine, np.arctan2(sine, cosine)) @ turn)


def _about(axis: Floats, angle: float) -> Floats:
    """(3, 3) rotation about a unit axis by Rodrigues' formula, rad."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross))


def _unit(vector: Floats) -> Floats:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-9 else np.zeros(3)


def quaternion(turn: Floats) -> Floats:
    """(4,) x, y, z, w of a rotation matrix, w >= 0 (Shepperd 1978: divides by the largest of the four)."""
    trace = float(np.trace(turn))
    squares = np.array([*(2.0 * np.diag(turn) - trace), trace])
    k = int(np.argmax(squares))
    found = np.empty(4)
    if k == 3:
        found[3] = 1.0 + trace
        found[:3] = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    else:
        i, j, m = k, (k + 1) % 3, (k + 2) % 3
        found[i] = 1.0 + turn[i, i] - turn[j, j] - turn[m, m]
        found[j] = turn[j, i] + turn[i, j]
        found[m] = turn[m, i] + turn[i, m]
        found[3] = turn[m, j] - turn[j, m]
    found /= np.linalg.norm(found)
    return found if found[3] >= 0 else -found
