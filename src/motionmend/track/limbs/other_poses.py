"""A limb that does not fit is looked for among other poses of its own, while the rest of the body stays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Bools, Floats, Ints, Singles, frozen
from ...bodies.performer import AXES, BONES, FIRST, LANDMARK_BONES, LANDMARKS, Performer, Pose
from ...bodies.surface import intrinsics
from ...kernels import judging, limbs, raycast, rendered
from ..database import PoseDatabase
from ..frame.evidence import Evidence
from .judge import GATE

MOST = 0.15  # m, a difference in depth that is as wrong as nothing at all
COARSE = 2  # every n-th pixel of the raster is looked at
SHAPES = 64  # poses of a limb that are kept of a library
NOTHING, NO_FORM = np.empty(0), np.empty((0, 0))


@final
@dataclass(frozen=True, eq=False)
class Limb:
    """One arm or leg, or the head.

    Attributes
    ----------
    name : l_arm, r_arm, l_leg, r_leg, head.
    bones : that it consists of. shown : the long ones of them.
    columns : (n,) of the 28 joint coordinates.
    begin : of the 16 landmarks that where it hangs. landmarks : (2,) its middle and its end, which it carries.
    mirror : (n,) signs that take its coordinates to those of the other side's limb.
    """

    name: str
    bones: tuple[int, ...]
    shown: tuple[int, ...]
    columns: Ints
    begin: int
    landmarks: Ints
    mirror: Floats


def _limb(side: str, bones: tuple[str, ...], joints: tuple[str, ...], name: str) -> Limb:
    index = tuple(BONES.index(f"{side}{bone}") for bone in bones)
    columns = frozen([c for b in index for c in range(FIRST[b], FIRST[b + 1])], np.int64)
    # What turns about x turns the same way on the other side, about y and z the other way.
    signs = [1.0 if abs(AXES[c, 0]) > 0.5 else -1.0 for c in columns]
    begin, *marks = (LANDMARKS.index(f"{side}{joint}") for joint in joints)
    shown = index[-2:] if name == "arm" else index[:2]
    return Limb(f"{side}{name}", index, shown, columns, begin, frozen(marks, np.int64), frozen(signs))


LIMBS = tuple(
    _limb(side, *parts)
    for parts in (
        (("clavicle", "upperarm", "forearm"), ("shoulder", "elbow", "wrist"), "arm"),
        (("thigh", "shank", "foot"), ("hip", "knee", "ankle"), "leg"),
    )
    for side in ("l_", "r_")
)
HEAD = _limb("", ("head",), ("chest", "neck", "head"), "head")
SEARCHED = (*LIMBS, HEAD)


def opposite(limb: Limb) -> Limb:
    """The limb on the other side; the head is its own."""
    return limb if limb is HEAD else LIMBS[LIMBS.index(limb) ^ 1]


def shapes_of(database: PoseDatabase, performer: Performer) -> tuple[Floats, ...]:
    """For each of `SEARCHED` up to 64 of its poses (C, n) that lie far apart, those of the other side mirrored.

    Without a library: a grid over the joints' ranges.
    """
    shapes = []
    for limb in SEARCHED:
        other = opposite(limb)
        if len(database):
            some = database.joints[:: max(1, len(database) // 4000)]
            poses = np.concatenate((some[:, limb.columns], some[:, other.columns] * other.mirror))
        else:
            low, high = performer.limits[6 + limb.columns].T
            rng = np.random.default_rng(7)
            poses = rng.uniform(0.6 * low, 0.6 * high, (2000, len(low)))
        shapes.append(_far_apart(poses, SHAPES))
    return tuple(shapes)


def _far_apart(poses: Floats, count: int) -> Floats:
    """Some of `poses` (N, n), each the farthest from those before it; the first is the one nearest the mean."""
    chosen = [int(np.argmin(((poses - poses.mean(axis=0)) ** 2).sum(axis=1)))]
    gap = ((poses - poses[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(count, len(poses)) and gap.max() > 1e-4:
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, ((poses - poses[chosen[-1]]) ** 2).sum(axis=1))
    return frozen(poses[chosen])


@final
@dataclass(frozen=True, eq=False)
class Coarse:
    """The evidence in few pixels, for comparing many poses."""

    intrinsics: Floats
    seen: Singles
    free: Bools
    pixels: int


def coarse_of(evidence: Evidence) -> Coarse:
    """Every second pixel of the raster."""
    seen = np.ascontiguousarray(evidence.depth[::COARSE, ::COARSE])
    free = np.ascontiguousarray(evidence.free[::COARSE, ::COARSE])
    return Coarse(intrinsics(evidence.camera.every(COARSE)), seen, free, int(np.isfinite(seen).sum()))


def cast_parts(performer: Performer, pose: Pose, coarse: Coarse) -> tuple[Singles, NDArray[np.int16]]:
    """The performer on the coarse raster.

    Parameters
    ----------
    performer, pose : what is cast.
    coarse : for its intrinsics and its shape (h, w).

    Returns
    -------
    depth : (h, w) float32 m, NaN = nothing there. solid : (h, w) int16, -1 = nothing there.
    """
    solids = performer.solids
    frames, count = np.empty((len(performer.bones), 4, 4)), len(solids)
    placed, parts = np.empty((count, 3, 4)), np.empty((count, raycast.PARTS))
    depth, solid = np.empty(coarse.seen.shape, np.float32), np.empty(coarse.seen.shape, np.int16)
    rendered.picture(
        performer.chain, pose.arrays, solids.arrays, coarse.intrinsics, frames, placed, parts, depth, solid
    )
    return depth, solid


@final
@dataclass(frozen=True, eq=False)
class LeftOver:
    """The person's surface that has nothing of a pose near it.

    Attributes
    ----------
    points : (N, 3) m. rows, columns : (N,) where, on the coarse raster.
    area : m^2, as if facing the camera.
    """

    points: Floats
    rows: Ints
    columns: Ints
    area: float


def left_over(performer: Performer, pose: Pose, coarse: Coarse) -> LeftOver:
    """What of the person a pose does not explain at all.

    Parameters
    ----------
    performer, pose : what is held against the frame.
    coarse : the frame.
    """
    depth, solid = cast_parts(performer, pose, coarse)
    loose, counts = np.empty((depth.size, 2), np.int64), np.empty(5, np.int64)
    visible, denied = np.zeros((2, len(BONES)))
    bones = performer.solids.arrays.carriers
    judging.judged(coarse.seen, coarse.free, depth, solid, bones, GATE, loose, visible, denied, counts)
    rows, columns = loose[: counts[3]].T
    z = coarse.seen[rows, columns].astype(np.float64)
    fx, fy, cx, cy = coarse.intrinsics
    points = np.stack(((columns - cx) * z / fx, (rows - cy) * z / fy, z), axis=1)
    return LeftOver(points, rows, columns, float(z @ z / (fx * fy)))


def disagreement(performer: Performer, pose: Pose, coarse: Coarse) -> float:
    """Share of the person's pixels that a pose explains wrongly, 0 (none) to 1 and, with too much body, beyond."""
    return float(disagreements(performer, [pose], coarse)[0])


def disagreements(performer: Performer, poses: Sequence[Pose], coarse: Coarse) -> Floats:
    """(C,) the same of each of C poses."""
    costs = np.empty(len(poses))
    limbs.disagreements(
        performer.chain,
        np.array([pose.translation for pose in poses]),
        np.array([pose.root for pose in poses]),
        np.array([pose.joints for pose in poses]),
        performer.solids.arrays,
        coarse.intrinsics,
        coarse.seen,
        coarse.free,
        MOST,
        costs,
    )
    return np.asarray(costs / max(coarse.pixels, 1))


@final
@dataclass(frozen=True, eq=False)
class Draws:
    """What is drawn about the best of many poses of a limb, to look closer and closer: the cross-entropy method
    (Rubinstein 1999).

    Attributes
    ----------
    picks : (R, K) in each of R rounds, about which of the best each of K poses is drawn.
    noise : (R, K, n) rad, and how far from it.
    kept : how many best stay.
    """

    picks: Ints
    noise: Floats
    kept: int


NO_DRAWS = Draws(np.empty((0, 0), np.int64), np.empty((0, 0, 0)), 1)


@final
@dataclass(frozen=True, eq=False)
class Searched:
    """What C poses of a limb cost, and the best of them and of what was drawn about these.

    Attributes
    ----------
    costs : (C,) what `disagreement` says of the pose with each. prices : (C,) the same with what is said against it.
    best : (n,) rad, the cheapest of all. price : of the best.
    """

    costs: Floats
    prices: Floats
    best: Floats
    price: float


def draws(rng: np.random.Generator, limb: Limb, spreads: Sequence[float], kept: int, count: int) -> Draws:
    """`count` poses of a limb for each of the rounds, whose standard deviations are `spreads`, rad."""
    picks = np.empty((len(spreads), count), np.int64)
    noise = np.empty((len(spreads), count, len(limb.columns)))
    for r, spread in enumerate(spreads):
        picks[r] = rng.integers(kept, size=count)
        noise[r] = spread * rng.normal(size=noise[r].shape)
    return Draws(picks, noise, kept)


def limb_costs(performer: Performer, pose: Pose, limb: Limb, candidates: Floats, coarse: Coarse) -> Floats:
    """(C,) what `disagreement` says of the pose with each of `candidates` (C, n), rad, for the limb's n coordinates."""
    return limb_search(performer, pose, limb, candidates, coarse).costs


def limb_search(
    performer: Performer,
    pose: Pose,
    limb: Limb,
    candidates: Floats,
    coarse: Coarse,
    drawn: Draws = NO_DRAWS,
    mean: Floats = NOTHING,
    form: Floats = NO_FORM,
) -> Searched:
    """The same of each candidate, and the best values for the limb among them and what is drawn about the best.

    A library's poses are too far apart to fit: the best of them may be no nearer to the truth than the worst, which
    only what is drawn about them tells.

    Parameters
    ----------
    performer, pose, limb, candidates, coarse : as above.
    drawn : about the best.
    mean, form : (28,), (28, 28) of a quadratic form that is against joint coordinates, as a share of the pixels;
        prices have by how much more it is against the candidates than against the pose as it is.
    """
    costs, best = np.empty((2, len(candidates))), np.empty(len(limb.columns))
    pixels = max(coarse.pixels, 1)
    # Copies, for what is kept is read-only or not by where it comes from: kernels are compiled for one kind of arrays.
    price = limbs.limb_search(
        performer.chain,
        pose.arrays,
        limb.columns,
        np.ascontiguousarray(candidates),
        np.array(limb.bones),
        performer.solids.arrays,
        coarse.intrinsics,
        coarse.seen,
        coarse.free,
        MOST,
        costs,
        performer.limits.copy(),
        mean.copy(),
        form * pixels,
        drawn.picks,
        drawn.noise,
        drawn.kept,
        best,
    )
    return Searched(costs[0] / pixels, costs[1] / pixels, best, price / pixels)


def limb_places(performer: Performer, pose: Pose, limb: Limb, candidates: Floats) -> Floats:
    """(C, K, 3) m, where the limb's K landmarks are with each of `candidates` (C, n), rad, for its coordinates."""
    marks = limb.landmarks
    places = np.empty((len(candidates), len(marks), 3))
    limbs.limb_places(
        performer.chain,
        pose.arrays,
        limb.columns,
        np.ascontiguousarray(candidates),
        np.array(limb.bones),
        LANDMARK_BONES[marks],
        performer.landmark_place[marks],
        places,
    )
    return places


def with_limb(pose: Pose, limb: Limb, values: Floats) -> Pose:
    """The pose with other joint coordinates (n,) of one limb."""
    joints = pose.joints.copy()
    joints[limb.columns] = values
    return Pose(pose.translation, pose.root, joints)
