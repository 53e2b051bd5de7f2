"""Acclaim motions (.amc): the degrees of freedom of an .asf skeleton, frame by frame."""

import filecmp
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.motion import Motion
from ..bodies.skeleton import ROTATION, Skeleton, same
from ..errors import FileError
from .acclaim import asf_of, dof_tokens
from .amc_frames import header_of, parse_lines, parse_regular
from .asf import Asf, read_asf, skeleton_of, write_asf
from .atomic import atomic
from .columns import UNENDED
from .text import finite, open_text, shown

USUAL_RATE = 120.0  # Hz
WRITTEN = 1 << 10  # frames that are text at a time
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
    """The folder's .asf files; hidden ones are being written, or another system's notes on the file."""
    try:
        beside = (p for p in path.parent.iterdir() if p.suffix.lower() == ".asf" and not p.name.startswith("."))
        return sorted(p for p in beside if p.is_file())
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
    fps : Hz, for a file that states no rate; None takes 120 Hz then and says so in the guesses.

    Returns
    -------
    Motion in metres and radians; a bone left out of a frame and the word `nan` are missing samples.

    Raises
    ------
    FileError : one line that names file, line, what was wanted, what came and what to do.
    """
    path = Path(path)
    text = open_text(path, "an Acclaim motion (.amc)")
    if asf is None:
        asf = find_asf(path)
    if not isinstance(asf, Asf):
        asf = read_asf(asf)
    skeleton = skeleton_of(asf)
    header, begin = header_of(text)
    degrees, rate, guesses = _read_header(header, asf, path)
    columns = _columns(skeleton, asf)
    frames = parse_regular(text.pieces(begin), columns, len(skeleton.dof_names))
    if frames is None:
        frames = parse_lines(text.pieces(begin), columns, asf, path, header.count("\n") + 1)
    if np.any(np.diff(frames.numbers) != 1):
        guesses.append("frame numbers are not consecutive: took the frames as evenly spaced")
    if fps is None and rate is None:
        guesses.append(f"no rate in .amc: took {USUAL_RATE:g} Hz; give --fps")
    source = AmcSource(asf, header, degrees, frames.bones, frames.numbers, frames.comments)
    q = frames.values
    q *= _unit(skeleton, asf, degrees)
    warnings = () if text.ended else (UNENDED,)
    return Motion(skeleton, q, rate or fps or USUAL_RATE, source, (*asf.guesses, *guesses), warnings)


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
    FileError : when `<stem>.asf` lies there already and holds another skeleton, unless an .amc of this name does so,
        too, and goes with it, and it is no other's.
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
    unit = _unit(skeleton, asf, source.degrees)
    with atomic(path) as temporary:
        with temporary.open("wb") as file:
            file.write(_stating(source.header, motion.fps, newline).encode())
            for start in range(0, motion.frames, WRITTEN):
                stop = min(start + WRITTEN, motion.frames)
                q = motion.q[start:stop]
                values = (np.where(np.isfinite(q), q, np.nan) / unit)[:, at]
                frames = zip(numbers[start:stop].tolist(), values.tolist(), strict=True)
                pieces = [template % (n, *row) for n, row in frames]
                last = stop == motion.frames
                for frame, comment in reversed(source.comments):
                    if start <= frame < stop or (last and frame >= stop):
                        pieces.insert(min(frame - start, len(pieces)), comment + newline)
                file.write("".join(pieces).encode())
        _place_asf(path, asf)  # last: a failure leaves neither


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
    own = next(p for p in beside if p.name.lower() == names[-1].lower())
    if path.exists() and own not in map(_skeleton_found, _others_beside(path)):
        write_asf(own, asf)  # that of the motion which is written over
        return
    raise FileError(
        f"{path}: its skeleton must go to {names[-1]} beside it, which holds another one; "
        "write to another name or folder"
    )


def _others_beside(path: Path) -> list[Path]:
    return [p for p in path.parent.iterdir() if p.suffix.lower() == ".amc" and p != path and not p.name.startswith(".")]


def _skeleton_found(path: Path) -> Path | None:
    try:
        return find_asf(path)
    except FileError:
        return None


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
                rate = finite(words[1]) or None  # 0 states none
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
