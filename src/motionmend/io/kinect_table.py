"""Tables of Kinect skeletons with tracking states: GaitKinect .skl, LabanotationSuite and KIMORE .csv, and their like.

One row per frame; for each joint x, y, z (m) and its state (2 tracked, 1 inferred, 0 not tracked); perhaps a time
stamp and other columns before and the floor plane behind. Without titles the joints stand in the order of the sensor's
SDK. Titles are not trusted: some recorders wrote the joints in the SDK's order under scrambled names.
"""

import os
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints
from ..bodies.joint_sets import AZURE32, meanings, parents
from ..bodies.postures import NOT_TRACKED, TRACKED, Postures
from ..errors import FileError
from .clock_times import SAID
from .kinect_titles import SDK, Columns, beside, columns_of, columns_without_titles
from .number_rows import NumberRows, read_number_rows
from .sensor_source import (
    SensorSource,
    counted_as_seconds,
    counts_frames,
    even_times,
    seconds_of,
    states_of,
    with_absent,
)
from .several_bodies import Body, one_person

WANTED = "a table of Kinect joints with x, y, z and state"
_HIGH = 3  # of Azure Kinect's levels of confidence
_KIND = {20: "Kinect v1 joints", 25: "Kinect v2 joints", 32: "Azure Kinect joints"}
LARGEST_BODY = 4.0  # m that a body with its arms stretched out may measure along an axis
SMALLEST_BODY = 0.05  # m; a body is larger, however little of it is seen
_SURELY = 0.98  # names are believed when they make the body so much smaller than the SDK's order does


def read_kinect_table(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read a table of Kinect joints.

    Parameters
    ----------
    path : .skl, .csv or .txt.
    fps : Hz, of a table without times; 30 when not given.

    Returns
    -------
    postures : names of the sensor's SDK, or the titles' where it has other joints; states where the table has them,
        the file's own times in seconds.

    Raises
    ------
    FileError : not there, not such a table, or damaged.
    """
    table = read_number_rows(path, WANTED, beside)
    columns = columns_of(table.titles) if table.titles else columns_without_titles(table.rows.shape[1])
    if columns is None:
        raise FileError(
            f"{path}: wanted {WANTED} for 20, 25 or 32 joints, came {table.rows.shape[1]} columns; "
            f"check the file's ending"
        )
    rows, several = _of_one_person(table, columns, fps)
    state, state_warning = _states(rows, columns.state)
    positions, nowhere = with_absent(rows[:, columns.xyz], state)
    positions, measured = in_metres(positions)
    names, named = _names(columns.titles, positions)
    if columns.others:
        named = (*named, f"left out, as no joint of a body is called so: {', '.join(columns.others)}")
    warnings: tuple[str, ...] = ()
    if not table.titles and columns.time >= 0 and counts_frames(rows[:, columns.time]):
        times, guesses = even_times(len(rows), fps, why="the first column counts frames")
        times = (rows[:, columns.time] - rows[0, columns.time]) * times[1]
    elif columns.time >= 0:
        times, guesses, warnings = seconds_of(rows[:, columns.time], "seconds" if table.clock else None)
        guesses += (SAID,) if table.clock else ()
        warnings += counted_as_seconds(times)
    else:
        times, guesses = even_times(len(rows), fps)
    kind = _KIND.get(len(names), f"{len(names)} joints") if _of_sdk(names) else "table of joints"
    return Postures(
        names,
        positions,
        times,
        state=state,
        source=SensorSource(kind),
        guesses=(*guesses, *named, *measured, *several),
        warnings=(*table.warnings, *state_warning, *nowhere, *warnings),
    )


def _of_one_person(table: NumberRows, columns: Columns, fps: float | None) -> tuple[Floats, tuple[str, ...]]:
    """One row for each frame, of a table with one for each body in it: that of the person who is seen longest, empty
    where they are not; and what was supposed of them. Rows of one time, or of one frame's number, are of one frame; in
    a table that has neither, a frame ends where a body comes again."""
    rows, whose = table.rows, table.named
    if len({*whose}) < 2:
        return rows, ()
    clock = columns.time if columns.time >= 0 else columns.frame
    if clock >= 0:
        starts = np.flatnonzero(np.diff(rows[:, clock], prepend=np.nan) != 0).tolist()
    else:
        starts = [0]
        for k, body in enumerate(whose):
            if body in whose[starts[-1] : k]:
                starts.append(k)
    state, _ = _states(rows, columns.state)
    positions, _ = in_metres(with_absent(rows[:, columns.xyz], state)[0])
    seen: Bools = np.asarray(np.isfinite(positions).any(axis=(1, 2)))
    frames = [[k for k in range(first, end) if seen[k]] for first, end in pairwise((*starts, len(rows)))]
    stamps = rows[starts, columns.time] if columns.time >= 0 else None
    unit = "seconds" if table.clock else None
    times = even_times(len(starts), fps)[0] if stamps is None else seconds_of(stamps, unit)[0]
    chosen, said = one_person([[Body(whose[k], positions[k]) for k in frame] for frame in frames], times)
    found = np.full((len(starts), rows.shape[1]), np.nan)
    for t, (first, frame, which) in enumerate(zip(starts, frames, chosen.tolist(), strict=True)):
        found[t] = rows[frame[which] if which >= 0 else first]
        if which < 0:
            found[t, columns.xyz] = np.nan
            if columns.state is not None:
                found[t, columns.state[columns.state >= 0]] = NOT_TRACKED
    return found, said


def in_metres(positions: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Positions (T, J, 3) in metres, and a sentence when the file must have another unit, as no body is so large."""
    size = size_of_body(positions)
    if size <= LARGEST_BODY:
        return positions, ()
    metres, unit = unit_of_body(size)
    return positions * metres, (f"the body is {size:.0f} units large: positions were taken as {unit}",)


def size_of_body(positions: Floats) -> float:
    """How large along an axis the body is in the median frame that shows half of its joints; 0 where none does.

    Parameters
    ----------
    positions : (T, J, 3) in any unit, NaN = missing.
    """
    there = np.isfinite(positions).all(axis=2).sum(axis=1) >= max(positions.shape[1] // 2, 1)
    if not there.any():
        return 0.0
    lowest, highest = np.nanmin(positions[there], axis=1), np.nanmax(positions[there], axis=1)
    return float(np.median((highest - lowest).max(axis=1)))


def not_in_metres(names: Sequence[str], positions: Floats) -> tuple[str, ...]:
    """A sentence when a table that promises metres holds a body larger than anybody; none of what is no body.

    Parameters
    ----------
    names : of J joints or markers.
    positions : (T, J, 3) as they stand in the table, NaN = missing.
    """
    size = size_of_body(positions) if 2 * sum(map(bool, meanings(names))) > len(names) else 0.0
    if size <= LARGEST_BODY:
        return ()
    return (f"metres were wanted, the body is {size:.4g} m large: are the numbers {unit_of_body(size)[1]}?",)


def unit_of_body(size: float) -> tuple[float, str]:
    """The unit in m, and its name, in which a body must be given that is so large that it cannot be metres."""
    return (0.01, "centimetres") if size <= 100 * LARGEST_BODY else (0.001, "millimetres")


def _states(rows: Floats, columns: Ints | None) -> tuple[Bytes | None, tuple[str, ...]]:
    """Tracking states (T, J) of a table, and what is wrong with them; joints without a column of their own are as
    good as tracked. Azure Kinects tell how sure they are: not, little, middling, very."""
    if columns is None:
        return None, ()
    told = np.where(columns >= 0, rows[:, columns], TRACKED)
    if len(columns) == len(AZURE32.names):
        told = np.where(told == _HIGH, TRACKED, told)
    return states_of(told)


def _names(titles: Sequence[str], positions: Floats) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names in the columns' order, and a sentence where the titles were not believed.

    Of the SDK's order and the titles', the right one joins the nearer joints: wrong names draw bones across the body.
    """
    sdk = SDK.get(positions.shape[1])
    if sdk is None:
        return tuple(titles), ()
    if not titles or tuple(titles) == sdk.names:
        return sdk.names, ()
    meant = meanings(titles)
    if (
        all(meant)
        and len(set(titles)) == len(titles)
        and _size(titles, positions) < _SURELY * _size(sdk.names, positions)
    ):
        known = sorted(titles) == sorted(sdk.names)
        said = "the joints stand in another order than the sensor's SDK has: took the titles'"
        return tuple(titles), (said,) if known else ()
    if meant == sdk.meanings:
        return sdk.names, ()
    return sdk.names, ("the titles' joint names do not fit the body: took the order of the sensor's SDK",)


def _of_sdk(names: Sequence[str]) -> bool:
    """Whether these are a sensor's own joints, in whatever order."""
    return len(names) in SDK and sorted(names) == sorted(SDK[len(names)].names)


def _size(names: Sequence[str], positions: Floats) -> float:
    """Sum of the bones' median lengths, m, if the joints are called so."""
    above = parents(names)
    child = np.flatnonzero(above >= 0)
    lengths = np.linalg.norm(positions[:, child] - positions[:, above[child]], axis=2)
    seen = np.isfinite(lengths).any(axis=0)
    return float(np.nanmedian(lengths[:, seen], axis=0).sum())
