"""The parameters of a C3D file: a chain of groups and of the parameters in them.

Each link is: length of the name (negative when locked), number of the group (negative for the group itself), name,
bytes to the next link, then for a parameter type, dimensions and values (first dimension runs fastest), and a
description. A name or group number of zero ends the chain.

Source: C3D User Guide, Motion Lab Systems, chapter on the parameter section.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import prod

from ..errors import FileError

MOST_ROWS = 255  # a dimension of a parameter is stated in one byte
GROUP, TEXT, BYTE, INTEGER, REAL = 0, -1, 1, 2, 4  # the file's own codes; a group has none, 0 stands for it
_LARGEST = 0xFFFF - 2  # the way to the next link is stated in 16 bits


@dataclass(frozen=True)
class Record:
    """One link of the chain: a group, or a parameter of the group with the same number; name as it is spelt."""

    name: str
    group: int
    locked: bool
    kind: int
    dims: tuple[int, ...]
    values: bytes
    description: bytes

    def named(self, name: str) -> bool:
        """Whether this is `name`; C3D names mean the same in upper and lower case."""
        return self.name.strip().upper() == name


def textual(group: int, name: str, rows: Sequence[str], description: str = "") -> list[Record]:
    """A new text parameter, continued in NAME2, NAME3, ... after 255 strings each; bytes beyond 255 are cut off."""
    encoded = [row.encode()[:MOST_ROWS] for row in rows]
    width = max([len(row) for row in encoded], default=0)
    parts = [encoded[k : k + MOST_ROWS] for k in range(0, max(len(encoded), 1), MOST_ROWS)]
    return [
        Record(
            continued(name, k),
            group,
            False,
            TEXT,
            (width, len(part)),
            b"".join(row.ljust(width) for row in part),
            description.encode(),
        )
        for k, part in enumerate(parts)
    ]


def continued(name: str, part: int) -> str:
    """NAME, NAME2, NAME3, ... for part 0, 1, 2, ..., as C3D continues what has more than 255 rows."""
    return name if part == 0 else f"{name}{part + 1}"


def with_values(records: Iterable[Record], old: Record | None, values: bytes) -> list[Record]:
    """The records, with other values in one of them."""
    return [replace(r, values=values) if r is old else r for r in records]


def read_chain(raw: bytes, at: int, order: str, name: str) -> tuple[tuple[Record, ...], int]:
    """All records from byte `at` on, and the byte after the last one."""
    records: list[Record] = []
    while True:
        if at + 2 > len(raw):
            raise FileError(
                f"{name}: the parameters of this C3D file run over its end; it is cut off or damaged: "
                "get a complete copy"
            )
        length, number = struct.unpack_from("2b", raw, at)
        if length == 0 or number == 0:
            return tuple(records), at + 2
        named = at + 2 + abs(length)
        try:
            (offset,) = struct.unpack_from(order + "H", raw, named)
            record, end = _record(raw, named + 2, number, raw[at + 2 : named], length < 0)
        except (struct.error, IndexError):
            raise FileError(
                f"{name}: parameter {len(records) + 1} of this C3D file runs over its end; it is cut off or damaged: "
                "get a complete copy"
            ) from None
        if offset and named + offset < end - (1 + len(record.description)):
            raise FileError(
                f"{name}: parameter {record.name!r} of this C3D file is longer than it says; the file is damaged: "
                "get a complete copy"
            )
        if offset and named + offset < end:
            record = replace(record, description=b"")  # some writers leave the description out
        records.append(record)
        if offset == 0:
            return tuple(records), end
        at = named + offset


def _record(raw: bytes, at: int, number: int, name: bytes, locked: bool) -> tuple[Record, int]:
    """The content of one record from byte `at` on, and the byte after it."""
    kind, values, dims = GROUP, b"", tuple[int, ...]()
    if number > 0:
        kind, count = struct.unpack_from("bB", raw, at)
        dims = tuple(raw[at + 2 : at + 2 + count])
        at += 2 + count
        size = abs(kind) * prod(dims)
        values = raw[at : at + size]
        if kind not in (TEXT, BYTE, INTEGER, REAL) or size > _LARGEST or len(values) < size:
            raise IndexError
        at += size
    length = raw[at]
    record = Record(name.decode("latin-1"), abs(number), locked, kind, dims, values, raw[at + 1 : at + 1 + length])
    return record, at + 1 + length


def write_chain(records: Sequence[Record], order: str) -> bytes:
    """The chain of records, closed by two zeros."""
    links = []
    for r in records:
        name = r.name.encode("latin-1")
        number = -r.group if r.kind == GROUP else r.group
        content = b"" if r.kind == GROUP else struct.pack(f"bB{len(r.dims)}B", r.kind, len(r.dims), *r.dims) + r.values
        content += bytes([len(r.description)]) + r.description
        head = struct.pack("2b", -len(name) if r.locked else len(name), number) + name
        links.append(head + struct.pack(order + "H", 2 + len(content)) + content)
    return b"".join(links) + b"\0\0"
