"""The performer of any skeleton's lengths, and its poses from that skeleton's motions.

A CMU body has 62 degrees of freedom in 30 bones, the performer 34 in 15 (section 3.5: "we preprocess them to suit the
simplified skeleton model"). Three spine joints become one in the middle of them, three neck joints one; fingers, wrists
and toes are stiff. What this costs is measured: `Retargeted.error`.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Ints, frozen
from ..errors import MismatchError
from . import anatomy
from .motion import Motion
from .performer import (
    AXES,
    BONES,
    DOFS,
    FIRST,
    LANDMARK_BONES,
    LANDMARKS,
    LIMITS,
    MOVES,
    PARENTS,
    RESTS,
    TIP_BONES,
    TIPS,
    Performer,
    Poses,
    rotation_vector,
)
from .roles import Roles, roles
from .skeleton import ROTATION, Skeleton, forward, rest_positions

HAND = 0.5  # of the forearm: hands reach at least so far beyond the wrist; rigs often end them at the knuckles
# How firmly degrees of freedom stay where the rotations put them while the joints are brought to their places, in
# metres of miss that weigh as much as one radian; the root's place is free.
HOLD, HOLD_ROOT = 0.02, 0.05
TIP_WEIGHT = 0.1  # tips of hands and feet beside the 16 joints: they say how a limb is twisted, and little else
BENT = 0.35  # sine of the bend above which elbow or knee show their own axis
ROUNDS = 12


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


@final
@dataclass(frozen=True, eq=False)
class Retargeted:
    """A motion as the performer does it.

    Attributes
    ----------
    poses : T poses, in the axes and metres of the motion.
    error : (T, 16) m, how far each of the performer's joints is from the motion's own; NaN in frames with missing
        angles, whose poses are those of the last whole frame.
    """

    poses: Poses
    error: Floats


def performer_of(skeleton: Skeleton) -> Performer:
    """The performer with the lengths of a skeleton, joints where CMU's bones begin and end, widths of an average adult.

    Chest and head turn about the mean of the spine's and the neck's joints: equal bends of all of them move what they
    carry exactly so, to first order.

    Raises
    ------
    MismatchError : a skeleton on which the 16 joints are not found, or with bones of no length.
    """
    rig = rig_of(skeleton)
    rest = rest_positions(skeleton)
    part = rig.roles
    wanted = _landmarks(part, rest[None], rig.rests[None, 2])[0]
    place = dict(zip(LANDMARKS, wanted, strict=True))
    begin = {"pelvis": place["pelvis"]}
    begin["chest"] = rest[list(part.spine)].mean(axis=0) if part.spine else (place["pelvis"] + place["chest"]) / 2
    begin["head"] = rest[list(part.neck)].mean(axis=0) if part.neck else place["neck"]
    for side, arm in zip("lr", part.arms, strict=True):
        begin[f"{side}_clavicle"] = rest[arm.clavicle] if arm.clavicle >= 0 else place["chest"]
        for bone, name in (("upperarm", "shoulder"), ("forearm", "elbow")):
            begin[f"{side}_{bone}"] = place[f"{side}_{name}"]
        for bone, name in (("thigh", "hip"), ("shank", "knee"), ("foot", "ankle")):
            begin[f"{side}_{bone}"] = place[f"{side}_{name}"]
    starts = np.array([begin[bone] for bone in BONES])
    offsets = np.zeros((len(BONES), 3))
    for b in range(1, len(BONES)):
        offsets[b] = rig.rests[PARENTS[b]].T @ (starts[b] - starts[PARENTS[b]])
    landmark = _local(wanted, LANDMARK_BONES, starts, rig.rests)
    for name in ("upperarm", "forearm", "thigh", "shank"):
        for side in "lr":
            length = np.linalg.norm(
                landmark[LANDMARKS.index(f"{side}_wrist")]
                if name == "forearm"
                else offsets[
                    BONES.index(f"{side}_{ {'upperarm': 'forearm', 'thigh': 'shank', 'shank': 'foot'}[name] }")
                ]
            )
            if not 0.02 < length < 2.0:
                raise MismatchError(f"a performer's {name} must be 0.02 to 2 m long, this skeleton's is {length:.3g} m")
    tip = _tips(skeleton, part, rest, starts, rig.rests, landmark)
    return anatomy.performer(offsets, landmark, tip)


def poses_of(motion: Motion, performer: Performer) -> Retargeted:
    """What the performer does in a motion: rotations of its bones in closed form, then joints brought to their places.

    Parameters
    ----------
    motion : of any skeleton with the 16 joints; best the one the performer was made of.
    performer : its lengths are kept.

    Returns
    -------
    Retargeted : the poses in the motion's axes, and the distances left between the 16 joints of both.
    """
    from ..kernels import articulated

    rig = rig_of(motion.skeleton)
    position, turned = forward(motion.skeleton, motion.q)
    whole: Bools = np.asarray(np.isfinite(motion.q).all(axis=1))
    if not whole.any():
        raise MismatchError("a motion needs one frame or more without missing angles")
    bone = turned[:, rig.joints] @ rig.rests
    wanted = _landmarks(rig.roles, position, bone[:, 2])
    _hinge_planes(motion.skeleton, rig, wanted, bone)
    translation, root, joints = wanted[:, 0].copy(), bone[:, 0].copy(), _coordinates(bone)
    targets, weights = _targets(rig.roles, position, wanted)
    hold = np.full(DOFS, HOLD)
    hold[:3], hold[3:6] = 1e-6, HOLD_ROOT
    bones = np.concatenate((LANDMARK_BONES, TIP_BONES))
    local = np.concatenate((performer.landmark_place, performer.tip_place))
    world = np.empty((len(bones), 3))
    frames = np.empty((len(BONES), 4, 4))
    error = np.full(wanted.shape[:2], np.nan)
    last = int(np.flatnonzero(whole)[0])
    for t in range(motion.frames):
        if not whole[t]:
            continue
        articulated.reach(
            *performer.chain,
            MOVES,
            bones,
            local,
            targets[t],
            weights,
            hold,
            performer.limits,
            ROUNDS,
            translation[t],
            root[t],
            joints[t],
        )
        articulated.frames(*performer.chain, translation[t], root[t], joints[t], frames)
        articulated.points(frames, bones, local, world)
        error[t] = np.linalg.norm(world[: len(LANDMARKS)] - wanted[t], axis=1)
    for t in range(motion.frames):
        if whole[t]:
            last = t
        else:
            translation[t], root[t], joints[t] = translation[last], root[last], joints[last]
    return Retargeted(Poses(translation, root, joints), error)


def rig_of(skeleton: Skeleton) -> Rig:
    """How a skeleton carries the performer: which joints turn its bones, and how the bones lie in them."""
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


def _landmarks(part: Roles, position: Floats, head: Floats) -> Floats:
    """(T, 16, 3) m, the joints of `LANDMARKS` from all joints (T, J, 3) and the head's axes (T, 3, 3)."""
    end = position[:, list(part.head_end)].mean(axis=1)
    if len(part.head_end) > 1:  # eyes and the like: the head's end is as high, above its joint
        rise = np.einsum("ti,ti->t", end - position[:, part.head], head[:, :, 1])
        end = position[:, part.head] + rise[:, None] * head[:, :, 1]
    arms = [joint for arm in part.arms for joint in (arm.shoulder, arm.elbow, arm.wrist)]
    legs = [chain[side] for side in (0, 1) for chain in (part.feet.hips, part.feet.knees, part.feet.ankles)]
    first = position[:, [part.pelvis, part.chest, part.head]]
    return np.asarray(np.concatenate((first, end[:, None], position[:, arms + legs]), axis=1))


def _local(points: Floats, bones: Ints, starts: Floats, rests: Floats) -> Floats:
    """Points (N, 3) of the rest pose in the axes of bones (N,)."""
    return np.asarray(np.einsum("nji,nj->ni", rests[bones], points - starts[bones]))


def _tips(skeleton: Skeleton, part: Roles, rest: Floats, starts: Floats, rests: Floats, landmark: Floats) -> Floats:
    """(5, 3) m, the points of `TIPS` in the axes of their bones."""
    head = landmark[LANDMARKS.index("head")]
    neck = landmark[LANDMARKS.index("neck")]
    tips = [head + 1.25 * (head - neck)]
    for side, arm in zip("lr", part.arms, strict=True):
        forearm = float(np.linalg.norm(landmark[LANDMARKS.index(f"{side}_wrist")]))
        hand = float(np.linalg.norm(rest[arm.tip] - rest[arm.wrist])) if arm.tip >= 0 else 0.0
        tips.append(np.array([0.0, -forearm - max(hand, HAND * forearm), 0.0]))
    for index, name in enumerate("lr"):
        shank = float(np.linalg.norm(starts[BONES.index(f"{name}_foot")] - starts[BONES.index(f"{name}_shank")]))
        end = _toe(part, index)
        tip = np.array([0.0, -0.1 * shank, 0.48 * shank])
        if end >= 0:
            seen = rests[BONES.index(f"{name}_foot")].T @ (rest[end] - rest[part.feet.ankles[index]])
            if seen[2] > 0.2 * shank:
                tip = seen
        tips.append(tip)
    return np.array(tips)


def _toe(part: Roles, side: int) -> int:
    """The tip of the toes, or what comes nearest to it; -1 where the foot has no length."""
    return part.feet.ends[side] if part.feet.ends[side] >= 0 else part.feet.toes[side]


def _targets(part: Roles, position: Floats, wanted: Floats) -> tuple[Floats, Floats]:
    """Where joints and tips (T, 21, 3) should be, and how much each counts (21,)."""
    targets = np.full((len(wanted), len(LANDMARKS) + len(TIPS), 3), np.nan)
    weights = np.zeros(targets.shape[1])
    targets[:, : len(LANDMARKS)], weights[: len(LANDMARKS)] = wanted, 1.0
    for side in (0, 1):
        end = _toe(part, side)
        if end >= 0:
            targets[:, len(LANDMARKS) + 3 + side] = position[:, end]
            weights[len(LANDMARKS) + 3 + side] = TIP_WEIGHT
    return targets, weights


def _hinge_planes(skeleton: Skeleton, rig: Rig, wanted: Floats, bone: Floats) -> None:
    """Turn upper arms and thighs, in place, so that elbow and knee bend in their own plane where they are bent.

    Only where the skeleton's elbow or knee is more than a hinge: a hinge's axis is the bone's already.
    """
    for side in "lr":
        for upper, lower, names, sign in (
            ("upperarm", "forearm", ("shoulder", "elbow", "wrist"), -1.0),
            ("thigh", "shank", ("hip", "knee", "ankle"), 1.0),
        ):
            u, w = BONES.index(f"{side}_{upper}"), BONES.index(f"{side}_{lower}")
            begin, middle, end = (wanted[:, LANDMARKS.index(f"{side}_{name}")] for name in names)
            along, further = _unit(middle - begin), _unit(end - middle)
            hinge = len(skeleton.dofs_of(int(rig.joints[w]))) == 1
            across = sign * np.cross(along, further)
            bent = np.linalg.norm(across, axis=1) > BENT
            x = np.where((bent & (not hinge))[:, None], across, bone[:, u, :, 0])
            y = -along
            x = _unit(x - np.einsum("ti,ti->t", x, y)[:, None] * y)
            bone[:, u] = np.stack((x, y, np.cross(x, y)), axis=2)
            y = -further
            x = _unit(x - np.einsum("ti,ti->t", x, y)[:, None] * y)
            bone[:, w] = np.stack((x, y, np.cross(x, y)), axis=2)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))


def _coordinates(bone: Floats) -> Floats:
    """(T, 28) rad, the joint coordinates that come nearest to world rotations (T, 15, 3, 3) of the bones."""
    joints = np.zeros((len(bone), len(AXES)))
    usable = np.isfinite(bone).all(axis=(1, 2, 3))
    for b in range(1, len(BONES)):
        rows = slice(FIRST[b], FIRST[b + 1])
        between = np.swapaxes(bone[usable][:, PARENTS[b]] @ RESTS[b], -1, -2) @ bone[usable][:, b]
        if FIRST[b + 1] - FIRST[b] == 1:  # the angle about the hinge that keeps most of the rotation
            axis = AXES[FIRST[b]]
            cross = np.stack(
                (
                    between[:, 2, 1] - between[:, 1, 2],
                    between[:, 0, 2] - between[:, 2, 0],
                    between[:, 1, 0] - between[:, 0, 1],
                ),
                axis=1,
            )
            stay = np.trace(between, axis1=1, axis2=2) - np.einsum("i,tij,j->t", axis, between, axis)
            joints[usable, rows] = np.arctan2(cross @ axis, stay)[:, None]
        else:
            joints[usable, rows] = rotation_vector(between) @ AXES[rows].T
    return np.clip(joints, LIMITS[6:, 0], LIMITS[6:, 1])
