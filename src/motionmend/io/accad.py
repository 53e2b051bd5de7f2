"""Marker text of the Advanced Computing Center for the Arts and Design (ACCAD): .txt, or a .zip that holds one.

One line of titles, `Field`, `Time`, then `<marker>:X`, `<marker>:Y`, `<marker>:Z` for each marker; then one row per
frame, separated by tabs. A missing marker is blank, or -9999.99 in all three.
"""

import codecs
import os
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..bodies.motion import Markers
from ..errors import FileError
from .columns import lines_of, read_rows, steady_rate, unended
from .marker_text import present_in_text
from .units import metres_per_unit
from .vertical import up_of

_MISSING = -9999.0  # positions are millimetres; nobody walks ten metres below the floor
_START = 4096  # bytes that hold the first titles
_UNREADABLE = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError)
_LARGEST = 1 << 29  # bytes a zip may unfold to
_WANTED = "ACCAD marker text"


def read_accad(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read markers from ACCAD's text.

    Parameters
    ----------
    path : .txt, or .zip with one .txt in it.
    fps : Hz, for a file with a single frame.

    Returns
    -------
    markers : positions in metres; the unit is guessed, the rate is taken from the times.

    Raises
    ------
    FileError : not there, not such a text, damaged, or a zip without exactly one .txt.
    """
    name = str(path)
    try:
        raw = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(f"{name}: wanted {_WANTED}, cannot open it: {failure.strerror}; check the path") from None
    if Path(path).suffix.lower() == ".zip":
        raw = _unzipped(path)
    lines = lines_of(raw, name, _WANTED)
    titles = [title.strip() for title in lines[0].split("\t")]
    while titles and not titles[-1]:
        titles.pop()
    names = _names(titles, name)
    rows = read_rows(lines[1:], "\t", len(titles), 2, name)
    if len(rows) > 1:
        rate, rate_guess = steady_rate(rows[:, 1], [line.split("\t", 2)[1] for line in lines[1 : len(rows) + 1]], name)
    elif fps is not None:
        rate, rate_guess = fps, (f"one frame states no rate: took {fps:g} Hz as given",)
    else:
        raise FileError(f"{name}: wanted two frames or more to tell the rate, came one; give it with --fps")
    values = rows[:, 2:].reshape(len(rows), len(names), 3)
    values = np.where((values <= _MISSING).all(axis=2, keepdims=True), np.nan, values)
    present, void_guesses = present_in_text(values)
    metres, unit_guess = metres_per_unit([], values, present, "the unit")
    positions = np.where(present[:, :, None], values * metres, np.nan)
    up, up_guess = up_of(names, positions)
    said = (*rate_guess, *unit_guess, *void_guesses, *((up_guess,) if up_guess else ()))
    return Markers(names, positions, rate, up=up, guesses=said, warnings=unended(lines))


def starts_as_accad(path: str | os.PathLike[str]) -> bool:
    """Whether a .txt, or one in a .zip, starts with the first two titles; also True for what cannot be opened."""
    try:
        if Path(path).suffix.lower() != ".zip":
            with Path(path).open("rb") as file:
                return _starts(file.read(_START))
        with zipfile.ZipFile(path) as archive:
            for entry in _texts(archive):
                with archive.open(entry) as text:
                    if _starts(text.read(_START)):
                        return True
            return False
    except _UNREADABLE:
        return True


def _starts(raw: bytes) -> bool:
    titles = raw.removeprefix(codecs.BOM_UTF8).lower().split(b"\t")
    return [title.strip() for title in titles[:2]] == [b"field", b"time"]


def _names(titles: Sequence[str], name: str) -> tuple[str, ...]:
    if [title.lower() for title in titles[:2]] != ["field", "time"] or len(titles) < 5 or len(titles) % 3 != 2:
        raise FileError(
            f"{name}: wanted {_WANTED} with titles Field, Time, <marker>:X, <marker>:Y, <marker>:Z, ...; "
            f"this file starts otherwise; check its ending"
        )
    names = []
    for k in range(2, len(titles), 3):
        marker = titles[k].rpartition(":")[0]
        if [title.upper() for title in titles[k : k + 3]] != [f"{marker}:{axis}".upper() for axis in "XYZ"]:
            raise FileError(f"{name}: wanted the titles of X, Y and Z of one marker in columns {k + 1} to {k + 3}")
        names.append(marker)
    if len(set(names)) < len(names) or "" in names:
        raise FileError(f"{name}: wanted a name of its own for each marker; rename the titles")
    return tuple(names)


def _texts(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    return [
        entry
        for entry in archive.infolist()
        if entry.filename.lower().endswith(".txt") and not entry.filename.startswith("__MACOSX/")
    ]


def _unzipped(path: str | os.PathLike[str]) -> bytes:
    """The one .txt in a zip."""
    try:
        with zipfile.ZipFile(path) as archive:
            texts = _texts(archive)
            if len(texts) != 1:
                raise FileError(f"{path}: wanted a zip with one .txt in it, came {len(texts)}; unpack it")
            if texts[0].file_size > _LARGEST:
                raise FileError(f"{path}: the text in this zip is larger than {_LARGEST >> 20} MB; unpack it")
            return archive.read(texts[0])
    except _UNREADABLE as failure:
        raise FileError(f"{path}: wanted a zip with {_WANTED}, cannot unpack it: {failure}") from None
