"""A recording of a depth camera, of whatever source: one type, frames read one at a time."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from ..arrays import Bytes, Floats, Singles, frozen
from ..bodies.camera import Camera, DepthFrame

UP = ("top", "left", "bottom", "right")  # sides of an image, each a quarter turn clockwise short of the one before
_QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # clockwise: (x, y, z) becomes (-y, x, z)


@final
@dataclass(frozen=True, eq=False)
class DepthRecording:
    """T frames of one camera that stands still; a frame is read when it is asked for and not kept.

    Attributes
    ----------
    path : the folder or file.
    camera : intrinsics of the depth images.
    times : (T,) s.
    fps : Hz.
    depth_of : depth (H, W) m of a frame by its number, NaN = no return; raises FileError for a damaged image.
    color_of : color (H, W, 3) registered to the depth, from the frame's number and depth; None where there is none.
    has_color : whether any frame has colour.
    mirrored : whether the images are as in a mirror, as the first Kinect gives them by default: who faces the camera
        has the right hand at the right of the image.
    up : side of the images at which the room's ceiling is: a camera that lies on its side has it at the left or right.
    guesses : a sentence for all that the recording did not say.
    warnings : a sentence for all that it holds less of than it promises, or otherwise.
    """

    path: Path
    camera: Camera
    times: Floats
    fps: float
    depth_of: Callable[[int], Singles]
    color_of: Callable[[int, Singles], Bytes | None]
    has_color: bool = False
    mirrored: bool = False
    up: str = "top"
    guesses: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def axes(self) -> Floats:
        """(3, 3) what turns the axes of `true_frame` into those of the images, mirrored or on their side."""
        mirror = np.diag([-1.0 if self.mirrored else 1.0, 1.0, 1.0])
        return frozen(mirror @ np.linalg.matrix_power(_QUARTER, self._turns).T)

    @property
    def _turns(self) -> int:
        """Quarter turns clockwise that bring the ceiling to the top, once a mirrored image is turned round."""
        side = UP.index(self.up)
        return (4 - side) % 4 if self.mirrored else side  # left and right are changed over then

    @property
    def frames(self) -> int:
        """T, the number of frames."""
        return len(self.times)

    def frame(self, number: int) -> DepthFrame:
        """The frame of this number, from 0.

        Raises
        ------
        FileError : its image is damaged.
        """
        depth = self.depth_of(number)
        return DepthFrame(self.camera, depth, self.color_of(number, depth), float(self.times[number]))

    def true_frame(self, number: int) -> DepthFrame:
        """The frame as an upright camera sees it, a mirrored one turned round: left is left, and up is up."""
        frame = self.frame(number)
        frame = turned_round(frame) if self.mirrored else frame
        for _ in range(self._turns):
            frame = quarter_turned(frame)
        return frame

    def __iter__(self) -> Iterator[DepthFrame]:
        return (self.frame(number) for number in range(self.frames))


def without_color(recording: DepthRecording) -> DepthRecording:
    """The recording with its colour images left unread, for who does not look at them: a damaged one costs nothing."""
    return replace(recording, color_of=lambda number, depth: None)


def turned_round(frame: DepthFrame) -> DepthFrame:
    """The frame with left and right of the image changed over; a point (x, y, z) of it becomes (-x, y, z)."""
    camera = frame.camera
    flipped = replace(camera, cx=camera.width - 1 - camera.cx)
    color = None if frame.color is None else np.ascontiguousarray(frame.color[:, ::-1])
    return DepthFrame(flipped, np.ascontiguousarray(frame.depth[:, ::-1]), color, frame.time)


def quarter_turned(frame: DepthFrame) -> DepthFrame:
    """The frame turned clockwise, its left at the top; a point (x, y, z) of it becomes (-y, x, z)."""
    camera = frame.camera
    turned = Camera(camera.height, camera.width, camera.fy, camera.fx, camera.height - 1 - camera.cy, camera.cx)
    color = None if frame.color is None else np.ascontiguousarray(np.rot90(frame.color, -1))
    return DepthFrame(turned, np.ascontiguousarray(np.rot90(frame.depth, -1)), color, frame.time)
