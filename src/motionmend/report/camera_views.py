"""What a depth camera saw and where the joints were put: from the camera, and from the side."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bools, Floats, Ints, Singles
from ..bodies.camera import DepthFrame
from .style import COLOURS

Image = NDArray[np.uint8]
Pose = tuple[Floats, Ints, Floats | None]
"""Joints (J, 3) m in camera axes, their parents (J,), and standard deviations (J,) m or None."""

TALL = 360  # px, of a picture
_MARGIN = 0.25  # m around the person
_STEP = 0.06  # m; neighbours that differ by more are an edge
_PAPER, _EDGE, _DOTS = (255, 255, 255), (230, 120, 0), (120, 126, 134)
_UNSURE = 0.10  # m


def camera_view(frame: DepthFrame, poses: Sequence[Pose]) -> bytes:
    """A PNG of one frame: depth with its edges and the poses drawn over it, and both again from the side.

    Parameters
    ----------
    frame : its depth is shown around the poses; all of it when there is none.
    poses : drawn in the colours of the page's recordings, in order. Joints with 0.10 m or more are drawn hollow.

    Returns
    -------
    PNG, 360 px high; the same input gives the same bytes.
    """
    import cv2

    box = _box(frame, poses)
    front = _front(frame, poses, box)
    side = _side(frame, poses, box)
    gap = np.full((TALL, 8, 3), 255, np.uint8)
    parts = [front, gap, side]
    if frame.color is not None:
        top, bottom, left, right = box[1]
        wide = max(1, round(TALL * (right - left) / (bottom - top)))
        crop = np.ascontiguousarray(frame.color[top:bottom, left:right])
        parts = [cv2.resize(crop, (wide, TALL), interpolation=cv2.INTER_AREA).astype(np.uint8), gap, *parts]
    fine, packed = cv2.imencode(".png", np.ascontiguousarray(np.concatenate(parts, axis=1)[:, :, ::-1]))
    assert fine
    return bytes(packed.tobytes())


def edges(depth: Singles) -> Bools:
    """(H, W) True on the near side of a step in depth, and along the outline."""
    far = np.where(np.isfinite(depth), depth, np.float32(1e3))
    found = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        step = np.diff(far, axis=axis)
        before: list[Any] = [slice(None), slice(None)]
        after: list[Any] = [slice(None), slice(None)]
        before[axis], after[axis] = slice(None, -1), slice(1, None)
        found[tuple(before)] |= step > _STEP
        found[tuple(after)] |= step < -_STEP
    return np.asarray(found & np.isfinite(depth))


Box = tuple[Floats, tuple[int, int, int, int]]
"""Lower and upper corner (2, 3) m in camera axes, and the rows and columns that show it."""


def _box(frame: DepthFrame, poses: Sequence[Pose]) -> Box:
    """What is looked at: around the joints, or around all of the depth."""
    points = np.concatenate([joints for joints, _, _ in poses]) if poses else np.empty((0, 3))
    points = points[np.isfinite(points).all(axis=1) & (points[:, 2] > 0.1)] if len(points) else points
    if not len(points):
        cloud = frame.camera.points(frame.depth).reshape(-1, 3)
        points = cloud[np.isfinite(cloud).all(axis=1)][::7]
    height, width = frame.depth.shape
    if not len(points):
        return np.array([[-1.0, -1.0, 1.0], [1.0, 1.0, 3.0]]), (0, height, 0, width)
    low, high = np.percentile(points, 1, axis=0) - _MARGIN, np.percentile(points, 99, axis=0) + _MARGIN
    corners = np.array([[x, y, max(low[2], 0.3)] for x in (low[0], high[0]) for y in (low[1], high[1])])
    pixel = frame.camera.project(corners)
    left, top = np.floor(pixel.min(axis=0)).astype(int)
    right, bottom = np.ceil(pixel.max(axis=0)).astype(int)
    top, bottom = int(np.clip(top, 0, height - 8)), int(np.clip(bottom, 8, height))
    left, right = int(np.clip(left, 0, width - 8)), int(np.clip(right, 8, width))
    bottom, right = max(bottom, top + 8), max(right, left + 8)
    return np.array([low, high]), (top, min(bottom, height), left, min(right, width))


def _front(frame: DepthFrame, poses: Sequence[Pose], box: Box) -> Image:
    """Seen from the camera."""
    import cv2

    (low, high), (top, bottom, left, right) = box
    depth = frame.depth[top:bottom, left:right]
    there: Bools = np.isfinite(depth)
    shade = np.clip((np.nan_to_num(depth, nan=high[2]) - low[2]) / max(high[2] - low[2], 1e-3), 0.0, 1.0)
    grey = (70 + 150 * shade).astype(np.uint8)
    image = np.where(there[..., None], grey[..., None], np.uint8(255)).repeat(3, axis=2)[..., :3]
    image[edges(depth)] = _EDGE
    scale = TALL / (bottom - top)
    wide = max(1, round(scale * (right - left)))
    picture: Image = cv2.resize(image, (wide, TALL), interpolation=cv2.INTER_NEAREST).astype(np.uint8)
    for number, (joints, above, std) in enumerate(poses):
        pixel = (frame.camera.project(joints) - (left, top) + 0.5) * scale
        _drawn(picture, pixel, above, std, number)
    return picture


def _side(frame: DepthFrame, poses: Sequence[Pose], box: Box) -> Image:
    """Seen from the camera's right: depth goes to the right of the picture, up is up."""
    (low, high), (top, bottom, left, right) = box
    scale = TALL / (high[1] - low[1])
    wide = int(np.clip(round(scale * (high[2] - low[2])), 80, 2 * TALL))
    picture: Image = np.full((TALL, wide, 3), _PAPER, np.uint8)
    window = np.full(frame.depth.shape, np.nan, np.float32)
    window[top:bottom, left:right] = frame.depth[top:bottom, left:right]
    cloud = frame.camera.points(window).reshape(-1, 3)
    cloud = cloud[np.flatnonzero(np.isfinite(cloud).all(axis=1))]
    at = np.rint((cloud[:, [2, 1]] - low[[2, 1]]) * scale).astype(int)
    at = at[np.flatnonzero(((at >= 0) & (at < (wide, TALL))).all(axis=1))]
    picture[at[:, 1], at[:, 0]] = _DOTS
    for number, (joints, above, std) in enumerate(poses):
        _drawn(picture, (joints[:, [2, 1]] - low[[2, 1]]) * scale, above, std, number)
    return picture


def _drawn(picture: Image, pixel: Floats, above: Ints, std: Floats | None, number: int) -> None:
    """Bones and joints of one pose, in place."""
    import cv2

    code = COLOURS[number % len(COLOURS)].lstrip("#")
    colour = tuple(int(code[k : k + 2], 16) for k in (0, 2, 4))
    there = np.asarray(np.isfinite(pixel).all(axis=1) & (np.abs(pixel) < 1e4).all(axis=1))
    at = np.rint(np.where(there[:, None], pixel, 0.0)).astype(int)
    for joint, parent in enumerate(above):
        if parent >= 0 and there[joint] and there[parent]:
            cv2.line(picture, at[joint].tolist(), at[int(parent)].tolist(), colour, 2, cv2.LINE_AA)
    for joint in np.flatnonzero(there).tolist():
        unsure = std is not None and not std[joint] < _UNSURE
        cv2.circle(picture, at[joint].tolist(), 4, colour, 1 if unsure else -1, cv2.LINE_AA)
