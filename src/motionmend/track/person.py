"""The person in a frame: all that is measured where the room was taken away, else what `foreground` tells apart."""

import numpy as np

from ..arrays import Floats
from ..bodies.camera import DepthFrame
from .foreground import LARGEST, SMALLEST, Foreground, Scene, clean, find_person, remember

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
    if not len(scene.planes):
        measured = np.isfinite(frame.depth)
        z = frame.depth[measured]
        area = float((z.astype(np.float64) ** 2).sum()) / (frame.camera.fx * frame.camera.fy)
        if SMALLEST < area < LARGEST:
            return _all_of_it(frame, median), scene
    person = find_person(scene, frame, last, median)
    return person, remember(scene, frame, person)


def _all_of_it(frame: DepthFrame, median: int) -> Foreground:
    import cv2

    depth = clean(frame.depth, median)
    on = np.isfinite(depth)
    free = cv2.morphologyEx(on.view(np.uint8), cv2.MORPH_CLOSE, np.ones((CLOSING, CLOSING), np.uint8)) == 0
    rows, columns = np.nonzero(on[::4, ::4])
    if not len(rows):
        return Foreground(depth, False, np.full(3, np.nan), 0.0, free)
    z = depth[::4, ::4][rows, columns].astype(np.float64)
    points = frame.camera.every(4).unproject(np.column_stack((columns, rows)), z)
    border = on[0].sum() + on[-1].sum() + on[:, 0].sum() + on[:, -1].sum()
    return Foreground(depth, True, np.median(points, axis=0), float(border / np.sqrt(on.sum())), free)
