"""Furniture told from people before anybody is followed: it keeps its place for a whole recording; somebody does not.

A box that is nearer and larger than the person looks more like somebody than they do, from the first frame to the last.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Bools, Floats, Singles
from ..bodies.camera import DepthFrame
from ..bodies.surface import intrinsics
from .fineness import evened
from .room import NOISE_NEAR, NOISE_STEEP, Scene, scene_of
from .surfaces import most_like_a_body, surfaces_of

LOOKED_AT = 24  # frames of a recording, spread over all of it
SEEN, SAME = 0.5, 0.9  # share of them in which a pixel is measured, and of those in which it is the same
STILL = 0.98  # share of such pixels in a piece of furniture; dropout and noise are at its rim
RIM = 2  # px
LEAVES = 0.2  # m, nearer than what is seen behind them later is somebody who moves
SOMEBODY = 0.1  # m^2 of that at once: a fifth of a body
MOST = 12  # pieces


def with_furniture(frames: Sequence[DepthFrame]) -> Scene | None:
    """The room of a recording with the furniture in it that looks like a body and never moves, while somebody does.

    Parameters
    ----------
    frames : some of all of a recording, the first one first.

    Returns
    -------
    The scene before the first frame. None where nobody moves, or no such furniture is: then nothing is known.
    """
    import cv2

    from ..kernels import scene as kernels

    even = [evened(frame) for frame in frames]
    if len(even) < 3 or len({frame.depth.shape for frame in even}) > 1:
        return None
    first = even[0]
    middle, still, leaving = _stays(np.stack([frame.depth for frame in even]), first.camera.fx * first.camera.fy)
    if leaving < SOMEBODY:
        return None
    scene = None
    room = scene_of(first)
    numbers, depth = intrinsics(first.camera), np.ascontiguousarray(first.depth, np.float32)
    window = np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)
    for _ in range(MOST):
        before = np.empty(depth.shape, np.bool_)
        kernels.before_scene(depth, numbers, room.planes, room.background, NOISE_NEAR, NOISE_STEEP, before)
        seen = surfaces_of(room, depth, before, numbers)
        main = most_like_a_body(seen, False, np.zeros(len(seen.measures), np.bool_), None)
        if main < 0:
            break
        mask = seen.pixels_of([main])
        inner = cv2.erode(mask.view(np.uint8), window) > 0
        if not inner.any() or still[inner].mean() < STILL:
            break
        nearest = cv2.erode(np.where(mask & np.isfinite(middle), middle, np.float32(np.inf)), window)
        background = np.where(np.isfinite(nearest), nearest, room.background)
        room = scene = replace(room, background=background)
    return scene


def _stays(depths: Singles, focal: float) -> tuple[Singles, Bools, float]:
    """The middle of what is measured (H, W) m, where it is always the same, and m² of somebody who moves, at most.

    Parameters
    ----------
    depths : (N, H, W) m, NaN = no return.
    focal : px², product of both focal lengths.
    """
    import cv2

    ordered = np.sort(depths, axis=0)  # what is not measured comes last
    count = np.isfinite(depths).sum(axis=0)
    at: Floats = np.maximum(count - 1, 0)
    middle = np.take_along_axis(ordered, (at // 2)[None], axis=0)[0]
    farthest = np.take_along_axis(ordered, at[None], axis=0)[0]
    noise = NOISE_NEAR + NOISE_STEEP * np.square(middle)
    same = (np.abs(depths - middle) < noise).sum(axis=0)
    still = (count >= SEEN * len(depths)) & (same >= SAME * count)
    leaving = 0.0
    for depth in depths:
        moves = np.isfinite(depth) & (depth < farthest - LEAVES) & ~still
        moves = cv2.morphologyEx(moves.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
        leaving = max(leaving, float(np.square(depth[moves], dtype=np.float64).sum()) / focal)
    return middle, still, leaving
