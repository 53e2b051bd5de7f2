"""UTD-MHAD skeletons: the first Kinect's 20 joints as `d_skel` (20, 3, T) in a MATLAB file, m, no states, no times.

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
    from scipy.io import loadmat

    try:
        content = loadmat(path, variable_names=["d_skel"])
    except FileNotFoundError:
        raise FileError(f"{path}: wanted {WANTED}, there is no such file; check the path") from None
    except Exception as why:  # scipy raises whatever a damaged file makes it stumble over
        raise FileError(f"{path}: wanted {WANTED}, cannot read it: {why}; get a complete copy") from None
    values = content.get("d_skel")
    if values is None or values.ndim != 3 or values.shape[:2] != (20, 3) or values.dtype.kind not in "fiu":
        came = "no d_skel" if values is None else f"d_skel {values.shape}"
        raise FileError(f"{path}: wanted {WANTED}, came {came}; depth is for `motionmend track`")
    positions = with_absent(np.moveaxis(values.astype(np.float64), 2, 0), None)
    times, guesses = even_times(len(positions), fps)
    return Postures(
        UTDMHAD20.names, positions, times, source=SensorSource("Kinect v1 joints (UTD-MHAD)"), guesses=guesses
    )


def variables_of(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of what a MATLAB file holds; none when it cannot be read."""
    from scipy.io import whosmat

    try:
        return tuple(name for name, _, _ in whosmat(path))
    except Exception:  # scipy raises whatever a damaged file makes it stumble over
        return ()
