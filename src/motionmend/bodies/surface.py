"""The performer's surface as a camera sees it: depth, which solid, points and normals."""

from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints, Singles
from .camera import Camera
from .performer import Performer, Pose

Solid16: TypeAlias = NDArray[np.int16]


@final
@dataclass(frozen=True, eq=False)
class Rendering:
    """A picture of a performer.

    Attributes
    ----------
    camera : that took it; of a picture of every n-th pixel, the camera that has only those.
    depth : (H, W) float32, m along z, NaN = nothing there.
    solid : (H, W) int16, index into the performer's solids, -1 = nothing there.
    bone : (P,) the bone that carries each solid.
    placed : (P, 3, 4) world from solid.
    performer : whose picture it is.
    """

    camera: Camera
    depth: Singles
    solid: Solid16
    bone: Ints
    placed: Floats
    performer: Performer

    @property
    def bones(self) -> Solid16:
        """(H, W) int16, index of the bone seen, -1 = none."""
        return np.append(self.bone, -1).astype(np.int16)[self.solid]

    @property
    def points(self) -> Floats:
        """(H, W, 3) m, NaN where nothing is."""
        return self.camera.points(self.depth)

    @property
    def normals(self) -> Singles:
        """(H, W, 3) outward unit normals, NaN where nothing is."""
        from ..kernels import raycast

        normal = np.empty((*self.depth.shape, 3), dtype=np.float32)
        shell = self.performer.solids.arrays
        raycast.normals(self.placed, shell, intrinsics(self.camera), self.depth, self.solid, normal)
        return normal


def render(performer: Performer, pose: Pose, camera: Camera, step: int = 1) -> Rendering:
    """Cast a ray through every `step`-th pixel of every `step`-th row, the first included.

    Parameters
    ----------
    performer, pose : who, and how; the pose's world is the camera's.
    camera : (width, height) px.
    step : 4 gives a picture a quarter as wide and as high, seen by `camera.every(4)`.

    Returns
    -------
    Rendering : exact up to float32. What is nearer than 0.05 m is not seen.
    """
    from ..kernels import raycast, rendered

    camera = camera.every(step)
    solids = performer.solids
    frames, placed = np.empty((len(performer.bones), 4, 4)), np.empty((len(solids), 3, 4))
    parts = np.empty((len(solids), raycast.PARTS))
    depth = np.empty((camera.height, camera.width), dtype=np.float32)
    solid = np.empty(depth.shape, dtype=np.int16)
    rendered.picture(
        performer.chain, pose.arrays, solids.arrays, intrinsics(camera), frames, placed, parts, depth, solid
    )
    return Rendering(camera, depth, solid, solids.bone, placed, performer)


def intrinsics(camera: Camera) -> Floats:
    """(4,) fx, fy, cx, cy, as the kernels take a camera."""
    return np.array((camera.fx, camera.fy, camera.cx, camera.cy))
