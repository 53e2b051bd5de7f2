"""Our own table of markers, .csv: `time,<marker>_x,<marker>_y,<marker>_z,...`.

Seconds and metres with 9 significant digits, a blank cell for what is missing. The columns `_std`, `_reliability` and
`_state` that tracking and correction add are kept in the source, and written again.
"""

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bodies.motion import Markers, Origin, Repaired
from ..bodies.postures import Postures
from ..errors import FileError, counted
from .atomic import atomic
from .columns import cells_of, read_lines, read_rows, steady_rate, unended
from .joint_table import read_joint_table, write_joint_table
from .vertical import up_of

_WANTED = "a table with time,<marker>_x,<marker>_y,<marker>_z,..."
_BESIDE = ("std", "reliability", "state")


@dataclass(frozen=True, eq=False)
class TableSource:
    """The time of a table's first row, s, and the table with what stands beside its positions, where anything does."""

    start: float
    beside: Postures | None = None


def read_table(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read markers from a table.

    Parameters
    ----------
    path : the .csv.
    fps : Hz, for a table with a single row.

    Returns
    -------
    markers : positions in metres; the rate is taken from the times.

    Raises
    ------
    FileError : not there, not such a table, or its times are uneven.
    """
    name = str(path)
    lines = read_lines(path, _WANTED)
    titles = [title.strip() for title in next(csv.reader([lines[0]]))]
    names, columns, beside = _columns(titles, name)
    rows = read_rows(lines[1:], ",", len(titles), 2, name)
    if len(rows) > 1:
        rate, said = steady_rate(rows[:, 0], [line.split(",", 1)[0] for line in lines[1 : len(rows) + 1]], name)
    elif fps is not None:
        rate, said = fps, (f"one row states no rate: took {fps:g} Hz as given",)
    else:
        raise FileError(f"{name}: wanted two rows or more to tell the rate, came one; give it with --fps")
    positions = rows[:, columns].reshape(len(rows), len(names), 3)
    joints = None
    if beside:
        try:
            joints = read_joint_table(path)
        except FileError as error:
            said += (f"{counted(beside, 'column')} beside the positions were not read: {error}",)
    said += unended(lines)
    up, up_guess = up_of(names, positions)
    start = float(rows[0, 0]) if np.isfinite(rows[0, 0]) else 0.0
    source = TableSource(start, joints)
    return Markers(names, positions, rate, up=up, source=source, guesses=(*said, *((up_guess,) if up_guess else ())))


def starts_as_table(path: str | os.PathLike[str]) -> bool:
    """Whether a .csv starts with `time` or has a column `..._x`; also True for what cannot be read as text."""
    try:
        titles = [title.strip().lower() for title in read_lines(path, _WANTED)[0].split(",")]
    except FileError:
        return True
    return titles[0] == "time" or any(title.endswith("_x") for title in titles)


def write_table(path: str | os.PathLike[str], markers: Markers, repaired: Repaired[Markers] | None = None) -> None:
    """Write markers to a table.

    Parameters
    ----------
    path : the .csv.
    markers : positions in metres; times start as in the table they came from, else at 0, and what stood there beside
        the positions does so again.
    repaired : the repair that made them. A filled sample has its deviation, any other the larger one of both: smoothing
        does not take away what is wrong all the time.

    Raises
    ------
    FileError : nothing to write, or the file cannot be written.
    """
    if not markers.names or not markers.frames:
        raise FileError(f"{path}: a table needs markers and frames, came {len(markers.names)} and {markers.frames}")
    joints = _joints(markers, repaired)
    if joints is not None:
        write_joint_table(path, joints)
        return
    text = io.StringIO()
    titles = [f"{name}_{axis}" for name in markers.names for axis in "xyz"]
    csv.writer(text, lineterminator="\n").writerow(["time", *titles])
    start = markers.source.start if isinstance(markers.source, TableSource) else 0.0
    times = cells_of(start + np.arange(markers.frames) / markers.fps)
    values = np.where(markers.present[:, :, None], markers.positions, np.nan).reshape(markers.frames, -1)
    for time, row in zip(times, values, strict=True):
        text.write(",".join([time, *cells_of(row)]) + "\n")
    with atomic(path) as temporary:
        temporary.write_bytes(text.getvalue().encode())


def _joints(markers: Markers, repaired: Repaired[Markers] | None) -> Postures | None:
    """The markers with what stood beside them in the table they came from; None where nothing did."""
    beside = markers.source.beside if isinstance(markers.source, TableSource) else None
    if beside is None or (beside.names, beside.frames) != (markers.names, markers.frames):
        return None
    std = beside.std
    if std is not None and repaired is not None:
        std = np.where(repaired.origin == Origin.FILLED, repaired.std, np.fmax(std, repaired.std))
    if std is not None:
        std = np.where(markers.present, std, np.nan)
    return replace(beside, positions=markers.positions, std=std)


def _columns(titles: Sequence[str], name: str) -> tuple[tuple[str, ...], list[int], int]:
    """Marker names, the columns of their x, y and z, and the number of columns that are let pass."""
    first = titles[0] if titles else ""
    if first.lower() != "time":
        raise FileError(f"{name}: wanted {_WANTED}, the first title is '{first[:40]}'; check the file's ending")
    places: dict[str, dict[str, int]] = {}
    beside = 0
    for column, title in enumerate(titles[1:], 1):
        marker, _, what = title.rpartition("_")
        if what in _BESIDE and marker:
            beside += 1
        elif what not in ("x", "y", "z") or not marker:
            raise FileError(f"{name}: wanted {_WANTED}, column {column + 1} is '{title[:40]}'; remove or rename it")
        elif what in places.setdefault(marker, {}):
            raise FileError(f"{name}: two columns are called '{title[:40]}'; rename one")
        else:
            places[marker][what] = column
    lacking = next((marker for marker, found in places.items() if len(found) < 3), None)
    if lacking is not None or not places:
        raise FileError(f"{name}: wanted x, y and z of every marker, {lacking or 'there is no marker'} lacks some")
    return tuple(places), [found[axis] for found in places.values() for axis in "xyz"], beside
