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

_NUMBERS = ("double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))
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
    from scipy.io import loadmat, whosmat

    try:
        held = {name: (shape, kind) for name, shape, kind in whosmat(path)}
        shape, kind = held.get("d_skel", ((), ""))
        axes = _frames_first(shape) if kind in _NUMBERS else None
        if axes is None:  # unread: of what is damaged, cells above all, scipy reads beyond the end of memory
            came = f"d_skel {shape} of {kind}" if kind else "no d_skel"
            raise FileError(f"{path}: wanted {WANTED}, came {came}; check the file")
        values = loadmat(path, variable_names=["d_skel"])["d_skel"]
    except FileError:
        raise
    except FileNotFoundError:
        raise FileError(f"{path}: wanted {WANTED}, there is no such file; check the path") from None
    except Exception as why:  # scipy raises whatever a damaged file makes it stumble over
        raise FileError(f"{path}: wanted {WANTED}, cannot read it: {why}; get a complete copy") from None
    if np.iscomplexobj(values) or values.shape != shape:
        raise FileError(f"{path}: wanted {WANTED}, came {values.shape} of {values.dtype}; get a complete copy")
    positions = with_absent(np.atleast_3d(values).transpose(axes).astype(np.float64), None)
    times, guesses = even_times(len(positions), fps)
    return Postures(
        UTDMHAD20.names, positions, times, source=SensorSource("Kinect v1 joints (UTD-MHAD)"), guesses=guesses
    )


def _frames_first(shape: tuple[int, ...]) -> tuple[int, int, int] | None:
    """Which axes of an array of this shape are frames, joints and coordinates; None where no three are."""
    joints, shape = len(UTDMHAD20.names), (*shape, 1) if len(shape) == 2 else shape
    orders = ((2, 0, 1), (0, 1, 2), (2, 1, 0), (0, 2, 1), (1, 0, 2), (1, 2, 0))  # the data set's first
    return next((one for one in orders if len(shape) == 3 and (shape[one[1]], shape[one[2]]) == (joints, 3)), None)


def variables_of(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of what a MATLAB file holds; none when it cannot be read."""
    from scipy.io import whosmat

    try:
        return tuple(name for name, _, _ in whosmat(path))
    except Exception:  # scipy raises whatever a damaged file makes it stumble over
        return ()
