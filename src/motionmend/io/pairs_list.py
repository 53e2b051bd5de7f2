"""Lists of pairs, .csv: which sensor's recording goes with which truth.

`sensor,truth,offset_s`: paths, absolute or relative to the list; the sensor's time + offset = the truth's time, and
where the cell is blank the offset is not known. Columns may stand in any order, others beside them are not read.
"""

import csv
import os
from dataclasses import dataclass
from pathlib import Path

from ..errors import FileError
from .columns import read_lines
from .text import finite, shown

_WANTED = "a list of pairs with the titles sensor,truth,offset_s"


@dataclass(frozen=True)
class Listed:
    """One row of a list: two files, the offset of time in s or None, and the row's line in the list."""

    sensor: Path
    truth: Path
    offset: float | None
    line: int


def read_pairs_list(path: str | os.PathLike[str]) -> tuple[Listed, ...]:
    """Read a list of pairs.

    Parameters
    ----------
    path : the .csv.

    Raises
    ------
    FileError : not there, not such a list, empty, or a row that lacks a file or whose offset is no number.
    """
    lines = read_lines(path, _WANTED)
    separator = next((one for one in (",", ";", "\t") if one in lines[0]), ",")
    rows = list(csv.reader(lines, delimiter=separator))
    titles = [title.strip().lower() for title in rows[0]]
    if not {"sensor", "truth"} <= set(titles):
        raise FileError(f"{path}: wanted {_WANTED}, its first line is {shown(lines[0])}")
    where = {title: titles.index(title) for title in ("sensor", "truth", "offset_s") if title in titles}
    folder = Path(path).parent
    found = []
    for line, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        cells = {title: row[k].strip() if k < len(row) else "" for title, k in where.items()}
        if not cells["sensor"] or not cells["truth"]:
            raise FileError(f"{path}: wanted a sensor and a truth in line {line}, one is blank; fill it in")
        try:
            spelt = cells.get("offset_s", "")
            spelt = spelt if separator == "," else spelt.replace(",", ".")  # as spreadsheets of many countries have it
            offset = finite(spelt) if spelt else None
        except ValueError:
            raise FileError(
                f"{path}: wanted seconds under offset_s in line {line}, came {shown(cells['offset_s'])}; "
                f"leave it blank where it is not known"
            ) from None
        known = None if offset is None or offset != offset else offset
        found.append(Listed(folder / cells["sensor"], folder / cells["truth"], known, line))
    if not found:
        raise FileError(f"{path}: wanted pairs below the titles, came none")
    return tuple(found)
