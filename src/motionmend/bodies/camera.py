"""The depth camera and what it sees: intrinsics, one frame, and the way between pixels and points."""

from dataclasses import dataclass
from math import isfinite
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Bytes, Floats, Singles, frozen
from ..errors import MismatchError


@final
@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion. Its axes are the tracker's world: x right, y down, z forward.

    A point (x, y, z) is seen at u = fx·x/z + cx, v = fy·y/z + cy; whole numbers are the centres of pixels.

    Attributes
    ----------
    width, height : of the image, px.
    fx, fy : focal lengths, px.
    cx, cy : principal point, px.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise MismatchError(f"a camera needs one pixel or more, came {self.width} x {self.height}")
        numbers = (self.fx, self.fy, self.cx, self.cy)
        if not np.all(np.isfinite(numbers)) or self.fx <= 0 or self.fy <= 0:
            raise MismatchError(f"a camera needs finite fx, fy > 0 and cx, cy, came {numbers}")

    def project(self, points: ArrayLike) -> Floats:
        """Pixels (..., 2) as (u, v) of points (..., 3) in m; NaN for points that are not in front of the camera."""
        points = np.asarray(points, dtype=np.float64)
        z = np.where(points[..., 2] > 0, points[..., 2], np.nan)
        return np.stack((self.fx * points[..., 0] / z + self.cx, self.fy * points[..., 1] / z + self.cy), axis=-1)

    def unproject(self, pixels: ArrayLike, depth: ArrayLike) -> Floats:
        """Points (..., 3) in m of pixels (..., 2) as (u, v) seen at `depth` (...) m along z."""
        pixels, z = np.asarray(pixels, dtype=np.float64), np.asarray(depth, dtype=np.float64)
        x, y = (pixels[..., 0] - self.cx) / self.fx * z, (pixels[..., 1] - self.cy) / self.fy * z
        return np.stack(np.broadcast_arrays(x, y, z), axis=-1)

    def points(self, depth: Singles) -> Floats:
        """Points (H, W, 3) in m of a whole depth image (H, W) in m; NaN where it is NaN."""
        u, v = np.meshgrid(np.arange(self.width, dtype=np.float64), np.arange(self.height, dtype=np.float64))
        return self.unproject(np.stack((u, v), axis=-1), depth)

    def every(self, step: int) -> "Camera":
        """The camera that sees only every `step`-th pixel of each row and column, the first included.

        Raises
        ------
        MismatchError : step is below 1.
        """
        if step < 1:
            raise MismatchError(f"a step over pixels must be 1 or more, came {step}")
        width, height = -(-self.width // step), -(-self.height // step)
        return Camera(width, height, self.fx / step, self.fy / step, self.cx / step, self.cy / step)

    def step_to(self, focal: float) -> int:
        """Every how many-th pixel of a row to look at, 1 or more, to see as finely as another camera.

        How many pixels a body at a given distance has depends on the focal length alone, not on how wide the image is.

        Parameters
        ----------
        focal : focal length of the other camera, px.
        """
        return max(1, round(self.fx / focal))


KINECT = Camera(320, 240, 285.63, 285.63, 160.0, 120.0)
"""The first Kinect's depth camera at half resolution, nominal: 57 x 43 degrees."""


@final
@dataclass(frozen=True, eq=False)
class DepthFrame:
    """One image of a depth camera.

    Attributes
    ----------
    camera : its intrinsics.
    depth : (H, W) float32, m along z, NaN = no return.
    color : (H, W, 3) red, green, blue, registered to the depth; None where there is none.
    time : s.

    Raises
    ------
    MismatchError : an image of another size than the camera's, or a time that is no number.
    """

    camera: Camera
    depth: Singles
    color: Bytes | None = None
    time: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "depth", frozen(self.depth, np.float32))
        if not isfinite(self.time):
            raise MismatchError(f"the time of a frame in s was wanted, came {self.time}")
        size = (self.camera.height, self.camera.width)
        if self.depth.shape != size:
            raise MismatchError(f"this camera's depth images are {size}, came {self.depth.shape}")
        if self.color is not None:
            object.__setattr__(self, "color", frozen(self.color, np.uint8))
            if self.color.shape != (*size, 3):
                raise MismatchError(f"this camera's colour images are {(*size, 3)}, came {self.color.shape}")

    def every(self, step: int) -> "DepthFrame":
        """Every `step`-th pixel of every `step`-th row, the first included, as `Camera.every` sees it.

        Raises
        ------
        MismatchError : step is below 1.
        """
        if step == 1:
            return self
        camera = self.camera.every(step)
        color = None if self.color is None else self.color[::step, ::step]
        return DepthFrame(camera, self.depth[::step, ::step], color, self.time)
