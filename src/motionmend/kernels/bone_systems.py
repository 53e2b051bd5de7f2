"""What matches ask of the bones, and the bones of the degrees of freedom: one 6 x 6 system per bone, no Jacobian.

A bone's small motion is a twist [omega, v]: a point x of it moves by omega x x + v (section 3.6; the per-bone sums are
those of equation 3.7, left of the chain rule). B bones, D degrees of freedom.
"""

from math import sqrt

import numpy as np

from ..arrays import Floats, Ints
from .body import Posed
from .compile import compiled
from .dense import turn_between


@compiled
def pull(
    bone: int,
    x: float,
    y: float,
    z: float,
    rx: float,
    ry: float,
    rz: float,
    nx: float,
    ny: float,
    nz: float,
    along: float,
    squared_scale: float,
    weight: float,
    hessian: Floats,
    gradient: Floats,
) -> tuple[float, float]:
    """Add to a bone's 6 x 6 system that its point (x, y, z) should move by (rx, ry, rz), all in m.

    `along` of the residual counts along the normal (nx, ny, nz), the rest in all directions. Returns the robust cost,
    s² r² / (s² + r²) times `weight` (Geman and McClure 1987), with an infinite squared scale plain r²; and r², m².
    """
    into = rx * nx + ry * ny + rz * nz
    free = 1.0 - along
    squared = along * into * into + free * (rx * rx + ry * ry + rz * rz)
    w, cost = weight, weight * squared
    if squared_scale < 1e12:
        shrink = squared_scale / (squared_scale + squared)
        w = weight * shrink * shrink
        cost = weight * squared * shrink
    # Each sum is read and written once: that, more than the arithmetic, is what this costs.
    h, g = hessian[bone], gradient[bone]
    a, b, c = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
    k, f = w * along, w * free
    e = k * into
    ka, kb, kc, kx, ky = k * a, k * b, k * c, k * nx, k * ny
    g[0] = g[0] + e * a + f * (y * rz - z * ry)
    g[1] = g[1] + e * b + f * (z * rx - x * rz)
    g[2] = g[2] + e * c + f * (x * ry - y * rx)
    g[3] = g[3] + e * nx + f * rx
    g[4] = g[4] + e * ny + f * ry
    g[5] = g[5] + e * nz + f * rz
    h[0, 0] = h[0, 0] + ka * a + f * (y * y + z * z)
    h[0, 1] = h[0, 1] + ka * b - f * x * y
    h[0, 2] = h[0, 2] + ka * c - f * x * z
    h[0, 3] += ka * nx
    h[0, 4] = h[0, 4] + ka * ny - f * z  # the cross product's matrix: (omega x p) . e_y has -z of omega_x
    h[0, 5] = h[0, 5] + ka * nz + f * y
    h[1, 1] = h[1, 1] + kb * b + f * (x * x + z * z)
    h[1, 2] = h[1, 2] + kb * c - f * y * z
    h[1, 3] = h[1, 3] + kb * nx + f * z
    h[1, 4] += kb * ny
    h[1, 5] = h[1, 5] + kb * nz - f * x
    h[2, 2] = h[2, 2] + kc * c + f * (x * x + y * y)
    h[2, 3] = h[2, 3] + kc * nx - f * y
    h[2, 4] = h[2, 4] + kc * ny + f * x
    h[2, 5] += kc * nz
    h[3, 3] = h[3, 3] + kx * nx + f
    h[3, 4] += kx * ny
    h[3, 5] += kx * nz
    h[4, 4] = h[4, 4] + ky * ny + f
    h[4, 5] += ky * nz
    h[5, 5] = h[5, 5] + k * nz * nz + f
    return cost, squared


@compiled
def assemble(
    hessian: Floats, gradient: Floats, twists: Floats, first: Ints, order: Ints, normal: Floats, right: Floats
) -> None:
    """Chain rule: per-bone systems to the one of all D degrees of freedom (the sums of equation 3.15).

    Parameters
    ----------
    hessian, gradient : (B, 6, 6) upper triangles and (B, 6).
    twists : (D, 6) of each degree of freedom.
    first, order : (B + 1,) and (M,): bone b is moved by order[first[b] : first[b + 1]].
    normal, right : (D, D) and (D,), added to; both triangles are filled.
    """
    moved = np.empty(6)
    for b in range(hessian.shape[0]):
        h = hessian[b]
        if h[3, 3] + h[4, 4] + h[5, 5] == 0.0:
            continue
        for i in range(6):
            for j in range(i):
                h[i, j] = h[j, i]
        for p in range(first[b], first[b + 1]):
            d = order[p]
            for i in range(6):
                moved[i] = 0.0
                for j in range(6):
                    moved[i] += h[i, j] * twists[d, j]
            for i in range(6):
                right[d] += gradient[b, i] * twists[d, i]
            for q in range(first[b], p + 1):
                e = order[q]
                value = 0.0
                for i in range(6):
                    value += moved[i] * twists[e, i]
                normal[d, e] += value
                if e != d:
                    normal[e, d] += value


@compiled
def spreads(
    covariance: Floats, twists: Floats, first: Ints, order: Ints, bones: Ints, points: Floats, std: Floats
) -> None:
    """Standard deviations of points on bones, m: the root of a third of the trace of their covariance.

    Parameters
    ----------
    covariance, twists, first, order : (D, D), (D, 6) and which degrees of freedom move which bone, as for `assemble`.
    bones, points : (N,), (N, 3) m. std : (N,) is written.
    """
    slope = np.empty((twists.shape[0], 3))
    for n in range(bones.shape[0]):
        b = bones[n]
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        variance = 0.0
        for p in range(first[b], first[b + 1]):
            d = order[p]
            w = twists[d]
            slope[d, 0] = w[1] * z - w[2] * y + w[3]
            slope[d, 1] = w[2] * x - w[0] * z + w[4]
            slope[d, 2] = w[0] * y - w[1] * x + w[5]
            for q in range(first[b], p + 1):
                e = order[q]
                product = slope[d, 0] * slope[e, 0] + slope[d, 1] * slope[e, 1] + slope[d, 2] * slope[e, 2]
                variance += (1.0 if e == d else 2.0) * covariance[d, e] * product
        std[n] = sqrt(max(variance, 0.0) / 3.0)


@compiled
def drawn_to(pose: Posed, to: Posed, weights: Floats, away: Floats, normal: Floats, right: Floats) -> float:
    """A weighted square of what separates a pose from another one: into the system of all degrees of freedom.

    Parameters
    ----------
    pose, to : it, and the one it is drawn to.
    weights : (D,). away : (D,) is written: the increment from the other pose to this one.
    normal, right : (D, D) and (D,), added to.

    Returns
    -------
    The cost.
    """
    turn_between(pose.root, to.root, away[3:6])
    cost = 0.0
    for d in range(weights.shape[0]):
        if d < 3:
            away[d] = pose.translation[d] - to.translation[d]
        elif d >= 6:
            away[d] = pose.joints[d - 6] - to.joints[d - 6]
        pull_back = weights[d] * away[d]
        normal[d, d] += weights[d]
        right[d] -= pull_back
        cost += pull_back * away[d]
    return cost


@compiled
def within(joints: Floats, limits: Floats, weight: float, normal: Floats, right: Floats) -> float:
    """A square beyond each limit, nothing within: joints (J,) rad, limits (D, 2), weight per rad². Returns the cost."""
    cost = 0.0
    for j in range(joints.shape[0]):
        d = 6 + j
        beyond = joints[j] - min(max(joints[j], limits[d, 0]), limits[d, 1])
        if beyond != 0.0:
            normal[d, d] += weight
            right[d] -= weight * beyond
            cost += weight * beyond * beyond
    return cost


@compiled
def about_mean(joints: Floats, mean: Floats, form: Floats, normal: Floats, right: Floats) -> float:
    """A quadratic form (J, J) of what separates joints from a mean (J,): into the system. Returns the cost."""
    cost = 0.0
    for j in range(joints.shape[0]):
        drawn = 0.0
        for k in range(joints.shape[0]):
            drawn += form[j, k] * (joints[k] - mean[k])
            normal[6 + j, 6 + k] += form[j, k]
        right[6 + j] -= drawn
        cost += drawn * (joints[j] - mean[j])
    return cost
