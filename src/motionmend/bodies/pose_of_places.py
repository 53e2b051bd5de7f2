"""How a skeleton's joints are turned so that its joints lie as near as they can to given places, without spinning.

A bone's direction leaves open how it is turned about itself. What leaves a joint beside its main bone tells that: of a
trunk shoulders and hips do, surely, of a hand only the thumb, which a sensor throws about. So turns begin as near as
may be to the parent's, what tells little is heard over half a second, and then all of a pose gives way together: a
shoulder that is a hand's breadth higher than the skeleton allows does not take the arm along.
"""

import numpy as np
from scipy.ndimage import correlate1d

from ..arrays import Bools, Floats, Ints
from .skeleton import Skeleton

STEADY = 1e-6  # weight (m2) of the parent's turn where bones tell how a joint is turned
WEAK = 0.06  # m beside the main bone, in the root of the sum of squares: what is less tells little
DOUBT = 0.03  # m of a place, by which the parent's turn weighs there
HEARD = 0.15  # s, deviation of the times over which it is heard
LIGHT = 0.1  # weight of a place that tells little, where the pose gives way
ROUNDS = 4  # of giving way
FAR = 0.05  # m; what is farther from its place pulls less (Geman and McClure), for its bone must be wrong
VARIES = 0.02  # m by which a bone's length varies whose end pulls a quarter as much
FIRM = 0.02  # m by which joints give way for a turn of one radian, in one round
TOGETHER = 256  # frames at a time


def turns_of(skeleton: Skeleton, places: Floats, fps: float) -> Floats:
    """(T, J, 3, 3) how the joints that carry others are turned in space, bones pointing as places (T, J, 3) m do; NaN
    for those that carry none, and where nothing is known of what they carry."""
    turns = np.full((*places.shape[:2], 3, 3), np.nan)
    rest = np.tile(np.eye(3), (len(places), 1, 1))
    for joint in _carrying(skeleton):
        parent = int(skeleton.parents[joint])
        carried = turns[:, parent] if parent >= 0 else rest
        children = np.flatnonzero(skeleton.parents == joint)
        offsets = skeleton.offsets[children]
        bones = places[:, children] - places[:, joint, None]
        there = np.isfinite(bones.sum(axis=2))
        bones = np.where(there[:, :, None], bones, 0.0)
        spread = np.einsum("tcd,ce->tde", bones, offsets)
        main = _main(skeleton, children)
        if _weak(offsets, main):
            swung = _swung(carried, offsets[main], bones[:, main])
            told = swung.swapaxes(1, 2) @ spread
            spread = swung @ (_over_time(told, HEARD * fps) + DOUBT**2 * np.eye(3))
        else:
            spread = spread + STEADY * carried
        known = np.isfinite(spread).all(axis=(1, 2)) & there.any(axis=1)
        turns[known, joint] = _nearest(spread[known])
    return turns


def given_way(skeleton: Skeleton, places: Floats, turns: Floats) -> tuple[Floats, Floats]:
    """The root's place (T, 3) m and the turns (T, J, 3, 3) with which joints are nearest to their places (T, J, 3) m,
    in the mean of squares, beginning with the given turns."""
    root, found, weights = np.array(places[:, 0]), np.array(turns), _weights(skeleton, places)
    for start in range(0, len(places), TOGETHER):
        some = slice(start, start + TOGETHER)
        for _ in range(ROUNDS):
            root[some], found[some] = _one_round(skeleton, weights, places[some], root[some], found[some])
    return root, found


def _one_round(
    skeleton: Skeleton, weights: Floats, places: Floats, root: Floats, turns: Floats
) -> tuple[Floats, Floats]:
    """One damped step of Gauss and Newton, of places that weigh (J,)."""
    carrying = _carrying(skeleton)
    now = np.full(places.shape, np.nan)
    now[:, 0] = root
    for joint in range(1, len(skeleton.names)):
        parent = int(skeleton.parents[joint])
        now[:, joint] = now[:, parent] + turns[:, parent] @ skeleton.offsets[joint]
    off = np.where(np.isfinite(places - now), places - now, 0.0)
    weight = weights * np.isfinite(places - now).all(axis=2) / (1.0 + (off**2).sum(axis=2) / FAR**2) ** 2
    below = _below(skeleton)
    rows = np.zeros((*places.shape, 1 + len(carrying), 3))
    rows[..., 0, :] = np.eye(3)
    for k, joint in enumerate(carrying, 1):
        arm = np.where(below[joint][:, None], np.nan_to_num(now - now[:, joint, None]), 0.0)
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            rows[..., b, k, a], rows[..., c, k, a] = -arm[..., c], arm[..., b]
    rows = rows.reshape(len(places), -1, 3 * (1 + len(carrying)))
    heavy = np.repeat(weight, 3, axis=1)[..., None] * rows
    normal = heavy.swapaxes(1, 2) @ rows
    damping = np.repeat([1e-9, *np.full(len(carrying), FIRM**2)], 3)
    step = np.linalg.solve(normal + np.diag(damping), heavy.swapaxes(1, 2) @ off.reshape(len(places), -1, 1))[..., 0]
    by = step[:, 3:].reshape(len(places), -1, 3)
    for joint in carrying:
        above = [m for m, one in enumerate(carrying) if one == joint or below[one][joint]]
        turns[:, joint] = _rotation(by[:, above].sum(axis=1)) @ turns[:, joint]
    return root + step[:, :3], turns


def _carrying(skeleton: Skeleton) -> list[int]:
    """The joints that carry others and turn, parents first."""
    return list(dict.fromkeys(skeleton.dof_joint.tolist()))


def _below(skeleton: Skeleton) -> Bools:
    """(J, J) what hangs on each joint."""
    found: Bools = np.zeros((len(skeleton.names), len(skeleton.names)), dtype=np.bool_)
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            found[:, joint] = found[:, parent]
            found[parent, joint] = True
    return found


def _weights(skeleton: Skeleton, places: Floats) -> Floats:
    """(J,) of places: little of those whose bones' lengths vary, which cannot be reached, and of those beside the main
    bone of a joint that they hardly tell how to turn."""
    found = np.ones(len(skeleton.names))
    for joint in range(1, len(found)):
        bones = places[:, joint] - places[:, skeleton.parents[joint]]
        lengths = np.sqrt((bones[np.isfinite(bones).all(axis=1)] ** 2).sum(axis=1))
        off = lengths - np.sqrt((skeleton.offsets[joint] ** 2).sum())
        found[joint] = 1.0 / (1.0 + float(np.mean(off**2)) / VARIES**2) ** 2 if len(off) else 0.0
    for joint in _carrying(skeleton):
        children = np.flatnonzero(skeleton.parents == joint)
        offsets = skeleton.offsets[children]
        main = _main(skeleton, children)
        if _weak(offsets, main):
            found[np.delete(children, main)] *= LIGHT**2
    return found


def _main(skeleton: Skeleton, children: Ints) -> int:
    """Which of a joint's children its main bone leads to: the one that carries most, or else the longest."""
    carried = _below(skeleton)[children].sum(axis=1)
    lengths = np.sqrt((skeleton.offsets[children] ** 2).sum(axis=1))
    return max(range(len(children)), key=lambda k: (int(carried[k]), float(lengths[k])))


def _weak(offsets: Floats, main: int) -> bool:
    """Whether the bones that leave a joint (C, 3) m tell little of how it is turned about the main one."""
    along = offsets[main] / max(float(np.sqrt(offsets[main] @ offsets[main])), 1e-9)
    beside = offsets - np.outer(offsets @ along, along)
    return float((beside**2).sum()) < WEAK**2


def _swung(carried: Floats, offset: Floats, bones: Floats) -> Floats:
    """(T, 3, 3) turns (T, 3, 3) changed by the least rotation so that the offset (3,) points as the bones (T, 3) do."""
    spread = 1e-3 * np.sqrt((bones**2).sum(axis=1))[:, None, None] * carried * np.sqrt(offset @ offset)
    known = np.isfinite(spread).all(axis=(1, 2)) & (bones != 0.0).any(axis=1)
    found = np.array(carried)
    found[known] = _nearest(spread[known] + np.einsum("td,e->tde", bones[known], offset))
    return found


def _over_time(told: Floats, frames: float) -> Floats:
    """Matrices (T, 3, 3) averaged over so many frames about each; NaN where there is none."""
    known: Bools = np.asarray(np.isfinite(told).all(axis=(1, 2)))
    if not known.any() or not frames > 0.0:
        return told
    reach = np.arange(-int(4.0 * frames), int(4.0 * frames) + 1)
    weights = np.exp(-0.5 * (reach / frames) ** 2)
    sums = correlate1d(np.where(known[:, None, None], told, 0.0), weights, axis=0, mode="constant")
    count = correlate1d(known.astype(np.float64), weights, mode="constant")
    return np.where(known[:, None, None], sums / np.maximum(count, 1e-12)[:, None, None], np.nan)


def _nearest(spread: Floats) -> Floats:
    """(N, 3, 3) the rotations nearest to matrices (N, 3, 3)."""
    left, _, right = np.linalg.svd(spread)
    sign = np.ones((len(spread), 3))
    sign[:, 2] = np.sign(np.linalg.det(left @ right))
    return np.asarray((left * sign[:, None]) @ right)


def _rotation(vectors: Floats) -> Floats:
    """(N, 3, 3) of rotation vectors (N, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())
