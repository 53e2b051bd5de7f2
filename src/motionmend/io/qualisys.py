"""TSV of Qualisys Track Manager: marker positions in millimetres as tab-separated text under lines of keys.

`NO_OF_FRAMES`, `FREQUENCY`, `MARKER_NAMES` and others, each with its values; then, if the exporter was asked for them,
a line of titles, and in each row the frame and its time before the positions. A missing marker is 0 0 0, blank or NULL,
as the exporter was asked; it is written as the file had it.
"""

import codecs
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bodies.motion import Markers
from ..errors import FileError
from .atomic import atomic
from .columns import cells_of, read_lines, read_rows, unended
from .marker_text import against_promise, coordinates_for_text, number_of, present_in_text, refuse_twice
from .units import metres_per_unit
from .vertical import up_of

_WANTED = "a Qualisys TSV file"
_NULL = "NULL"


@dataclass(frozen=True, eq=False)
class QualisysSource:
    """What a TSV file says beside names and positions.

    Attributes
    ----------
    head : its lines before the rows, of keys and, if there is one, of titles.
    numbered : each row begins with its frame and its time in s, these in the first.
    missing : how the coordinates of a missing marker are written.
    """

    head: tuple[str, ...]
    numbered: tuple[float, float] | None
    missing: str


def read_qualisys(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read the markers of a TSV file that Qualisys Track Manager exported with its header.

    Parameters
    ----------
    path : the file.
    fps : Hz, for a file without FREQUENCY.

    Returns
    -------
    markers : positions in metres.

    Raises
    ------
    FileError : not there, not such a file (bodies of six degrees of freedom are none), or shorter than it promises.
    """
    name = str(path)
    lines = read_lines(path, _WANTED)
    begin = next((k for k, line in enumerate(lines) if _starts_with_number(line)), len(lines))
    head = {cells[0].strip().upper(): cells[1:] for cells in (line.split("\t") for line in lines[:begin])}
    names = [one.strip() for one in head.get("MARKER_NAMES", ()) if one.strip()]
    if not names:
        raise FileError(f"{name}: wanted {_WANTED} with a line MARKER_NAMES, there is none; export it with its header")
    if head.get("DATA_INCLUDED", ["3D"])[0].strip().upper() != "3D":
        raise FileError(f"{name}: wanted DATA_INCLUDED 3D, came {head['DATA_INCLUDED'][0].strip()}; export the 3D data")
    refuse_twice(names, name)
    stated, promised = (number_of(head.get(key, [""])[0]) for key in ("FREQUENCY", "NO_OF_FRAMES"))
    rate = stated or fps
    if rate is None:
        raise FileError(f"{name}: wanted a FREQUENCY above 0 Hz, this TSV file states none; give it with --fps")
    rows_text = [
        "\t".join("" if cell.strip() == _NULL else cell for cell in line.split("\t")) for line in lines[begin:]
    ]
    numbered = bool(rows_text) and len(rows_text[0].split("\t")) >= 2 + 3 * len(names)
    skipped = 2 if numbered else 0
    rows = read_rows(rows_text, "\t", skipped + 3 * len(names), begin + 1, name)
    values = rows[:, skipped:].reshape(len(rows), len(names), 3)
    blank = bool(np.isnan(values).any())
    present, void_guesses = present_in_text(values)
    metres, unit_guess = metres_per_unit(["mm"], values, present, "the unit of TSV")
    positions = np.where(present[:, :, None], values * metres, np.nan)
    up, up_guess = up_of(names, positions)
    said = (*against_promise(promised, len(rows), "NO_OF_FRAMES", name), *unit_guess, *void_guesses)
    said += () if stated else (f"the file states no frame rate: took {rate:g} Hz as given",)
    said += (up_guess,) if up_guess else ()
    missing = (_NULL if any(f"\t{_NULL}" in line for line in lines[begin:]) else "") if blank else "0.000"
    start = (float(rows[0, 0]), float(rows[0, 1])) if numbered else None
    source = QualisysSource(tuple(lines[:begin]), start, missing)
    return Markers(tuple(names), positions, rate, up=up, source=source, guesses=said, warnings=unended(lines))


def write_qualisys(path: str | os.PathLike[str], markers: Markers) -> None:
    """Write markers to a TSV file.

    Parameters
    ----------
    path : the file.
    markers : positions in metres, written in millimetres: with the header, and the missing written as in the TSV file
        that they came from; else with a header of the keys that matter.

    Raises
    ------
    FileError : a name that a TSV file cannot hold, or the file cannot be written.
    """
    rows = coordinates_for_text(markers, 0.001, path, _WANTED)
    source = markers.source if isinstance(markers.source, QualisysSource) else _fresh(markers)
    stated = {"NO_OF_FRAMES": str(markers.frames), "FREQUENCY": f"{markers.fps:.9g}"}
    lines = [_restated(line, stated) for line in source.head]
    first, start = source.numbered or (0.0, 0.0)
    times = cells_of(start + np.arange(markers.frames) / markers.fps)
    for k, row in enumerate(rows):
        cells = [cell or source.missing for cell in cells_of(row)]
        lines.append("\t".join([f"{first + k:.0f}", times[k], *cells] if source.numbered else cells))
    with atomic(path) as temporary:
        temporary.write_bytes(("\n".join(lines) + "\n").encode())


def starts_as_qualisys(path: str | os.PathLike[str]) -> bool:
    """Whether a .tsv starts with one of Qualisys' keys; also True for what cannot be opened."""
    try:
        with Path(path).open("rb") as file:
            start = file.read(64).removeprefix(codecs.BOM_UTF8).upper()
    except OSError:
        return True
    return start.startswith((b"NO_OF_", b"MARKER_NAMES", b"FREQUENCY", b"DATA_INCLUDED"))


def _fresh(markers: Markers) -> QualisysSource:
    names = "\t".join(markers.names)
    keys = ("NO_OF_FRAMES\t", f"NO_OF_MARKERS\t{len(markers.names)}", "FREQUENCY\t", "DATA_INCLUDED\t3D")
    titles = "\t".join(f"{name} {axis}" for name in markers.names for axis in "XYZ")
    return QualisysSource((*keys, f"MARKER_NAMES\t{names}", f"Frame\tTime\t{titles}"), (1.0, 0.0), "")


def _restated(line: str, stated: dict[str, str]) -> str:
    """A line of the header with the value that now holds."""
    key = line.split("\t", 1)[0]
    return f"{key}\t{stated[key.upper()]}" if key.upper() in stated else line


def _starts_with_number(line: str) -> bool:
    try:
        float(line.split("\t", 1)[0].replace(_NULL, "") or "0" if line.strip() else "")
    except ValueError:
        return False
    return True
