"""Markers in text files: what the formats of .trc, Qualisys' .tsv and ACCAD have in common."""

import os
from collections.abc import Sequence

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.motion import Markers
from ..errors import FileError, counted
from .text import LARGEST

_SPECK = 1e-9  # m, by which a marker on the very origin is moved, where it would read as missing


def present_in_text(values: Floats) -> tuple[Bools, tuple[str, ...]]:
    """(T, M) which positions count: no NaN, none at (0, 0, 0) or beyond `LARGEST`, which is said where there are.

    Parameters
    ----------
    values : (T, M, 3) in the file's unit.
    """
    near = np.asarray((np.abs(values) <= LARGEST).all(axis=2))
    zero, far = near & ~values.any(axis=2), np.isfinite(values).all(axis=2) & ~near
    named = ((zero, "at exactly (0, 0, 0)"), (far, f"beyond {LARGEST:g}"))
    said = tuple(f"{int(some.sum())} positions {where} were taken as missing" for some, where in named if some.any())
    return np.asarray(near & ~zero), said


def number_of(cell: str) -> float:
    """A positive number as a header states it; 0 when it is none."""
    try:
        value = float(cell)
    except ValueError:
        return 0.0
    return value if 0 < value < np.inf else 0.0


def refuse_twice(names: Sequence[str], name: str) -> None:
    """Raise FileError where a marker of the file of this name stands in two columns."""
    if len(set(names)) < len(names):
        twice = next(one for one in names if names.count(one) > 1)
        raise FileError(f"{name}: marker {twice} stands in two columns; rename one")


def against_promise(promised: float, held: int, key: str, name: str) -> tuple[str, ...]:
    """A sentence where a file holds more frames than its header promises.

    Parameters
    ----------
    promised, held : frames; 0 promised = the header says nothing.
    key : of the header, that promises.
    name : of the file.

    Raises
    ------
    FileError : it holds fewer.
    """
    frames = counted(int(promised), "frame")
    if promised > held:
        raise FileError(
            f"{name}: the header promises {frames}, the file holds {held}: it is cut off; get a complete copy, or "
            f"state {held} as {key} where that is all"
        )
    return (f"the header says {frames}, the file holds {held}: took them all",) if 0 < promised < held else ()


def coordinates_for_text(markers: Markers, metres: float, path: str | os.PathLike[str], what: str) -> Floats:
    """(T, 3M) coordinates as a file of tabs holds them, NaN = missing.

    Parameters
    ----------
    markers : to be written.
    metres : in one unit of the file.
    path : of the file. what : it is, such as "a TRC file", for messages.

    Raises
    ------
    FileError : no markers, no frames, or a name that tabs cannot tell from others.
    """
    wrong = next((name for name in markers.names if not name.strip() or any(c in name for c in "\t\r\n")), None)
    if wrong is not None:
        raise FileError(f"{path}: {what} cannot hold the marker name {wrong!r}; rename it")
    if not markers.names or not markers.frames:
        raise FileError(f"{path}: {what} needs markers and frames, came {len(markers.names)} and {markers.frames}")
    values = np.where(markers.present[:, :, None], markers.positions, np.nan) / metres
    values[~values.any(axis=2), 0] = _SPECK / metres
    return np.asarray(values.reshape(markers.frames, -1))
