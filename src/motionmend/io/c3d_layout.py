"""The bytes of a C3D file: header, chain of parameters, frames; enough to change some and leave the rest alone.

A C3D file is a 512-byte header, a chain of groups and parameters in blocks of 512 bytes, and one row of numbers
per frame: x, y, z and a fourth word for each point, then the analog samples. The fourth word is a 16-bit integer,
-1 for a missing point, else a 7-bit camera mask in the high byte and the residual divided by |POINT:SCALE| in the low
byte. Rows are 16-bit integers when POINT:SCALE is positive and 32-bit floats when it is negative; numbers are
Intel's, DEC's (floats of the VAX) or MIPS's (big-endian).

Source: C3D User Guide, Motion Lab Systems, chapters on the header, parameter and 3D data sections.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats
from ..errors import FileError, counted
from .c3d_chain import BYTE, GROUP, INTEGER, REAL, TEXT, Record, continued, read_chain, write_chain

BLOCK = 512
MOST_COUNTED = 65_535  # frames that the header and POINT:FRAMES count, in 16 bits; two parameters count further
MOST_BLOCKS = 255  # the parameter section states its length in one byte
INTEL, DEC, MIPS = 84, 85, 86
_MOST_BLOCKS_BEFORE = 65_535  # a pointer to a section has 16 bits
_RANGES_FOLLOW = 12345  # header word 148: word 149 points at a section of label ranges


@dataclass(frozen=True, eq=False)
class Layout:
    """Where everything stands in one C3D file; positions in bytes, `scale` in the file's unit of length per step."""

    processor: int
    records: tuple[Record, ...] = ()
    parameters_at: int = BLOCK
    parameters_end: int = BLOCK
    data_at: int = BLOCK
    points: int = 0
    analogs: int = 0
    header_frames: int = 0
    first_frame: int = 1
    header_rate: float = 0.0
    scale: float = -1.0

    @property
    def integers(self) -> bool:
        """Whether rows are 16-bit integers, not floats."""
        return self.scale > 0

    @property
    def row(self) -> int:
        """Numbers in one frame."""
        return 4 * self.points + self.analogs

    @property
    def stride(self) -> int:
        """Bytes of one frame."""
        return self.row * (2 if self.integers else 4)

    @property
    def order(self) -> str:
        """Byte order of integers, as numpy and struct spell it."""
        return ">" if self.processor == MIPS else "<"

    def find(self, group: str, name: str) -> Record | None:
        """The parameter GROUP:NAME, or None."""
        number = next((r.group for r in self.records if r.kind == GROUP and r.named(group)), None)
        same = (r for r in self.records if r.kind != GROUP and r.group == number and r.named(name))
        return next(same, None)

    def numbers(self, group: str, name: str) -> Floats:
        """Values of a numeric parameter in file order, integers without sign; empty when absent or text."""
        record = self.find(group, name)
        if record is None or record.kind in (TEXT, GROUP):
            return np.empty(0)
        if record.kind == REAL:
            return self.decode(np.frombuffer(record.values, "<u4")).astype(np.float64)
        dtype = "u1" if record.kind == BYTE else self.order + "u2"
        return np.frombuffer(record.values, dtype).astype(np.float64)

    def number(self, group: str, name: str) -> float:
        """First value of a numeric parameter; 0 when absent or not finite."""
        found = self.numbers(group, name)
        return float(found[0]) if found.size and np.isfinite(found[0]) else 0.0

    def texts(self, group: str, name: str) -> tuple[str, ...]:
        """Strings of a text parameter and of its continuations NAME2, NAME3, ...; blanks at the ends cut off."""
        found: list[str] = []
        record, part = self.find(group, name), 0
        while record is not None and record.kind == TEXT:
            width = record.dims[0] if record.dims else 1
            rows = len(record.values) // width if width else int(np.prod(record.dims[1:]))
            found += [_text(record.values[k * width : (k + 1) * width]) for k in range(rows)]
            part += 1
            record = self.find(group, continued(name, part))
        return tuple(found)

    def decode(self, words: NDArray[Any]) -> NDArray[np.float32]:
        """Floats of raw 32-bit words (read as little-endian)."""
        bits = np.ascontiguousarray(words, "<u4")
        if self.processor == MIPS:
            return np.asarray(bits.byteswap().view("<f4"), np.float32)
        if self.processor == DEC:  # the halves are swapped and the exponent is larger by 2
            with np.errstate(invalid="ignore"):  # a damaged file may hold any bits
                return np.asarray(((bits >> 16) | (bits << 16)).view("<f4") / 4, np.float32)
        return np.asarray(bits.view("<f4"), np.float32)

    def encode(self, floats: NDArray[Any]) -> NDArray[np.uint32]:
        """Raw 32-bit words (to be written as little-endian) of finite floats."""
        values = np.ascontiguousarray(floats, "<f4")
        if self.processor == MIPS:
            return np.asarray(values.view("<u4").byteswap(), np.uint32)
        if self.processor == DEC:
            bits = (values * np.float32(4)).view("<u4")
            return np.asarray((bits >> 16) | (bits << 16), np.uint32)
        return np.asarray(values.view("<u4"), np.uint32)

    def rows(self, raw: bytes, frames: int) -> NDArray[Any]:
        """(frames, row) of the numbers as they are stored: 16-bit integers, or raw 32-bit words."""
        dtype = self.order + "i2" if self.integers else "<u4"
        return np.frombuffer(raw, dtype, frames * self.row, self.data_at).reshape(frames, self.row)

    def fourth_words(self, rows: NDArray[Any]) -> NDArray[np.int16]:
        """(frames, points) -1 or camera mask and residual of each point."""
        words = rows[:, 3 : 4 * self.points : 4]
        values = words if self.integers else np.nan_to_num(self.decode(words))
        return np.asarray(np.clip(values, -32_768, 32_767).astype(np.int16))

    def coordinates(self, rows: NDArray[Any]) -> NDArray[np.float32]:
        """(frames, points, 3) in the file's unit, without regard to what is missing."""
        stored = rows[:, : 4 * self.points].reshape(len(rows), self.points, 4)[:, :, :3]
        return np.asarray(stored * self.scale, np.float32) if self.integers else self.decode(stored)

    def numeric(self, group: int, name: str, values: Any, kind: int, description: str = "") -> Record:
        """A new parameter of kind INTEGER (16 bits, up to 65,535) or REAL; any shape, a scalar has no dimension."""
        array = np.asarray(values)
        column_first = array.ravel(order="F")
        stored = column_first.astype(self.order + "u2") if kind == INTEGER else self.encode(column_first)
        return Record(name, group, False, kind, array.shape, stored.tobytes(), description.encode())


def parse(raw: bytes, name: str) -> Layout:
    """Read header and parameters of a C3D file.

    Parameters
    ----------
    raw : the whole file.
    name : of the file, for messages.

    Raises
    ------
    FileError : not a C3D file, or its sections do not hold together.
    """
    if len(raw) < BLOCK or raw[1] != 0x50:
        raise FileError(f"{name}: wanted a C3D file, its first bytes are not those of one; check the file's ending")
    blocks = len(raw) // BLOCK
    parameters_at = (raw[0] - 1) * BLOCK
    if raw[0] < 2 or raw[0] > blocks:
        raise FileError(
            f"{name}: wanted C3D parameters in block {raw[0]}, the file has {blocks} blocks; it is cut off: "
            "get a complete copy"
        )
    processor = raw[parameters_at + 3]
    if processor not in (INTEL, DEC, MIPS):
        raise FileError(
            f"{name}: wanted processor 84, 85 or 86 in the C3D parameters, came {processor}; it is damaged: "
            "get a complete copy"
        )
    bare = Layout(processor)
    points, analogs, first, last = struct.unpack_from(bare.order + "4H", raw, 2)
    (data_block,) = struct.unpack_from(bare.order + "H", raw, 16)
    records, chain_end = read_chain(raw, parameters_at + 4, bare.order, name)
    data_at = (data_block - 1) * BLOCK
    if not chain_end <= data_at <= len(raw):
        raise FileError(
            f"{name}: wanted C3D data after the parameters, the header says block {data_block} of {blocks}; "
            f"the file is cut off or damaged: get a complete copy"
        )
    in_header_scale, header_rate = np.nan_to_num(bare.decode(np.frombuffer(raw, "<u4", 6))[[3, 5]]).tolist()
    stated_end = parameters_at + raw[parameters_at + 2] * BLOCK
    found = Layout(
        processor=processor,
        records=records,
        parameters_at=parameters_at,
        parameters_end=stated_end if chain_end <= stated_end <= data_at else -(-chain_end // BLOCK) * BLOCK,
        data_at=data_at,
        points=points,
        analogs=analogs,
        header_frames=last - first + 1,
        first_frame=first,
        header_rate=header_rate,
    )
    for parameter, in_header in (("USED", points), ("DATA_START", data_block)):
        stated = found.number("POINT", parameter)
        unset = parameter == "DATA_START" and stated == 0  # then it is said that the header tells
        if found.find("POINT", parameter) and stated != in_header and not unset:
            raise FileError(
                f"{name}: wanted a C3D file that agrees with itself, POINT:{parameter} is {stated:g} and the header "
                f"says {in_header}; export it again from the capture software"
            )
    left_out = found.find("POINT", "USED") and not found.find("POINT", "SCALE")  # of parameters that else are there
    scale = in_header_scale if left_out else found.number("POINT", "SCALE")
    if scale == 0:
        raise FileError(
            f"{name}: wanted a POINT:SCALE above or below zero, came none; the C3D file is damaged: get a complete copy"
        )
    if in_header_scale * scale < 0:
        raise FileError(
            f"{name}: wanted a C3D file that agrees with itself, the header has the scale of "
            f"{'integers' if scale < 0 else 'floats'} and POINT:SCALE {scale:g}; export it again"
        )
    return _beyond_the_header(replace(found, scale=scale), raw)


def frames_of(raw: bytes, layout: Layout, name: str) -> tuple[int, tuple[str, ...]]:
    """Number of frames that the file promises and holds, and a sentence for each promise that differs.

    Raises
    ------
    FileError : no points or frames, fewer frames than promised, or more than are counted anywhere.
    """
    if not layout.points:
        raise FileError(f"{name}: wanted points over time, this C3D file holds none; nothing to do with it")
    promised = layout.header_frames
    others = {
        "POINT:FRAMES": int(layout.number("POINT", "FRAMES")),
        "POINT:LONG_FRAMES": int(layout.number("POINT", "LONG_FRAMES")),
        "TRIAL:ACTUAL_END_FIELD": _trial_frames(layout),
    }
    long = [(where, count) for where, count in others.items() if count > MOST_COUNTED]
    if long and layout.data_at + long[0][1] * layout.stride <= len(raw):
        # Then the header counts as far as it can, or lets the count run over.
        promised = long[0][1]
        others = dict(long)
    end = layout.data_at + max(promised, 0) * layout.stride
    rotations = (int(layout.number("ROTATION", "DATA_START")) - 1) * BLOCK
    stop = rotations if end <= rotations < len(raw) else len(raw)
    tail = raw[end:stop].rstrip(b"\0")  # the last block is filled up with zeros
    held = (stop - layout.data_at) // layout.stride if end > stop else promised + -(-len(tail) // layout.stride)
    for where, count in others.items():
        if count > MOST_COUNTED and count != promised:
            raise FileError(_too_long(name, f"{where} says {count} frames", promised))
    if held > MOST_COUNTED and not long:
        raise FileError(_too_long(name, f"the file holds {held} frames", promised))
    if promised <= 0:
        raise FileError(
            f"{name}: wanted frames, the header of this C3D file promises {promised}; it is empty or damaged: "
            "get a complete copy"
        )
    if held < promised:
        raise FileError(
            f"{name}: the header promises {counted(promised, 'frame')}, the file holds {held}: it is cut off; "
            "get a complete copy"
        )
    notes = [
        f"the header says {counted(promised, 'frame')}, {where} {count}: took {promised}"
        for where, count in others.items()
        if count not in (0, promised)
    ]
    if layout.find("POINT", "DATA_START") and not layout.number("POINT", "DATA_START"):
        notes.append("POINT:DATA_START is 0: took the points from where the header says")
    if not layout.find("POINT", "SCALE"):
        notes.append(f"POINT:SCALE is missing: took {layout.scale:g} from the header")
    if len(tail) > BLOCK:
        notes.append(f"{len(tail)} bytes follow the last frame that the header promises: not read")
    return promised, tuple(notes)


def assemble(raw: bytes, layout: Layout, frames: int, records: Iterable[Record], data: bytes, name: str) -> bytes:
    """A whole file: the header of `raw`, other parameters, other rows, and whatever else stood in `raw`.

    What follows the parameters moves by whole blocks when they no longer fit where they stood; the pointers to it
    (in the header, and every DATA_START) move along.

    Raises
    ------
    FileError : the parameters no longer fit into the 255 blocks that a C3D file has for them.
    """
    listed = list(records)
    same = listed == list(layout.records)
    had = (layout.parameters_end - layout.parameters_at) // BLOCK
    needed = had if same else -(-(4 + len(write_chain(listed, layout.order))) // BLOCK)
    blocks = max(needed, had)
    if needed > MOST_BLOCKS:
        raise FileError(f"{name}: the parameters need {needed} blocks, a C3D file has room for {MOST_BLOCKS}")
    between = raw[layout.parameters_end : layout.data_at]
    old_end = layout.data_at + frames * layout.stride
    data_at = layout.parameters_at + blocks * BLOCK + len(between)
    # What follows the rows keeps its place within a block.
    data += b"\0" * (-(data_at + len(data) - old_end) % BLOCK)

    def moved(block: int) -> int:
        at, by = (block - 1) * BLOCK, 0
        if at >= old_end:
            by = (data_at + len(data) - old_end) // BLOCK
        elif at >= layout.parameters_end:
            by = (data_at - layout.data_at) // BLOCK
        if block + by > _MOST_BLOCKS_BEFORE:
            raise FileError(f"{name}: a section would start in block {block + by}, C3D counts to {_MOST_BLOCKS_BEFORE}")
        return block + by

    header = bytearray(raw[: layout.parameters_at])
    struct.pack_into(layout.order + "H", header, 16, data_at // BLOCK + 1)
    key, ranges = struct.unpack_from(layout.order + "2H", header, 294)
    if key == _RANGES_FOLLOW:
        struct.pack_into(layout.order + "H", header, 296, moved(ranges))
    pointed = [_pointing(r, layout.order, moved) for r in listed]
    section = bytearray(blocks * BLOCK)
    if same:  # then nothing moves either, and what stands between or behind the parameters stays too
        section[:] = raw[layout.parameters_at : layout.parameters_end]
    else:
        section[:4] = raw[layout.parameters_at], raw[layout.parameters_at + 1], blocks, layout.processor
        chain = write_chain(pointed, layout.order)
        section[4 : 4 + len(chain)] = chain
    return b"".join((header, section, between, data, raw[old_end:]))


def _pointing(record: Record, order: str, moved: Callable[[int], int]) -> Record:
    if not record.named("DATA_START") or record.kind != INTEGER or len(record.values) != 2:
        return record
    (block,) = struct.unpack(order + "H", record.values)
    return replace(record, values=struct.pack(order + "H", moved(block)))


def _too_long(name: str, found: str, promised: int) -> str:
    return (
        f"{name}: {found}, the header {promised}: it counts to {MOST_COUNTED}, and TRIAL:ACTUAL_END_FIELD or "
        f"POINT:LONG_FRAMES has to say what the file holds; export it again, or split the recording"
    )


def _beyond_the_header(found: Layout, raw: bytes) -> Layout:
    """The layout with its first frame, and the number of frames, by TRIAL where the header's 16 bits end before these.

    A piece cut out of a long trial keeps its numbers: the header lets what is beyond 65,535 run over, or stops there.
    """
    start, end = _trial(found)
    first, last = struct.unpack_from(found.order + "2H", raw, 6)
    if end <= MOST_COUNTED or last not in (MOST_COUNTED, end & MOST_COUNTED):
        return found
    if start < 1 or first not in (start, MOST_COUNTED, start & MOST_COUNTED):
        return found
    frames = end - start + 1
    held = found.data_at + frames * found.stride <= len(raw)
    piece = frames <= MOST_COUNTED and (held or found.header_frames <= 0)  # longer ones: `frames_of`
    return replace(found, first_frame=start, header_frames=frames if piece else found.header_frames)


def _trial_frames(layout: Layout) -> int:
    start, end = _trial(layout)
    return end - start + 1 if end else 0


def _trial(layout: Layout) -> tuple[int, int]:
    """Numbers of the first and the last frame by TRIAL; zeros where it says neither."""
    start = layout.numbers("TRIAL", "ACTUAL_START_FIELD")
    end = layout.numbers("TRIAL", "ACTUAL_END_FIELD")
    if not start.size or not end.any() or not np.isfinite([*start, *end]).all():
        return 0, 0
    # Two 16-bit words, the low one first; some writers store one float.
    low_first = (1.0, 65_536.0)
    return int(np.dot(start[:2], low_first[: start[:2].size])), int(np.dot(end[:2], low_first[: end[:2].size]))


def _text(row: bytes) -> str:
    cut = row.split(b"\0")[0]
    try:
        return cut.decode().strip()
    except UnicodeDecodeError:
        return cut.decode("latin-1").strip()
