"""Frames of any camera about as fine as the first Kinect's of 320 x 240: how many pixels a limb has is what counts.

That depends on the focal length, in pixels, and not on how wide the image is: a wide lens has fewer on a body. Pixels
in which a camera blends what is before an edge with what is behind it are none of either.
"""

from dataclasses import replace

import numpy as np

from ...arrays import Singles, frozen
from ...bodies.camera import KINECT, Camera, DepthFrame
from .surfaces import JUMP_NEAR, JUMP_STEEP

BRIDGE = 6  # leaps of depth from pixel to pixel; in no more than these one surface goes over into another


def evened(frame: DepthFrame) -> DepthFrame:
    """The frame with one pixel for each block of n x n of its own, n being what makes it about as fine as `KINECT`.

    A block's depth is the mean of what is measured on its nearer surface, for of pixels that nobody looks at the noise
    is not averaged out. Its place is the block's middle. What lies between two surfaces and is neither counts as no
    return: time of flight has such flying pixels at edges, and a phone, whose images are finer than its laser, bridges
    all of them; the body would be that much wider.

    Parameters
    ----------
    frame : of any camera, depth (H, W) m; 0, less and infinity are no distances and count as no return, like NaN.

    Returns
    -------
    Of ceil(H / n) x ceil(W / n) pixels; the frame itself where there is nothing to do, and so for one that was evened.
    """
    none = (frame.depth <= 0.0) | np.isinf(frame.depth)
    if none.any():
        frame = replace(frame, depth=np.where(none, np.float32(np.nan), frame.depth))
    camera = frame.camera
    step = camera.step_to(KINECT.fx)
    if step == 1:
        parted = _parted(frame.depth)
        return frame if parted is frame.depth else replace(frame, depth=parted)
    import cv2

    from ...kernels import regions

    few = camera.every(step)
    depth = np.empty((few.height, few.width), np.float32)
    regions.blocks(frame.depth.copy(), step, JUMP_NEAR, JUMP_STEEP, depth)
    color = None
    if frame.color is not None:
        beside = cv2.boxFilter(frame.color, -1, (step, step), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
        color = np.asarray(beside[::step, ::step], np.uint8)
    middle = (step - 1) / (2.0 * step)
    seen_by = Camera(few.width, few.height, few.fx, few.fy, few.cx - middle, few.cy - middle)
    return DepthFrame(seen_by, _parted(depth), color, frame.time)


def _parted(depth: Singles) -> Singles:
    """The image without what lies between two surfaces and is neither; itself where nothing does."""
    from ...kernels import regions

    between = np.empty(depth.shape, np.bool_)
    # Twice a jump: the last pixel of a limb, which turns away there, is one jump from the next and no blend.
    if not regions.bridges(frozen(depth, np.float32), 2 * JUMP_NEAR, 2 * JUMP_STEEP, BRIDGE, between):
        return depth
    return np.where(between, np.float32(np.nan), depth)
