"""The performer of any skeleton's lengths, and its poses from that skeleton's motions.

A CMU body has 62 degrees of freedom in 30 bones, the performer 34 in 15 (section 3.5: "we preprocess them to suit the
simplified skeleton model"). Three spine joints become one in the middle of them, three neck joints one; fingers, wrists
and toes are stiff. What this costs is measured: `Retargeted.error`.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..errors import MismatchError
from ..kernels.body import Posed
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
from .rig import Rig, landmark_positions, rig_of, toe_tip
from .roles import Roles
from .skeleton import Skeleton, forward, rest_positions

HAND = 0.5  # of the forearm: hands reach at least so far beyond the wrist; rigs often end them at the knuckles
# How firmly degrees of freedom stay where the rotations put them while the joints are brought to their places, in
# metres of miss that weigh as much as one radian; the root's place is free.
HOLD, HOLD_ROOT = 0.02, 0.05
TIP_WEIGHT = 0.1  # tips of hands and feet beside the 16 joints: they say how a limb is twisted, and little else
BENT = 0.35  # sine of the bend above which elbow or knee show their own axis
ROUNDS = 12


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
    wanted = landmark_positions(part, rest[None], rig.rests[None, 2])[0]
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
    Retargeted : the poses in the motion's axes, and the distances left between the 16 joints of both, m.

    Raises
    ------
    MismatchError : no frame is without missing angles, or the skeleton's parts are not to be told.
    """
    from ..kernels import articulated

    rig = rig_of(motion.skeleton)
    position, turned = forward(motion.skeleton, motion.q)
    whole: Bools = np.asarray(np.isfinite(motion.q).all(axis=1))
    if not whole.any():
        raise MismatchError("a motion needs one frame or more without missing angles")
    bone = turned[:, rig.joints] @ rig.rests
    wanted = landmark_positions(rig.roles, position, bone[:, 2])
    _hinge_planes(motion.skeleton, rig, wanted, bone)
    translation, root, joints = wanted[:, 0].copy(), bone[:, 0].copy(), _coordinates(bone)
    targets, weights = _targets(rig.roles, position, wanted)
    hold = np.full(DOFS, HOLD)
    hold[:3], hold[3:6] = 1e-6, HOLD_ROOT
    bones = np.concatenate((LANDMARK_BONES, TIP_BONES))
    local = np.concatenate((performer.landmark_place, performer.tip_place))
    moves, limits = MOVES.copy(), performer.limits.copy()  # as kernels take arrays
    world = np.empty((len(bones), 3))
    frames = np.empty((len(BONES), 4, 4))
    error = np.full(wanted.shape[:2], np.nan)
    last = int(np.flatnonzero(whole)[0])
    for t in range(motion.frames):
        if not whole[t]:
            continue
        posed = Posed(translation[t], root[t], joints[t])
        articulated.reach(
            performer.chain,
            moves,
            bones,
            local,
            targets[t],
            weights,
            hold,
            limits,
            ROUNDS,
            posed,
        )
        articulated.frames(performer.chain, posed, frames)
        articulated.points(frames, bones, local, world)
        error[t] = np.linalg.norm(world[: len(LANDMARKS)] - wanted[t], axis=1)
    for t in range(motion.frames):
        if whole[t]:
            last = t
        else:
            translation[t], root[t], joints[t] = translation[last], root[last], joints[last]
    return Retargeted(Poses(translation, root, joints), error)


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
        end = toe_tip(part, index)
        tip = np.array([0.0, -0.1 * shank, 0.48 * shank])
        if end >= 0:
            seen = rests[BONES.index(f"{name}_foot")].T @ (rest[end] - rest[part.feet.ankles[index]])
            if seen[2] > 0.2 * shank:
                tip = seen
        tips.append(tip)
    return np.array(tips)


def _targets(part: Roles, position: Floats, wanted: Floats) -> tuple[Floats, Floats]:
    """Where joints and tips (T, 21, 3) should be, and how much each counts (21,)."""
    targets = np.full((len(wanted), len(LANDMARKS) + len(TIPS), 3), np.nan)
    weights = np.zeros(targets.shape[1])
    targets[:, : len(LANDMARKS)], weights[: len(LANDMARKS)] = wanted, 1.0
    for side in (0, 1):
        end = toe_tip(part, side)
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


def skeleton_of(performer: Performer) -> Skeleton:
    """A skeleton of the performer's own, 34 degrees of freedom and the usual names, y up, at rest with hanging arms.

    `performer_of` gives its lengths back, and `motion_of` its poses exactly.
    """
    at = dict(zip(LANDMARKS, performer.landmark_place, strict=True))
    begin = dict(zip(BONES, performer.offsets, strict=True))
    tip = dict(zip(TIPS, performer.tip_place, strict=True))
    free, ball, hinge = "txyz rzxy", "rzxy", "rx"
    rows: list[tuple[str, str, Floats, str]] = [
        ("Hips", "", at["pelvis"], free),
        ("Spine", "Hips", begin["chest"], ball),
        ("Chest", "Spine", at["chest"], ""),
        ("Neck", "Chest", begin["head"] - at["chest"], ball),
        ("Head", "Neck", at["neck"], ""),
        ("Head_end", "Head", at["head"] - at["neck"], ""),
    ]
    for side, name in (("l", "Left"), ("r", "Right")):
        rows += [
            (f"{name}Shoulder", "Spine", begin[f"{side}_clavicle"], "ryz"),
            (f"{name}Arm", f"{name}Shoulder", begin[f"{side}_upperarm"], ball),
            (f"{name}ForeArm", f"{name}Arm", begin[f"{side}_forearm"], hinge),
            (f"{name}Hand", f"{name}ForeArm", at[f"{side}_wrist"], ""),
            (f"{name}Hand_end", f"{name}Hand", tip[f"{side}_hand"] - at[f"{side}_wrist"], ""),
        ]
    for side, name in (("l", "Left"), ("r", "Right")):
        rows += [
            (f"{name}UpLeg", "Hips", begin[f"{side}_thigh"], ball),
            (f"{name}Leg", f"{name}UpLeg", begin[f"{side}_shank"], hinge),
            (f"{name}Foot", f"{name}Leg", begin[f"{side}_foot"], hinge),
            (f"{name}Foot_end", f"{name}Foot", tip[f"{side}_toe"], ""),
        ]
    names = [name for name, *_ in rows]
    dofs = [
        (joint, kind, axis)
        for joint, row in enumerate(rows)
        for part in row[3].split()
        for kind, axis in ((part[0], letter) for letter in part[1:])
    ]
    letters = "xyz"
    return Skeleton(
        names=tuple(names),
        parents=np.array([names.index(parent) if parent else -1 for _, parent, _, _ in rows]),
        offsets=np.array([offset for _, _, offset, _ in rows]),
        dof_names=tuple(
            f"{names[joint]}.{axis.upper()}{'rotation' if kind == 'r' else 'position'}" for joint, kind, axis in dofs
        ),
        dof_joint=np.array([joint for joint, _, _ in dofs]),
        dof_axis=np.array([np.eye(3)[letters.index(axis)] for _, _, axis in dofs]),
        dof_kind=np.array([0 if kind == "r" else 1 for _, kind, _ in dofs], dtype=np.uint8),
        limits=np.full((len(dofs), 2), (-np.inf, np.inf)),
    )
