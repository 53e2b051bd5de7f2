"""Images of a lens that bends straight lines, made those of a pinhole camera.

A point whose pinhole pixel is u = fx·x + cx, v = fy·y + cy is seen elsewhere: the radial and tangential model of Brown
(1966) with OpenCV's order of coefficients, k1 k2 p1 p2 [k3 [k4 k5 k6]], which cameras' own software reports.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bytes, Singles, frozen
from ..bodies.camera import Camera
from ..errors import MismatchError

COUNTS = (4, 5, 8)


@final
@dataclass(frozen=True, eq=False)
class Lens:
    """Where the pixels of a pinhole camera are found in a bent image: `columns`, `rows` (H, W) px."""

    columns: Singles
    rows: Singles

    def straight_depth(self, depth: Singles) -> Singles:
        """The depth image (H, W) m without the bend: the nearest pixel's, for between two surfaces there is nothing."""
        import cv2

        return np.asarray(
            cv2.remap(depth, self.columns, self.rows, cv2.INTER_NEAREST, borderValue=float("nan")), np.float32
        )

    def straight_color(self, color: Bytes) -> Bytes:
        """The colour image (H, W, 3) without the bend, black beyond its border."""
        import cv2

        return np.asarray(cv2.remap(color, self.columns, self.rows, cv2.INTER_LINEAR), np.uint8)


def lens_of(camera: Camera, coefficients: Sequence[float]) -> Lens:
    """The lens before a camera.

    Parameters
    ----------
    camera : its pinhole intrinsics. coefficients : k1 k2 p1 p2 [k3 [k4 k5 k6]].

    Raises
    ------
    MismatchError : another number of coefficients, or one that is not finite.
    """
    import cv2

    bend = np.asarray(coefficients, dtype=np.float64)
    if bend.ndim != 1 or len(bend) not in COUNTS or not np.isfinite(bend).all():
        raise MismatchError("a lens needs 4, 5 or 8 finite numbers, k1 k2 p1 p2 [k3 [k4 k5 k6]]")
    matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    size = camera.width, camera.height
    columns, rows = cv2.initUndistortRectifyMap(matrix, bend, np.eye(3), matrix, size, cv2.CV_32FC1)
    return Lens(frozen(columns, np.float32), frozen(rows, np.float32))
