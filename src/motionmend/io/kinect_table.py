"""Tables of Kinect skeletons with tracking states: GaitKinect .skl, LabanotationSuite and KIMORE .csv, and their like.

One row per frame; for each joint x, y, z (m) and its state (2 tracked, 1 inferred, 0 not tracked); perhaps a time
stamp and other columns before and the floor plane behind. Without titles the joints stand in the order of the sensor's
SDK. Titles are not trusted: some recorders wrote the joints in the SDK's order under scrambled names.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..bodies.joint_sets import AZURE32, KINECT20, KINECT25, JointSet
from ..bodies.postures import Postures
from ..errors import FileError
from .number_rows import NumberRows, read_number_rows
from .sensor_source import SensorSource, even_times, seconds_of, states_of, with_absent

WANTED = "a table of Kinect joints with x, y, z and state"
_BY_COUNT = {20: KINECT20, 25: KINECT25, 32: AZURE32}
_KIND = {20: "Kinect v1 joints", 25: "Kinect v2 joints", 32: "Azure Kinect joints"}
LARGEST_BODY = 4.0  # m that a body with its arms stretched out may measure along an axis
_SURELY = 0.98  # names are believed when they make the body so much smaller than the SDK's order does


@dataclass(frozen=True)
class _Layout:
    """Where things stand in a row: the time's column (-1 for none), the first joint's, how many, columns of each."""

    time: int
    first: int
    joints: int
    width: int


def read_kinect_table(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read a table of Kinect joints.

    Parameters
    ----------
    path : .skl, .csv or .txt.
    fps : Hz, of a table without times; 30 when not given.

    Returns
    -------
    postures : names of the sensor's SDK, states where the table has them, the file's own times in seconds.

    Raises
    ------
    FileError : not there, not such a table, or damaged.
    """
    table = read_number_rows(path, WANTED)
    layout = _titled(table.titles) if table.titles else layout_without_titles(table.rows.shape[1])
    if layout is None or layout.first + layout.joints * layout.width > table.rows.shape[1]:
        raise FileError(
            f"{path}: wanted {WANTED} for 20, 25 or 32 joints, came {table.rows.shape[1]} columns; "
            f"check the file's ending"
        )
    stop = layout.first + layout.joints * layout.width
    blocks = table.rows[:, layout.first : stop].reshape(len(table.rows), layout.joints, layout.width)
    state, state_warning = states_of(blocks[:, :, 3]) if layout.width == 4 else (None, ())
    positions = with_absent(blocks[:, :, :3], state)
    positions, measured = in_metres(positions)
    names, named = _names(table, layout, positions)
    if layout.time >= 0:
        times, guesses, warnings = seconds_of(table.rows[:, layout.time])
    else:
        (times, guesses), warnings = even_times(len(table.rows), fps), ()
    source = SensorSource(
        _KIND.get(layout.joints, f"{layout.joints} joints"), (*table.warnings, *state_warning, *warnings)
    )
    return Postures(names, positions, times, state=state, source=source, guesses=(*guesses, *named, *measured))


def layout_without_titles(columns: int) -> _Layout | None:
    """How a row of so many numbers is laid out, when it is that of a Kinect table."""
    for width in (4, 3):
        for before in (0, 1):
            joints, rest = divmod(columns - before, width)
            if joints in _BY_COUNT and not rest:
                return _Layout(before - 1, before, joints, width)
    return None


def titles_of_kinect(titles: Sequence[str]) -> bool:
    """Whether these are titles of such a table and not of our own, which starts with `time` and `<joint>_x`."""
    return _titled(titles) is not None


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


def _titled(titles: Sequence[str]) -> _Layout | None:
    plain = [title.strip().lower() for title in titles]
    starts = [k for k, title in enumerate(plain) if title.endswith(("_x", ".x", " x"))]
    if len(starts) not in _BY_COUNT:
        return None
    width = 4 if starts[0] + 3 < len(plain) and plain[starts[0] + 3].endswith(("tracked", "state")) else 3
    if starts != list(range(starts[0], starts[0] + width * len(starts), width)):
        return None
    time = next((k for k, title in enumerate(plain[: starts[0]]) if "time" in title), -1)
    return _Layout(time, starts[0], len(starts), width)


def _names(table: NumberRows, layout: _Layout, positions: Floats) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names in the columns' order, and a sentence where the titles were not believed.

    Of the SDK's order and the titles', the right one joins the nearer joints: wrong names draw bones across the body.
    """
    sdk = _BY_COUNT[layout.joints]
    if not table.titles:
        return sdk.names, ()
    titles = [table.titles[layout.first + k * layout.width].strip()[:-2] for k in range(layout.joints)]
    if titles == list(sdk.names):
        return sdk.names, ()
    if sorted(titles) == sorted(sdk.names):
        order = [titles.index(name) for name in sdk.names]
        if _size(sdk, positions[:, order]) < _SURELY * _size(sdk, positions):
            return tuple(titles), ("the joints stand in another order than the sensor's SDK has: took the titles'",)
    return sdk.names, ("the titles' joint names do not fit the body: took the order of the sensor's SDK",)


def _size(joints: JointSet, positions: Floats) -> float:
    """Sum of the bones' median lengths, m."""
    child = [k for k, parent in enumerate(joints.parents) if parent >= 0]
    parent = [joints.parents[k] for k in child]
    lengths = np.linalg.norm(positions[:, child] - positions[:, parent], axis=2)
    seen = np.isfinite(lengths).any(axis=0)
    return float(np.nanmedian(lengths[:, seen], axis=0).sum())
