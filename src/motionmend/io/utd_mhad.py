"""Depth images of UTD-MHAD: a MATLAB file per clip, the background removed.

C. Chen, R. Jafari, N. Kehtarnavaz, "UTD-MHAD: A multimodal dataset for human action recognition utilizing a depth
camera and a wearable inertial sensor", ICIP 2015. `d_depth` is uint16 (240, 320, T) in mm, 0 = no return. The images
are mirrored: in clips of the right arm (swipes, throws) it is the arm at the image's right that moves.
"""

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Singles
from ..bodies.camera import KINECT
from ..errors import FileError
from .depth_recording import DepthRecording

_VARIABLE = "d_depth"
_WANTED = "a depth clip of UTD-MHAD"
_FPS = 30.0  # Hz, the first Kinect's
_METRES = 0.001  # of one unit


def read_utd_depth(path: str | os.PathLike[str]) -> DepthRecording:
    """Read a `*_depth.mat` of UTD-MHAD.

    Parameters
    ----------
    path : the file.

    Returns
    -------
    recording : depth of a first Kinect with nominal intrinsics at 30 Hz; no colour.

    Raises
    ------
    FileError : not there, no MATLAB file, damaged, or without `d_depth` of the right shape and type.
    """
    name = str(path)
    volume = _volume(Path(path), name)
    if volume.ndim == 2:  # MATLAB drops a last dimension of one
        volume = volume[:, :, None]
    if volume.ndim != 3 or not volume.shape[2]:
        raise FileError(f"{name}: wanted {_VARIABLE} of {KINECT.height} x {KINECT.width} x frames, came {volume.shape}")
    if volume.shape[:2] != (KINECT.height, KINECT.width):
        raise FileError(
            f"{name}: wanted images of {KINECT.width} x {KINECT.height} pixels, which the nominal intrinsics are for, "
            f"came {volume.shape[1]} x {volume.shape[0]}"
        )
    if volume.dtype.kind not in "ui" and not np.array_equal(volume, np.round(volume)):
        raise FileError(f"{name}: wanted {_VARIABLE} in whole millimetres, came {volume.dtype}")
    if volume.min() < 0 or volume.max() > np.iinfo(np.uint16).max:
        raise FileError(f"{name}: wanted {_VARIABLE} from 0 to 65535 mm, it goes from {volume.min()} to {volume.max()}")
    images = np.ascontiguousarray(np.moveaxis(volume, 2, 0), dtype=np.uint16)

    def depth_of(number: int) -> Singles:
        raw = images[number]
        return np.where(raw > 0, raw * np.float32(_METRES), np.float32(np.nan)).astype(np.float32)

    guess = (
        f"took the first Kinect's nominal intrinsics (f {KINECT.fx:g}, centre {KINECT.cx:g} {KINECT.cy:g}) and "
        f"{_FPS:g} Hz, the file states none"
    )
    return DepthRecording(
        Path(path),
        KINECT,
        np.arange(len(images)) / _FPS,
        _FPS,
        depth_of,
        lambda number, depth: None,
        mirrored=True,
        guesses=(guess,),
    )


def _volume(path: Path, name: str) -> np.ndarray[Any, Any]:
    from .mat5 import MatError, variables

    try:
        held = next((one for one in variables(path) if one.name == _VARIABLE), None)
        if held is None:
            raise FileError(f"{name}: wanted {_WANTED}, there is no {_VARIABLE} in it; give the *_depth.mat")
        if not held.numeric or 0 in held.shape:
            raise FileError(f"{name}: wanted {_VARIABLE} as numbers, came {held.kind} {held.shape}")
        return held.numbers()
    except OSError as failure:
        raise FileError(f"{name}: wanted {_WANTED}, cannot open it: {failure.strerror}; check the path") from None
    except MatError as why:
        raise FileError(f"{name}: wanted {_WANTED}, cannot read it: {why}") from None
