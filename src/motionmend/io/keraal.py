"""Keraal: exercises recorded by a second Kinect and by optical rigid bodies at once, as rows of numbers.

Kinect: 25 joints, each x y z (m) and a quaternion, about 30 rows a second. Optical: 17 rigid bodies, each x y z (mm)
and a quaternion, about 60 rows a second. No titles, no times, no states. Nguyen et al. 2024, the Keraal data set.
"""

import os
from dataclasses import replace

from ..bodies.joint_sets import KINECT25
from ..bodies.postures import Postures
from ..errors import FileError
from .number_rows import read_number_rows
from .sensor_source import SensorSource, even_times, with_absent

WANTED = "Keraal's Kinect joints, 175 numbers a row"
WANTED_BODIES = "Keraal's rigid bodies, 119 numbers a row"
BODY_FPS = 60.0
# A rigid body at the middle of a segment is no joint: its name says so, and nothing takes it for one.
BODIES = [
    "RForearm segment",
    "LForearm segment",
    "RArm segment",
    "LArm segment",
    "Chest",
    "RThigh segment",
    "LThigh segment",
    "RShoulder",
    "LShoulder",
    "RHand",
    "LHand",
    "RFoot",
    "LFoot",
    "Hips",
    "Head",
    "RTibia segment",
    "LTibia segment",
]
_EACH = 7  # numbers of a joint or a body


def read_keraal(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read the Kinect's joints.

    Parameters
    ----------
    path : the .txt.
    fps : Hz; 30 when not given.

    Raises
    ------
    FileError : not there, of another shape, or damaged.
    """
    return _read(path, fps, KINECT25.names, 1.0, WANTED, "Kinect v2 joints (Keraal)")


def read_keraal_bodies(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read the optical rigid bodies.

    Parameters
    ----------
    path : the .txt.
    fps : Hz; 60 when not given.

    Raises
    ------
    FileError : not there, of another shape, or damaged.
    """
    found = _read(path, fps or BODY_FPS, tuple(BODIES), 1e-3, WANTED_BODIES, "optical rigid bodies (Keraal)")
    return found if fps else replace(found, guesses=(f"the file has no times: took {BODY_FPS:g} Hz",))


def _read(
    path: str | os.PathLike[str], fps: float | None, names: tuple[str, ...], metres: float, wanted: str, kind: str
) -> Postures:
    table = read_number_rows(path, wanted)
    if table.rows.shape[1] != _EACH * len(names):
        raise FileError(f"{path}: wanted {wanted}, came {table.rows.shape[1]}; check the file")
    positions, nowhere = with_absent(table.rows.reshape(-1, len(names), _EACH)[:, :, :3], None)
    times, guesses = even_times(len(positions), fps)
    source = SensorSource(kind)
    said = (*table.warnings, *nowhere)
    return Postures(names, positions * metres, times, source=source, guesses=guesses, warnings=said)
