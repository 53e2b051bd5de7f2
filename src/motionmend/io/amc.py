"""Acclaim motions (.amc): the degrees of freedom of an .asf skeleton, frame by frame."""

import filecmp
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.motion import Motion
from ..bodies.skeleton import ROTATION, Skeleton, same
from ..errors import FileError
from .acclaim import asf_of, dof_tokens
from .asf import Asf, read_asf, skeleton_of, write_asf
from .atomic import atomic
from .text import finite, read_text, shown

USUAL_RATE = 120.0  # Hz
BLOCK = 1 << 22  # characters parsed at a time, so that the words of a long file are never all in memory
HEADER = "#!OML:ASF\n:FULLY-SPECIFIED\n:DEGREES\n"


@dataclass(frozen=True, eq=False)
class AmcSource:
    """What an .amc says beside its values.

    Attributes
    ----------
    asf : the skeleton file.
    header : everything before the first frame, verbatim.
    degrees : whether its angles are in degrees.
    bones : in the order of the file's lines.
    numbers : (T,) frame numbers.
    comments : frame index and line of each comment among the frames; the line stood before that frame.
    """

    asf: Asf
    header: str = HEADER
    degrees: bool = True
    bones: tuple[str, ...] = ()
    numbers: Ints = field(default_factory=lambda: np.array([1]))
    comments: tuple[tuple[int, str], ...] = ()


def find_asf(path: str | Path) -> Path:
    """The skeleton that belongs to an .amc: `<stem>.asf`, else `<stem up to the first _>.asf`, else the folder's only.

    Copies of one file, as they lie beside recordings of one person, count as one.

    Raises
    ------
    FileError : when there is none, or several and none has the name.
    """
    path = Path(path)
    skeletons = _skeletons_beside(path)
    if own := _by_name(path, skeletons):
        return own
    if skeletons and all(filecmp.cmp(skeletons[0], other, shallow=False) for other in skeletons[1:]):
        return skeletons[0]
    came = f"{len(skeletons)} others" if skeletons else "none"
    raise FileError(
        f"{path}: wanted its skeleton {' or '.join(_asf_names(path))} in the same folder, found {came}; "
        "name one with --skeleton"
    )


def _asf_names(path: Path) -> list[str]:
    return list(dict.fromkeys((f"{path.stem}.asf", f"{path.stem.split('_')[0]}.asf")))


def _skeletons_beside(path: Path) -> list[Path]:
    try:
        return sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf" and p.is_file())
    except OSError as failure:
        raise FileError(f"{path}: cannot look for its .asf: {failure.strerror}; check the path") from None


def _by_name(path: Path, skeletons: list[Path]) -> Path | None:
    for name in _asf_names(path):
        for skeleton in skeletons:
            if skeleton.name.lower() == name.lower():
                return skeleton
    return None


def read_amc(path: str | Path, asf: Asf | str | Path | None = None, fps: float | None = None) -> Motion:
    """Read an Acclaim motion.

    Parameters
    ----------
    path : the .amc.
    asf : its skeleton or where that lies; None looks for it beside the .amc, as `find_asf` does.
    fps : Hz; None takes the file's own if it states one, else 120 Hz and says so in the guesses.

    Returns
    -------
    Motion in metres and radians; a bone left out of a frame and the word `nan` are missing samples.

    Raises
    ------
    FileError : one line that names file, line, what was wanted, what came and what to do.
    """
    path = Path(path)
    text = read_text(path, "an Acclaim motion (.amc)").removeprefix("\ufeff")
    if "\n" not in text:
        text = text.replace("\r", "\n")
    if asf is None:
        asf = find_asf(path)
    if not isinstance(asf, Asf):
        asf = read_asf(asf)
    skeleton = skeleton_of(asf)
    start = re.search(r"^[ \t]*\d+[ \t]*\r?$", text, re.MULTILINE)
    if not start:
        raise FileError(
            f"{path}: wanted an Acclaim motion, found no frame (a line with its number); get a complete copy"
        )
    header, body = text[: start.start()], text[start.start() :]
    degrees, rate, guesses = _read_header(header, asf, path)
    columns = _columns(skeleton, asf)
    frames = _parse_regular(body, columns, len(skeleton.dof_names))
    if frames is None:
        frames = _parse_lines(body, columns, asf, path, header.count("\n") + 1)
    if np.any(np.diff(frames.numbers) != 1):
        guesses.append("frame numbers are not consecutive: took the frames as evenly spaced")
    if not text.endswith("\n"):
        guesses.append("the last line has no line break: should the file be cut off there, its last value is wrong")
    if fps is None and rate is None:
        guesses.append(f"no rate in .amc: took {USUAL_RATE:g} Hz; give --fps")
    elif fps is not None and rate is not None and fps != rate:
        guesses.append(f"the file states {rate:g} Hz, took {fps:g} Hz as given")
    source = AmcSource(asf, header, degrees, frames.bones, frames.numbers, frames.comments)
    q = frames.values * _unit(skeleton, asf, degrees)
    return Motion(skeleton, q, fps or rate or USUAL_RATE, source, (*asf.guesses, *guesses))


def write_amc(path: str | Path, motion: Motion) -> None:
    """Write an Acclaim motion, and beside it the skeleton unless it lies there under a name that makes it the motion's.

    A motion read from an .amc keeps the file's header, units, order and frame numbers; any other gets a skeleton
    from `asf_of`. A rate other than 120 Hz is stated in the header. Missing samples are written as `nan`. Ten
    digits are kept of each value.

    Parameters
    ----------
    path : the .amc to write; the skeleton goes by its old name if that makes it the motion's, else `<stem>.asf`.
    motion : any.

    Raises
    ------
    MismatchError : when an .asf cannot express the skeleton.
    FileError : when `<stem>.asf` lies there already and holds another skeleton.
    """
    path = Path(path)
    skeleton = motion.skeleton
    source = motion.source
    if isinstance(source, AmcSource) and skeleton_of(source.asf).dof_names == skeleton.dof_names:
        asf, columns = source.asf, _columns(skeleton, source.asf)
    else:
        asf = asf_of(skeleton, f"{path.stem}.asf")
        source = AmcSource(asf, bones=("root", *(bone.name for bone in asf.bones if bone.dof)))
        columns = _columns_of(skeleton)
    values = np.where(motion.present, motion.q, np.nan) / _unit(skeleton, asf, source.degrees)
    seen = np.atleast_1d(motion.present.any(axis=0))
    added = [bone for bone, at in columns.items() if bone not in source.bones and seen[at].any()]
    order = (*source.bones, *added)
    newline = "\r\n" if "\r\n" in source.header else "\n"
    rows = "".join(f"{bone}{' %.10g' * len(columns[bone])}{newline}" for bone in order)
    template = f"%d{newline}{rows}"
    numbers = source.numbers
    if len(numbers) != motion.frames:
        numbers = numbers[0] + np.arange(motion.frames)
    at = [column for bone in order for column in columns[bone]]
    pieces = [template % (n, *row) for n, row in zip(numbers.tolist(), values[:, at].tolist(), strict=True)]
    for frame, comment in reversed(source.comments):
        pieces.insert(min(frame, len(pieces)), comment + newline)
    _place_asf(path, asf)
    with atomic(path) as temporary:
        temporary.write_bytes("".join([_stating(source.header, motion.fps, newline), *pieces]).encode())


def _stating(header: str, fps: float, newline: str) -> str:
    """The header with the rate stated, wherever a reader would otherwise take another."""
    stated = re.search(r"(?<=:SAMPLES-PER-SECOND)\s+(\S+)", header, re.IGNORECASE)
    rate = finite(stated[1]) if stated else USUAL_RATE
    if rate == fps:
        return header
    if stated:
        return f"{header[: stated.start(1)]}{fps!r}{header[stated.end(1) :]}"
    place = re.search(r"^[ \t]*:", header, re.MULTILINE)
    at = place.start() if place else len(header)
    return f"{header[:at]}:SAMPLES-PER-SECOND {fps!r}{newline}{header[at:]}"


def _unit(skeleton: Skeleton, asf: Asf, degrees: bool) -> Floats:
    """(D,) radians or metres per unit of the file."""
    return np.where(skeleton.dof_kind == ROTATION, np.pi / 180 if degrees else 1.0, asf.metres)


def _columns(skeleton: Skeleton, asf: Asf) -> dict[str, list[int]]:
    """Columns of q by bone, in the order of the bone's values in the file."""
    column = {name: d for d, name in enumerate(skeleton.dof_names)}
    return {bone.name: [column[f"{bone.name}.{token}"] for token in bone.dof] for bone in (asf.root, *asf.bones)}


def _columns_of(skeleton: Skeleton) -> dict[str, list[int]]:
    """The same for a skeleton that `asf_of` expresses."""
    names = ("root", *skeleton.names[1:])
    return {name: list(dof_tokens(skeleton, j)[0].values()) for j, name in enumerate(names)}


def _place_asf(path: Path, asf: Asf) -> None:
    beside = _skeletons_beside(path)
    found = _by_name(path, beside)  # a folder's only skeleton would do until another one comes to lie beside it
    if found and _holds(found, asf):
        return
    taken = {p.name.lower() for p in beside}
    names = [name for name in _asf_names(path) if name.lower() == asf.name.lower()] + [f"{path.stem}.asf"]
    for name in names:
        if name.lower() not in taken:
            write_asf(path.with_name(name), asf)
            return
    raise FileError(
        f"{path}: its skeleton must go to {names[-1]} beside it, which holds another one; "
        "write to another name or folder"
    )


def _holds(path: Path, asf: Asf) -> bool:
    try:
        found = read_asf(path)
    except FileError:  # a broken file is another skeleton
        return False
    return found.text == asf.text or same(skeleton_of(found), skeleton_of(asf))


def _read_header(header: str, asf: Asf, path: Path) -> tuple[bool, float | None, list[str]]:
    """Whether angles are in degrees, the rate in Hz if stated, and what was supposed."""
    degrees: bool | None = None
    rate: float | None = None
    for number, line in enumerate(header.splitlines(), start=1):
        words = line.split("#")[0].split()
        if not words:
            continue
        keyword = words[0].upper()
        if keyword in (":DEGREES", ":RADIANS"):
            degrees = keyword == ":DEGREES"
        elif keyword == ":SAMPLES-PER-SECOND":
            try:
                rate = finite(words[1])
            except (IndexError, ValueError):
                raise FileError(
                    f"{path}, line {number}: wanted the rate in Hz, came {shown(line)}; correct it"
                ) from None
        elif not keyword.startswith(":"):
            raise FileError(
                f"{path}, line {number}: wanted a :KEYWORD, a # comment or the first frame's number, "
                f"came {shown(line)}; check that this is an .amc"
            )
    if degrees is not None:
        return degrees, rate, []
    unit = "degrees" if asf.degrees else "radians"
    return asf.degrees, rate, [f"neither :DEGREES nor :RADIANS in .amc: took {unit}, as {asf.name} states"]


class _Frames(NamedTuple):
    values: Floats  # (T, D) in the file's units
    numbers: Ints  # (T,)
    bones: tuple[str, ...]
    comments: tuple[tuple[int, str], ...] = ()


def _parse_regular(body: str, columns: dict[str, list[int]], dofs: int) -> _Frames | None:
    """Frames that all look like the first, word for word; None when they do not or anything else is odd."""
    end = re.compile(r"\n[ \t]*\d+[ \t]*\r?\n").search(body)
    pattern = (body[: end.start()] if end else body).splitlines()[1:]
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

    lines = body.rstrip()
    frames = (lines.count("\n") + 1) // (1 + len(bones))
    if (lines.count("\n") + 1) % (1 + len(bones)):
        return None
    if lines.count("_") != frames * sum(bone.count("_") for bone in bones):
        return None  # Python would read 1_0 as 10
    values = np.full((frames, dofs), np.nan)
    numbers = np.empty(frames, dtype=np.int64)
    done, start, rest = 0, 0, list[str]()
    while start < len(lines):
        cut = lines.find("\n", start + BLOCK)
        stop = len(lines) if cut < 0 else cut
        rest += lines[start:stop].split()
        start = stop
        count = len(rest) // period
        used, rest = rest[: count * period], rest[count * period :]
        if done + count > frames or any(used[k::period].count(bone) != count for k, bone in names):
            return None
        try:
            numbers[done : done + count] = [int(word) for word in used[::period]]
            for k, column in at:
                values[done : done + count, column] = [float(word) for word in used[k::period]]
        except ValueError:
            return None
        done += count
    if rest or done < frames or np.isinf(values).any():
        return None
    return _Frames(values, numbers, bones)


def _parse_lines(body: str, columns: dict[str, list[int]], asf: Asf, path: Path, first: int) -> _Frames:
    """Frames line by line: bones may be left out, in any order, with comments between; `first` is the line number."""
    spelled = {bone.lower(): bone for bone in columns}
    dofs = sum(map(len, columns.values()))
    rows: list[list[float]] = []
    numbers: list[int] = []
    comments: list[tuple[int, str]] = []
    order: dict[str, None] = {}
    frame: list[str] = []  # bones of the frame being read
    before: list[str] = []  # of the one before
    number = first
    for number, line in enumerate(body.splitlines(), start=first):
        words = line.split()
        place = f"{path}, line {number}"
        if not words:
            continue
        if words[0].startswith("#"):
            comments.append((len(rows), line))
            continue
        if len(words) == 1 and words[0].isdecimal():
            numbers.append(int(words[0]))
            rows.append([np.nan] * dofs)
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
                rows[-1][column] = finite(word)
            except ValueError:
                raise FileError(f"{place}: wanted a number or nan for {bone}, came {shown(word)}; correct it") from None
        frame.append(bone)
        order[bone] = None
    if before and (not frame or (frame[-1] != before[-1] and before[-1] not in frame)):
        raise FileError(
            f"{path}, line {number}: frame {numbers[-1]} wants bones up to {before[-1]} like the one before, "
            f"the file ends after {frame[-1] if frame else 'its number'}; it is cut off: get a complete copy"
        )
    return _Frames(np.array(rows), np.array(numbers), tuple(order), tuple(comments))
