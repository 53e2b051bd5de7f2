"""How deep limbs are inside the trunk, and which way is out: penetration depths to first order (Taubin 1991)."""

from math import sqrt

import numpy as np

from ..arrays import Floats, Ints
from .body import Shell
from .compile import compiled

CONE = 1
ALONG = (-1.5, -1.0, -0.4, 0.3, 1.0)  # of a limb's half length from its middle: points that are looked at, hand first
FADES = 0.04  # m from a cone's flat ends, over which it ceases to be in the way: others go on there
LEAST = 1e-6  # of the way from a solid's axis to its surface: nearer, no way out can be told


@compiled
def kept_out(
    placed: Floats,
    twists: Floats,
    first: Ints,
    order: Ints,
    shell: Shell,
    trunk: Ints,
    limbs: Ints,
    clear: Floats,
    squared_scale: float,
    weight: float,
    normal: Floats,
    right: Floats,
) -> float:
    """Add a robust square of how deep points of limbs are inside solids to the system of all degrees of freedom.

    A point's distance from a surface is that of its implicit function from 1, over the function's slope there.

    Parameters
    ----------
    placed : (P, 3, 4) world from solid.
    twists, first, order : (D, 6) of each degree of freedom, and which move which bone, as for `bone_systems.assemble`.
    trunk : (S,) the solids that are in the way: on bones that carry the limbs'.
    limbs : (L,) the cones that are kept out of them. clear : (L,) m, so far before the surface is inside.
    squared_scale : m², of Geman and McClure's estimator. weight : per m².
    normal, right : (D, D) and (D,), added to.

    Returns
    -------
    The cost.
    """
    carriers, kinds, _, _, sizes, tapers = shell
    cost, slope = 0.0, np.empty(right.shape[0])
    for i in range(limbs.shape[0]):
        limb = limbs[i]
        bone, p = carriers[limb], placed[limb]
        for s in trunk:
            bound = bounding_radius(kinds[s], sizes[s], tapers[s]) + clear[i]
            for along in ALONG:
                far = along * sizes[limb, 1]
                x, y, z = p[0, 3] + far * p[0, 1], p[1, 3] + far * p[1, 1], p[2, 3] + far * p[2, 1]
                if (x - placed[s, 0, 3]) ** 2 + (y - placed[s, 1, 3]) ** 2 + (z - placed[s, 2, 3]) ** 2 > bound * bound:
                    continue
                deep, share, nx, ny, nz = inside(placed[s], kinds[s], sizes[s], tapers[s], x, y, z)
                deep += clear[i]
                if deep <= 0.0 or share <= 0.0:
                    continue
                shrink = squared_scale / (squared_scale + deep * deep)
                cost += weight * share * shrink * deep * deep
                w = weight * share * shrink * shrink
                begin = first[bone] + first[carriers[s] + 1] - first[carriers[s]]  # what moves both alike comes first
                for n in range(begin, first[bone + 1]):
                    t = twists[order[n]]
                    slope[n - begin] = nx * (t[1] * z - t[2] * y + t[3])
                    slope[n - begin] += ny * (t[2] * x - t[0] * z + t[4]) + nz * (t[0] * y - t[1] * x + t[5])
                for n in range(begin, first[bone + 1]):
                    right[order[n]] += w * deep * slope[n - begin]
                    for m in range(begin, first[bone + 1]):
                        normal[order[n], order[m]] += w * slope[n - begin] * slope[m - begin]
    return cost


@compiled
def bounding_radius(kind: int, size: Floats, taper: float) -> float:
    """The radius, m, of a ball about a solid's middle that holds all of it; `size` (3,) m, `taper` as in `Solids`."""
    if kind == CONE:
        wide = max(size[0], size[2]) * (1.0 + abs(taper))
        return sqrt(wide * wide + size[1] * size[1])
    return float(max(size[0], size[1], size[2]))


@compiled
def inside(
    placed: Floats, kind: int, size: Floats, taper: float, x: float, y: float, z: float
) -> tuple[float, float, float, float, float]:
    """How deep a point of the world is inside a solid, m, below 0 outside; how much that counts, 0 to 1; the way out.

    `placed` (3, 4) is world from solid; `size` (3,) m and `taper` are as in `Solids`; x, y, z, m, are the point. The
    way out is a unit vector in the world. On a cone's axis, or beyond its ends, nothing is inside.
    """
    p, sx, sy, sz = placed, size[0], size[1], size[2]
    x, y, z = x - p[0, 3], y - p[1, 3], z - p[2, 3]
    a = p[0, 0] * x + p[1, 0] * y + p[2, 0] * z
    b = p[0, 1] * x + p[1, 1] * y + p[2, 1] * z
    c = p[0, 2] * x + p[1, 2] * y + p[2, 2] * z
    share = 1.0
    if kind == CONE:
        share = min(1.0, (sy - abs(b)) / FADES)
        if share <= 0.0:
            return -1.0, 0.0, 0.0, 0.0, 0.0
        wide = 1.0 + taper * b / sy
        sx, sz, b = sx * wide, sz * wide, 0.0
    far = sqrt((a / sx) ** 2 + (b / sy) ** 2 + (c / sz) ** 2)  # 1 at the surface
    if far < LEAST:
        return -1.0, 0.0, 0.0, 0.0, 0.0
    a, b, c = a / (sx * sx), b / (sy * sy), c / (sz * sz)
    steep = sqrt(a * a + b * b + c * c)
    a, b, c = a / steep, b / steep, c / steep
    return (
        (1.0 - far) * far / steep,
        share,
        p[0, 0] * a + p[0, 1] * b + p[0, 2] * c,
        p[1, 0] * a + p[1, 1] * b + p[1, 2] * c,
        p[2, 0] * a + p[2, 1] * b + p[2, 2] * c,
    )
