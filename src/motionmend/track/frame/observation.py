"""What the tracker looks at: one cleaned frame in which every pixel is person, free or unknown."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Bools, Bytes, Singles, frozen
from ...bodies.camera import Camera
from ...errors import MismatchError


@final
@dataclass(frozen=True, eq=False)
class Observation:
    """One frame after clean-up and segmentation (section 3.3.1). Camera axes: x right, y down, z forward.

    Attributes
    ----------
    camera : of the images below.
    depth : (H, W) m along z where the person is, NaN elsewhere.
    free : (H, W) True where the person surely is not: the scene behind is seen, or nothing is in range. A pixel
        that is neither person nor free is unknown (dropout, something in front) and has no influence at all.
    time : s.
    intensity : (H, W) 0 to 255, registered to depth; None without colour.
    rim : (H, W) True where the person ends though nothing is measured (`Foreground.rim`); None = nowhere.
    """

    camera: Camera
    depth: Singles
    free: Bools
    time: float
    intensity: Singles | None = None
    rim: Bools | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width)
        object.__setattr__(self, "depth", frozen(self.depth, np.float32))
        object.__setattr__(self, "free", frozen(self.free, np.bool_))
        if self.intensity is not None:
            object.__setattr__(self, "intensity", frozen(self.intensity, np.float32))
        if self.rim is not None:
            object.__setattr__(self, "rim", frozen(self.rim, np.bool_))
        for image in (self.depth, self.free, self.intensity, self.rim):
            if image is not None and image.shape != shape:
                raise MismatchError(f"an image of {shape} pixels was wanted, came {image.shape}")

    def __reduce__(self) -> tuple[object, ...]:
        """To another process only the box that the person is in goes, and what is true or false as bits."""
        there = np.isfinite(self.depth)
        rows, columns = (np.flatnonzero(there.any(axis=axis)) for axis in (1, 0))
        box = slice(0), slice(0)
        if len(rows):
            box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
        bits = [None if image is None else np.packbits(image) for image in (self.free, self.rim)]
        return _unpacked, (self.camera, box, self.depth[box], *bits, self.time, self.intensity)

    @property
    def pixels(self) -> int:
        """How many pixels show the person."""
        return int(np.count_nonzero(np.isfinite(self.depth)))

    def as_fine_as(self, focal: float) -> "Observation":
        """As coarse as `every` has it for a focal length of about `focal` px (`Camera.step_to`), or as it is."""
        return self.every(self.camera.step_to(focal))

    def every(self, step: int) -> "Observation":
        """Every `step`-th pixel of every `step`-th row, with the camera that would have taken it."""
        if step == 1:
            return self
        depth, free = self.depth[::step, ::step], self.free[::step, ::step]
        intensity = None if self.intensity is None else self.intensity[::step, ::step]
        rim = None if self.rim is None else self.rim[::step, ::step]
        return Observation(self.camera.every(step), depth, free, self.time, intensity, rim)


def _unpacked(
    camera: Camera,
    box: tuple[slice, slice],
    depth: Singles,
    free: Bytes,
    rim: Bytes | None,
    time: float,
    intensity: Singles | None,
) -> Observation:
    """What `Observation.__reduce__` packed."""
    shape = (camera.height, camera.width)
    whole = np.full(shape, np.nan, np.float32)
    whole[box] = depth
    bits = [
        None if packed is None else np.unpackbits(packed, count=whole.size).reshape(shape).astype(bool)
        for packed in (free, rim)
    ]
    assert bits[0] is not None
    return Observation(camera, whole, bits[0], time, intensity, bits[1])
