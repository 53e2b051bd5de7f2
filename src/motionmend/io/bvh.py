"""Biovision hierarchies (.bvh): a skeleton and its motion in one text file."""

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..bodies.motion import Motion
from ..bodies.put_before import rest_frames
from ..bodies.skeleton import ROTATION, Skeleton, height, rest_positions
from ..errors import FileError, counted
from .atomic import atomic
from .biovision import bvh_of
from .hierarchy import BvhSource, parse_hierarchy, replaces, skeleton_of
from .supposed import is_half, length_unit, up_axis
from .text import LARGEST, Text, finite, open_text, shown

UNITS = ((1.0, "m"), (0.01, "cm"), (0.001, "mm"), (0.0254, "inch"), (0.0254 / 0.45, "inch / 0.45, as CMU's data"))
RATES = (24, 25, 30, 48, 50, 60, 72, 75, 90, 100, 120, 144, 150, 180, 200, 240, 250, 300, 360, 480, 500, 1000)
HALF = 0.3, 1.4  # m that a part of a person is tall
SLOWEST = 1.0  # Hz of a capture
NAMED = 4  # joints in one guess
WRITTEN = 1 << 10  # frames that are text at a time
LONGEST_HEADING = 1 << 12  # characters from MOTION to the frame time
MOTION = re.compile(r"^[ \t]*MOTION\s+Frames\s*:\s*(\S+)\s+Frame\s*Time\s*:\s*(\S+)", re.MULTILINE | re.IGNORECASE)


def read_bvh(path: str | Path, fps: float | None = None) -> Motion:
    """Read a Biovision hierarchy.

    Parameters
    ----------
    path : the .bvh.
    fps : Hz; None takes the file's own.

    Returns
    -------
    Motion in metres and radians; the word `nan` is a missing sample. The guesses say what the format leaves open:
    the unit of length, the way up, and whether positions of joints below the root replace their OFFSET or add to
    it; those of the root add.

    Raises
    ------
    FileError : one line that names file, line, what was wanted, what came and what to do.
    """
    path = Path(path)
    text = open_text(path, "a BVH file")
    head, found = _up_to_motion(text)
    hierarchy = parse_hierarchy(head[: found.start()] if found else head.partition("MOTION")[0], path)
    if not found:
        raise FileError(
            f"{path}: wanted MOTION, 'Frames:' and 'Frame Time:' after the hierarchy, found none or not all; "
            "the file is cut off: get a complete copy"
        )
    frames, rate, rate_guesses = _stated(found, head, path)
    guesses = list(rate_guesses)
    width = sum(map(len, hierarchy.channels))
    if not width:
        raise FileError(f"{path}: wanted at least one joint with CHANNELS, found none; nothing moves in this file")
    values = _values(text, found.end(), frames, width, head.count("\n", 0, found.end()) + 1)
    if len(values) > frames:
        guesses.append(f"{counted(frames, 'frame')} stated after 'Frames:', {len(values)} in the file: took all")

    still, columns = skeleton_of(hierarchy, 1.0, np.array([0.0, 1.0, 0.0]))
    up, up_guess = up_axis(still.names, rest_positions(still))
    tall = height(replace(still, up=up))
    metres, unit_guess = length_unit(tall, UNITS, otherwise=0.01)
    if is_half(still.names) and HALF[0] <= 0.01 * tall <= HALF[1]:
        metres, unit_guess = 0.01, f"took 1 unit of length = 0.01 m (cm): {0.01 * tall:.2f} m of a person, not all"
    skeleton, columns = skeleton_of(hierarchy, metres, up)
    turns = skeleton.dof_kind == ROTATION
    q = values[:, columns] * np.where(turns, np.pi / 180, metres)
    shift, shift_guesses = _rest_values(skeleton, q, turns)
    q -= shift
    guesses = [*hierarchy.guesses, *guesses, f"no length unit in .bvh: {unit_guess}", up_guess, *shift_guesses]
    if fps is not None and abs(fps / rate - 1) > 1e-4:
        guesses.append(f"the file states {rate:.6g} Hz, took {fps:g} Hz as given")
    source = BvhSource(
        before=head[: found.start(1)],
        between=head[found.end(1) : found.start(2)],
        frame_time=found[2],
        fps=rate,
        dof_names=skeleton.dof_names,
        columns=columns,
        metres=metres,
        shift=shift,
        rate_guesses=tuple(rate_guesses),
        encoding=text.encoding,
    )
    motion = Motion(skeleton, q, fps or rate, source, tuple(guesses))
    if rested := rest_frames(motion):
        which = "first frame is" if rested == 1 else f"first {rested} frames are"
        return replace(motion, guesses=(*motion.guesses, f"the {which} a rest pose put before the recording"))
    return motion


def write_bvh(path: str | Path, motion: Motion) -> None:
    """Write a Biovision hierarchy.

    A motion read from a .bvh keeps the text of its hierarchy, its encoding too, channel order and unit; any other is
    first made one by `bvh_of`. Missing samples are written as `nan`. Ten digits are kept of each value.

    Raises
    ------
    MismatchError : when a .bvh cannot express the skeleton.
    """
    source = motion.source
    if not isinstance(source, BvhSource) or source.dof_names != motion.skeleton.dof_names:
        motion = bvh_of(motion)
        source = motion.source
    newline = "\r\n" if source.between.startswith("\r") else "\n"
    row = " ".join(["%.10g"] * motion.q.shape[1]) + newline
    unit, order = np.where(motion.skeleton.dof_kind == ROTATION, np.pi / 180, source.metres), np.argsort(source.columns)
    frame_time = source.frame_time if motion.fps == source.fps else f"{1 / motion.fps!r}"
    head = f"{source.before}{motion.frames}{source.between}{frame_time}{newline}"
    with atomic(path) as temporary, temporary.open("wb") as file:
        file.write(head.encode(source.encoding))
        for start in range(0, motion.frames, WRITTEN):
            q = motion.q[start : start + WRITTEN]
            values = ((np.where(np.isfinite(q), q, np.nan) + source.shift) / unit)[:, order]
            file.write("".join(row % tuple(frame) for frame in values.tolist()).encode())


def _up_to_motion(text: Text) -> tuple[str, re.Match[str] | None]:
    """The text up to some place after the frame time, and where that is said in it; else all of it."""
    head, found = "", None
    for piece in text.pieces():
        seen = max(0, len(head) - LONGEST_HEADING)
        head += piece
        found = MOTION.search(head, seen)
        if found:
            break
    return head, found


def _stated(found: re.Match[str], text: str, path: Path) -> tuple[int, float, list[str]]:
    """Number of frames, rate in Hz and what was supposed about it."""
    place = f"{path}, line {text.count(chr(10), 0, found.start(1)) + 1}"
    if not found[1].isdecimal() or int(found[1]) < 1:
        raise FileError(f"{place}: wanted the number of frames, came {shown(found[1])}; correct it")
    place = f"{path}, line {text.count(chr(10), 0, found.start(2)) + 1}"
    try:
        frame_time = finite(found[2])
    except ValueError:
        frame_time = 0.0
    if not frame_time > 0:
        raise FileError(f"{place}: wanted the frame time in seconds, came {shown(found[2])}; correct it")
    rate = _rate(found[2], frame_time)
    said = [] if abs(rate * frame_time - 1) < 1e-9 else [f"Frame Time {found[2]}: took {rate:g} Hz"]
    if rate < SLOWEST:
        meant = f", or milliseconds, {1000.0 / frame_time:.4g} Hz: say which with --fps" if frame_time > 1.0 else ""
        said = [f"Frame Time {found[2]}: took {rate:.4g} Hz, at which nothing is captured{meant}"]
    return int(found[1]), rate, said


def _rate(spelled: str, frame_time: float) -> float:
    """The usual rate that this frame time is rounded or cut from, if there is just one; else its inverse."""
    mantissa, _, exponent = spelled.lower().partition("e")
    last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))  # one unit of the last digit
    possible = [
        rate
        for rate in RATES
        if frame_time - last / 2 <= 1 / rate < frame_time + last and abs(rate * frame_time - 1) < 0.02
    ]
    return float(possible[0]) if len(possible) == 1 else 1 / frame_time


def _values(text: Text, after: int, frames: int, width: int, line: int) -> Floats:
    """The numbers after so many characters, in a line, as (`frames` or more, width), in the file's units."""
    parsed: list[Floats] = []
    number = line
    for piece in text.pieces(after):
        try:
            numbers = np.array([float(word) for word in piece.split()])
            told = "_" not in piece and not (np.abs(numbers) > LARGEST).any()
        except ValueError:
            told = False
        if not told:
            _complain([piece], number, text.path)
            numbers = np.array([finite(word) for word in piece.split()])
        parsed.append(numbers)
        number += piece.count("\n")
    values = np.concatenate(parsed) if parsed else np.empty(0)
    if len(values) % width:
        _complain(text.pieces(after), line, text.path, width)
    if len(values) < frames * width:
        raise FileError(
            f"{text.path}: wanted {frames} frames as stated after 'Frames:', came {len(values) / width:g}; "
            "the file is cut off, or correct the number"
        )
    return values.reshape(-1, width)


def _complain(pieces: Iterable[str], first: int, path: Path, width: int = 0) -> None:
    """Raise for the first line whose words are no numbers or, given `width`, not as many."""
    lines = (line for piece in pieces for line in piece.removesuffix("\n").split("\n"))
    for number, line in enumerate(lines, start=first):
        words = line.split()
        for word in words:
            try:
                finite(word)
            except ValueError:
                raise FileError(
                    f"{path}, line {number}: wanted a number or nan, came {shown(word)}; correct it"
                ) from None
        if width and words and len(words) != width:
            raise FileError(
                f"{path}, line {number}: wanted {width} values, one for each channel, came {len(words)}; "
                "the line is broken or cut off"
            )


def _rest_values(skeleton: Skeleton, q: Floats, turns: Bools) -> tuple[Floats, list[str]]:
    """What the file's positions are at rest (D,) in m, and what was supposed about it.

    Some programs write a joint's place relative to its parent, some how far it has left its OFFSET.
    """
    shift = np.zeros(q.shape[1])
    guesses: list[str] = []
    told: dict[str, list[str]] = {}
    if np.any(skeleton.offsets[0] != 0) and np.any(skeleton.dof_kind[skeleton.dofs_of(0)] != ROTATION):
        guesses.append(f"the positions of the root {skeleton.names[0]} add to its OFFSET, which is not zero")
    for joint in range(1, len(skeleton.names)):
        rows: Ints = np.flatnonzero((skeleton.dof_joint == joint) & ~turns)
        offset = skeleton.dof_axis[rows] @ skeleton.offsets[joint]
        if not np.any(offset != 0):
            continue
        near = replaces(q[:, rows], offset)
        shift[rows] = offset if near else 0.0
        how = "replace {} OFFSET, near which they start" if near else "add to {} OFFSET, far from which they start"
        told.setdefault(how, []).append(skeleton.names[joint])
    for how, names in told.items():
        joints = f"joint {names[0]}" if len(names) == 1 else f"joints {', '.join(names[:NAMED])}"
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        guesses.append(f"the positions of {joints}{more} {how.format('its' if len(names) == 1 else 'their')}")
    return shift, guesses
