"""UI-PRMD: rehabilitation movements recorded by a second Kinect and by optical markers at once.

`Kinect/Positions` holds 22 joints (cm, relative to the parent joint) and its sibling `Kinect/Angles` their turns
(degrees); together they give places in the room by forward kinematics. `Vicon/Positions` holds 39 markers (mm) of the
Plug-in Gait set. All are rows of numbers without titles, gzipped or not. Vakanski et al. 2018, doi:10.3390/data3010002.
"""

import os
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..bodies.joint_sets import UIPRMD22
from ..bodies.motion import Markers
from ..bodies.postures import Postures
from ..errors import FileError
from .number_rows import read_number_rows
from .sensor_source import SensorSource, even_times
from .text import LARGEST

WANTED = "UI-PRMD's Kinect positions, 66 numbers a row"
WANTED_ANGLES = "UI-PRMD's Kinect angles, 66 numbers a row"
WANTED_MARKERS = "UI-PRMD's Vicon positions, 117 numbers a row"
MARKERS = [
    "LFHD",
    "RFHD",
    "LBHD",
    "RBHD",
    "C7",
    "T10",
    "CLAV",
    "STRN",
    "RBAK",
    "LSHO",
    "LUPA",
    "LELB",
    "LFRM",
    "LWRA",
    "LWRB",
    "LFIN",
    "RSHO",
    "RUPA",
    "RELB",
    "RFRM",
    "RWRA",
    "RWRB",
    "RFIN",
    "LASI",
    "RASI",
    "LPSI",
    "RPSI",
    "LTHI",
    "LKNE",
    "LTIB",
    "LANK",
    "LHEE",
    "LTOE",
    "RTHI",
    "RKNE",
    "RTIB",
    "RANK",
    "RHEE",
    "RTOE",
]
MARKER_FPS = 100.0
_CM, _MM = 1e-2, 1e-3


def read_uiprmd(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read the Kinect's joints, in the room, from positions and the angles that lie beside them.

    Parameters
    ----------
    path : `.../Kinect/Positions/NAME_positions.txt[.gz]`; the angles are `.../Kinect/Angles/NAME_angles.txt[.gz]`.
    fps : Hz; 30 when not given, the files have no times.

    Raises
    ------
    FileError : positions or angles are not there, of another shape, cut off or damaged.
    """
    positions = read_number_rows(path, WANTED)
    beside = angles_beside(path)
    if beside is None:
        wanted = _renamed(Path(path), "angles")
        raise FileError(
            f"{path}: the angles that go with these positions were wanted at "
            f"{Path(path).parent.parent / 'Angles' / wanted} or beside it: put them there"
        )
    angles = read_number_rows(beside, WANTED_ANGLES)
    shape = (len(positions.rows), 3 * len(UIPRMD22.names))
    if positions.rows.shape != shape:
        raise FileError(f"{path}: wanted {WANTED}, came {positions.rows.shape[1]}; check the file")
    if angles.rows.shape != shape:
        raise FileError(
            f"{path}: wanted angles for {shape[0]} frames of 22 joints, {beside} holds {angles.rows.shape[0]} rows of "
            f"{angles.rows.shape[1]} numbers: it is cut off or of another recording"
        )
    places = joints_in_room(
        positions.rows.reshape(-1, len(UIPRMD22.names), 3) * _CM,
        np.radians(angles.rows.reshape(-1, len(UIPRMD22.names), 3)),
    )
    times, guesses = even_times(len(places), fps)
    source = SensorSource("Kinect v2 joints (UI-PRMD)")
    warnings = tuple(dict.fromkeys((*positions.warnings, *angles.warnings)))
    return Postures(UIPRMD22.names, places, times, source=source, guesses=guesses, warnings=warnings)


def joints_in_room(local: Floats, angles: Floats) -> Floats:
    """(T, 22, 3) m: the joints' places in the room.

    Each joint turns by Rz(az) Rx(ax) Ry(ay) and carries those that hang from it.

    Parameters
    ----------
    local : (T, 22, 3) m, relative to the parent joint; the first in the room.
    angles : (T, 22, 3) rad about x, y and z.
    """
    turns = _turns(angles)
    places = np.empty_like(local)
    frames = np.empty_like(turns)
    for joint, parent in enumerate(UIPRMD22.parents):
        if parent < 0:
            places[:, joint], frames[:, joint] = local[:, joint], turns[:, joint]
            continue
        places[:, joint] = places[:, parent] + np.einsum("tij,tj->ti", frames[:, parent], local[:, joint])
        frames[:, joint] = frames[:, parent] @ turns[:, joint]
    return places


def read_uiprmd_markers(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read the optical markers; those at (0, 0, 0) are missing.

    Parameters
    ----------
    path : `.../Vicon/Positions/NAME_positions.txt[.gz]`.
    fps : Hz; 100 when not given.

    Raises
    ------
    FileError : not there, of another shape, or damaged.
    """
    table = read_number_rows(path, WANTED_MARKERS)
    if table.rows.shape[1] != 3 * len(MARKERS):
        raise FileError(f"{path}: wanted {WANTED_MARKERS}, came {table.rows.shape[1]}; check the file")
    positions = table.rows.reshape(-1, len(MARKERS), 3) * _MM
    absent = np.asarray(~positions.any(axis=2) | ~(np.abs(positions) <= LARGEST).all(axis=2))
    rate = fps or MARKER_FPS
    said = f"the file has no times: took {rate:g} Hz"
    positions = np.where(absent[:, :, None], np.nan, positions)
    return Markers(tuple(MARKERS), positions, rate, guesses=(said, *table.warnings))


def angles_beside(path: str | os.PathLike[str]) -> Path | None:
    """The file of angles that goes with a file of positions; None when there is none."""
    file = Path(path)
    wanted = _renamed(file, "angles")
    other = wanted.removesuffix(".gz") if wanted.endswith(".gz") else wanted + ".gz"
    for folder in (file.parent.parent / "Angles", file.parent.parent / "angles", file.parent):
        for name in (wanted, other):
            if name != file.name and (folder / name).is_file():
                return folder / name
    return None


def is_angles(path: str | os.PathLike[str]) -> bool:
    """Whether a file of 66 columns holds angles, as its name or its folder says."""
    file = Path(path)
    named = file.name.lower()
    return "angles" in named or ("positions" not in named and file.parent.name.lower() == "angles")


def _renamed(file: Path, to: str) -> str:
    return file.name.replace("positions", to).replace("Positions", to.capitalize())


def _turns(angles: Floats) -> Floats:
    """(T, J, 3, 3) Rz Rx Ry of angles (T, J, 3) about x, y, z in radians."""
    (cx, cy, cz), (sx, sy, sz) = np.moveaxis(np.cos(angles), -1, 0), np.moveaxis(np.sin(angles), -1, 0)
    rows = [
        [cz * cy - sz * sx * sy, -sz * cx, cz * sy + sz * sx * cy],
        [sz * cy + cz * sx * sy, cz * cx, sz * sy - cz * sx * cy],
        [-cx * sy, sx, cx * cy],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
