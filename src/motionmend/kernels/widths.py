"""What matches tell of a bone's widths and motion together: one system of ten rows and columns per bone.

A match's row is [point x direction, direction, what a stretch along x, y, z of the bone does, how far it should move]:
the bone's twist, the logarithms of its three stretches, and the residual. Their weighted outer products are summed.
"""

from math import sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from .compile import compiled
from .match import nearest, to_allowed

ROW = 10


@compiled
def stretch_row(
    frame: Floats,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    residual: float,
    scale: float,
    trust: float,
    row: Floats,
    system: Floats,
) -> None:
    """Add one match to a bone's system (10, 10).

    Parameters
    ----------
    frame : (4, 4) camera from bone.
    x .. z, nx .. nz : the bone's point, m, and the unit direction in which it should move by `residual`, m.
    scale : m, of Geman and McClure's estimator. trust : weight of a match without residual, per m².
    row : (10,), written. system : added to.
    """
    row[0], row[1], row[2] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
    row[3], row[4], row[5] = nx, ny, nz
    for k in range(3):
        local = frame[0, k] * (x - frame[0, 3]) + frame[1, k] * (y - frame[1, 3]) + frame[2, k] * (z - frame[2, 3])
        row[6 + k] = local * (frame[0, k] * nx + frame[1, k] * ny + frame[2, k] * nz)
    row[9] = residual
    shrink = 1.0 / (1.0 + (residual / scale) ** 2)
    weight = trust * shrink * shrink
    for i in range(ROW):
        part = weight * row[i]
        for k in range(ROW):
            system[i, k] += part * row[k]


@compiled
def from_model(
    pixels: Ints,
    points: Singles,
    normals: Singles,
    bones: Ints,
    frames: Floats,
    seen: Singles,
    free: Bools,
    camera: Floats,
    reach: int,
    half: int,
    gate: float,
    apart: float,
    scale: float,
    trust: float,
    systems: Floats,
) -> None:
    """Points of the model along their normals to the observed ones; where nobody is, sideways to where somebody may be.

    Parameters
    ----------
    pixels .. bones : (N, ...) of the model, as `rendered.sampled` writes them. frames : (B, 4, 4) camera from bone.
    seen, free, camera : (H, W) m and True where nobody is, and (4,).
    reach : px, farther sideways is not looked.
    half, gate, apart : see `match.nearest`. scale, trust : see `stretch_row`.
    systems : (B, 10, 10), added to.
    """
    row, over_x, over_y, cx, cy = np.empty(ROW), 1.0 / camera[0], 1.0 / camera[1], camera[2], camera[3]
    for i in range(pixels.shape[0]):
        r, c, b = pixels[i, 0], pixels[i, 1], bones[i]
        x, y, z = np.float64(points[i, 0]), np.float64(points[i, 1]), np.float64(points[i, 2])
        if free[r, c]:
            down, across = to_allowed(r, c, free, reach)
            dx, dy = across * z / camera[0], down * z / camera[1]
            size = sqrt(dx * dx + dy * dy)
            if size > 0.0:
                stretch_row(frames[b], x, y, z, dx / size, dy / size, 0.0, size, scale, trust, row, systems[b])
            continue
        r, c = nearest(r, c, x, y, z, seen, over_x, over_y, cx, cy, half, gate, apart, np.nan, seen, 0.0)
        if r < 0:
            continue
        far = np.float64(seen[r, c])
        dx, dy = (c - cx) * far / camera[0] - x, (r - cy) * far / camera[1] - y
        nx, ny, nz = np.float64(normals[i, 0]), np.float64(normals[i, 1]), np.float64(normals[i, 2])
        off = dx * nx + dy * ny + (far - z) * nz
        stretch_row(frames[b], x, y, z, nx, ny, nz, off, scale, trust, row, systems[b])


@compiled
def from_seen(
    pixels: Ints,
    samples: Singles,
    depth: Singles,
    solid: np.ndarray,
    camera: Floats,
    carriers: Ints,
    frames: Floats,
    half: int,
    gate: float,
    apart: float,
    scale: float,
    trust: float,
    systems: Floats,
) -> None:
    """To observed points beside the model its nearest points straight.

    Parameters
    ----------
    pixels, samples : (N, 2) and (N, 3) m of what is observed.
    depth, solid, camera : (H, W), (H, W) and (4,) of the model's picture. carriers : (P,) the bone of each solid.
    frames, half .. systems : as above.
    """
    row, over_x, over_y, cx, cy = np.empty(ROW), 1.0 / camera[0], 1.0 / camera[1], camera[2], camera[3]
    for i in range(pixels.shape[0]):
        r, c = pixels[i, 0], pixels[i, 1]
        if not np.isnan(depth[r, c]):
            continue
        to_x, to_y, to_z = np.float64(samples[i, 0]), np.float64(samples[i, 1]), np.float64(samples[i, 2])
        r, c = nearest(r, c, to_x, to_y, to_z, depth, over_x, over_y, cx, cy, half, gate, apart, np.nan, depth, 0.0)
        if r < 0:
            continue
        z = np.float64(depth[r, c])
        x, y = (c - cx) * z / camera[0], (r - cy) * z / camera[1]
        dx, dy, dz = to_x - x, to_y - y, to_z - z
        size = sqrt(dx * dx + dy * dy + dz * dz)
        if size > 0.0:
            b = carriers[solid[r, c]]
            stretch_row(frames[b], x, y, z, dx / size, dy / size, dz / size, size, scale, trust, row, systems[b])
