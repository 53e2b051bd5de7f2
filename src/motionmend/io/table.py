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

from ..arrays import Floats
from ..bodies.joint_sets import meanings
from ..bodies.motion import Markers, Origin, Repaired
from ..bodies.postures import Postures
from ..errors import FileError, counted
from .atomic import atomic
from .columns import cells_of, read_lines, read_rows, steady_rate, unended
from .joint_table import read_joint_table, time_cell, write_joint_table
from .kinect_table import not_in_metres
from .number_rows import split_cells
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
    markers : positions in metres; the rate is taken from the times. Joints may have uneven times, which they keep: the
        rate is that of the usual step then, and a sentence says so.

    Raises
    ------
    FileError : not there, not such a table, or the times of markers are uneven.
    """
    name = str(path)
    lines = read_lines(path, _WANTED)
    titles = [title.strip() for title in next(csv.reader([lines[0]]))]
    try:
        names, columns, beside = _columns(titles, name)
    except FileError:
        if (spelt_otherwise := _of_recorder(path, fps)) is None:
            raise
        return spelt_otherwise
    rows = read_rows(lines[1:], ",", len(titles), 2, name)
    times, said, warnings = rows[:, 0], tuple[str, ...](), unended(lines)
    spelt = [line.split(",", 1)[0] for line in lines[1 : len(rows) + 1]]
    joints = None
    if beside or are_joints(names):
        try:
            joints = read_joint_table(path)
        except FileError as error:
            if beside:
                said += (f"{counted(beside, 'column')} beside the positions were not read: {error}",)
    kept = bool(beside)
    if joints is not None and not np.array_equal(joints.times, times):
        times, spelt, kept = joints.times, [time_cell(time) for time in joints.times.tolist()], True
        said, warnings = (*said, *joints.guesses), joints.warnings
    if len(rows) > 1:
        rate, strays, uneven = _rate(times, spelt, name, joints)
        kept, said = kept or uneven, (*strays, *said)
    elif fps is not None:
        rate, said = fps, (f"one row states no rate: took {fps:g} Hz as given", *said)
    else:
        raise FileError(f"{name}: wanted two rows or more to tell the rate, came one; give it with --fps")
    positions = rows[:, columns].reshape(len(rows), len(names), 3)
    warnings = tuple(dict.fromkeys((*warnings, *not_in_metres(names, positions))))
    start = float(times[0]) if np.isfinite(times[0]) else 0.0
    return _markers(names, positions, rate, TableSource(start, joints if kept else None), said, warnings)


def are_joints(names: Sequence[str]) -> bool:
    """Whether most of a table's names are those of a body's joints."""
    return 2 * sum(map(bool, meanings(names))) > len(names)


def _rate(
    times: Floats, spelt: Sequence[str], name: str, joints: Postures | None
) -> tuple[float, tuple[str, ...], bool]:
    """The rate of a table, Hz, what there is to say, and whether its times are uneven, as those of joints may be.

    Sensors drop frames, and a table of their joints has each at its own time.
    """
    try:
        return *steady_rate(times, spelt, name), False
    except FileError:
        if joints is None or not np.isfinite(joints.fps):
            raise
        return joints.fps, uneven_times(times), True


def uneven_times(times: Floats) -> tuple[str, ...]:
    """A sentence about frames (T,) whose times in s are uneven: they are repaired as if they were not."""
    if len(times) < 3:
        return ()
    steps = np.diff(times)
    usual = float(np.median(steps))
    if not usual > 0 or not (np.abs(steps - usual) > 0.5 * usual).any():
        return ()
    long, back = int((steps > 1.5 * usual).sum()), int((steps <= 0).sum())
    dropped = f"{counted(long, 'step')} longer than 1.5 frames, up to {steps.max():.3g} s, as of dropped frames"
    what = ", ".join(
        [*([dropped] if long else []), *([f"{counted(back, 'step')} that do not go forward"] if back else [])]
    )
    said = f"times are uneven ({what or 'steps stray by more than half a frame'})"
    return (f"{said}: rows are taken one after another at {1 / usual:.4g} Hz, and keep their times",)


def _of_recorder(path: str | os.PathLike[str], fps: float | None) -> Markers | None:
    """The joints of a table as recorders and spreadsheets spell it: without times, or titles, with semicolons, with
    tabs; None for what is none."""
    from .sensor import kind_of, read_postures

    if kind_of(path) != "table":
        return None
    joints = read_postures(path, fps=fps)
    rate = joints.fps if np.isfinite(joints.fps) else fps or 0.0
    if not rate:
        raise FileError(f"{path}: wanted two rows or more to tell the rate, came one; give it with --fps")
    said = (*joints.guesses, *uneven_times(joints.times))
    if not _titled(read_lines(path, _WANTED)):
        said += (f"no titles: took the columns for {joints.source.kind}, in the order of the sensor's SDK",)
    said += ("written as a table of joints with times, commas and metres",)
    source = TableSource(float(joints.times[0]), joints)
    return _markers(joints.names, joints.positions, rate, source, said, joints.warnings)


def _markers(
    names: tuple[str, ...],
    positions: Floats,
    rate: float,
    source: TableSource,
    said: tuple[str, ...],
    warnings: tuple[str, ...],
) -> Markers:
    up, up_guess = up_of(names, positions)
    said += (up_guess,) if up_guess else ()
    return Markers(names, positions, rate, up=up, source=source, guesses=said, warnings=warnings)


def starts_as_table(path: str | os.PathLike[str]) -> bool:
    """Whether a .csv starts with `time`, has a column `..._x`, or no titles and as many columns as a sensor's joints
    have; also True for what cannot be read as text."""
    from .sensor import kind_of

    try:
        lines = read_lines(path, _WANTED)
        titles = [title.strip().lower() for title in split_cells(lines[0])]
        sensed = not _titled(lines) and kind_of(path) == "table"
    except FileError:
        return True
    return sensed or titles[:1] == ["time"] or any(title.endswith("_x") for title in titles)


def _titled(lines: Sequence[str]) -> bool:
    """Whether the first line of a table that is not blank holds names."""
    return any(letter.isalpha() for letter in next((line for line in lines if line.strip()), ""))


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
    std = None if beside.std is None else np.where(markers.present, _deviations(beside.std, repaired), np.nan)
    return replace(beside, positions=markers.positions, std=std)


def _deviations(given: Floats, repaired: Repaired[Markers] | None) -> Floats:
    """(T, J) m of what a table gave and a repair made of it."""
    if repaired is None:
        return given
    return np.asarray(np.where(repaired.origin == Origin.FILLED, repaired.std, np.fmax(given, repaired.std)))


def as_written(repaired: Repaired[Markers]) -> Repaired[Markers]:
    """The repair of a table with the deviations that `write_table` gives it, where it has any."""
    source = repaired.recording.source
    beside = source.beside if isinstance(source, TableSource) else None
    if beside is None or beside.std is None or beside.std.shape != repaired.std.shape:
        return repaired
    std = np.where(repaired.recording.present, _deviations(beside.std, repaired), np.nan)
    return replace(repaired, std=std.astype(repaired.std.dtype))


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
