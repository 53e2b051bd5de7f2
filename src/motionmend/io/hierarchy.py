"""The HIERARCHY part of a .bvh as text, as lists and as a skeleton."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.skeleton import ROTATION, TRANSLATION, Skeleton
from ..errors import FileError
from .text import finite, shown

CHANNELS = {  # by lower-case name: spelling, axis, kind of degree of freedom
    f"{letter}{kind}": (f"{letter.upper()}{kind}", "xyz".index(letter), number)
    for letter in "xyz"
    for kind, number in (("rotation", ROTATION), ("position", TRANSLATION))
}


@dataclass(frozen=True, eq=False)
class BvhSource:
    """What a .bvh says beside its values.

    Attributes
    ----------
    before, between : verbatim text up to the number of frames, and from there to the frame time.
    frame_time, fps : as the file spells it, and the rate it was taken for.
    dof_names : (D,) of the skeleton read from it.
    columns : (D,) column of the file for each degree of freedom.
    metres : per unit of length.
    shift : (D,) m or rad, the file's value where the degree of freedom is zero.
    rate_guesses : those of the motion's guesses that are of its rate.
    encoding : of the text.
    """

    before: str
    between: str
    frame_time: str
    fps: float
    dof_names: tuple[str, ...]
    columns: Ints
    metres: float
    shift: Floats
    rate_guesses: tuple[str, ...] = ()
    encoding: str = "utf-8"


@dataclass
class Hierarchy:
    """J joints, End Sites among them, in the order and the unit of the file; channels as the file lists them."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[list[float]] = field(default_factory=list)
    channels: list[list[str]] = field(default_factory=list)
    guesses: list[str] = field(default_factory=list)


def skeleton_of(hierarchy: Hierarchy, metres: float, up: Floats) -> tuple[Skeleton, Ints]:
    """The skeleton and, for each degree of freedom (D,), its column in the file.

    A joint's positions come before its rotations in the chain, wherever the file lists them; rotations are made in
    the order listed, the first outermost.
    """
    rows: list[tuple[int, str, int]] = []  # joint, channel, column
    column = 0
    for joint, channels in enumerate(hierarchy.channels):
        own = [(joint, channel, column + i) for i, channel in enumerate(channels)]
        rows += sorted(own, key=lambda row: CHANNELS[row[1].lower()][2] == ROTATION)  # stable
        column += len(channels)
    spelled = [CHANNELS[channel.lower()] for _, channel, _ in rows]
    skeleton = Skeleton(
        names=tuple(hierarchy.names),
        parents=np.array(hierarchy.parents),
        offsets=np.array(hierarchy.offsets) * metres,
        dof_names=tuple(f"{hierarchy.names[row[0]]}.{s[0]}" for row, s in zip(rows, spelled, strict=True)),
        dof_joint=np.array([row[0] for row in rows]),
        dof_axis=np.eye(3)[[axis for _, axis, _ in spelled]],
        dof_kind=np.array([kind for _, _, kind in spelled]),
        limits=np.tile([-np.inf, np.inf], (len(rows), 1)),
        up=up,
    )
    return skeleton, np.array([row[2] for row in rows])


def replaces(places: Floats, offset: Floats) -> bool:
    """Whether a joint's positions (T, 3) say where it is, near its OFFSET (3,), or how far it has left it.

    Programs write either. They replace the OFFSET when the first is nearer to it than to zero. Whatever the joint
    does, one of the two ways to write it down is so understood.
    """
    seen = places[np.isfinite(places).all(axis=1)]
    return bool(len(seen) and np.linalg.norm(seen[0] - offset) < np.linalg.norm(seen[0]))


def parse_hierarchy(text: str, path: Path) -> Hierarchy:
    """Read everything before MOTION; white space and the case of keywords do not matter.

    Raises
    ------
    FileError : one line that names file, line, what was wanted and what came.
    """
    words = _words(text)
    _expect(words, "hierarchy", path)
    result = Hierarchy()
    open_joints: list[int] = []
    seen_offset: set[int] = set()
    for number, word in words:
        place = f"{path}, line {number}"
        keyword = word.lower()
        joint = open_joints[-1] if open_joints else -1
        if keyword in ("root", "joint", "end"):
            if (keyword == "root") != (not open_joints):
                raise FileError(f"{place}: {shown(word)} stands in the wrong place; check the braces above")
            name = _name(words, path, number)
            name = f"{result.names[joint]}_end" if keyword == "end" else name
            open_joints.append(len(result.names))
            result.names.append(_unique(name, result))
            result.parents.append(joint)
            result.offsets.append([0.0, 0.0, 0.0])
            result.channels.append([])
        elif joint < 0:
            raise FileError(f"{place}: wanted ROOT, came {shown(word)}; check the braces above")
        elif keyword == "offset":
            result.offsets[joint] = [_number(words, "OFFSET", path, number) for _ in range(3)]
            seen_offset.add(joint)
        elif keyword == "channels":
            result.channels[joint] = _channels(words, result.names[joint], path, number)
        elif keyword == "}":
            if joint not in seen_offset:
                raise FileError(f"{place}: joint {shown(result.names[joint])} has no OFFSET; add it")
            open_joints.pop()
        else:
            raise FileError(
                f"{place}: wanted OFFSET, CHANNELS, JOINT, End Site or a brace, came {shown(word)}; correct it"
            )
    if open_joints or not result.names:
        wanted = f"a brace to close joint {result.names[open_joints[-1]]}" if open_joints else "a ROOT"
        raise FileError(f"{path}: wanted {wanted} before MOTION, found none; get a complete copy")
    return result


Words = Iterator[tuple[int, str]]  # line number and word


def _words(text: str) -> Words:
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), start=1):
        for word in re.sub(r"([{}])", r" \1 ", line).split():
            yield number, word


def _expect(words: Words, wanted: str, path: Path) -> None:
    number, word = next(words, (1, "nothing"))
    if word.lower() != wanted:
        raise FileError(
            f"{path}, line {number}: wanted {wanted.upper()}, came {shown(word)}; check that this is a .bvh"
        )


def _name(words: Words, path: Path, number: int) -> str:
    """All words up to the opening brace: names may have spaces."""
    parts = []
    for _, word in words:
        if word == "{":
            break
        parts.append(word)
    if not parts or len(parts) > 8:
        raise FileError(f"{path}, line {number}: wanted a joint's name and a brace, found none; correct it")
    return " ".join(parts)


def _unique(name: str, result: Hierarchy) -> str:
    if name not in result.names:
        return name
    count = next(n for n in range(2, len(result.names) + 3) if f"{name}_{n}" not in result.names)
    result.guesses.append(f"joint name {name} comes more than once: called one {name}_{count}")
    return f"{name}_{count}"


def _number(words: Words, what: str, path: Path, number: int) -> float:
    number, word = next(words, (number, "the end"))
    try:
        value = finite(word)
    except ValueError:
        value = np.nan
    if np.isnan(value):
        raise FileError(f"{path}, line {number}: wanted a number for {what}, came {shown(word)}; correct it")
    return value


def _channels(words: Words, name: str, path: Path, number: int) -> list[str]:
    count = _number(words, "CHANNELS", path, number)
    if count not in range(7):
        raise FileError(f"{path}, line {number}: wanted 0 to 6 CHANNELS for {name}, came {count:g}; correct it")
    channels: list[str] = []
    for _ in range(int(count)):
        number, word = next(words, (number, "the end"))
        if word.lower() not in CHANNELS or word.lower() in [c.lower() for c in channels]:
            raise FileError(
                f"{path}, line {number}: wanted {count:g} different channels such as Xposition or Zrotation for "
                f"{name}, came {shown(word)}; correct the line"
            )
        channels.append(word)
    return channels
