"""One frame as the terms want it: cropped, thinned, as points, with its edges and its outline."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Bools, Floats, Ints, Singles, frozen
from ...bodies.camera import KINECT, Camera
from ...bodies.surface import intrinsics
from ..settings import TrackSettings
from .observation import Observation

JUMP = 0.06  # m, the least step in depth that is an edge
USUAL = 3.0  # m, from the camera; a body farther off has too few pixels on the raster
MARGIN = 0.45  # m about the person's pixels that are worked on: no limb gets farther between two frames


@final
@dataclass(frozen=True, eq=False)
class Evidence:
    """What is observed, on a raster of h x w pixels about the person.

    Attributes
    ----------
    camera : of the raster.
    intrinsics : (4,) the same as numbers.
    depth, free : (h, w) as in `Observation`.
    pixels, samples : (N, 2) row and column and (N, 3) m of the sampled points of the person.
    edge_pixels, edge_samples : (E, 2) and (E, 3) of the observed edges; empty when edges do not count.
    tones : (h, w) intensities, or (0, 0).
    apart : m, at least so far is a point at depth 1 from a ray one pixel beside the one it is on.
    weight : of one surface sample: all samples together count as much as `STANDARD`, whatever the distance.
    """

    camera: Camera
    intrinsics: Floats
    depth: Singles
    free: Bools
    pixels: Ints
    samples: Singles
    edge_pixels: Ints
    edge_samples: Singles
    tones: Singles
    apart: float
    weight: float


STANDARD = 400.0
KNOWN = np.empty((0, 0), np.bool_)  # no pixel is unknown


def raster_step(settings: TrackSettings, observation: Observation) -> int:
    """How many pixels of a frame apart those of the raster are: fewer where the person is farther than `USUAL`."""
    few = observation.depth[::8, ::8]
    there = few[np.isfinite(few)]
    away = float(there.mean()) if len(there) else USUAL
    return observation.camera.step_to(KINECT.fx / settings.raster * max(1.0, away / USUAL))


def evidence_of(observation: Observation, settings: TrackSettings, margin: float = MARGIN) -> Evidence | None:
    """The evidence in one frame; None when the person has no pixel.

    Parameters
    ----------
    observation : (H, W) m, the whole frame.
    settings : the raster, which pixels of it are samples, and which terms want edges and tones.
    margin : m, how far from the person's pixels a limb may be looked for.

    Returns
    -------
    On the pixels of the raster that are within the margin of the person's, h x w of them.
    """
    seen = observation.every(raster_step(settings, observation))
    box = _box(seen, margin)
    if box is None:
        return None
    top, bottom, left, right = box
    cam = seen.camera
    camera = Camera(right - left, bottom - top, cam.fx, cam.fy, cam.cx - left, cam.cy - top)
    # Copies, for a box as wide as the image is contiguous and would stay read-only: kernels are compiled for one kind.
    depth, free = seen.depth[top:bottom, left:right].copy(), seen.free[top:bottom, left:right].copy()
    tones = np.empty((0, 0), np.float32)
    if "color" in settings.terms and seen.intensity is not None:
        tones = seen.intensity[top:bottom, left:right].copy()
    numbers = intrinsics(camera)
    pixels, samples = listed(depth, numbers, settings.every)
    edge_pixels, edge_samples = np.empty((0, 2), np.int64), np.empty((0, 3), np.float32)
    if "edge" in settings.terms:
        unknown = ~free & np.isnan(depth)
        if seen.rim is not None:
            unknown &= ~seen.rim[top:bottom, left:right]
        edges = edges_of(depth, settings.canny, unknown)
        edge_pixels, edge_samples = listed(edges, numbers, settings.edge_every)
    weight = STANDARD / max(len(pixels), 1) if settings.evened else 1.0
    corners = (
        [(u - camera.cx) / camera.fx for u in (0, camera.width)],
        [(v - camera.cy) / camera.fy for v in (0, camera.height)],
    )
    widest = 1.0 + max(x * x for axis in corners for x in axis)
    apart = 1.0 / (max(camera.fx, camera.fy) * np.sqrt(widest))
    return Evidence(
        camera,
        numbers,
        depth,
        free,
        pixels,
        samples,
        edge_pixels,
        edge_samples,
        tones,
        apart,
        weight,
    )


def edges_of(depth: Singles, canny: bool, unknown: Bools = KNOWN, jump: float = JUMP) -> Singles:
    """(h, w) the depths on edges of a depth image, NaN elsewhere: near sides of steps, or Canny's edges.

    Parameters
    ----------
    depth : (h, w) m, NaN off the person.
    canny : which of the two; Canny's background pixels are moved to the foreground as in section 3.4.2.
    unknown : (h, w) True where NaN proves nothing; nowhere when not given.
    jump : m, the least step.
    """
    from ...kernels import rendered

    if not canny:
        edge = np.empty(depth.shape, np.float32)
        rendered.steps(depth, unknown, jump, edge)
        return edge
    import cv2

    on = np.isfinite(depth)
    if not on.any():
        return np.full(depth.shape, np.nan, np.float32)
    near, far = float(np.nanmin(depth)), float(np.nanmax(depth))
    # The background stands a metre behind the person: beyond any step on the body, yet within the range of a byte.
    scene = np.where(on, depth, np.float32(far + 1.0))
    scaled = np.clip((scene - near) * (255.0 / (far + 1.0 - near)), 0, 255).astype(np.uint8)
    step = 255.0 / (far + 1.0 - near) * jump
    sharp = cv2.Canny(scaled, 2.0 * step, 4.0 * step) > 0  # Sobel sums to four times a step
    return np.where(_to_foreground(sharp, on), depth, np.float32(np.nan))


def _to_foreground(edge: Bools, on: Bools) -> Bools:
    """Background pixels of an edge give way to their immediate foreground neighbours, if there are any (3.4.2)."""
    off = edge & ~on
    moved = np.zeros_like(edge)
    moved[1:] |= off[:-1]
    moved[:-1] |= off[1:]
    moved[:, 1:] |= off[:, :-1]
    moved[:, :-1] |= off[:, 1:]
    return np.asarray((edge | moved) & on)


def _box(seen: Observation, margin: float) -> tuple[int, int, int, int] | None:
    from ...kernels import regions

    box = np.empty(4, np.int64)
    nearest = regions.extent(seen.depth, box)
    top, bottom, left, right = box.tolist()
    if bottom < 0:
        return None
    wide = int(np.ceil(margin * seen.camera.fx / max(nearest, 0.3)))
    height, width = seen.depth.shape
    return max(0, top - wide), min(height, bottom + wide + 1), max(0, left - wide), min(width, right + wide + 1)


def listed(depth: Singles, intrinsics: Floats, every: int) -> tuple[Ints, Singles]:
    """Row and column (N, 2) and place (N, 3) in m of what is measured at every so-many-th row and column.

    Parameters
    ----------
    depth, intrinsics : (h, w) m, NaN = none, and (4,) of its camera. every : px.
    """
    from ...kernels import rendered

    most = -(-depth.shape[0] // every) * -(-depth.shape[1] // every)
    pixels, samples = np.empty((most, 2), np.int64), np.empty((most, 3), np.float32)
    count = rendered.listed(frozen(depth, np.float32), intrinsics, every, pixels, samples)
    return pixels[:count].copy(), samples[:count].copy()


def middle(points: Singles) -> Floats:
    """(n,) the median of each coordinate of points (N, n), N at least 1; sooner than numpy's for so few."""
    ranked = np.sort(points, axis=0)
    return np.asarray(0.5 * (ranked[(len(points) - 1) // 2].astype(np.float64) + ranked[len(points) // 2]))
