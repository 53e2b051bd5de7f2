"""Rows of numbers as sensors' recorders write them: any separator, blank lines between, perhaps a line of titles."""

import gzip
import os
import re
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import FileError
from .clock_times import clock_seconds
from .columns import lines_of, with_points
from .text import ABSURD, shown

_STATES = {"tracked": 2.0, "inferred": 1.0, "nottracked": 0.0}  # as the sensors' SDKs spell them
_DECIMAL = re.compile(r"\d,\d+\s+[-+]?\d")  # numbers between blanks, with commas for points
_NO_NUMBER = re.compile(r"^[-+]?(?:nan(?:\(.*\))?|inf(?:inity)?|1\.#\w+|null|none|)$", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class NumberRows:
    """Titles (empty when there are none), rows (T, columns) with NaN for what is no number, what is wrong, and the
    cells (T,) of the column of names as they are written, where there is one. `clock` says that times were written as
    a clock shows them, and are s."""

    titles: tuple[str, ...]
    rows: Floats
    warnings: tuple[str, ...]
    named: tuple[str, ...] = ()
    clock: bool = False


@dataclass(frozen=True)
class Beside:
    """Columns whose cells need be no numbers: `whose` names somebody, who may have more digits than a number keeps;
    `time` may be written as a clock shows it; in `free` ones nothing is looked for. -1 for none."""

    whose: int = -1
    time: int = -1
    free: frozenset[int] = frozenset()


def unpacked(path: str | os.PathLike[str], wanted: str) -> bytes:
    """The bytes of a file, unzipped when it is gzip.

    Parameters
    ----------
    path : the file.
    wanted : what it should be, for the message.

    Raises
    ------
    FileError : not there, or a gzip file that is damaged or cut off.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(f"{path}: wanted {wanted}, cannot open it: {failure.strerror}; check the path") from None
    if raw[:2] != b"\x1f\x8b":
        return raw
    try:
        return gzip.decompress(raw)
    except (OSError, EOFError, zlib.error) as failure:
        raise FileError(f"{path}: wanted {wanted}, cannot unzip it: {failure}; get a complete copy") from None


def read_number_rows(
    path: str | os.PathLike[str], wanted: str, beside: Callable[[Sequence[str]], Beside] | None = None
) -> NumberRows:
    """Read a text of numbers; see `number_rows`.

    Raises
    ------
    FileError : as `unpacked` and `number_rows`.
    """
    return number_rows(lines_of(unpacked(path, wanted), str(path), wanted), str(path), wanted, beside)


def number_rows(
    lines: Sequence[str], name: str, wanted: str, beside: Callable[[Sequence[str]], Beside] | None = None
) -> NumberRows:
    """The rows of a text.

    A last row that is shorter than the others was cut off with the file: it is left out, and a warning says so.

    Parameters
    ----------
    lines : of the file; cells stand between tabs, semicolons, commas or blanks, perhaps in quotes. Where not commas
        part them they may stand for decimal points. The words for tracking states are 2, 1 and 0.
    name : of the file, for messages.
    wanted : what it should be, for messages.
    beside : of the titles, the columns whose cells need be no numbers.

    Raises
    ------
    FileError : no rows, rows of different lengths, or a cell that is no number.
    """
    used = [(k, line) for k, line in enumerate(lines, start=1) if line.strip()]
    separator = _separator(used[0][1])
    used = [(k, with_points(line.replace('"', ""), separator)) for k, line in used]
    titles: tuple[str, ...] = ()
    if any(_number(cell) is None for cell in _cells(used[0][1], separator)):
        titles = tuple(cell.strip() for cell in _cells(used[0][1], separator))
        used = used[1:]
    if not used:
        raise FileError(f"{name}: wanted {wanted}, there are titles and no rows; get a complete copy")
    split = [_cells(line, separator) for _, line in used]
    columns = len(split[0])
    warnings = []
    if len(split) > 1 and len(split[-1]) < columns:
        warnings.append(
            f"the file is cut off: its last row holds {len(split[-1])} of {columns} numbers and was left out"
        )
        split, used = split[:-1], used[:-1]
    elif lines[-1].strip():
        warnings.append("the last line has no line break: should the file be cut off there, its last value is wrong")
    if titles and len(titles) != columns:
        raise FileError(
            f"{name}: wanted {len(titles)} numbers in line {used[0][0]}, as there are titles, came {columns}; "
            f"the file is cut off or damaged"
        )
    rows = np.empty((len(split), columns))
    words = beside(titles) if beside is not None and titles else Beside()
    named = _column(split, columns, words.whose)
    passed = [*words.free, *([words.whose] if words.whose >= 0 else [])]
    stamps = clock_seconds(_column(split, columns, words.time))
    for k, cells in enumerate(split):
        if len(cells) != columns:
            raise FileError(
                f"{name}: wanted {columns} numbers in line {used[k][0]}, came {len(cells)}; the file is damaged"
            )
        for column in passed:
            cells[column] = "nan"
        if stamps is not None:
            cells[words.time] = repr(stamps[k])
        try:
            if "_" in used[k][1]:  # which Python would take for part of a number
                raise ValueError
            rows[k] = [float(cell) for cell in cells]
        except ValueError:
            rows[k] = [_told_number(cell, used[k][0], name) for cell in cells]
    rows[np.abs(rows) > ABSURD] = np.nan
    return NumberRows(titles, rows, tuple(warnings), named, stamps is not None)


def _column(split: Sequence[Sequence[str]], columns: int, column: int) -> tuple[str, ...]:
    """The cells of a column, of rows that are whole; none of a column that is not there."""
    return tuple(cells[column].strip() for cells in split if len(cells) == columns) if column >= 0 else ()


def split_cells(line: str) -> list[str]:
    """The cells of a line by whatever separates them, without empty ones behind the last."""
    separator = _separator(line)
    return _cells(with_points(line.replace('"', ""), separator), separator)


def numbers_of(cells: Sequence[str]) -> list[float] | None:
    """What cells hold, NaN where they say that there is none, 2, 1 and 0 for words of tracking states; None where one
    is another word."""
    found = [_number(cell) for cell in cells]
    known = [one for one in found if one is not None]
    return known if len(known) == len(found) else None


def _separator(line: str) -> str | None:
    """What stands between the cells of a line; None for blanks."""
    bare = line.strip()
    found = next((one for one in ("\t", ";", ",") if one in bare), None)
    return None if found == "," and _DECIMAL.search(bare) else found


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line without empty ones behind the last."""
    cells = line.split(separator)
    while len(cells) > 1 and not cells[-1].strip():
        cells.pop()
    return cells


def _number(cell: str) -> float | None:
    """The number in a cell, NaN for the spellings of none, None for other words."""
    text = cell.strip()
    if _NO_NUMBER.match(text):
        return float("nan")
    if text.lower() in _STATES:
        return _STATES[text.lower()]
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def _told_number(cell: str, line: int, name: str) -> float:
    value = _number(cell)
    if value is None:
        raise FileError(f"{name}: {shown(cell.strip())} in line {line} is no number; repair the file")
    return value
