"""The axes of sensors, of the page and of Unity."""

import numpy as np

from ..arrays import Floats, frozen

# Rows: the page's right, forward (away from who looks) and up in the sensor's axes; who looks stands at the sensor.
_KINECT = frozen([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # x to the sensor's left, y up, z away
_CAMERA = frozen([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # x right, y down, z away
_FACING = frozen([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # x right, y up, z toward the sensor

_OF_SKELETON = {"azure32": _CAMERA, "tracker16": _CAMERA, "uiprmd22": _FACING, "mediapipe33": _FACING}

UNITY_FROM_PAGE = frozen(
    [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
)  # left-handed; an avatar that looks at who looks: +z


def page_from_sensor(skeleton: str) -> Floats:
    """(3, 3) rotation from a sensor's axes to right, forward, up, all seen from the sensor.

    Parameters
    ----------
    skeleton : key of a joint set. Those not known have the axes of the Kinects.
    """
    return _OF_SKELETON.get(skeleton, _KINECT)


def unity_from_sensor(skeleton: str) -> Floats:
    """(3, 3) from a sensor's right-handed axes to Unity's left-handed ones (x right, y up, z forward).

    Somebody who faces the sensor looks along +z, the own right along +x: as an avatar does that has not moved.
    """
    return frozen(UNITY_FROM_PAGE @ page_from_sensor(skeleton))


def turned_up(rise: Floats) -> Floats:
    """(3, 3) the turn of whole axes that takes the one nearest to `rise` (3,) to +y.

    Of the half turns that take -y there the one that leaves z: where y points down, z mostly is a camera's depth.
    """
    axis = int(np.argmax(np.abs(rise)))
    up = np.sign(rise[axis])
    if axis == 1:
        return np.diag([up, up, 1.0])
    turn = np.eye(3)
    turn[[1, axis]] = 0.0
    turn[1, axis], turn[axis, 1] = up, -up
    return turn
