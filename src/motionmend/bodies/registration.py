"""Colour to depth: what colour each depth pixel has when the two cameras stand side by side."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bytes, Floats, Singles, frozen
from ..errors import MismatchError
from .camera import Camera

HIDDEN = 0.05  # m; a point this far behind another on the same line of sight is not what the colour camera sees


@final
@dataclass(frozen=True, eq=False)
class ColorCamera:
    """A colour camera beside a depth camera.

    Attributes
    ----------
    camera : its own intrinsics.
    rotation, translation : (3, 3) and (3,) m; a point p of the depth camera lies at `rotation @ p + translation` in
        the axes of the colour camera.
    """

    camera: Camera
    rotation: Floats
    translation: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", frozen(self.rotation))
        object.__setattr__(self, "translation", frozen(self.translation))
        if self.rotation.shape != (3, 3) or self.translation.shape != (3,):
            raise MismatchError(
                f"a (3, 3) rotation and a (3,) translation were wanted, came {self.rotation.shape} and "
                f"{self.translation.shape}"
            )
        if not np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-2) or np.linalg.det(self.rotation) < 0:
            raise MismatchError("a rotation was wanted between depth and colour camera, came another matrix")


def registered(color: Bytes, depth: Singles, depth_camera: Camera, color_camera: ColorCamera) -> Bytes:
    """The colour of every depth pixel.

    Each pixel is unprojected, moved to the colour camera and looked up at the nearest colour pixel. Where another
    surface stands in that line of sight the colour is not this pixel's own.

    Parameters
    ----------
    color : (h, w, 3) as the colour camera took it.
    depth : (H, W) m, NaN = no return.

    Returns
    -------
    color : (H, W, 3); black where the depth has no return or the colour camera does not see the point.

    Raises
    ------
    MismatchError : `color` has another size than its camera.
    """
    taker = color_camera.camera
    if color.shape != (taker.height, taker.width, 3):
        raise MismatchError(f"this camera's colour images are {(taker.height, taker.width, 3)}, came {color.shape}")
    out = np.zeros((*depth.shape, 3), dtype=np.uint8)
    rows, columns = np.nonzero(np.isfinite(depth))
    here = depth_camera.unproject(np.column_stack([columns, rows]), depth[rows, columns])
    there = here @ color_camera.rotation.T + color_camera.translation
    pixel = taker.project(there)
    corner = np.array([taker.width - 0.5, taker.height - 0.5])
    with np.errstate(invalid="ignore"):
        inside = np.flatnonzero(((pixel > -0.5) & (pixel < corner)).all(axis=1))
    rows, columns, z = rows[inside], columns[inside], there[inside, 2]
    u, v = np.rint(pixel[inside]).astype(np.int64).T
    # The nearest surface over a few pixels, since depth pixels may lie sparser than colour pixels.
    coarse = max(1, int(np.ceil(2 * taker.fx / depth_camera.fx)))
    nearest = np.full((taker.height // coarse + 1, taker.width // coarse + 1), np.inf)
    np.minimum.at(nearest, (v // coarse, u // coarse), z)
    seen = z <= nearest[v // coarse, u // coarse] + HIDDEN
    out[rows[seen], columns[seen]] = color[v[seen], u[seen]]
    return out
