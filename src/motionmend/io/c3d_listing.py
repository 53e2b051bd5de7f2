"""The group MOTIONMEND of a C3D file: which samples a repair filled or replaced.

The residual of such a sample is 0, which in C3D means "not measured"; but many writers state 0 for everything, so the
samples are listed as well. Points are counted as in POINT:LABELS and frames as in the file, both from 1, whatever
number the header gives the first frame.

============== ======= ========= =====================================================================================
parameter      type    size      content
============== ======= ========= =====================================================================================
VERSION        integer           1, of this encoding
METHOD         text    1         the method of the last repair
POINTS         integer n         the points with samples that were filled, replaced or left open
LABELS         text    n         their labels
COUNTS         integer 3 x n     samples filled, replaced, left open
FILLED         integer 3 x k     ranges of filled samples: point, first frame, last frame
REPAIRED       integer 3 x k     ranges of replaced samples, likewise
JOINED         integer 2         for FILLED and for REPAIRED: 0 when the ranges are exact; else ranges of one point with
                                 at most so many frames between them are listed as one, because the parameters of a
                                 C3D file end at 130,560 bytes (REPAIRED gives way first); COUNTS is always exact
============== ======= ========= =====================================================================================

Integers are 16 bits without sign. Of a file with more than 32,767 frames COUNTS, FILLED and REPAIRED are 32-bit floats
instead, which hold such numbers exactly and read the same by programs that take integers to have a sign. A parameter
holds at most 255 columns; the next ones stand in COUNTS2, FILLED2 and so on, as C3D continues POINT:LABELS.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bools, Bytes, Ints
from ..bodies.motion import Origin
from ..errors import FileError
from .c3d_chain import GROUP, INTEGER, MOST_ROWS, REAL, Record, continued, textual, write_chain
from .c3d_layout import BLOCK, MOST_BLOCKS, Layout

NAME = "MOTIONMEND"
_VERSION = 1
_LAST_GROUP = 127
_SIGNED = 32_767  # the highest number that every reader takes an integer for
_LISTED = {Origin.FILLED: "FILLED", Origin.REPAIRED: "REPAIRED"}


def listed_points(layout: Layout) -> tuple[int, ...]:
    """Places (from 0) of the points that an earlier repair filled or replaced in part."""
    places = [columns[0] for origin in _LISTED for columns in _columns(layout, _LISTED[origin]).T]
    return tuple(sorted({int(place) - 1 for place in places if 1 <= place <= layout.points}))


def read_origin(layout: Layout, fourth: NDArray[np.int16]) -> Bytes:
    """(T, P) of `Origin` as an earlier repair listed it; MEASURED where it says nothing.

    `fourth` (T, P) are the points' fourth words: a sample that states cameras or a residual was measured, whatever
    range it stands in.
    """
    origin = np.full(fourth.shape, Origin.MEASURED, np.uint8)
    for kind in (Origin.REPAIRED, Origin.FILLED):
        for point, first, last in _columns(layout, _LISTED[kind]).T:
            if 1 <= point <= layout.points:
                origin[max(first - 1, 0) : last, point - 1] = kind
    return np.where(fourth == 0, origin, Origin.MEASURED).astype(np.uint8)


def listed_counts(layout: Layout) -> tuple[int, int]:
    """How many samples an earlier repair filled and how many it replaced."""
    filled, replaced, _ = _columns(layout, "COUNTS").sum(axis=1).tolist()
    return filled, replaced


def listed_method(layout: Layout) -> str | None:
    """The method of an earlier repair; None when the file has no group of ours."""
    return next(iter(layout.texts(NAME, "METHOD")), "") if layout.find(NAME, "VERSION") else None


def without_listing(records: Sequence[Record]) -> list[Record]:
    """The records without an earlier group of ours."""
    ours = {r.group for r in records if r.kind == GROUP and r.named(NAME)}
    return [r for r in records if r.group not in ours]


def with_listing(
    layout: Layout, records: Sequence[Record], labels: Sequence[str], origin: Bytes, method: str, name: str
) -> list[Record]:
    """The records and a new group of ours.

    Parameters
    ----------
    layout : of the file, for the way it writes numbers.
    records : without a group of ours.
    labels : (P,) of all points.
    origin : (T, P) of `Origin`.
    method : of the repair.
    name : of the file, for messages.

    Raises
    ------
    FileError : no room for another group.
    """
    room = BLOCK * MOST_BLOCKS - 4 - len(write_chain(records, layout.order))
    number = next((n for n in range(1, _LAST_GROUP + 1) if n not in {r.group for r in records}), _LAST_GROUP + 1)
    # Ranges are joined over twice as many frames each time, until the list fits.
    gaps = [0, *(2**k - 1 for k in range(1, len(origin).bit_length() + 1))]
    for joined in [*((0, gap) for gap in gaps), *((gap, gaps[-1]) for gap in gaps[1:])]:
        group = _group(layout, number, labels, origin, method, joined)
        if number <= _LAST_GROUP and len(write_chain(group, layout.order)) <= room:
            return [*records, *group]
    raise FileError(
        f"{name}: its parameters leave no room to list the repaired samples; remove parameters you can spare"
    )


def _group(
    layout: Layout, number: int, labels: Sequence[str], origin: Bytes, method: str, joined: tuple[int, int]
) -> list[Record]:
    touched = np.flatnonzero((origin != Origin.MEASURED).any(axis=0))
    kinds = (Origin.FILLED, Origin.REPAIRED, Origin.LEFT_OPEN)
    counts = np.array([(origin[:, touched] == kind).sum(axis=0) for kind in kinds])
    kind_of_number = INTEGER if len(origin) <= _SIGNED else REAL
    title = Record(NAME, number, False, GROUP, (), b"", b"Samples filled or replaced; points and frames from 1")
    records = [
        title,
        layout.numeric(number, "VERSION", _VERSION, INTEGER),
        *textual(number, "METHOD", [method]),
        layout.numeric(number, "JOINED", joined, INTEGER, "FILLED, REPAIRED; 0: exact"),
    ]
    records += _continued(layout, number, "POINTS", touched + 1, INTEGER, "Places in POINT:LABELS")
    records += textual(number, "LABELS", [labels[int(k)] for k in touched])
    records += _continued(layout, number, "COUNTS", counts, kind_of_number, "Filled, replaced, left open")
    for (kind, parameter), gap in zip(_LISTED.items(), joined, strict=True):
        ranges = _ranges(origin == kind, gap)
        records += _continued(layout, number, parameter, ranges, kind_of_number, "Point, first frame, last frame")
    return records


def _ranges(chosen: Bools, joined: int) -> Ints:
    """(3, k) point, first and last frame (from 1) of every run of True down the columns of (T, P)."""
    frames, points = chosen.shape
    padded = np.zeros((points, frames + 2), np.int8)
    padded[:, 1:-1] = chosen.T
    steps = np.diff(padded, axis=1)
    point, first = np.nonzero(steps == 1)
    last = np.nonzero(steps == -1)[1]
    starts = np.ones(len(first), bool)
    starts[1:] = (point[1:] != point[:-1]) | (first[1:] - last[:-1] > joined)
    ends = np.roll(starts, -1)
    return np.array([point[starts] + 1, first[starts] + 1, last[ends]], np.int64).reshape(3, -1)


def _continued(layout: Layout, number: int, name: str, columns: Ints, kind: int, description: str) -> list[Record]:
    parts = range(0, max(columns.shape[-1], 1), MOST_ROWS)
    return [
        layout.numeric(number, continued(name, k), columns[..., at : at + MOST_ROWS], kind, description)
        for k, at in enumerate(parts)
    ]


def _columns(layout: Layout, name: str) -> Ints:
    """(3, k) of a parameter of ours and its continuations."""
    found, part = [], 0
    while (values := layout.numbers(NAME, continued(name, part))).size:
        found.append(values[: values.size // 3 * 3].reshape(-1, 3))
        part += 1
    return np.concatenate(found).T.astype(np.int64) if found else np.empty((3, 0), np.int64)
