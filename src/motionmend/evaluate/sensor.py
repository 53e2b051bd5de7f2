"""What a structured-light depth camera makes of a true depth image: its noise, steps, shadows and holes.

Axial noise grows with the square of the distance (Nguyen, Izadi and Lovell 2012, "Modeling Kinect sensor noise for
improved 3D reconstruction and tracking", eq. 3); depth is the inverse of a disparity that comes in eighths of a pixel
(Khoshelham and Elberink 2012, eq. 5); samples near an edge are taken a fraction of a pixel beside their pixel
(Nguyen's lateral noise); what the projector does not light, what is seen at a grazing angle and some of what lies on
an edge gives no return.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats, Singles
from ..bodies.camera import Camera


@dataclass(frozen=True)
class Sensor:
    """A structured-light depth camera.

    Attributes
    ----------
    floor, growth, nearest : axial standard deviation floor + growth · (z - nearest)², m, 1/m, m.
    baseline : from camera to projector, m; 0 casts no shadows. The projector is to the left of the image.
    steps : of disparity in one pixel of the sensor's full width of 640.
    lateral : standard deviation of where a pixel samples, in pixels of a width of 640.
    edge : share of the pixels on either side of a depth edge that are lost.
    jump : m, neighbours farther apart than this (and three times their noise) are an edge.
    grazing : degrees from the surface below which the share lost rises from 0 to all at the surface.
    speckle : share of all pixels that are lost.
    holes : mean number of round holes of 1 to 3 pixels' radius in the picture of one person; 0 for none.
    near, far : m, the range outside which there is no return.
    """

    floor: float = 0.0012
    growth: float = 0.0019
    nearest: float = 0.4
    baseline: float = 0.075
    steps: float = 8.0
    lateral: float = 0.8
    edge: float = 0.35
    jump: float = 0.06
    grazing: float = 12.0
    speckle: float = 0.003
    holes: float = 3.0
    near: float = 0.5
    far: float = 8.0


KINECT_SENSOR = Sensor()


def sensed(depth: Singles, camera: Camera, seed: int, frame: int = 0, sensor: Sensor = KINECT_SENSOR) -> Singles:
    """A true depth image as the sensor would report it.

    Parameters
    ----------
    depth : (H, W) float32, m along z, NaN = nothing there.
    camera : that sees it.
    seed, frame : the same two give the same noise, other frames of a seed other noise.
    sensor : its properties.

    Returns
    -------
    (H, W) float32 m, NaN = no return.
    """
    rng = np.random.default_rng([seed, frame])
    true = np.where(np.isfinite(depth), depth, np.inf).astype(np.float64)
    lost = ~_lit(true, camera, sensor.baseline) if sensor.baseline > 0 else np.zeros(true.shape, dtype=bool)
    scale = camera.width / 640.0
    seen = _beside(true, rng, sensor.lateral * scale)
    edges = _edges(true, sensor)
    lost |= edges & (rng.random(true.shape) < sensor.edge)
    lost |= ~edges & _grazing_losses(true, camera, rng, sensor)  # from pixel to pixel across an edge is no surface
    lost |= rng.random(true.shape) < sensor.speckle
    lost |= _holes(true, rng, sensor.holes)
    with np.errstate(invalid="ignore"):
        noise = sensor.floor + sensor.growth * np.square(seen - sensor.nearest)
        seen = seen + np.where(np.isfinite(seen), noise, 0.0) * rng.standard_normal(true.shape)
        if sensor.steps > 0 and sensor.baseline > 0:
            # disparity = f · baseline / z, in steps of 1/8 px of the full width
            finest = sensor.steps * camera.fx / scale * sensor.baseline
            seen = finest / np.maximum(np.round(finest / seen), 1e-9)
        lost |= ~((seen > sensor.near) & (seen < sensor.far))
    return np.where(lost, np.nan, seen).astype(np.float32)


def _lit(depth: Floats, camera: Camera, baseline: float) -> Bools:
    """What the projector reaches: of all that lies in one column of its own image, the nearest."""
    height, width = depth.shape
    fine = 2  # columns of the projector's image in one of the camera's
    u = np.arange(width)
    with np.errstate(invalid="ignore"):
        disparity = np.where(np.isfinite(depth), camera.fx * baseline / depth, 0.0)
    shift = np.round(fine * (u + disparity)).astype(np.int64)
    columns = int(fine * (width + disparity.max())) + 3
    nearest = np.full((height, columns), np.inf)
    rows = np.broadcast_to(np.arange(height)[:, None], depth.shape)
    for side in (0, 1):  # a pixel of the camera covers two columns
        np.minimum.at(nearest, (rows, shift + side), depth)
    return np.asarray(depth <= nearest[rows, shift] + 0.02 * depth + 0.02)


def _beside(depth: Floats, rng: np.random.Generator, std: float) -> Floats:
    """Every pixel's depth from where it happens to sample."""
    height, width = depth.shape
    shift = np.clip(np.round(std * rng.standard_normal((2, height, width))), -2, 2).astype(np.int64)
    v = np.clip(np.arange(height)[:, None] + shift[0], 0, height - 1)
    u = np.clip(np.arange(width) + shift[1], 0, width - 1)
    return np.asarray(depth[v, u])


def _edges(depth: Floats, sensor: Sensor) -> Bools:
    """The pixels beside a jump of depth, either side."""
    edge = np.zeros(depth.shape, dtype=bool)
    finite = np.where(np.isfinite(depth), depth, 1e3)
    for axis in (0, 1):
        step = np.abs(np.diff(finite, axis=axis))
        near = np.minimum(finite.take(range(step.shape[axis]), axis), finite.take(range(1, step.shape[axis] + 1), axis))
        jumps = step > np.maximum(sensor.jump, 3 * (sensor.floor + sensor.growth * np.square(near)))
        first = [slice(None), slice(None)]
        second = [slice(None), slice(None)]
        first[axis], second[axis] = slice(0, -1), slice(1, None)
        edge[tuple(first)] |= jumps
        edge[tuple(second)] |= jumps
    return edge


def _grazing_losses(depth: Floats, camera: Camera, rng: np.random.Generator, sensor: Sensor) -> Bools:
    """Surfaces seen almost along themselves return less and less."""
    points = camera.points(np.where(np.isfinite(depth), depth, np.nan).astype(np.float32))
    across = np.full(points.shape, np.nan)
    along = np.full(points.shape, np.nan)
    across[:, 1:-1] = points[:, 2:] - points[:, :-2]
    along[1:-1] = points[2:] - points[:-2]
    normal = np.cross(across, along)
    with np.errstate(invalid="ignore", divide="ignore"):
        sine = np.abs(np.einsum("vui,vui->vu", normal, points))
        sine /= np.linalg.norm(normal, axis=2) * np.linalg.norm(points, axis=2)
        share = 1.0 - np.degrees(np.arcsin(np.clip(sine, 0.0, 1.0))) / max(sensor.grazing, 1e-6)
    return np.asarray(rng.random(depth.shape) < np.nan_to_num(share))


def _holes(depth: Floats, rng: np.random.Generator, mean: float) -> Bools:
    """Round holes at random places of what is there, as dark or shiny patches leave."""
    holes = np.zeros(depth.shape, dtype=bool)
    there = np.argwhere(np.isfinite(depth))
    if not len(there):
        return holes
    for _ in range(int(rng.poisson(mean))):
        v, u = there[rng.integers(len(there))]
        radius = rng.uniform(1.0, 3.0)
        r = int(np.ceil(radius))
        rows, columns = np.ogrid[max(v - r, 0) : v + r + 1, max(u - r, 0) : u + r + 1]
        disc = (rows - v) ** 2 + (columns - u) ** 2 <= radius**2
        holes[max(v - r, 0) : v + r + 1, max(u - r, 0) : u + r + 1] |= disc[
            : depth.shape[0] - max(v - r, 0), : depth.shape[1] - max(u - r, 0)
        ]
    return holes
