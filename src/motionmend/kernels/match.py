"""Nearest points in a pixel window, and what they ask of the bones: one 6 x 6 system per bone, never a Jacobian.

Throughout: depth images of H x W pixels, m along z, NaN = none, and their camera (fx, fy, cx, cy) in px; N samples in
camera axes; B bones.
"""

from math import sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from .body import Shell
from .bone_systems import pull
from .compile import compiled
from .raycast import outward

HALF = 0.41  # of the squared scale: at such a squared residual a match counts half, for (1 + 0.41)^-2 = 0.5


@compiled
def nearest(
    row: int,
    column: int,
    x: float,
    y: float,
    z: float,
    target: Singles,
    over_x: float,
    over_y: float,
    cx: float,
    cy: float,
    half: int,
    gate: float,
    apart: float,
    tone: float,
    target_tones: Singles,
    tone_weight: float,
) -> tuple[int, int]:
    """The pixel of a depth image whose point is nearest to one, within a window about its pixel (section 3.4.1).

    The window is searched ring by ring and left when no farther ring can hold anything nearer. The first ring is looked
    at whole, without a branch that the processor would have to guess: mostly the nearest point is there.

    Parameters
    ----------
    row, column : px, where the point is seen, to half a pixel.
    x, y, z : m, the point.
    target : (H, W) m, depths where to look, NaN = no point.
    over_x, over_y, cx, cy : of that image's camera: 1 / fx, 1 / fy, per px; px.
    half : the window is 2 half + 1 pixels wide and high; 0 matches along the ray (projective).
    gate : m; points farther than this are not found.
    apart : a point at depth 1 that is seen one pixel from a ray is at least so far from it, m.
    tone, target_tones : intensity of the point, NaN = not known, and (H, W); read when `tone_weight` > 0.
    tone_weight : m² per squared unit of intensity, added to the squared distance. An unknown (NaN) intensity adds
        nothing.

    Returns
    -------
    Its row and column; -1, -1 where there is none.
    """
    height, width = target.shape
    best, at_row, at_column = gate * gate, -1, -1
    toned = tone_weight > 0.0 and not np.isnan(tone)
    begin = 0
    if half > 0 and 0 < row < height - 1 and 0 < column < width - 1 and not toned:
        begin = 2
        best, at_row, at_column = _nearer(
            row, column, x, y, z, target, over_x, over_y, cx, cy, best, at_row, at_column
        )  # of equal ones the first, as ring by ring
        for r in range(row - 1, row + 2):
            for c in range(column - 1, column + 2):
                best, at_row, at_column = _nearer(
                    r, c, x, y, z, target, over_x, over_y, cx, cy, best, at_row, at_column
                )
    for ring in range(begin, half + 1):
        if ring > 0 and ((ring - 0.5) * apart * z) ** 2 > best:
            break
        first, last = max(0, column - ring), min(width - 1, column + ring)
        for r in range(max(0, row - ring), min(height, row + ring + 1)):
            step = 1 if r == row - ring or r == row + ring else 2 * ring
            c = first if step == 1 or column - ring >= 0 else max(0, column + ring)
            while c <= last:
                here = c
                c += step
                far = np.float64(target[r, here])
                squared = (far - z) * (far - z)
                if not squared < best:  # also where there is none
                    continue
                dx, dy = (here - cx) * far * over_x - x, (r - cy) * far * over_y - y
                squared += dx * dx + dy * dy
                if toned and squared < best:
                    difference = target_tones[r, here] - tone
                    if not np.isnan(difference):
                        squared += tone_weight * difference * difference
                if squared < best:
                    best, at_row, at_column = squared, r, here
    return at_row, at_column


@compiled
def _nearer(
    row: int,
    column: int,
    x: float,
    y: float,
    z: float,
    target: Singles,
    over_x: float,
    over_y: float,
    cx: float,
    cy: float,
    best: float,
    at_row: int,
    at_column: int,
) -> tuple[float, int, int]:
    """The squared distance, row and column of a pixel's point if it is nearer than the best so far, else of that."""
    far = np.float64(target[row, column])
    dx, dy = (column - cx) * far * over_x - x, (row - cy) * far * over_y - y
    squared = (far - z) * (far - z) + (dx * dx + dy * dy)
    nearer = squared < best  # not where there is none
    return squared if nearer else best, row if nearer else at_row, column if nearer else at_column


@compiled
def draw_to_seen(
    pixels: Ints,
    points: Singles,
    normals: Singles,
    bones: Ints,
    seen: Singles,
    camera: Floats,
    half: int,
    gate: float,
    apart: float,
    tones: Singles,
    seen_tones: Singles,
    tone_weight: float,
    along: float,
    scale: float,
    weight: float,
    hessian: Floats,
    gradient: Floats,
) -> tuple[float, int]:
    """Each point of the model is drawn to the nearest one seen: into the bones' systems.

    Parameters
    ----------
    pixels, points, normals, bones : (N, 2), (N, 3), (N, 3), (N,) of the model.
    seen, camera, half .. tone_weight : where to look, see `nearest`; tones (N,), seen_tones (H, W).
    along, scale, weight : see `pull`; scale in m.
    hessian, gradient : (B, 6, 6), of which the upper triangle, and (B, 6), are added to.

    Returns
    -------
    cost and how many matches count for at least half.
    """
    fx, fy, cx, cy = camera[0], camera[1], camera[2], camera[3]
    over_x, over_y = 1.0 / fx, 1.0 / fy
    cost, inliers, tone, squared_scale = 0.0, 0, np.nan, scale * scale
    for i in range(pixels.shape[0]):
        if tone_weight > 0.0:
            tone = np.float64(tones[i])
        x, y, z = np.float64(points[i, 0]), np.float64(points[i, 1]), np.float64(points[i, 2])
        row, column = nearest(
            pixels[i, 0], pixels[i, 1], x, y, z, seen, over_x, over_y, cx, cy, half, gate, apart, tone, seen_tones,
            tone_weight,
        )  # fmt: skip
        if row < 0:
            continue
        far = np.float64(seen[row, column])
        rx, ry = (column - cx) * far / fx - x, (row - cy) * far / fy - y
        nx, ny, nz = np.float64(normals[i, 0]), np.float64(normals[i, 1]), np.float64(normals[i, 2])
        one, squared = pull(
            bones[i], x, y, z, rx, ry, far - z, nx, ny, nz, along, squared_scale, weight, hessian, gradient
        )
        cost += one
        inliers += squared < HALF * squared_scale
    return cost, inliers


@compiled
def draw_from_seen(
    pixels: Ints,
    samples: Singles,
    depth: Singles,
    solid: np.ndarray,
    camera: Floats,
    placed: Floats,
    shell: Shell,
    half: int,
    gate: float,
    apart: float,
    along: float,
    scale: float,
    weight: float,
    hessian: Floats,
    gradient: Floats,
) -> tuple[float, int]:
    """Each point seen draws the nearest one of the model to itself: into the bones' systems.

    Parameters
    ----------
    pixels, samples : (N, 2) row and column and (N, 3) m of what is seen.
    depth, solid, camera : (H, W), (H, W) and (4,) of the model's picture, or of those of its pixels that count.
    placed : (P, 3, 4) m, of the shell's solids.
    half, gate, apart : see `nearest`. along, scale, weight, hessian, gradient : as above.

    Returns
    -------
    cost and how many matches count for at least half.
    """
    fx, fy, cx, cy = camera[0], camera[1], camera[2], camera[3]
    over_x, over_y = 1.0 / fx, 1.0 / fy
    cost, inliers, squared_scale = 0.0, 0, scale * scale
    nx, ny, nz = 0.0, 0.0, 0.0
    carriers, kinds, _, _, sizes, tapers = shell
    for i in range(pixels.shape[0]):
        to_x, to_y, to_z = np.float64(samples[i, 0]), np.float64(samples[i, 1]), np.float64(samples[i, 2])
        row, column = nearest(
            pixels[i, 0], pixels[i, 1], to_x, to_y, to_z, depth, over_x, over_y, cx, cy, half, gate, apart, np.nan,
            depth, 0.0,
        )  # fmt: skip
        if row < 0:
            continue
        z = np.float64(depth[row, column])
        x, y = (column - cx) * z / fx, (row - cy) * z / fy
        s = solid[row, column]
        if along > 0.0:
            nx, ny, nz = outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z)
        one, squared = pull(
            carriers[s], x, y, z, to_x - x, to_y - y, to_z - z, nx, ny, nz, along, squared_scale, weight, hessian,
            gradient,
        )  # fmt: skip
        cost += one
        inliers += squared < HALF * squared_scale
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
    cost, outside = 0.0, 0
    for i in range(pixels.shape[0]):
        row, column = pixels[i, 0], pixels[i, 1]
        if not free[row, column]:
            continue
        outside += 1
        down, across = to_allowed(row, column, free, reach)
        if down == 0 and across == 0:
            continue
        x, y, z = np.float64(points[i, 0]), np.float64(points[i, 1]), np.float64(points[i, 2])
        rx, ry = across * z / fx, down * z / fy
        size = sqrt(rx * rx + ry * ry)
        one, _ = pull(
            bones[i], x, y, z, rx, ry, 0.0, rx / size, ry / size, 0.0,
            1.0, scale * scale, weight, hessian, gradient,
        )  # fmt: skip
        cost += one
    return cost, outside


@compiled
def to_allowed(row: int, column: int, free: Bools, reach: int) -> tuple[int, int]:
    """Rows and columns from a pixel to the nearest one that may hold the person; 0, 0 when none is within `reach`."""
    height, width = free.shape
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
    return down, across
