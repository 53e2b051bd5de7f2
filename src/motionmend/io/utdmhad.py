"""UTD-MHAD skeletons: the first Kinect's 20 joints as `d_skel` (20, 3, T) in a MATLAB file, m, no states, no times.

MATLAB leaves out the last axis of a single frame. Other programs turn the axes about when they write one.

Chen, Jafari, Kehtarnavaz: UTD-MHAD, ICIP 2015.
"""

import os

import numpy as np

from ..bodies.joint_sets import UTDMHAD20
from ..bodies.postures import Postures
from ..errors import FileError
from .sensor_source import SensorSource, even_times, with_absent

WANTED = "a UTD-MHAD skeleton with d_skel (20, 3, frames)"


def read_utdmhad(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read a skeleton.

    Parameters
    ----------
    path : the .mat.
    fps : Hz; 30 when not given.

    Raises
    ------
    FileError : not there, damaged, or without a skeleton.
    """
    from .mat5 import MatError, variables

    try:
        held = next((one for one in variables(path) if one.name == "d_skel"), None)
        axes = None if held is None else _frames_first(held.shape)
        if held is None or axes is None or not held.numeric:
            came = "no d_skel" if held is None else f"d_skel {held.shape} of {held.kind}"
            raise FileError(f"{path}: wanted {WANTED}, came {came}; check the file")
        values = held.numbers()
    except OSError as error:
        what = "there is no such file" if isinstance(error, FileNotFoundError) else f"cannot open it: {error.strerror}"
        raise FileError(f"{path}: wanted {WANTED}, {what}; check the path") from None
    except MatError as why:
        raise FileError(f"{path}: wanted {WANTED}, cannot read it: {why}") from None
    positions, nowhere = with_absent(np.atleast_3d(values).transpose(axes).astype(np.float64), None)
    times, guesses = even_times(len(positions), fps)
    source = SensorSource("Kinect v1 joints (UTD-MHAD)")
    return Postures(UTDMHAD20.names, positions, times, source=source, guesses=guesses, warnings=nowhere)


def _frames_first(shape: tuple[int, ...]) -> tuple[int, int, int] | None:
    """Which axes of an array of this shape are frames, joints and coordinates; None where no three are."""
    joints, shape = len(UTDMHAD20.names), (*shape, 1) if len(shape) == 2 else shape
    orders = ((2, 0, 1), (0, 1, 2), (2, 1, 0), (0, 2, 1), (1, 0, 2), (1, 2, 0))  # the data set's first
    return next((one for one in orders if len(shape) == 3 and (shape[one[1]], shape[one[2]]) == (joints, 3)), None)


def variables_of(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of what a MATLAB file holds; none when it cannot be read."""
    from .mat5 import MatError, variables

    try:
        return tuple(one.name for one in variables(path))
    except (OSError, MatError):
        return ()
