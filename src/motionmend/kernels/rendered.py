"""What a cast picture of the body says of every pixel: point, normal and bone, as images and as a list of samples."""

import numpy as np

from ..arrays import Bytes, Floats, Ints, Singles
from .compile import compiled
from .raycast import outward


@compiled
def describe(
    depth: Singles,
    solid: np.ndarray,
    placed: Floats,
    kinds: Bytes,
    sizes: Floats,
    tapers: Floats,
    carriers: Ints,
    camera: Floats,
    every: int,
    points: Singles,
    pixels: Ints,
    samples: Singles,
    normals: Singles,
    bones: Ints,
) -> int:
    """Points of a picture by `raycast.cast`, and of its samples normals and bones.

    Parameters
    ----------
    depth, solid : (H, W), as cast.
    placed, kinds, sizes, tapers : of the P solids, as for casting.
    carriers : (P,) the bone of each solid.
    camera : (4,) fx, fy, cx, cy, px.
    every : of rows and columns that become samples.
    points : (H, W, 3) is written, NaN where nothing is.
    pixels, samples, normals, bones : (H W, ...) row and column, point, outward unit normal and bone of each sample
        are written, from the top left.

    Returns
    -------
    The number of samples.
    """
    count = 0
    local, normal = np.empty(3), np.empty(3)
    for row in range(depth.shape[0]):
        upright = (row - camera[3]) / camera[1]
        for column in range(depth.shape[1]):
            z = np.float64(depth[row, column])
            x, y = (column - camera[2]) / camera[0] * z, upright * z
            points[row, column, 0] = x
            points[row, column, 1] = y
            points[row, column, 2] = z
            s = solid[row, column]
            if s < 0 or row % every != 0 or column % every != 0:
                continue
            outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z, local, normal)
            pixels[count, 0] = row
            pixels[count, 1] = column
            samples[count, 0] = x
            samples[count, 1] = y
            samples[count, 2] = z
            for i in range(3):
                normals[count, i] = normal[i]
            bones[count] = carriers[s]
            count += 1
    return count


@compiled
def describe_found(
    found: Ints,
    points: Singles,
    solid: np.ndarray,
    placed: Floats,
    kinds: Bytes,
    sizes: Floats,
    tapers: Floats,
    carriers: Ints,
    samples: Singles,
    normals: Singles,
    bones: Ints,
) -> None:
    """Point, normal and bone of the pixels that were found, `found` (N,) flat index or -1; the rest as above."""
    local, normal = np.empty(3), np.empty(3)
    width = points.shape[1]
    for n in range(found.shape[0]):
        if found[n] < 0:
            continue
        row, column = found[n] // width, found[n] % width
        s = solid[row, column]
        x, y, z = points[row, column, 0], points[row, column, 1], points[row, column, 2]
        outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z, local, normal)
        samples[n, 0] = x
        samples[n, 1] = y
        samples[n, 2] = z
        for i in range(3):
            normals[n, i] = normal[i]
        bones[n] = carriers[s]


@compiled
def samples_of(pixels: Ints, count: int, image: Singles, values: Singles) -> None:
    """Copy `image` (H, W, 3) at the first `count` of `pixels` (.., 2) to `values` (count, 3)."""
    for i in range(count):
        for k in range(3):
            values[i, k] = image[pixels[i, 0], pixels[i, 1], k]


@compiled
def listed(depth: Singles, every: int, pixels: Ints) -> int:
    """Row and column of every `every`-th row's and column's pixel that has a depth, to `pixels`; how many they are."""
    count = 0
    for row in range(0, depth.shape[0], every):
        for column in range(0, depth.shape[1], every):
            if not np.isnan(depth[row, column]):
                pixels[count, 0] = row
                pixels[count, 1] = column
                count += 1
    return count
