"""What a cast picture of the body says of every pixel: point, normal and bone, as images and as a list of samples."""

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from . import articulated, raycast
from .body import Chain, Posed, Shell
from .compile import compiled

_frames, _twists = articulated.frames, articulated.twists


@compiled
def picture(
    chain: Chain,
    pose: Posed,
    shell: Shell,
    camera: Floats,
    frames: Floats,
    placed: Floats,
    parts: Floats,
    depth: Singles,
    solid: np.ndarray,
) -> None:
    """A body in a pose as a camera sees it.

    Parameters
    ----------
    camera : (4,) fx, fy, cx, cy, px.
    frames, placed, parts : (B, 4, 4), (P, 3, 4) and (P, 18), written: world from bone, from solid, and for casting.
    depth, solid : (H, W), written as by `raycast.cast`.
    """
    carriers, kinds, centers, turns, sizes, tapers = shell
    _frames(chain, pose, frames)
    raycast.place(frames, carriers, centers, turns, placed)
    raycast.prepare(placed, kinds, sizes, tapers, camera, depth.shape[1], depth.shape[0], parts)
    raycast.cast(parts, depth, solid)


@compiled
def sampled(
    chain: Chain,
    pose: Posed,
    shell: Shell,
    camera: Floats,
    every: int,
    frames: Floats,
    moving: Floats,
    placed: Floats,
    parts: Floats,
    depth: Singles,
    solid: np.ndarray,
    pixels: Ints,
    samples: Singles,
    normals: Singles,
    bones: Ints,
) -> int:
    """The same with what the terms want of it: how each degree of freedom moves, and samples of the surface.

    Parameters
    ----------
    every : of rows and columns that become samples.
    moving : (D, 6), written as by `articulated.twists`.
    pixels, samples, normals, bones : (N, ...) row and column, point, outward unit normal and bone of each sample are
        written, from the top left.

    Returns
    -------
    The number of samples.
    """
    picture(chain, pose, shell, camera, frames, placed, parts, depth, solid)
    _twists(chain, pose.joints, frames, moving)
    carriers, kinds, _, _, sizes, tapers = shell
    count = 0
    for row in range(0, depth.shape[0], every):
        for column in range(0, depth.shape[1], every):
            s = solid[row, column]
            if s < 0:
                continue
            z = np.float64(depth[row, column])
            x, y = (column - camera[2]) / camera[0] * z, (row - camera[3]) / camera[1] * z
            nx, ny, nz = raycast.outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z)
            pixels[count, 0], pixels[count, 1] = row, column
            samples[count, 0], samples[count, 1], samples[count, 2] = x, y, z
            normals[count, 0], normals[count, 1], normals[count, 2] = nx, ny, nz
            bones[count] = carriers[s]
            count += 1
    return count


@compiled
def listed(depth: Singles, camera: Floats, every: int, pixels: Ints, samples: Singles) -> int:
    """Row and column (N, 2) and point (N, 3) of every `every`-th row's and column's pixel that has a depth; N."""
    count = 0
    for row in range(0, depth.shape[0], every):
        for column in range(0, depth.shape[1], every):
            z = np.float64(depth[row, column])
            if not np.isnan(z):
                pixels[count, 0], pixels[count, 1] = row, column
                samples[count, 0] = (column - camera[2]) * z / camera[0]
                samples[count, 1] = (row - camera[3]) * z / camera[1]
                samples[count, 2] = z
                count += 1
    return count


@compiled
def steps(depth: Singles, unknown: Bools, jump: float, edge: Singles) -> None:
    """Near sides of steps in depth: pixels beside one that is empty, or farther by more than `jump` m.

    Parameters
    ----------
    depth : (H, W) m, NaN = empty.
    unknown : (H, W) True where an empty pixel proves nothing, or (0, 0): all are known. The image's border proves
        nothing either.
    edge : (H, W) gets the depths on edges, NaN elsewhere.
    """
    height, width = depth.shape
    nan, least = np.float32(np.nan), np.float32(jump)
    doubts, none = unknown.shape[0] > 0, np.zeros(width, np.bool_)
    for row in range(height):  # without branches, several pixels at once; the border's own neighbour is itself
        up, down = max(row - 1, 0), min(row + 1, height - 1)
        here, above, below, out = depth[row], depth[up], depth[down], edge[row]
        measured = 0
        for c in range(width):
            measured += here[c] == here[c]  # not NaN
        if measured == 0:  # as in every third row about a person
            out[:] = nan
            continue
        over, beside, under = (unknown[up], unknown[row], unknown[down]) if doubts else (none, none, none)
        for c in range(width):
            far = here[c] + least  # what is empty is not nearer either
            sharp = (not above[c] <= far) & (not over[c]) | (not below[c] <= far) & (not under[c])
            out[c] = here[c] if sharp else nan
        for c in range(1, width):
            sharp = (not here[c - 1] <= here[c] + least) & (not beside[c - 1])
            out[c] = here[c] if sharp else out[c]
        for c in range(width - 1):
            sharp = (not here[c + 1] <= here[c] + least) & (not beside[c + 1])
            out[c] = here[c] if sharp else out[c]
