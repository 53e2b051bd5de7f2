"""Arrays of numbers in MATLAB files of level 5 (versions 5 to 7), every length held against what is there.

scipy's reader goes by what the file says of itself: of one that is damaged it reads beyond the end of memory, which
ends the process, and with it all that the process was asked to do.

MathWorks: MAT-File Format, chapter 1.
"""

import math
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

_HEADER, _TAG, _HEAD = 128, 8, 1024  # bytes: of a file, before an element, of an array beyond all before its numbers
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}  # as stored
_NUMBERS = {6: "double", 7: "single", 8: "int8", 9: "uint8", 10: "int16", 11: "uint16", 12: "int32", 13: "uint32"}
_NUMBERS |= {14: "int64", 15: "uint64"}
_OTHERS = {1: "cell", 2: "struct", 3: "object", 4: "char", 5: "sparse", 16: "function", 17: "opaque"}
_COMPLEX = 0x0800

Array: TypeAlias = np.ndarray[Any, Any]


class MatError(ValueError):
    """What is no such file, or damaged, and what to do; one line without the file's name."""

    def __init__(self, why: str, remedy: str = "get a complete copy") -> None:
        super().__init__(f"{why}; {remedy}")


@dataclass(frozen=True)
class Variable:
    """One variable of a file, its numbers unread.

    Attributes
    ----------
    name, shape : as MATLAB has them.
    kind : double, single, int8 ... uint64; complex, char, cell, struct or what else holds no plain numbers.
    body : of the element, as it stands in the file.
    packed : whether that is compressed.
    order : of bytes, `<` or `>`.
    """

    name: str
    shape: tuple[int, ...]
    kind: str
    body: bytes
    packed: bool
    order: str

    @property
    def numeric(self) -> bool:
        """Whether it holds plain numbers."""
        return self.kind in _NUMBERS.values()

    def numbers(self) -> Array:
        """Its numbers, of the type they are stored as, which for whole ones may be a shorter one than its kind.

        Raises
        ------
        MatError : it holds none, or not as many as its shape promises.
        """
        if not self.numeric:
            raise MatError(f"{self.name} holds no plain numbers but {self.kind}")
        body = _unpacked(self.body, _HEAD + 8 * math.prod(self.shape), whole=True)[_TAG:] if self.packed else self.body
        kind, data = list(_parts(body, self.order, 4))[-1]
        if kind not in _TYPES:
            raise MatError(f"{self.name} is stored as type {kind}, which there is not")
        values = np.frombuffer(
            data[: len(data) - len(data) % np.dtype(_TYPES[kind]).itemsize], self.order + _TYPES[kind]
        )
        if values.size != math.prod(self.shape):
            raise MatError(f"{self.name} promises {math.prod(self.shape)} numbers and holds {values.size}")
        return np.asarray(values.astype(_TYPES[kind]).reshape(self.shape, order="F"))


def variables(path: str | os.PathLike[str]) -> tuple[Variable, ...]:
    """What a file holds.

    Parameters
    ----------
    path : the .mat.

    Raises
    ------
    OSError : the file cannot be opened.
    MatError : it is no MATLAB file of level 5, cut off or damaged.
    """
    data = Path(path).read_bytes()
    if len(data) < _HEADER:
        raise MatError("this is no MATLAB file, or it is cut off")
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None or 0 in data[:4]:
        if _of_version_4(data):
            raise MatError("a MATLAB 4 file, none of version 5 to 7", "save it with -v7 to have it read")
        raise MatError("this is no MATLAB file of version 5 to 7, or its header is damaged")
    if struct.unpack(f"{order}H", data[124:126])[0] >> 8 == 2:
        raise MatError("a MATLAB 7.3 file", "save it with -v7 to have it read")
    found = []
    for kind, body in _elements(data[_HEADER:], order, padded=False):
        packed = kind == _COMPRESSED
        head = body
        if packed:
            head = _unpacked(body, _HEAD)
            kind, head = struct.unpack(f"{order}I", head[:4])[0] if len(head) > _TAG else 0, head[_TAG:]
        if kind == _MATRIX:
            found.append(_variable(head, body, packed, order))
    return tuple(found)


def _of_version_4(data: bytes) -> bool:
    """Whether a file begins as those of level 4: type, rows, columns, whether complex, and the length of a name."""
    for order in "<>":
        kind, rows, columns, imaginary, name = struct.unpack(f"{order}5i", data[:20])
        if 0 <= kind < 5000 and rows >= 0 and columns >= 0 and imaginary in (0, 1) and 1 < name < 64:
            return True
    return False


def _variable(head: bytes, body: bytes, packed: bool, order: str) -> Variable:
    (_, flags), (_, shape), (_, name) = _parts(head, order, 3)
    if len(flags) < 4 or len(shape) < 8 or len(shape) % 4:
        raise MatError("an array without a kind or a shape: the file is damaged")
    told = struct.unpack(f"{order}I", flags[:4])[0]
    kind = (_NUMBERS | _OTHERS).get(told & 0xFF, "unknown")
    sizes = struct.unpack(f"{order}{len(shape) // 4}i", shape)
    if min(sizes) < 0:
        raise MatError("an array of a negative size: the file is damaged")
    named = bytes(name).rstrip(b"\0").decode("utf-8", "replace")
    return Variable(named, sizes, "complex" if told & _COMPLEX else kind, body, packed, order)


def _parts(array: bytes, order: str, count: int) -> list[tuple[int, bytes]]:
    """The first elements within an array, whose tag is left out; with all four the last is its numbers."""
    found = []
    for part in _elements(array, order, padded=True):
        found.append(part)
        if len(found) == count:
            return found
    raise MatError("an array ends before its numbers: the file is cut off or damaged")


def _elements(data: bytes, order: str, *, padded: bool) -> Iterator[tuple[int, bytes]]:
    """Type and body of each element; short ones stand within their tag, and those within an array fill 8 bytes."""
    at = 0
    while at < len(data):
        if at + _TAG > len(data):
            raise MatError("the file is cut off")
        kind, size = struct.unpack(f"{order}II", data[at : at + _TAG])
        if kind >> 16:
            kind, size, start, after = kind & 0xFFFF, kind >> 16, at + 4, at + _TAG
        else:
            start = at + _TAG
            after = start + size + (-size % _TAG if padded else 0)
        if size > len(data) - start or (start == at + 4 and size > 4):
            raise MatError("an element is longer than what is there: the file is cut off or damaged")
        yield kind, data[start : start + size]
        at = after


def _unpacked(body: bytes, most: int, *, whole: bool = False) -> bytes:
    """A compressed element with its tag: the first `most` bytes of it, or the `whole` if that is no longer."""
    packer = zlib.decompressobj()
    try:
        data = packer.decompress(body, most)
    except zlib.error as error:
        raise MatError(f"a compressed array is damaged ({error})") from None
    if whole and not packer.eof:
        why = "is cut off" if len(data) < most else "unpacks to more than its shape promises"
        raise MatError(f"a compressed array {why}")
    return data
