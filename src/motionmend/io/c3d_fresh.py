"""A C3D file from nothing, for markers that came from elsewhere."""

import struct

import numpy as np

from ..bodies.motion import Markers
from ..errors import FileError
from .c3d_chain import GROUP, INTEGER, MOST_ROWS, REAL, Record, textual, write_chain
from .c3d_layout import BLOCK, INTEL, MOST_BLOCKS, MOST_COUNTED, Layout

UNIT, METRES = "mm", 0.001
_SCALE = -0.1  # floats; residuals in steps of 0.1 mm


def blank(markers: Markers, name: str) -> bytes:
    """A valid file for the markers with every point missing, unit millimetres.

    Parameters
    ----------
    markers : for names, frames, rate and the way up.
    name : of the file to be, for messages.

    Raises
    ------
    FileError : no markers or frames, or more markers than the parameters of a C3D file can name.
    """
    points, frames = len(markers.names), markers.frames
    if not points or not frames:
        raise FileError(f"{name}: a C3D file needs markers and frames, came {points} and {frames}")
    longest = max(markers.names, key=lambda label: len(label.encode()))
    if len(longest.encode()) > MOST_ROWS:
        raise FileError(f"{name}: a C3D file holds labels of up to {MOST_ROWS} bytes, came '{longest[:40]}...'")
    chain = _parameters(markers)
    blocks = -(-(4 + len(write_chain(chain, "<"))) // BLOCK)
    if blocks > MOST_BLOCKS:
        raise FileError(f"{name}: the labels of {points} markers need {blocks} blocks, a C3D file has {MOST_BLOCKS}")
    data_block = 2 + blocks
    header = bytearray(BLOCK)
    struct.pack_into(
        "<BB5HfHHf", header, 0, 2, 0x50, points, 0, 1, min(frames, MOST_COUNTED), 0, _SCALE, data_block, 1, markers.fps
    )
    chain = [
        Record(r.name, r.group, r.locked, r.kind, r.dims, struct.pack("<H", data_block), r.description)
        if r.name == "DATA_START"
        else r
        for r in chain
    ]
    section = (bytes([1, 0x50, blocks, INTEL]) + write_chain(chain, "<")).ljust(blocks * BLOCK, b"\0")
    row = np.tile(np.array([0, 0, 0, -1], "<f4"), points).tobytes()
    data = row * frames
    return bytes(header) + section + data + b"\0" * (-len(data) % BLOCK)


def _parameters(markers: Markers) -> list[Record]:
    """What the standard asks for, and what other readers stumble over when it is not there."""
    layout = Layout(INTEL)
    points = len(markers.names)
    none = np.empty(0)
    upward = np.abs(markers.up) > 1 - 1e-9

    def group(number: int, name: str, description: str) -> Record:
        return Record(name, number, False, GROUP, (), b"", description.encode())

    records = [
        group(1, "POINT", "Marker positions"),
        layout.numeric(1, "USED", points, INTEGER),
        layout.numeric(1, "FRAMES", min(markers.frames, MOST_COUNTED), INTEGER),
        *([layout.numeric(1, "LONG_FRAMES", markers.frames, REAL)] if markers.frames > MOST_COUNTED else []),
        layout.numeric(1, "DATA_START", 0, INTEGER),
        layout.numeric(1, "SCALE", _SCALE, REAL),
        layout.numeric(1, "RATE", markers.fps, REAL),
        *textual(1, "UNITS", [UNIT]),
        *textual(1, "LABELS", markers.names),
        *textual(1, "DESCRIPTIONS", [""] * points),
    ]
    if upward.any():
        axis = int(np.argmax(upward))
        sign = "+" if markers.up[axis] > 0 else "-"
        records += textual(1, "X_SCREEN", ["+Y" if axis == 0 else "+X"])
        records += textual(1, "Y_SCREEN", [sign + "XYZ"[axis]])
    return [
        *records,
        group(2, "ANALOG", "No analog channels"),
        layout.numeric(2, "USED", 0, INTEGER),
        layout.numeric(2, "RATE", markers.fps, REAL),
        layout.numeric(2, "GEN_SCALE", 1.0, REAL),
        layout.numeric(2, "SCALE", none, REAL),
        layout.numeric(2, "OFFSET", none, INTEGER),
        *textual(2, "LABELS", []),
        *textual(2, "DESCRIPTIONS", []),
        *textual(2, "UNITS", []),
        group(3, "FORCE_PLATFORM", "No force platforms"),
        layout.numeric(3, "USED", 0, INTEGER),
        layout.numeric(3, "TYPE", none, INTEGER),
        layout.numeric(3, "ZERO", [1, 0], INTEGER),
        layout.numeric(3, "CORNERS", np.empty((3, 4, 0)), REAL),
        layout.numeric(3, "ORIGIN", np.empty((3, 0)), REAL),
        layout.numeric(3, "CHANNEL", np.empty((6, 0)), INTEGER),
        layout.numeric(3, "CAL_MATRIX", np.empty((6, 6, 0)), REAL),
        group(4, "TRIAL", "First and last frame"),
        layout.numeric(4, "ACTUAL_START_FIELD", [1, 0], INTEGER),
        layout.numeric(4, "ACTUAL_END_FIELD", divmod(markers.frames, 1 << 16)[::-1], INTEGER),
        layout.numeric(4, "CAMERA_RATE", markers.fps, REAL),
    ]
