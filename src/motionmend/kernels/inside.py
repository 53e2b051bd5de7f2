"""How deep limbs are inside the trunk, and which way is out."""

from math import sqrt

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints
from .compile import compiled

CONE = 1
ALONG = (-1.5, -1.0, -0.4, 0.3, 1.0)  # of a limb's half length from its middle: points that are looked at, hand first
FADES = 0.04  # m from a cone's flat ends, over which it ceases to be in the way: others go on there
LEAST = 1e-6  # of the way from a solid's axis to its surface: nearer, no way out can be told


@compiled
def kept_out(
    frames: Floats,
    twists: Floats,
    moves: Bools,
    carriers: Ints,
    kinds: Bytes,
    centers: Floats,
    turns: Floats,
    sizes: Floats,
    tapers: Floats,
    trunk: Ints,
    limbs: Ints,
    clear: Floats,
    squared_scale: float,
    weight: float,
    normal: Floats,
    right: Floats,
) -> float:
    """Add a robust square of how deep points of limbs are inside solids to the system of all degrees of freedom.

    How far a point is from a solid's surface is told to first order: by what it fails by, over the slope of that.

    Parameters
    ----------
    frames, twists, moves : (B, 4, 4) world from bone, (D, 6) of each degree of freedom, (B, D) which moves which bone.
    carriers .. tapers : the body's solids, as in `rendered.picture`.
    trunk : (S,) the solids that are in the way.
    limbs : (L,) the cones that are kept out of them. clear : (L,) m, so far before the surface is inside.
    squared_scale : m², of Geman and McClure's estimator. weight : per m².
    normal, right : (D, D) and (D,), added to.

    Returns
    -------
    The cost.
    """
    cost = 0.0
    place, out, slope = np.empty(3), np.empty(3), np.empty(right.shape[0])
    for i in range(limbs.shape[0]):
        limb = limbs[i]
        bone = carriers[limb]
        for along in ALONG:
            for k in range(3):
                place[k] = centers[limb, k] + along * sizes[limb, 1] * turns[limb, k, 1]
            placed(frames[bone], place)
            for s in trunk:
                carrier = carriers[s]
                deep, share = inside(frames[carrier], kinds[s], centers[s], turns[s], sizes[s], tapers[s], place, out)
                deep += clear[i]
                if deep <= 0.0 or share <= 0.0:
                    continue
                shrink = squared_scale / (squared_scale + deep * deep)
                cost += weight * share * shrink * deep * deep
                w = weight * share * shrink * shrink
                for d in range(right.shape[0]):
                    slope[d] = 0.0
                    if moves[bone, d] != moves[carrier, d]:  # the others move both alike
                        sign = 1.0 if moves[bone, d] else -1.0
                        slope[d] = sign * speed(twists[d], place, out)
                for d in range(right.shape[0]):
                    if slope[d] != 0.0:
                        right[d] += w * deep * slope[d]
                        for e in range(right.shape[0]):
                            normal[d, e] += w * slope[d] * slope[e]
    return cost


@compiled
def placed(frame: Floats, point: Floats) -> None:
    """A point (3,) of a bone whose frame is (4, 4) becomes one of the world."""
    x, y, z = point
    for k in range(3):
        point[k] = frame[k, 0] * x + frame[k, 1] * y + frame[k, 2] * z + frame[k, 3]


@compiled
def speed(twist: Floats, point: Floats, direction: Floats) -> float:
    """How fast a point (3,) goes in a direction (3,) with a twist (6,)."""
    x, y, z = point
    return float(
        direction[0] * (twist[1] * z - twist[2] * y + twist[3])
        + direction[1] * (twist[2] * x - twist[0] * z + twist[4])
        + direction[2] * (twist[0] * y - twist[1] * x + twist[5])
    )


@compiled
def inside(
    frame: Floats, kind: int, center: Floats, turn: Floats, size: Floats, taper: float, point: Floats, out: Floats
) -> tuple[float, float]:
    """How deep a point (3,) of the world is inside a solid, m, below 0 outside; and how much that counts, 0 to 1.

    `frame` (4, 4) is that of the bone that carries it, `center` .. `taper` are as in `Solids`; `out` (3,) is written:
    the unit vector, in the world, that leads out of it.
    """
    own, away = np.empty(3), np.empty(3)
    for k in range(3):
        own[k] = -center[k]
        for m in range(3):
            own[k] += frame[m, k] * (point[m] - frame[m, 3])
    for k in range(3):
        away[k] = turn[0, k] * own[0] + turn[1, k] * own[1] + turn[2, k] * own[2]
    share, wide = 1.0, 1.0
    if kind == CONE:
        share = min(1.0, (size[1] - abs(away[1])) / FADES)
        wide = 1.0 + taper * away[1] / size[1]
    if share <= 0.0:
        return -1.0, 0.0
    far, steep = 0.0, 0.0  # from the axis, 1 at the surface; and the slope of its square, halved, 1/m
    for k in range(3):
        radius = size[k] if k == 1 else size[k] * wide
        if k == 1 and kind == CONE:
            away[k] = 0.0
        far += (away[k] / radius) ** 2
        away[k] /= radius * radius
        steep += away[k] * away[k]
    far, steep = sqrt(far), sqrt(steep)
    if far < LEAST:
        return -1.0, 0.0
    for k in range(3):
        own[k] = (turn[k, 0] * away[0] + turn[k, 1] * away[1] + turn[k, 2] * away[2]) / steep
    for k in range(3):
        out[k] = frame[k, 0] * own[0] + frame[k, 1] * own[1] + frame[k, 2] * own[2]
    return (1.0 - far) * far / steep, share
