"""Columns of numbers in text files: what .trc, .csv and ACCAD's marker text have in common."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import FileError
from .text import ABSURD, shown

_EVEN = 0.02  # of a frame; more is worth a sentence
_UNEVEN = 0.25  # of a frame; more is no frame rate


def read_lines(path: str | os.PathLike[str], wanted: str) -> list[str]:
    """The lines of a text file without their ends.

    Parameters
    ----------
    path : the file.
    wanted : what it should be, for messages, such as "a TRC file".

    Raises
    ------
    FileError : not there, empty, or not text.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(f"{path}: wanted {wanted}, cannot open it: {failure.strerror}; check the path") from None
    return lines_of(raw, str(path), wanted)


def lines_of(raw: bytes, name: str, wanted: str) -> list[str]:
    """The same for a file that was read already."""
    if not raw.strip():
        raise FileError(f"{name}: wanted {wanted}, came an empty file; get a complete copy")
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):  # UTF-16, as spreadsheets save text
        raw = raw.decode("utf-16", errors="replace").encode()
    if b"\0" in raw:
        raise FileError(f"{name}: wanted {wanted}, came binary data; check the file's ending")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def with_points(line: str, separator: str | None) -> str:
    """A line of numbers whose cells something else than commas parts, with points for decimal commas; any other line
    as it is."""
    return line if separator == "," or "." in line else line.replace(",", ".")


def read_rows(lines: Sequence[str], separator: str, columns: int, first: int, name: str) -> Floats:
    """Numbers of the lines, NaN where a cell is blank.

    Parameters
    ----------
    lines : one row each; blank lines may follow the last row.
    separator : of the cells.
    columns : wanted in every row; blank cells beyond are let pass.
    first : number of the first line in the file, for messages.
    name : of the file.

    Returns
    -------
    rows : (T, columns), T > 0.

    Raises
    ------
    FileError : no rows, a row of another length, or a cell that is no number.
    """
    used = len(lines)
    while used and not lines[used - 1].strip():
        used -= 1
    if not used:
        raise FileError(f"{name}: wanted rows of numbers from line {first} on, the file ends before; it is cut off")
    rows = np.empty((used, columns))
    for k in range(used):
        cells = lines[k].split(separator)
        if len(cells) < columns or any(cell.strip() for cell in cells[columns:]):
            raise FileError(
                f"{name}: wanted {columns} cells in line {first + k}, came {len(cells)}; the file is cut off or damaged"
            )
        try:
            if "_" in lines[k]:  # which Python would take for part of a number
                raise ValueError
            rows[k] = [float(cell) if cell and not cell.isspace() else np.nan for cell in cells[:columns]]
        except ValueError:
            raise FileError(
                f"{name}: {_first_wrong(cells)} in line {first + k} is no number; repair the file"
            ) from None
    absurd = (np.abs(rows) > ABSURD).any(axis=1)
    if absurd.any():
        line = first + int(np.flatnonzero(absurd)[0])
        raise FileError(f"{name}: a number in line {line} is infinite or absurdly large; leave missing cells blank")
    return rows


UNENDED = "the last line has no line break: should the file be cut off there, its last value is wrong"


def unended(lines: Sequence[str]) -> tuple[str, ...]:
    """A sentence when the last line has no end: then nobody can tell a whole file from one cut off in its last cell."""
    if not lines[-1].strip():
        return ()
    return (UNENDED,)


def steady_rate(times: Floats, spelt: Sequence[str], name: str) -> tuple[float, tuple[str, ...]]:
    """Frames per second of a column of times.

    Parameters
    ----------
    times : (T,) s, T > 1.
    spelt : (T,) the times as the file spells them; their digits say how exact they are.
    name : of the file, for messages.

    Returns
    -------
    fps : Hz; the roundest number that the times allow, when they are exact to a thousandth (two decimals at most).
    guesses : a sentence when the times stray by more than 2 % of a frame.

    Raises
    ------
    FileError : times are missing, do not rise, or stray by more than a quarter of a frame.
    """
    if not np.isfinite(times).all():
        raise FileError(
            f"{name}: the time of row {int(np.flatnonzero(~np.isfinite(times))[0]) + 1} is missing; fill it in"
        )
    span, steps = float(times[-1] - times[0]), len(times) - 1
    if span <= 0:
        raise FileError(f"{name}: wanted times that rise, they go from {times[0]:g} to {times[-1]:g} s; repair them")
    stray = np.abs(times - (times[0] + np.arange(steps + 1) * (span / steps))) * (steps / span)
    worst = int(np.argmax(stray))
    if stray[worst] > _UNEVEN:
        raise FileError(
            f"{name}: wanted evenly spaced times, row {worst + 1} is {stray[worst]:.2f} frames off; resample it first"
        )
    exact = steps / span
    slack = 2 * _half_digit(spelt, float(np.abs(times).max()))
    slack = slack if slack < 1e-3 * span else 1e-12 * span
    rounder = (round(exact, digits) for digits in range(3))
    fps = next((r for r in rounder if r > 0 and abs(steps / r - span) <= slack), exact)
    said = (f"times stray by up to {stray[worst]:.2f} of a frame: took an even {fps:g} Hz",)
    return fps, said if stray[worst] > _EVEN else ()


def cells_of(values: Floats) -> list[str]:
    """Numbers with 9 significant digits, blank for NaN."""
    return ["" if value != value else f"{value:.9g}" for value in values.tolist()]


def _half_digit(spelt: Sequence[str], largest: float) -> float:
    """Half of the last place of `largest` among numbers with so many decimals, or so many significant digits."""
    mantissas = [token.strip().lower().partition("e")[0].lstrip("+-") for token in spelt]
    decimals = max(len(mantissa.partition(".")[2]) for mantissa in mantissas)
    significant = max(len(mantissa.replace(".", "").lstrip("0")) for mantissa in mantissas)
    return 0.5 * float(max(10.0**-decimals, 10.0 ** (np.floor(np.log10(largest)) - significant + 1)))


def _first_wrong(cells: Sequence[str]) -> str:
    for cell in cells:
        try:
            float(cell.replace("_", "x") or "0")
        except ValueError:
            return shown(cell.strip())
    return "a cell"
