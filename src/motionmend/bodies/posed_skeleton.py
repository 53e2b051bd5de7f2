"""Joint positions as the motion of a skeleton, for formats that hold angles."""

from dataclasses import replace

import numpy as np

from ..arrays import Floats, Ints
from ..errors import MismatchError
from .joint_sets import meanings, parents
from .motion import Motion
from .pose_of_places import given_way, turns_of
from .postures import Postures
from .skeleton import ROTATION, TRANSLATION, Skeleton, forward

NOTHING = 0.1  # cm in the mean, by which joints may be beside their places without a word
SHORTER = 0.02  # of the recording's time, by which frames at even times may last shorter or longer
_ROUNDS = 3  # of angles by the bones' directions, and those by the angles
_BETWEEN = {"pelvis": ("MidHip", "l_hip", "r_hip"), "neck_base": ("MidShoulder", "l_shoulder", "r_shoulder")}


def motion_of(postures: Postures, fps: float | None = None) -> Motion:
    """A skeleton with the postures' median bone lengths, turned so that its bones point as theirs do.

    Each joint that carries others has three angles, chosen by least squares over the bones that leave it; the turn
    about a single bone is its parent's. Bones whose length varies end beside the positions by as much. Where a sensor
    has no pelvis, or nothing between its shoulders, a joint there is added, `MidHip` and `MidShoulder`: limbs that hang
    from each other could not move by themselves. At rest legs are straight and in line with the trunk, whoever sits:
    readers tell a file's unit by how tall that is.

    Parameters
    ----------
    postures : T frames. One in which a joint that carries others is missing, or all that it carries, leaves its angles
        missing. A joint that is never there is left out, and said.
    fps : Hz; None takes the rate of the postures' times, of which there must be two or more then.

    Returns
    -------
    motion : at that rate; joints in an order in which parents come first.

    Raises
    ------
    MismatchError : nobody in any frame, or a joint that is never there in the same frame as the one it hangs from.
    """
    names, places, said = _hanging_together(postures)
    above = parents(names)
    root = int(np.flatnonzero(above < 0)[0])
    above = np.where((above < 0) & (np.arange(len(above)) != root), root, above)
    order = _parents_first(above)
    up = {joint: k for k, joint in enumerate(order)}
    tree = np.array([-1 if above[j] < 0 else up[int(above[j])] for j in order], dtype=np.int64)
    names, places = tuple(names[j] for j in order), places[:, order]
    offsets = _standing(names, tree, _offsets(names, tree, places))
    rate = postures.fps if fps is None else fps
    for _ in range(_ROUNDS):
        skeleton = _skeleton(names, tree, offsets)
        turns = turns_of(skeleton, places, rate)
        offsets = _as_turned(offsets, tree, places, turns)
    skeleton = _skeleton(names, tree, offsets)
    moved, turns = given_way(skeleton, places, turns_of(skeleton, places, rate))
    motion = Motion(skeleton, _angles(skeleton, moved, turns), rate)
    said += (*_beside(motion, places), *_lasting(motion, postures.times))
    return replace(motion, guesses=(*postures.guesses, *said), warnings=postures.warnings)


def _hanging_together(postures: Postures) -> tuple[tuple[str, ...], Floats, tuple[str, ...]]:
    """Names (J,) and places (T, J, 3) of the joints that are ever there, with those between the hips and the shoulders
    where there are none; and what was left out."""
    ever = np.flatnonzero(postures.present.any(axis=0))
    if not len(ever):
        raise MismatchError("wanted a frame in which joints have positions, to take the skeleton from, came none")
    names = tuple(postures.names[k] for k in ever)
    never = ", ".join(name for name in postures.names if name not in names)
    places = postures.positions[:, ever]
    at = {meaning: k for k, meaning in enumerate(meanings(names)) if meaning}
    for meaning, (name, left, right) in _BETWEEN.items():
        if meaning not in at and {left, right} <= at.keys():
            names = (*names, name)
            places = np.concatenate([places, places[:, [at[left], at[right]]].mean(axis=1, keepdims=True)], axis=1)
    return names, places, (f"never seen, so not in the skeleton: {never}",) if never else ()


def _beside(motion: Motion, places: Floats) -> tuple[str, ...]:
    """A sentence about how far the skeleton's joints are from the places (T, J, 3) m they were to have."""
    off = np.sqrt(np.square(forward(motion.skeleton, motion.q)[0] - places).sum(axis=2))
    each = [100.0 * float(np.mean(one[np.isfinite(one)])) if np.isfinite(one).any() else 0.0 for one in off.T]
    mean, most = 100.0 * float(np.mean(off[np.isfinite(off)])), int(np.argmax(each))
    if mean < NOTHING:
        return ()
    farthest = f"{motion.skeleton.names[most]} {each[most]:.1f}"
    return (f"a skeleton's bones leave each joint alike: its joints are {mean:.1f} cm from the positions ({farthest})",)


def _lasting(motion: Motion, times: Floats) -> tuple[str, ...]:
    """A sentence about frames at even times that last shorter or longer than the recording's."""
    whole, even = float(times[-1] - times[0]), (motion.frames - 1) / motion.fps
    if abs(whole - even) <= SHORTER * whole:
        return ()
    return (f"frames are at even times: {even:.2f} s of motion where the recording takes {whole:.2f} s",)


def _offsets(names: tuple[str, ...], tree: Ints, places: Floats) -> Floats:
    """(J, 3) m: bones of median length, as they point in the first frame that has most of them."""
    bones = places[:, 1:] - places[:, tree[1:]]
    there = np.isfinite(bones.sum(axis=2))
    never = np.flatnonzero(~there.any(axis=0))
    if len(never):
        apart = names[1 + int(never[0])]
        raise MismatchError(f"wanted {apart} in some frame together with the joint that it hangs from, came none")
    fullest = int(there.sum(axis=1).argmax())
    first = np.where(there[fullest], fullest, there.argmax(axis=0))
    lengths = np.nanmedian(np.linalg.norm(bones, axis=2), axis=0)
    offsets = np.zeros((len(names), 3))
    offsets[1:] = _pointing(bones[first, np.arange(len(first))]) * lengths[:, None]
    return offsets


def _standing(names: tuple[str, ...], tree: Ints, offsets: Floats) -> Floats:
    """Offsets (J, 3) with thighs and shins, which alone leave their joints, in line with the trunk."""
    at = {meaning: k for k, meaning in enumerate(meanings(names)) if meaning}
    high = next((at[one] for one in ("neck_base", "neck", "head") if one in at), 0)
    trunk = np.zeros(3)
    while high > 0:
        trunk, high = trunk + offsets[high], int(tree[high])
    if not trunk.any():
        return offsets
    made = offsets.copy()
    for lower in (f"{side}_{joint}" for side in "lr" for joint in ("knee", "ankle")):
        if lower in at and (tree == tree[at[lower]]).sum() == 1:
            made[at[lower]] = -_pointing(trunk) * np.linalg.norm(offsets[at[lower]])
    return made


def _as_turned(offsets: Floats, tree: Ints, places: Floats, turns: Floats) -> Floats:
    """Offsets (J, 3) of the same lengths that point as the bones do in the mean, seen from the joints they leave."""
    bones = places[:, 1:] - places[:, tree[1:]]
    seen = _pointing(np.einsum("tjba,tjb->tja", turns[:, tree[1:]], bones))
    mean = np.nansum(seen, axis=0)
    mean = np.where(mean.any(axis=1, keepdims=True), mean, offsets[1:])
    lengths = np.linalg.norm(offsets[1:], axis=1)
    return np.concatenate([offsets[:1], _pointing(mean) * lengths[:, None]])


def _pointing(bones: Floats) -> Floats:
    """Vectors (..., 3) of length 1."""
    return np.asarray(bones / np.maximum(np.linalg.norm(bones, axis=-1, keepdims=True), 1e-9))


def _parents_first(above: Ints) -> list[int]:
    """Joints in an order in which each comes behind its parent, otherwise as they stand."""
    order: list[int] = []
    waiting = list(range(len(above)))
    while waiting:
        ready = next(j for j in waiting if above[j] < 0 or int(above[j]) in order)
        order.append(ready)
        waiting.remove(ready)
    return order


def _skeleton(names: tuple[str, ...], tree: Ints, offsets: Floats) -> Skeleton:
    """Translations at the root; rotations about z, x, y at every joint that carries others."""
    rows = [(0, f"{axis}position", k, TRANSLATION) for k, axis in enumerate("XYZ")]
    rows += [
        (joint, f"{'XYZ'[k]}rotation", k, ROTATION) for joint in range(len(names)) if joint in tree for k in (2, 0, 1)
    ]
    return Skeleton(
        names,
        np.asarray(tree, dtype=np.int64),
        offsets,
        tuple(f"{names[joint]}.{channel}" for joint, channel, _, _ in rows),
        np.array([joint for joint, *_ in rows], dtype=np.int64),
        np.array([np.eye(3)[k] for *_, k, _ in rows]),
        np.array([kind for *_, kind in rows], dtype=np.uint8),
        np.tile([-np.inf, np.inf], (len(rows), 1)),
    )


def _angles(skeleton: Skeleton, root: Floats, turns: Floats) -> Floats:
    """(T, D) the root's place and the joints' angles."""
    from scipy.spatial.transform import Rotation

    q = np.full((len(root), len(skeleton.dof_names)), np.nan)
    q[:, :3] = root
    for joint in dict.fromkeys(skeleton.dof_joint.tolist()):
        parent = int(skeleton.parents[joint])
        local = turns[:, joint] if parent < 0 else turns[:, parent].swapaxes(1, 2) @ turns[:, joint]
        known = np.isfinite(local).all(axis=(1, 2))
        rows = np.flatnonzero((skeleton.dof_joint == joint) & (skeleton.dof_kind == ROTATION))
        if known.any():
            q[np.ix_(known, rows)] = np.unwrap(Rotation.from_matrix(local[known]).as_euler("ZXY"), axis=0)
    return q
