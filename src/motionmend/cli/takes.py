"""Takes of every kind: what a pipeline is given, what each is, and where its output belongs."""

import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from ..errors import FileError, UsageError
from .inputs import (
    Input,
    Job,
    Refusal,
    closed_below,
    closed_to_us,
    ending,
    identities,
    is_new,
    is_no_file,
    jobs_of,
    name_of,
    ready,
    say_hidden,
    say_not_followed,
)
from .options import Writing
from .speech import say

Kind: TypeAlias = Literal["depth", "sensor", "recording"]
WRITTEN = {"depth": (".csv", ".bvh", ".amc"), "sensor": (".csv", ".bvh")}
_FEWEST = 6  # joints whose meaning is known, and more than half of all: then points with names are a skeleton
_ON_SKIN = re.compile(r"(asis?|psis?|sacr(al|um)?)$")  # what only markers are called that lie about a pelvis


@dataclass(frozen=True)
class Take:
    """One take to work on.

    Attributes
    ----------
    job : its file or folder, and its output.
    kind : depth pictures, a sensor's skeleton, or a recording of joint angles or markers.
    """

    job: Job
    kind: Kind


def gather_takes(given: Sequence[Path], out: Path) -> tuple[list[tuple[Input, Kind]], list[Refusal]]:
    """All takes meant by files and folders, in the order given and sorted within a folder; each once.

    Parameters
    ----------
    given : as on the command line.
    out : what -o names; what lies below it inside a folder of takes is output, no take.

    Raises
    ------
    UsageError : nothing was given.
    """
    from ..io.depth import looks_like_depth_folder

    if not given:
        raise UsageError("a take was wanted, none was given: name a depth folder, a sensor's recording, or markers")
    found: list[tuple[Input, Kind]] = []
    refused: list[Refusal] = []
    seen: dict[Path, Path] = {}
    for path in given:
        if (closed := closed_to_us(path)) is not None or not path.exists():
            refused.append(closed or Refusal(path, "no such file or folder"))
            continue
        shut = closed_below(path) if path.is_dir() else []
        refused += shut
        holds_takes = path.is_dir() and not looks_like_depth_folder(path)
        top = Path(name_of(path)) if len(given) > 1 and holds_takes else Path()
        takes = list(_below(path, top))
        if not takes and not shut:
            what = "no take in this folder" if path.is_dir() else f"no take: {_seldom(path)}"
            refused.append(Refusal(path, what))
        for take, kind in takes:
            ours = take.path != path and out.resolve() in take.path.resolve().parents
            if not ours and is_new(take.path, seen):
                found.append((take, kind))
    return found, refused


def _below(path: Path, top: Path) -> Iterator[tuple[Input, Kind]]:
    """The takes that one name stands for; a place has the name of its take."""
    from ..io import READABLE
    from ..io.depth import looks_like_depth_folder
    from ..io.sensor import SENSOR_ENDINGS

    if looks_like_depth_folder(path):
        yield Input(path, top / name_of(path)), "depth"
    elif path.is_dir():
        within = sorted(path.iterdir())
        hidden = [one for one in within if one.name.startswith(".")]
        say_hidden([one for one in hidden if ending(one) in {*READABLE, *SENSOR_ENDINGS}])
        for one in within:
            if one in hidden or one.name.endswith(".mend.json"):
                continue
            if one.is_dir() and not looks_like_depth_folder(one):
                if one.is_symlink():
                    say_not_followed(one)
                elif closed_to_us(one) is None:
                    yield from _below(one, top / one.name)
                continue
            takes = list(_below(one, top))
            yield from takes
            if not takes and ending(one) not in (".asf", ".mend", ".toml", ".html"):
                say(f"{one} is left out: {_seldom(one)}")
    elif not is_no_file(path) and (kind := kind_of_take(path)) is not None:
        yield Input(path, top / path.name), kind


def kind_of_take(file: Path) -> Kind | None:
    """What a file is; None for none of the kinds. What cannot be read is what its ending says, so that reading it
    says why."""
    from ..io import READABLE, looks_meant
    from ..io.sensor import SENSOR_ENDINGS, kind_of, looks_like_sensor, read_postures

    if ending(file) in (".amc", ".bvh", ".c3d", ".zip"):
        return "recording"
    known = ending(file) in SENSOR_ENDINGS
    try:
        if known and kind_of(file) == "depth":
            return "depth"
        if known and looks_like_sensor(file):
            if ending(file) not in READABLE:
                return "sensor"
            return "sensor" if is_skeleton(read_postures(file).names) or not looks_meant(file) else "recording"
        return "recording" if ending(file) in READABLE and looks_meant(file) else None
    except FileError:
        return "recording" if ending(file) in READABLE and looks_meant(file) else "sensor" if known else None


def is_skeleton(names: Sequence[str]) -> bool:
    """Whether named points are a skeleton's joints rather than markers on the skin, of which some lie at joints."""
    from ..bodies.joint_sets import meanings

    joints = sum(map(bool, meanings(names)))
    bare = (re.sub(r"[^a-z]", "", name.rpartition(":")[2].lower()) for name in names)
    return joints >= _FEWEST and 2 * joints > len(names) and not any(_ON_SKIN.search(name) for name in bare)


def plan_takes(
    found: Sequence[tuple[Input, Kind]], given: Sequence[Path], out: Path, form: str | None, writing: Writing
) -> tuple[list[Take], list[Refusal]]:
    """Where each output goes: OUT itself for one take, a tree below OUT for several or for a folder of them.

    Parameters
    ----------
    found : from `gather_takes(given)`.
    out : what -o names.
    form : csv, bvh or amc for depth and sensors; None takes the ending of OUT, else csv.
    writing : what to do about outputs that are there.

    Raises
    ------
    UsageError : OUT cannot be what is needed, or two takes would share an output.
    """
    if not found and len(given) == 1:
        return [], []
    alone = len(given) == 1 and len(found) == 1 and found[0][0].path == given[0]
    if alone and out.suffix and not out.is_dir():
        targets = [_checked(out, found[0][1], form)]
    else:
        if out.exists() and not out.is_dir():
            raise UsageError(f"-o {out}: a folder was wanted for several takes, came a file")
        if not out.is_dir() and any(ending(out) in endings for endings in WRITTEN.values()):
            raise UsageError(f"-o {out}: a folder was wanted for several takes, came the name of a file")
        targets = [out / _place(one, kind, form) for one, kind in found]
    for shared, count in Counter(map(os.path.normcase, targets)).items():
        if count > 1:
            raise UsageError(f"{count} takes would all be written to {shared}: give them apart")
    takes: list[Take] = []
    refused: list[Refusal] = []
    inputs = [one for one, _ in found]
    taken = identities(inputs)
    for (_, kind), planned in zip(found, jobs_of(inputs, targets), strict=True):
        job = ready(planned, taken, [".mend.json"], force=writing.force, resume=writing.resume)
        if isinstance(job, Refusal):
            refused.append(job)
        else:
            takes.append(Take(job, kind))
    return takes, refused


def _checked(out: Path, kind: Kind, form: str | None) -> Path:
    from ..io import WRITABLE

    endings = WRITTEN.get(kind, WRITABLE)
    if ending(out) not in endings:
        raise UsageError(f"-o {out}: an ending of {', '.join(endings)} was wanted, came {out.suffix!r}")
    if form is not None and kind in WRITTEN and ending(out) != f".{form}":
        raise UsageError(f"-o {out}: its ending and format {form} differ: leave one of them out")
    return out


def _place(one: Input, kind: Kind, form: str | None) -> Path:
    """A take's place with the ending of its output."""
    from ..io import WRITABLE

    if kind == "recording":
        return one.place if ending(one.path) in WRITABLE else one.place.with_suffix(".c3d")
    name = one.place.name if one.path.is_dir() else _stem(one.place.name)
    wanted = f".{form or 'csv'}"
    return one.place.with_name(name + (wanted if wanted in WRITTEN[kind] else ".csv"))


def _stem(name: str) -> str:
    """A file's name without its endings: `x_positions.txt.gz` is `x_positions`."""
    whole = Path(name)
    return Path(whole.stem).stem if whole.suffix.lower() == ".gz" and Path(whole.stem).suffix else whole.stem


def _seldom(path: Path) -> str:
    return f"neither depth, nor a sensor's skeleton, nor markers or joint angles ({path.suffix or 'no ending'})"
