"""The room in depth images: what lies on its planes or background or hides the person, and what is learned of it."""

import numpy as np

from ..arrays import Bools, Floats, Singles
from .compile import compiled

LOST = 2  # px, that a step in depth costs


@compiled
def _take_below(
    depths: Singles, y: float, intrinsics: Floats, plane: Floats, near: float, steep: float, out: Bools
) -> None:
    """Take from a row (W,) what lies on a plane or below it, as `before_scene` has it; y is of its rays at depth 1.

    Without a branch, so that the processor takes several pixels at once.
    """
    level, side = plane[1] * y + plane[2], plane[0] / intrinsics[0]
    for c in range(len(depths)):
        z = np.float64(depths[c])
        along = z * (level + side * (c - intrinsics[2]))
        out[c] &= not (along + plane[3] < near + steep * z * abs(along))


@compiled
def before_scene(
    depth: Singles,
    intrinsics: Floats,
    planes: Floats,
    background: Singles,
    near: float,
    steep: float,
    out: Bools,
) -> None:
    """True where a measured pixel lies in front of the planes and of the background.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return.
    intrinsics : (4,) fx, fy, cx, cy in pixels.
    planes : (P, 4) unit normal towards the camera and offset: normal . x + offset is the height above it, m.
    background : (H, W) m, farthest surface known at each pixel, NaN where nothing is known.
    near, steep : a depth counts only beyond near + steep z^2, in m (a depth camera's noise grows so), a height above
        a plane beyond near + steep z^2 times the part of the ray along the plane's normal.
    out : (H, W) written.
    """
    for r in range(depth.shape[0]):
        for c in range(depth.shape[1]):
            z = np.float64(depth[r, c])
            out[r, c] = (z == z) & (not (np.float64(background[r, c]) - z < near + steep * z * z))
        y = (r - intrinsics[3]) / intrinsics[1]
        for p in range(len(planes)):
            _take_below(depth[r], y, intrinsics, planes[p], near, steep, out[r])


@compiled
def hiding(
    depth: Singles, intrinsics: Floats, planes: Floats, near: float, steep: float, closest: float, free: Bools
) -> None:
    """Take from the free pixels those where something that stands in the room is nearer than the person.

    What is behind a table is hidden by it; behind a floor or a wall nothing is.

    Parameters
    ----------
    depth, intrinsics, planes, near, steep : as of `before_scene`.
    closest : m, depths below this are nearer than the person.
    free : (H, W) True where the person is not; written.
    """
    hides = np.empty(depth.shape[1], np.bool_)
    for r in range(depth.shape[0]):
        some = False
        for c in range(depth.shape[1]):
            hides[c] = free[r, c] & (depth[r, c] < closest)
            some |= hides[c]
        if not some:
            continue
        y = (r - intrinsics[3]) / intrinsics[1]
        for p in range(len(planes)):
            _take_below(depth[r], y, intrinsics, planes[p], near, steep, hides)
        for c in range(depth.shape[1]):
            free[r, c] &= not hides[c]


@compiled
def farthest(depth: Singles, seen: Bools, person: Singles, near: float, steep: float, background: Singles) -> None:
    """The background (H, W) with a frame learned, in place: the farthest that is seen at each pixel.

    What was learned at the depth of the person who is there now was a piece of them, and is forgotten.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return. seen : (H, W) True where that is background.
    person : (H, W) m, NaN beside.
    near, steep : what is less than near + steep z^2 behind a depth, in m, lies on it.
    background : (H, W) m, NaN where nothing is known; written.
    """
    for r in range(depth.shape[0]):
        for c in range(depth.shape[1]):
            z, known = np.float64(depth[r, c]), np.float64(background[r, c])
            piece = (person[r, c] == person[r, c]) & (known - z < near + steep * z * z)
            taken = seen[r, c] & (piece | (not z < known))
            background[r, c] = depth[r, c] if taken else np.float32(np.nan) if piece else background[r, c]


@compiled
def gaps(depth: Singles, person: Singles, free: Bools, reach: float, rim: Bools) -> None:
    """Narrow gaps between the person and something farther: they are nobody's.

    At a step a depth camera loses a pixel or so on either side, and along rows the near side hides the far one from
    the projector: a step from z to z' casts a shadow of reach (1 / z - 1 / z') px. Wider gaps tell nothing.

    Parameters
    ----------
    depth, person : (H, W) m, what is measured and what of it is the person's, NaN = nothing.
    free : (H, W) True where something else is measured.
    reach : px m, focal length times the distance from camera to projector, which may be on either side.
    rim : (H, W) False; set where a gap is nobody's.
    """
    height, width = depth.shape
    for r in range(height):
        for c in range(width):
            near = np.float64(person[r, c])
            if np.isnan(near):
                continue
            for way in range(4):
                down, across = (0, 2 * way - 1) if way < 2 else (2 * way - 5, 0)
                shadow = 0.0 if way > 1 else reach
                count, i, j = 0, r + down, c + across
                while 0 <= i < height and 0 <= j < width and np.isnan(depth[i, j]) and np.isnan(person[i, j]):
                    if count > LOST + shadow / near:
                        break
                    count, i, j = count + 1, i + down, j + across
                if count == 0 or i < 0 or j < 0 or i >= height or j >= width or not free[i, j]:
                    continue
                far = np.float64(depth[i, j])
                # A far side that is missing is no end of a gap either.
                if not far >= near or count > LOST + shadow * (1.0 / near - 1.0 / far):
                    continue
                for k in range(1, count + 1):
                    rim[r + k * down, c + k * across] = True
