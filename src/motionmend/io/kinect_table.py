"""Tables of Kinect skeletons with tracking states: GaitKinect .skl, LabanotationSuite and KIMORE .csv, and their like.

One row per frame; for each joint x, y, z (m) and its state (2 tracked, 1 inferred, 0 not tracked); perhaps a time
stamp and other columns before and the floor plane behind. Without titles the joints stand in the order of the sensor's
SDK. Titles are not trusted: some recorders wrote the joints in the SDK's order under scrambled names.
"""

import os
from collections.abc import Sequence

import numpy as np

from ..arrays import Bytes, Floats, Ints
from ..bodies.joint_sets import AZURE32, meanings, parents
from ..bodies.postures import TRACKED, Postures
from ..errors import FileError
from .kinect_titles import SDK, columns_of, columns_without_titles
from .number_rows import read_number_rows
from .sensor_source import SensorSource, even_times, seconds_of, states_of, with_absent

WANTED = "a table of Kinect joints with x, y, z and state"
_HIGH = 3  # of Azure Kinect's levels of confidence
_KIND = {20: "Kinect v1 joints", 25: "Kinect v2 joints", 32: "Azure Kinect joints"}
LARGEST_BODY = 4.0  # m that a body with its arms stretched out may measure along an axis
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
    table = read_number_rows(path, WANTED)
    columns = columns_of(table.titles) if table.titles else columns_without_titles(table.rows.shape[1])
    if columns is None:
        raise FileError(
            f"{path}: wanted {WANTED} for 20, 25 or 32 joints, came {table.rows.shape[1]} columns; "
            f"check the file's ending"
        )
    state, state_warning = _states(table.rows, columns.state)
    positions = with_absent(table.rows[:, columns.xyz], state)
    positions, measured = in_metres(positions)
    names, named = _names(columns.titles, positions)
    if columns.others:
        named = (*named, f"left out, as no joint of a body is called so: {', '.join(columns.others)}")
    if columns.time >= 0:
        times, guesses, warnings = seconds_of(table.rows[:, columns.time])
    else:
        (times, guesses), warnings = even_times(len(table.rows), fps), ()
    kind = _KIND.get(len(names), f"{len(names)} joints") if _of_sdk(names) else "table of joints"
    return Postures(
        names,
        positions,
        times,
        state=state,
        source=SensorSource(kind),
        guesses=(*guesses, *named, *measured),
        warnings=(*table.warnings, *state_warning, *warnings),
    )


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
