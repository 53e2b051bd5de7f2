"""The level top of a desk: it hangs together with who sits at it, in one surface that sways."""

import numpy as np

from ...arrays import Bools, Floats, Ints, Singles
from ...bodies.camera import Camera
from .room import GRAZING, NOISE_NEAR, NOISE_STEEP, refitted, spread
from .surfaces import SOMEBODY

LARGE = 0.3  # m², of a level piece
ABOVE = 0.1  # m, above a desk is whoever sits at it: what lies on it is lower
EDGE = 0.05  # m, high at most is a top's edge
TILTED = 0.985  # cosine of 10 degrees, from the vertical, of a top at most
_LEAST = 0.5  # of an upward normal that points up in the image: cameras look down by 60 degrees at most
_THICK, _TRIED = 0.04, 4  # m, layers in which a top is looked for, and how many of them
_FULL = 0.1  # of `LARGE`, from which on another piece of the same top is one
_ALONG = 0.7  # of a top's own slope
_FITS, _THIN = 2, 5000  # and points that a plane is fitted to


def vertical(planes: Floats) -> Floats | None:
    """(3,) unit vector upwards, from a room's floor or else its walls (P, 4); None where neither tells."""
    if not len(planes):
        return None
    floor = planes[int(np.argmin(planes[:, 1]))]
    if floor[1] < -_LEAST:
        return np.array(floor[:3])
    walls, up = planes[:, :3], np.array([0.0, -1.0, 0.0])
    up = up - np.linalg.pinv(walls, rcond=0.3) @ (walls @ up)  # what of the image's own is at right angles to them
    length = float(np.linalg.norm(up))
    return up / length if length > _LEAST else None


def top_in(camera: Camera, stays: Singles, depth: Singles, surface: Bools, up: Floats) -> Bools | None:
    """The largest top of a desk in a surface with somebody above it, as pixels (H, W); None where there is none.

    Parameters
    ----------
    camera : that looks. stays : (H, W) m, what is the same in many frames (`standing.stays_of`), NaN = nothing.
    depth : (H, W) m, one of them. surface : (H, W) True on it there. up : (3,) unit vector.
    """
    import cv2

    focal = camera.fx * camera.fy
    with np.errstate(invalid="ignore"):  # what stays behind somebody who walks is not theirs
        rows, columns = np.nonzero(surface & (np.abs(stays - depth) < NOISE_NEAR + NOISE_STEEP * np.square(stays)))
    z = stays[rows, columns].astype(np.float64)
    points = camera.unproject(np.column_stack([columns, rows]), z)
    facing = z**2 / focal
    if facing.sum() < GRAZING * LARGE:
        return None
    level = points @ up
    seen = np.where(level < 0.0, spread(points, facing, up), 0.0)  # the upper side shows from above
    layer = np.floor((level - level.min()) / (0.5 * _THICK)).astype(np.int64)
    halves = np.append(np.bincount(layer, seen), 0.0)
    sizes = halves[:-1] + halves[1:]
    at = np.argwhere(surface)
    deep = depth[surface].astype(np.float64)
    everything = camera.unproject(at[:, ::-1], deep)
    some = slice(None, None, 1 + len(points) // _THIN)
    found, most = None, LARGE
    for k in np.argsort(-sizes, kind="stable")[:_TRIED]:
        if sizes[k] < 0.5 * LARGE:
            break
        plane = np.append(up, -(level.min() + 0.5 * _THICK * (k + 1)))
        for _ in range(_FITS):
            plane = refitted(points[some], facing[some], plane)
        plane = plane if plane[:3] @ up > 0.0 else -plane
        above = everything @ plane[:3] + plane[3] > ABOVE
        if plane[:3] @ up < TILTED or np.square(deep[above]).sum() < SOMEBODY * focal:
            continue
        # A camera that looks along a top is wrong along its rays alone.
        along, noise = np.abs(points @ plane[:3]), NOISE_NEAR + NOISE_STEEP * z**2
        on = np.abs(points @ plane[:3] + plane[3]) < noise * along / z
        if not on.any():
            continue
        piece = np.zeros(depth.shape, np.uint8)
        piece[rows[on], columns[on]] = 1
        labels = cv2.connectedComponents(piece, connectivity=4)[1]
        own, most_own = labels[rows, columns], int(labels.max())
        areas = np.bincount(own, np.where(on, spread(points, facing, plane), 0.0), most_own + 1)
        if areas.max() <= most:
            continue
        # Who is upright where the plane goes on behind a desk is cut by it in a strip that does not go away with it.
        wanted = -plane[3] * z / (points @ plane[:3])
        goes = _goes_along(z[on], wanted[on], own[on], columns[on], depth.shape[1])
        top = ((areas >= _FULL * LARGE) & (goes > _ALONG))[labels] & (piece > 0)
        if areas[goes > _ALONG].max(initial=0.0) > most:
            most = float(areas[goes > _ALONG].max())
            # Its front edge, left over, would be taken for a piece of them.
            below = int(np.ceil(2.0 * EDGE * camera.fy / z.min()))
            under = cv2.dilate(top.view(np.uint8), np.ones((below + 1, 1), np.uint8), anchor=(0, below)) > 0
            height = points @ plane[:3] + plane[3]
            edge = under[rows, columns] & (height > -EDGE) & (height < NOISE_NEAR)
            found = top.copy()
            found[rows[edge], columns[edge]] = True
    return found


def _goes_along(depth: Floats, wanted: Floats, piece: Ints, column: Ints, columns: int) -> Floats:
    """How much pieces go away from the camera, by what a plane would from row to row: 1 = as it does, 0 = not at all.

    Parameters
    ----------
    depth, wanted : (N,) m, measured and the plane's. piece, column : (N,) which piece and column each is of.
    columns : of the image.
    """
    each = np.unique(piece * columns + column, return_inverse=True)[1]
    count = np.bincount(each)
    off, want = (one - (np.bincount(each, one) / count)[each] for one in (depth, wanted))
    return np.asarray(np.bincount(piece, off * want) / np.maximum(np.bincount(piece, want * want), 1e-9))
