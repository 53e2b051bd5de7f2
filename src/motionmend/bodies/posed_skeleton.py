"""Joint positions as the motion of a skeleton, for formats that hold angles."""

import numpy as np

from ..arrays import Floats, Ints
from ..errors import MismatchError
from .joint_sets import parents
from .motion import Motion
from .postures import Postures
from .skeleton import ROTATION, TRANSLATION, Skeleton

_TWIST = 1e-6  # weight of keeping the parent's turn, which decides what the bones leave open


def motion_of(postures: Postures, fps: float | None = None) -> Motion:
    """A skeleton with the postures' median bone lengths, turned so that its bones point as theirs do.

    Each joint that carries others has three angles, chosen by least squares over the bones that leave it; the turn
    about a single bone is its parent's. Bones whose length varies end beside the positions by as much.

    Parameters
    ----------
    postures : T frames. One in which a joint that carries others is missing leaves its angles missing.
    fps : Hz; None takes the rate of the postures' times, of which there must be two or more then.

    Returns
    -------
    motion : at that rate; joints in an order in which parents come first.

    Raises
    ------
    MismatchError : no frame in which all joints are there, or joints that hang from nothing.
    """
    above = parents(postures.names)
    root = int(np.flatnonzero(above < 0)[0])
    above = np.where((above < 0) & (np.arange(len(above)) != root), root, above)
    order = _parents_first(above)
    up = {joint: k for k, joint in enumerate(order)}
    tree = np.array([-1 if above[j] < 0 else up[int(above[j])] for j in order], dtype=np.int64)
    names = tuple(postures.names[j] for j in order)
    places = postures.positions[:, order]
    whole = np.flatnonzero(np.isfinite(places).all(axis=(1, 2)))
    if not len(whole):
        raise MismatchError("wanted a frame in which every joint has a position, to take the skeleton from, came none")
    bones = places[:, 1:] - places[:, tree[1:]]
    lengths = np.nanmedian(np.linalg.norm(bones, axis=2), axis=0)
    still = bones[whole[0]]
    offsets = np.zeros((len(names), 3))
    offsets[1:] = still / np.maximum(np.linalg.norm(still, axis=1), 1e-9)[:, None] * lengths[:, None]
    skeleton = _skeleton(names, tree, offsets)
    return Motion(skeleton, _angles(skeleton, places), postures.fps if fps is None else fps, guesses=postures.guesses)


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


def _angles(skeleton: Skeleton, places: Floats) -> Floats:
    """(T, D) the root's place and the joints' angles."""
    from scipy.spatial.transform import Rotation

    frames = len(places)
    q = np.full((frames, len(skeleton.dof_names)), np.nan)
    q[:, :3] = places[:, 0]
    turns = np.full((frames, len(skeleton.names), 3, 3), np.nan)
    rest = np.tile(np.eye(3), (frames, 1, 1))
    for joint in dict.fromkeys(skeleton.dof_joint.tolist()):
        parent = int(skeleton.parents[joint])
        carried = turns[:, parent] if parent >= 0 else rest
        children = np.flatnonzero(skeleton.parents == joint)
        spread = _TWIST * carried
        for child in children:
            bone = places[:, child] - places[:, joint]
            spread = spread + bone[:, :, None] * skeleton.offsets[child]
        known = np.isfinite(spread).all(axis=(1, 2))
        left, _, right = np.linalg.svd(spread[known])
        sign = np.ones((int(known.sum()), 3))
        sign[:, 2] = np.sign(np.linalg.det(left @ right))
        turns[known, joint] = (left * sign[:, None]) @ right
        local = carried[known].swapaxes(1, 2) @ turns[known, joint]
        rows = np.flatnonzero((skeleton.dof_joint == joint) & (skeleton.dof_kind == ROTATION))
        if known.any():
            q[np.ix_(known, rows)] = np.unwrap(Rotation.from_matrix(local).as_euler("ZXY"), axis=0)
    return q
