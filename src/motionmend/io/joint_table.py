"""Tables of joints over time, .csv: what tracking and correction write, and what correction reads.

`time,<joint>_x,<joint>_y,<joint>_z,...[,<joint>_std,...][,<joint>_reliability,...][,<joint>_state,...]`: seconds and
metres with 9 significant digits, a blank cell for what is missing; state 2 tracked, 1 inferred, 0 not tracked.
Columns are read by their titles, in whatever order they stand.
"""

import csv
import io
import os
from collections.abc import Sequence

import numpy as np

from ..arrays import Floats
from ..bodies.postures import TRACKED, Postures
from ..errors import FileError
from .atomic import atomic
from .clock_times import SAID, clock_seconds
from .columns import cells_of, read_lines, read_rows, unended
from .kinect_table import not_in_metres
from .sensor_source import counted_as_seconds, seconds_of

_WANTED = "a table with time,<joint>_x,<joint>_y,<joint>_z,..."
_AXES = ("x", "y", "z")
BESIDE = ("std", "reliability", "state")
_SLOWEST = 5.0  # s from one frame to the next; more is of another unit
_TICK = 1e-6  # s; times that 9 significant digits would move by more are written in full


def read_joint_table(path: str | os.PathLike[str]) -> Postures:
    """Read joint positions from a table.

    Parameters
    ----------
    path : the .csv.

    Returns
    -------
    postures : positions and deviations in metres. A joint that lacks a coordinate is missing.

    Raises
    ------
    FileError : not there, not such a table, cut off, or a value that cannot be what its title says.
    """
    name = str(path)
    lines = read_lines(path, _WANTED)
    titles = [title.strip() for title in next(csv.reader([lines[0]]))]
    places = _places(titles, name)
    plain = [line.replace('"', "") for line in lines[1:]]
    stamps = clock_seconds([line.partition(",")[0] for line in plain if line.strip()])
    if stamps is not None:
        left = iter(stamps)
        plain = [f"{next(left)!r},{line.partition(',')[2]}" if line.strip() else line for line in plain]
    rows = read_rows(plain, ",", len(titles), 2, name)
    times = rows[:, 0]
    if np.isnan(times).any():
        row = int(np.flatnonzero(np.isnan(times))[0]) + 2
        raise FileError(f"{name}: the time in line {row} is missing; fill it in")
    xyz = np.stack([rows[:, [found[axis] for axis in _AXES]] for found in places.values()], axis=1)
    xyz[np.isnan(xyz).any(axis=2)] = np.nan
    beside = {what: _beside(rows, places, what) for what in BESIDE}
    _check(beside, name)
    state = beside["state"]
    warnings = (*unended(lines), *not_in_metres(tuple(places), xyz))
    times, guesses = (times, (SAID,)) if stamps is not None else _in_seconds(times)
    warnings += counted_as_seconds(times)
    falling = int((np.diff(times) < 0).sum())
    if falling:
        warnings += (f"the time goes back {falling} times: rows are kept in the order of the file",)
    return Postures(
        tuple(places),
        xyz,
        times,
        state=None if state is None else np.nan_to_num(state, nan=0.0).astype(np.uint8),
        std=beside["std"],
        reliability=beside["reliability"],
        guesses=guesses,
        warnings=warnings,
    )


def write_joint_table(path: str | os.PathLike[str], postures: Postures) -> None:
    """Write joint positions to a table; deviations, reliabilities and states where there are any.

    Parameters
    ----------
    path : the .csv; it is whole or not there.
    postures : T frames of J joints, T and J > 0. A joint without a position has blank cells.

    Raises
    ------
    FileError : nothing to write, a name that stands twice, or the file cannot be written.
    """
    if not postures.names or not postures.frames:
        raise FileError(f"{path}: a table needs joints and frames, came {len(postures.names)} and {postures.frames}")
    if len(set(postures.names)) < len(postures.names):
        twice = next(one for one in postures.names if postures.names.count(one) > 1)
        raise FileError(f"{path}: two joints are called '{twice}'; a table needs a name for each")
    beside = [(what, getattr(postures, what)) for what in BESIDE if getattr(postures, what) is not None]
    titles = [f"{joint}_{axis}" for joint in postures.names for axis in _AXES]
    titles += [f"{joint}_{what}" for what, _ in beside for joint in postures.names]
    xyz = np.where(postures.present[:, :, None], postures.positions, np.nan).reshape(postures.frames, -1)
    cells = np.concatenate([xyz, *(np.asarray(values, dtype=np.float64) for _, values in beside)], axis=1)
    cells[np.isinf(cells)] = np.nan
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(["time", *titles])
    for time, row in zip(postures.times.tolist(), cells, strict=True):
        text.write(",".join([time_cell(time), *cells_of(row)]) + "\n")
    with atomic(path) as temporary:
        temporary.write_bytes(text.getvalue().encode())


def time_cell(time: float) -> str:
    """A time in seconds: 9 significant digits where they hold a microsecond, else as many as it needs."""
    short = f"{time:.9g}"
    return short if abs(float(short) - time) <= _TICK else repr(time)


def starts_as_joint_table(path: str | os.PathLike[str]) -> bool:
    """Whether a .csv starts with `time` and has x, y and z of each joint; False for what cannot be read as text."""
    try:
        titles = [title.strip() for title in next(csv.reader([read_lines(path, _WANTED)[0]]))]
        return bool(_places(titles, str(path)))
    except FileError:
        return False


def beside_of(path: str | os.PathLike[str]) -> frozenset[str]:
    """Which of `std`, `reliability` and `state` the titles of a table have."""
    titles = next(csv.reader([read_lines(path, _WANTED)[0]]))
    return frozenset(what for title in titles if (what := title.strip().rpartition("_")[2]) in BESIDE)


def _in_seconds(times: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Times (T,) in seconds, and a sentence where they must be of a smaller unit, as no sensor is so slow."""
    rising = np.diff(times)
    rising = rising[rising > 0]
    if not len(rising) or np.median(rising) <= _SLOWEST:
        return times, ()
    return seconds_of(times)[:2]


def _places(titles: Sequence[str], name: str) -> dict[str, dict[str, int]]:
    """Of each joint, in the order of the file, the columns of its x, y, z and of what stands beside them."""
    first = titles[0] if titles else ""
    if first.lower() != "time":
        raise FileError(f"{name}: wanted {_WANTED}, the first title is '{first[:40]}'; check the file's ending")
    places: dict[str, dict[str, int]] = {}
    for column, title in enumerate(titles[1:], 1):
        joint, _, what = title.rpartition("_")
        if what not in (*_AXES, *BESIDE) or not joint:
            raise FileError(f"{name}: wanted {_WANTED}, column {column + 1} is '{title[:40]}'; remove or rename it")
        if what in places.setdefault(joint, {}):
            raise FileError(f"{name}: two columns are called '{title[:40]}'; rename one")
        places[joint][what] = column
    lacking = next((joint for joint, found in places.items() if not {*_AXES} <= found.keys()), None)
    if lacking is not None or not places:
        raise FileError(f"{name}: wanted x, y and z of every joint, {lacking or 'there is no joint'} lacks some")
    return places


def _beside(rows: Floats, places: dict[str, dict[str, int]], what: str) -> Floats | None:
    """(T, J) of what stands beside the positions; NaN where a joint lacks it, None where all do."""
    if not any(what in found for found in places.values()):
        return None
    missing = np.full(len(rows), TRACKED if what == "state" else np.nan)  # a joint of which no state is told
    return np.stack([rows[:, found[what]] if what in found else missing for found in places.values()], axis=1)


def _check(beside: dict[str, Floats | None], name: str) -> None:
    """Refuse negative deviations, reliabilities outside 0 to 1, and states that are none."""
    std, reliability, state = beside["std"], beside["reliability"], beside["state"]
    wrong = {
        "_std of 0 or more": None if std is None else std < 0,
        "_reliability from 0 to 1": None if reliability is None else (reliability < 0) | (reliability > 1),
        "_state of 0, 1 or 2": None if state is None else np.isfinite(state) & ~np.isin(state, range(TRACKED + 1)),
    }
    for wanted, bad in wrong.items():
        if bad is not None and bad.any():
            row = int(np.flatnonzero(bad.any(axis=1))[0]) + 2
            raise FileError(f"{name}: wanted {wanted}, line {row} has another; repair the file")
