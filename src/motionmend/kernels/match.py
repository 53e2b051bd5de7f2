"""Nearest points in a pixel window, and what they ask of the bones: one 6 x 6 system per bone, never a Jacobian.

Throughout: images of H x W pixels as float32 points (H, W, 3) in camera axes, m, NaN = none; N samples; B bones.
A bone's small motion is a twist [omega, v]: a point x of it moves by omega x x + v (section 3.6; the per-bone sums are
those of equation 3.7, left of the chain rule).
"""

from math import sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from .compile import compiled


@compiled
def unproject(depth: Singles, fx: float, fy: float, cx: float, cy: float, points: Singles) -> None:
    """Depth (H, W) to `points` (H, W, 3): pixel (column u, row v) at depth z lies at ((u - cx) z / fx, ..., z)."""
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            z = depth[row, column]
            points[row, column, 0] = (column - cx) * z / fx
            points[row, column, 1] = (row - cy) * z / fy
            points[row, column, 2] = z


@compiled
def nearest_in_window(
    pixels: Ints,
    points: Singles,
    target: Singles,
    half: int,
    gate: float,
    apart: float,
    tones: Singles,
    target_tones: Singles,
    tone_weight: float,
    found: Ints,
) -> int:
    """For each point the nearest one of an image within a window about its pixel (section 3.4.1).

    The window is searched ring by ring and left when no farther ring can hold anything nearer.

    Parameters
    ----------
    pixels : (N, 2) row and column at which the points are seen, to half a pixel.
    points : (N, 3) m.
    target : (H, W, 3) where to look, NaN = no point; each lies on its pixel's ray.
    half : the window is 2 half + 1 pixels wide and high; 0 matches along the ray (projective).
    gate : m; points farther than this are not found.
    apart : a point at depth 1 that is seen one pixel from a ray is at least so far from it, m.
    tones, target_tones : (N,) and (H, W) intensities, read when `tone_weight` > 0.
    tone_weight : m per unit of intensity, added to the distance. An unknown (NaN) intensity adds nothing.
    found : (N,) gets row * W + column, or -1.

    Returns
    -------
    How many were found.
    """
    height, width = target.shape[0], target.shape[1]
    count = 0
    for i in range(pixels.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        best, at = np.float32(gate * gate), -1
        toned = tone_weight > 0.0 and not np.isnan(tones[i])
        middle, centre = pixels[i, 0], pixels[i, 1]
        for ring in range(half + 1):
            if ring > 0 and ((ring - 0.5) * apart * z) ** 2 > best:
                break
            for row in range(max(0, middle - ring), min(height, middle + ring + 1)):
                ends = ring > 0 and row != middle - ring and row != middle + ring
                stride = 2 * ring if ends else 1
                for column in range(centre - ring, centre + ring + 1, stride):
                    if column < 0 or column >= width:
                        continue
                    dz = target[row, column, 2] - z
                    squared = dz * dz
                    if not squared < best:  # also where there is none
                        continue
                    dx = target[row, column, 0] - x
                    dy = target[row, column, 1] - y
                    squared += dx * dx + dy * dy
                    if toned and squared < best:
                        difference = abs(target_tones[row, column] - tones[i])
                        if not np.isnan(difference):
                            distance = sqrt(squared) + tone_weight * difference
                            squared = np.float32(distance * distance)
                    if squared < best:
                        best = squared
                        at = row * width + column
        found[i] = at
        count += at >= 0
    return count


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
    Geman and McClure's s² r² / (s² + r²) times `weight`, with an infinite squared scale plain r²; and r², m².
    """
    into = rx * nx + ry * ny + rz * nz
    free = 1.0 - along
    squared = along * into * into + free * (rx * rx + ry * ry + rz * rz)
    w, cost = weight, weight * squared
    if squared_scale < 1e12:
        shrink = squared_scale / (squared_scale + squared)
        w = weight * shrink * shrink
        cost = weight * squared * shrink
    h, g = hessian[bone], gradient[bone]
    if along > 0.0:
        a = y * nz - z * ny
        b = z * nx - x * nz
        c = x * ny - y * nx
        k = w * along
        e = k * into
        g[0] += e * a
        g[1] += e * b
        g[2] += e * c
        g[3] += e * nx
        g[4] += e * ny
        g[5] += e * nz
        ka, kb, kc, kx, ky = k * a, k * b, k * c, k * nx, k * ny
        h[0, 0] += ka * a
        h[0, 1] += ka * b
        h[0, 2] += ka * c
        h[0, 3] += ka * nx
        h[0, 4] += ka * ny
        h[0, 5] += ka * nz
        h[1, 1] += kb * b
        h[1, 2] += kb * c
        h[1, 3] += kb * nx
        h[1, 4] += kb * ny
        h[1, 5] += kb * nz
        h[2, 2] += kc * c
        h[2, 3] += kc * nx
        h[2, 4] += kc * ny
        h[2, 5] += kc * nz
        h[3, 3] += kx * nx
        h[3, 4] += kx * ny
        h[3, 5] += kx * nz
        h[4, 4] += ky * ny
        h[4, 5] += ky * nz
        h[5, 5] += k * nz * nz
    if free > 0.0:
        k = w * free
        g[0] += k * (y * rz - z * ry)
        g[1] += k * (z * rx - x * rz)
        g[2] += k * (x * ry - y * rx)
        g[3] += k * rx
        g[4] += k * ry
        g[5] += k * rz
        h[0, 0] += k * (y * y + z * z)
        h[1, 1] += k * (x * x + z * z)
        h[2, 2] += k * (x * x + y * y)
        h[0, 1] -= k * x * y
        h[0, 2] -= k * x * z
        h[1, 2] -= k * y * z
        h[0, 4] -= k * z  # the cross product's matrix: (omega x p) . e_y has -z of omega_x
        h[0, 5] += k * y
        h[1, 3] += k * z
        h[1, 5] -= k * x
        h[2, 3] -= k * y
        h[2, 4] += k * x
        h[3, 3] += k
        h[4, 4] += k
        h[5, 5] += k
    return cost, squared


@compiled
def gather(
    found: Ints,
    bones: Ints,
    points: Singles,
    normals: Singles,
    wanted: Singles,
    looked_up: bool,
    along: float,
    scale: float,
    weight: float,
    hessian: Floats,
    gradient: Floats,
) -> tuple[float, int]:
    """All matches into the bones' systems.

    Parameters
    ----------
    found : (N,) index into the image searched, -1 = none.
    bones, points, normals : (N,), (N, 3), (N, 3) of the model.
    wanted : where the points should be: (N, 3), or with `looked_up` the image searched, flat (H W, 3).
    along, scale, weight : see `pull`; scale in m.
    hessian, gradient : (B, 6, 6), of which the upper triangle, and (B, 6), are added to.

    Returns
    -------
    cost and how many matches count for at least half.
    """
    cost, inliers = 0.0, 0
    squared_scale = scale * scale
    for i in range(found.shape[0]):
        if found[i] < 0:
            continue
        o = found[i] if looked_up else i
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        rx, ry, rz = wanted[o, 0] - x, wanted[o, 1] - y, wanted[o, 2] - z
        one, squared = pull(bones[i], x, y, z, rx, ry, rz, nx, ny, nz, along, squared_scale, weight, hessian, gradient)
        cost += one
        inliers += squared < 0.41 * squared_scale  # (1 + 0.41)^-2 = one half
    return cost, inliers


@compiled
def push_out(
    pixels: Ints,
    bones: Ints,
    points: Singles,
    free: Bools,
    reach: int,
    fx: float,
    fy: float,
    scale: float,
    weight: float,
    hessian: Floats,
    gradient: Floats,
) -> tuple[float, int]:
    """Model points seen where nobody is are drawn sideways to the nearest pixel that may hold them.

    Parameters
    ----------
    pixels, bones, points : (N, 2), (N,), (N, 3) of the model.
    free : (H, W) True where nobody is.
    reach : px, farther is not looked.
    fx, fy : px.
    scale, weight : see `pull`; scale in m.

    Returns
    -------
    cost and how many were outside.
    """
    height, width = free.shape
    cost, outside = 0.0, 0
    for i in range(pixels.shape[0]):
        row, column = pixels[i, 0], pixels[i, 1]
        if not free[row, column]:
            continue
        best, down, across = (reach + 1) * (reach + 1), 0, 0
        for ring in range(1, reach + 1):
            if ring * ring > best:
                break
            for r in range(max(0, row - ring), min(height, row + ring + 1)):
                ends = r != row - ring and r != row + ring
                for c in range(column - ring, column + ring + 1, 2 * ring if ends else 1):
                    if c < 0 or c >= width or free[r, c]:
                        continue
                    squared = (r - row) * (r - row) + (c - column) * (c - column)
                    if squared < best:
                        best, down, across = squared, r - row, c - column
        outside += 1
        if down == 0 and across == 0:
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        rx, ry = across * z / fx, down * z / fy
        size = sqrt(rx * rx + ry * ry)
        one, _ = pull(
            bones[i], x, y, z, rx, ry, 0.0, rx / size, ry / size, 0.0,
            1.0, scale * scale, weight, hessian, gradient,
        )  # fmt: skip
        cost += one
    return cost, outside


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
def steps(depth: Singles, unknown: Bools, jump: float, points: Singles, edge: Singles) -> None:
    """Near sides of steps in depth: pixels beside one that is empty, or farther by more than `jump` m.

    Parameters
    ----------
    depth : (H, W) m, NaN = empty.
    unknown : (H, W) True where an empty pixel proves nothing. The image's border proves nothing either.
    points : (H, W, 3) m.
    edge : (H, W, 3) gets the points on edges, NaN elsewhere.
    """
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            z = depth[row, column]
            edge[row, column, 2] = np.nan
            if np.isnan(z):
                continue
            for k in range(4):
                r = row + (k == 0) - (k == 1)
                c = column + (k == 2) - (k == 3)
                if r < 0 or c < 0 or r >= height or c >= width or unknown[r, c]:
                    continue
                if np.isnan(depth[r, c]) or depth[r, c] > z + jump:
                    edge[row, column, 0] = points[row, column, 0]
                    edge[row, column, 1] = points[row, column, 1]
                    edge[row, column, 2] = z
                    break
