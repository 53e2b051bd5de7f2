"""The person in a frame: all that is measured where the room was taken away, else what `foreground` tells apart."""

import numpy as np

from ..arrays import Floats
from ..bodies.camera import DepthFrame
from ..bodies.surface import intrinsics
from .evidence import listed, middle
from .foreground import Foreground, Scene, find_person, mended, remember
from .surfaces import LARGEST, SMALLEST, about

CLOSING = 5  # px; dropout inside the person is narrower


def person_of(scene: Scene, frame: DepthFrame, last: Floats | None, median: int) -> tuple[Foreground, Scene]:
    """The person in a frame, and the scene with what the frame taught of it.

    Parameters
    ----------
    scene : as known so far. last : (3,) m, where the person was, if known. median : radius of the filter, px.

    Notes
    -----
    A recording without background has no floor or wall, and no more in it than one body: then nothing need be, and
    nothing is, told apart, so that limbs before and behind each other are never taken for something else.
    """
    if not len(scene.planes) and not np.isfinite(scene.background).any():
        from ..kernels import regions

        box = np.empty(4, np.int64)
        area = regions.extent(frame.depth, box)
        if SMALLEST < area / (frame.camera.fx * frame.camera.fy) < LARGEST:
            return _all_of_it(frame, median, about(box, frame.depth.shape, CLOSING + median)), scene
    person = find_person(scene, frame, last, median)
    return person, remember(scene, frame, person)


def _all_of_it(frame: DepthFrame, median: int, box: tuple[slice, slice]) -> Foreground:
    """What is measured, cleaned; `box` holds all of it and a margin wide enough for the clean-up."""
    import cv2

    depth, free = np.full(frame.depth.shape, np.nan, np.float32), np.ones(frame.depth.shape, np.bool_)
    part = mended(frame.depth[box], median)
    on = np.isfinite(part)
    depth[box] = part
    free[box] = cv2.morphologyEx(on.view(np.uint8), cv2.MORPH_CLOSE, np.ones((CLOSING, CLOSING), np.uint8)) == 0
    points = listed(depth, intrinsics(frame.camera), 4)[1]
    if not len(points):
        return Foreground(depth, False, np.full(3, np.nan), free)
    return Foreground(depth, True, middle(points), free)
