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
    normals: Singles,
    bones: Ints,
    pixels: Ints,
) -> int:
    """Points and normals of a picture by `raycast.cast`.

    Parameters
    ----------
    depth, solid : (H, W), as cast.
    placed, kinds, sizes, tapers : of the P solids, as for casting.
    carriers : (P,) the bone of each solid.
    camera : (4,) fx, fy, cx, cy, px.
    every : of rows and columns that become samples.
    points, normals : (H, W, 3) are written, points NaN where nothing is.
    bones : (H, W) is written, -1 where nothing is.
    pixels : (H W, 2) row and column of each sample are written, from the top left.

    Returns
    -------
    The number of samples.
    """
    count = 0
    local, normal = np.empty(3), np.empty(3)
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            s = solid[row, column]
            if s < 0:
                bones[row, column] = -1
                points[row, column, 0] = np.nan
                points[row, column, 1] = np.nan
                points[row, column, 2] = np.nan
                continue
            z = np.float64(depth[row, column])
            x = (column - camera[2]) / camera[0] * z
            y = (row - camera[3]) / camera[1] * z
            outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z, local, normal)
            points[row, column, 0] = x
            points[row, column, 1] = y
            points[row, column, 2] = z
            for i in range(3):
                normals[row, column, i] = normal[i]
            bones[row, column] = carriers[s]
            if row % every == 0 and column % every == 0:
                pixels[count, 0] = row
                pixels[count, 1] = column
                count += 1
    return count


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


@compiled
def nearest_allowed(free: np.ndarray, nearest: Ints) -> None:
    """For each pixel (H, W) the flat index of a nearest one that is not free; -1 when all are.

    Two sweeps each way in which every pixel asks its neighbours for theirs (Danielsson 1980): the distance is exact
    but for rare pixels, where it is too long by a fraction of a pixel.
    """
    height, width = free.shape
    for row in range(height):
        for column in range(width):
            nearest[row, column] = -1 if free[row, column] else row * width + column
    for sweep in range(2):
        for i in range(height):
            row = i if sweep == 0 else height - 1 - i
            above = row - 1 if sweep == 0 else row + 1
            if 0 <= above < height:
                for column in range(width):
                    for shift in range(-1, 2):
                        if 0 <= column + shift < width:
                            _take(nearest, row, column, above, column + shift, width)
            for column in range(1, width):
                _take(nearest, row, column, row, column - 1, width)
            for column in range(width - 2, -1, -1):
                _take(nearest, row, column, row, column + 1, width)


@compiled
def _take(nearest: Ints, row: int, column: int, other: int, beside: int, width: int) -> None:
    """Adopt the neighbour's nearest pixel where it is nearer than one's own."""
    offered = nearest[other, beside]
    if offered < 0:
        return
    dr, dc = offered // width - row, offered % width - column
    own = nearest[row, column]
    if own >= 0:
        r, c = own // width - row, own % width - column
        if r * r + c * c <= dr * dr + dc * dc:
            return
    nearest[row, column] = offered
