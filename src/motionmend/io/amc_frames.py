"""The text of an .amc, a piece at a time: its header, and its frames."""

import re
from array import array
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Floats, Ints
from ..errors import FileError
from .asf import Asf
from .text import LARGEST, Text, finite, shown


class Frames(NamedTuple):
    """The frames of an .amc as they stand in it."""

    values: Floats  # (T, D) in the file's units
    numbers: Ints  # (T,)
    bones: tuple[str, ...]
    comments: tuple[tuple[int, str], ...] = ()


def header_of(text: Text) -> tuple[str, int]:
    """Everything before the first frame, verbatim, and after how many characters of the file that frame begins."""
    seen = ""
    for piece in text.pieces():
        start = re.search(r"^[ \t]*\d+[ \t]*\r?$", piece, re.MULTILINE)
        if start:
            header = seen + piece[: start.start()]
            return header.removeprefix("\ufeff"), len(header)
        seen += piece
    raise FileError(
        f"{text.path}: wanted an Acclaim motion, found no frame (a line with its number); get a complete copy"
    )


def parse_regular(body: Iterator[str], columns: dict[str, list[int]], dofs: int) -> Frames | None:
    """Frames that all look like the first, word for word; None when they do not or anything else is odd."""
    first = next(body) + next(body, "")  # a whole frame at least
    end = re.compile(r"\n[ \t]*\d+[ \t]*\r?\n").search(first)
    pattern = (first[: end.start()] if end else first).splitlines()[1:]
    bones = tuple(line.split()[0] for line in pattern if line.split())
    words = [word for line in pattern for word in line.split()]
    if not set(bones) <= set(columns) or len(set(bones)) < len(bones):
        return None
    if [len(line.split()) - 1 for line in pattern] != [len(columns[bone]) for bone in bones]:
        return None
    period = 1 + len(words)
    at: list[tuple[int, int]] = []  # place among a frame's words, column of q
    names: list[tuple[int, str]] = []
    place = 1
    for bone in bones:
        names.append((place, bone))
        at += [(place + 1 + i, column) for i, column in enumerate(columns[bone])]
        place += 1 + len(columns[bone])

    values: list[Floats] = []
    numbers: list[Ints] = []
    lines = breaks = bars = 0
    rest = list[str]()
    for piece in chain([first], body):
        filled = piece.rstrip()
        lines = breaks + filled.count("\n") + 1 if filled else lines
        breaks += piece.count("\n")
        bars += piece.count("_")
        rest += piece.split()
        count = len(rest) // period
        used, rest = rest[: count * period], rest[count * period :]
        if any(used[k::period].count(bone) != count for k, bone in names):
            return None
        some = np.full((count, dofs), np.nan)
        try:
            numbers.append(np.array([int(word) for word in used[::period]], dtype=np.int64))
            for k, column in at:
                some[:, column] = [float(word) for word in used[k::period]]
        except (ValueError, OverflowError):
            return None
        if (np.abs(some) > LARGEST).any():
            return None
        values.append(some)
    frames = sum(map(len, numbers))
    if rest or lines != frames * (1 + len(bones)):
        return None
    if bars != frames * sum(bone.count("_") for bone in bones):
        return None  # Python would read 1_0 as 10
    return Frames(np.concatenate(values), np.concatenate(numbers), bones)


def parse_lines(body: Iterator[str], columns: dict[str, list[int]], asf: Asf, path: Path, first: int) -> Frames:
    """Frames line by line: bones may be left out, in any order, with comments between; `first` is the line number."""
    spelled = {bone.lower(): bone for bone in columns}
    dofs = sum(map(len, columns.values()))
    nothing = [np.nan] * dofs
    values = array("d")  # of all frames, one after the other
    numbers: list[int] = []
    comments: list[tuple[int, str]] = []
    order: dict[str, None] = {}
    frame: list[str] = []  # bones of the frame being read
    before: list[str] = []  # of the one before
    number = first
    for number, line in enumerate((line for piece in body for line in piece.splitlines()), start=first):
        words = line.split()
        place = f"{path}, line {number}"
        if not words:
            continue
        if words[0].startswith("#"):
            comments.append((len(numbers), line))
            continue
        if len(words) == 1 and words[0].isdecimal():
            numbers.append(int(words[0]))
            values.extend(nothing)
            before, frame = frame, []
            continue
        bone = spelled.get(words[0].lower())
        if bone is None:
            raise FileError(
                f"{place}: wanted a bone of {asf.name} or a frame number, came {shown(words[0])}; "
                "check the file, or name its own skeleton with --skeleton"
            )
        if bone in frame:
            raise FileError(f"{place}: {bone} comes twice in frame {numbers[-1]}; remove one")
        at = columns[bone]
        if len(words) - 1 != len(at):
            raise FileError(
                f"{place}: wanted {len(at)} values for {bone} as in {asf.name}, came {len(words) - 1}; "
                "the line is broken or cut off, or belongs to another skeleton"
            )
        for column, word in zip(at, words[1:], strict=True):
            try:
                values[len(values) - dofs + column] = finite(word)
            except ValueError:
                raise FileError(f"{place}: wanted a number or nan for {bone}, came {shown(word)}; correct it") from None
        frame.append(bone)
        order[bone] = None
    if before and (not frame or (frame[-1] != before[-1] and before[-1] not in frame)):
        raise FileError(
            f"{path}, line {number}: frame {numbers[-1]} wants bones up to {before[-1]} like the one before, "
            f"the file ends after {frame[-1] if frame else 'its number'}; it is cut off: get a complete copy"
        )
    q = np.frombuffer(values).reshape(len(numbers), dofs)
    return Frames(q, np.array(numbers), tuple(order), tuple(comments))
