"""From what stands on the command line to files in and files out."""

import json
import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence, Set
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import UsageError
from .speech import say

FileNumber = tuple[int, int]  # of a device, and on it
SENSED = (".skl", ".skeleton", ".mat", ".gz")  # what is mostly a sensor's skeleton
NO_FILE = "a pipe or a device, which cannot be read twice: give a file"


@dataclass(frozen=True)
class Input:
    """One file to work on, and where it belongs in a mirrored tree of outputs."""

    path: Path
    place: Path


@dataclass(frozen=True)
class Refusal:
    """Something named on the command line that cannot be worked on, and why in one line."""

    path: Path
    reason: str


@dataclass(frozen=True)
class Job:
    """One file in, one file out.

    Attributes
    ----------
    source, target : the input and its output.
    stem : the output without its ending, to which the files beside it add theirs.
    finished : whether the output is there already and nothing is left to do.
    """

    source: Path
    target: Path
    stem: Path
    finished: bool = False

    def beside(self, ending: str) -> Path:
        """The file beside the output with another ending, e.g. `.mend.json`."""
        return self.stem.with_name(self.stem.name + ending)

    @contextmanager
    def together(self, *sidecars: str) -> Iterator[None]:
        """Within it the output and the files beside it are written: when it fails, none of those that are new stays."""
        outputs = {self.target, *map(self.beside, sidecars)}
        new = {output for output in outputs if not output.exists()}
        try:
            yield
        except BaseException:
            for output in new:
                with suppress(OSError):
                    output.unlink(missing_ok=True)
            raise


def ending(path: Path) -> str:
    """The ending that says what a file is, in lower case with its dot."""
    return path.suffix.lower()


def gather(
    given: Sequence[Path],
    endings: Collection[str],
    what: str = "recording",
    meant: Callable[[Path], bool] | None = None,
) -> tuple[list[Input], list[Refusal]]:
    """All files meant by files and folders, in the order given and sorted within a folder; each once.

    Parameters
    ----------
    given : files, taken whatever their place, and folders, searched to any depth; hidden names are left out.
    endings : lower case with the dot; a file named outright that has none of them is refused.
    what : what one such file is called.
    meant : whether a file found in a folder is one; `io.looks_meant` when None. What is not is said and left out.

    Raises
    ------
    UsageError
        When nothing was given.
    """
    if not given:
        raise UsageError(f"a {what} or a folder of them was wanted, none was given: name at least one FILE")
    inputs: list[Input] = []
    refused: list[Refusal] = []
    several = len(given) > 1
    seen: dict[Path, Path] = {}
    for path in given:
        found, why = _stood_for(path, endings, what, meant, several=several)
        refused += why
        for one in found:
            if is_no_file(one.path):
                refused.append(Refusal(one.path, NO_FILE))
                continue
            if is_new(one.path, seen):
                inputs.append(one)
    return inputs, refused


def _stood_for(
    path: Path, endings: Collection[str], what: str, meant: Callable[[Path], bool] | None, *, several: bool
) -> tuple[list[Input], list[Refusal]]:
    """The files that one name on the command line stands for, and what of it cannot be worked on."""
    if (closed := closed_to_us(path)) is not None:
        return [], [closed]
    if path.is_dir():
        top = Path(name_of(path)) if several else Path()
        refused = closed_below(path)
        files = _meant(_files_in(path, endings, {why.path for why in refused}), what, meant)
        if not files and not refused:
            refused = [Refusal(path, f"no {what} in this folder ({', '.join(sorted(endings))})")]
        return [Input(file, top / file.relative_to(path)) for file in files], refused
    if not path.exists():
        return [], [Refusal(path, "no such file or folder")]
    if ending(path) == ".asf" and ".asf" not in endings:
        return [], [Refusal(path, "a skeleton, no recording: give the .amc files that go with it")]
    if ending(path) not in endings:
        came = f"came {path.suffix!r}" if path.suffix else "came none"
        how = "; of a sensor's skeleton `motionmend correct` makes a table (.csv)" if ending(path) in SENSED else ""
        return [], [Refusal(path, f"an ending of {', '.join(sorted(endings))} was wanted, {came}{how}")]
    return [Input(path, Path(path.name))], []


def closed_to_us(path: Path) -> Refusal | None:
    """Why something named cannot be looked at, as what lies in a folder that may not be read; None where it can, or
    where nothing is there."""
    try:
        if path.is_dir():
            with os.scandir(path):
                (path / "x").exists()  # to list a folder is one right, to reach what is in it another
    except OSError as failure:
        return Refusal(path, f"cannot be looked at: {failure.strerror}: check the name, or who may read it")
    return None


def closed_below(folder: Path) -> list[Refusal]:
    """The folders below one that may not be read, whatever they hold; not those whose names hide them, nor those of a
    recording of depth, of which its reader speaks."""
    from ..io.depth import looks_like_depth_folder

    found: list[Refusal] = []
    for top, folders, _ in os.walk(folder):
        if looks_like_depth_folder(Path(top)):
            folders.clear()
        below = sorted(Path(top, name) for name in folders if not name.startswith("."))
        closed = [why for one in below if not one.is_symlink() and (why := closed_to_us(one)) is not None]
        found += closed
        folders[:] = [one.name for one in below if all(one != why.path for why in closed)]
    return found


def is_new(path: Path, seen: dict[Path, Path]) -> bool:
    """Whether a file is none of those `seen`, to which it is added; says of one that is, by another name, which.

    Parameters
    ----------
    path : a file or folder.
    seen : by where it is, the name under which it was met.
    """
    whole = path.resolve()
    if whole not in seen:
        seen[whole] = path
        return True
    first = seen[whole]
    if os.path.abspath(first) != os.path.abspath(path):
        say(f"{path} is left out: the same as {first}")
    return False


def plan(
    inputs: Sequence[Input], given: Sequence[Path], out: Path, endings: Collection[str], otherwise: str
) -> list[Job]:
    """Where each output goes: OUT itself for one file, a tree below OUT for a folder or several.

    Parameters
    ----------
    inputs : from `gather(given, ...)`.
    given : as on the command line.
    out : what -o names.
    endings : of the files that can be written, lower case with the dot.
    otherwise : the ending of an output whose input cannot be written as what it is.

    Raises
    ------
    UsageError
        When OUT cannot be what is needed, or two inputs would share an output.
    """
    one_file = len(given) == 1 and not os.path.isdir(given[0])
    if one_file and out.suffix and not out.is_dir():
        if ending(out) not in endings:
            raise UsageError(f"-o {out}: an ending of {', '.join(sorted(endings))} was wanted, came {out.suffix!r}")
        targets = [out] * len(inputs)
    else:
        if out.exists() and not out.is_dir():
            wanted = f"a name that ends in {', '.join(sorted(endings))}" if one_file else "a folder for several inputs"
            raise UsageError(f"-o {out}: {wanted} was wanted, this file is there")
        if not out.is_dir() and ending(out) in endings:
            raise UsageError(f"-o {out}: a folder was wanted for several inputs, came the name of a file")
        targets = [out / (i.place if ending(i.path) in endings else i.place.with_suffix(otherwise)) for i in inputs]
    for target, count in Counter(map(os.path.normcase, targets)).items():
        if count > 1:
            raise UsageError(f"{count} inputs would all be written to {target}: give them apart")
    return jobs_of(inputs, targets)


def jobs_of(inputs: Sequence[Input], targets: Sequence[Path]) -> list[Job]:
    """The jobs of inputs and their outputs, none of which has another's name.

    Files beside `walk.bvh` are called `walk.mend.json` and so on; where another output is `walk.amc`, theirs are
    `walk.bvh.mend.json` and `walk.amc.mend.json`.
    """
    stems = [target.with_suffix("") for target in targets]
    shared = Counter(map(os.path.normcase, stems))
    return [
        Job(one.path, target, stem if shared[os.path.normcase(stem)] == 1 else target)
        for one, target, stem in zip(inputs, targets, stems, strict=True)
    ]


def ready(
    job: Job, taken: Set[Path | FileNumber], sidecars: Sequence[str], *, force: bool, resume: bool
) -> Job | Refusal:
    """The job as it is to be done, or why it must not write what it would write; `taken`: `identities` of the inputs.

    An output appears under its name only when it is complete: with `resume`, what is there with all that belongs
    beside it is finished, and what lacks some of it, or was emptied since, is done again. Where the file beside it
    belongs to an output of the same name in another format, its own gets the whole name.
    """
    try:
        return _ready(job, taken, sidecars, force=force, resume=resume)
    except OSError as failure:  # a name that is too long, a folder that is closed
        return Refusal(job.source, f"the output {job.target} cannot be written: {failure.strerror}")


def _ready(
    job: Job, taken: Set[Path | FileNumber], sidecars: Sequence[str], *, force: bool, resume: bool
) -> Job | Refusal:
    if any(_owner(job.beside(sidecar)) not in (None, job.target.name) for sidecar in sidecars):
        job = replace(job, stem=job.target)
    outputs = [job.target, *(job.beside(sidecar) for sidecar in sidecars)]
    for output in outputs:
        if output.is_dir():
            return Refusal(job.source, f"the output {output} is a folder: choose another name with -o")
        if not taken.isdisjoint(_identities(output)):
            return Refusal(job.source, f"the output {output} is an input itself: choose another name with -o")
    if resume and all(output.exists() and output.stat().st_size for output in outputs):
        return replace(job, finished=True)
    there = next((output for output in outputs if output.exists()), None)
    if there is not None and not (force or resume):
        reason = f"the output {there} is there already: --force overwrites it, --resume skips what is finished"
        return Refusal(job.source, reason)
    return job


def _owner(sidecar: Path) -> str | None:
    """The name of the output that a sidecar in JSON says it belongs to."""
    if sidecar.suffix != ".json" or not sidecar.is_file():
        return None
    try:
        owner = json.loads(sidecar.read_text("utf-8-sig")).get("output")
    except (ValueError, AttributeError):  # not ours
        return None
    return owner if isinstance(owner, str) else None


def _files_in(folder: Path, endings: Collection[str], closed: Collection[Path]) -> Iterator[Path]:
    """The files below a folder that have an ending, sorted, without those of `closed` folders; says which are left
    out as their names hide them.

    What is there under such a name but is no file, as a link to nothing, is among them, so that reading it says why.
    """
    hidden: list[Path] = []
    for file in sorted(folder.rglob("*")):
        if closed and any(one in closed for one in (file, *file.parents)):
            continue
        unseen = any(part.startswith(".") for part in file.relative_to(folder).parts)
        if file.is_dir():
            if file.is_symlink() and not unseen:
                say_not_followed(file)
        elif ending(file) in endings and unseen:
            hidden.append(file)
        elif ending(file) in endings:
            yield file
    say_hidden(hidden)


def say_hidden(files: Sequence[Path]) -> None:
    """Say which files found in a folder are left out because their names hide them."""
    if files:
        which = f"{files[0]} is" if len(files) == 1 else f"{files[0]} and {len(files) - 1} more are"
        say(f"{which} left out: hidden by a name that begins with a dot; give such a file by name to take it")


def name_of(path: Path) -> str:
    """The last name of a path, as it was given: of a link its own, of `.` and `..` the folder's."""
    return path.resolve().name if path.name in ("", "..") else path.name


def place_among(path: Path, given: Sequence[Path]) -> tuple[int, Path]:
    """Where a file stands among what was given: by what names it or holds it, then by its own name; else before all."""
    for number, one in enumerate(given):
        if path == one or one in path.parents:
            return number, path
    return -1, Path()


def is_no_file(path: Path) -> bool:
    """Whether something is there that is neither a file nor a folder: to open it may take for ever."""
    return path.exists() and not path.is_file() and not path.is_dir()


def say_not_followed(link: Path) -> None:
    """Say that a link found in a folder is not followed: it may lead back into that folder, or out of it."""
    say(f"{link} is left out: a link to a folder; give it by name to take what is in it")


def _meant(files: Iterable[Path], what: str, meant: Callable[[Path], bool] | None) -> list[Path]:
    """The files that are what is looked for; says which others are left out."""
    from ..io import looks_meant

    kept: list[Path] = []
    others: dict[Path, list[Path]] = {}
    for file in files:
        if not file.is_file() or (meant or looks_meant)(file):
            kept.append(file)
        else:
            others.setdefault(file.parent, []).append(file)
    for folder, left in others.items():
        if len(left) == 1:
            say(f"{left[0]} is left out: not a {what}, as it starts otherwise")
        else:
            names = ", ".join(file.name for file in left)
            say(f"{folder}: {len(left)} files are left out ({names}): none is a {what}, as they start otherwise")
    return kept


def identities(inputs: Iterable[Input]) -> frozenset[Path | FileNumber]:
    """What the inputs are, whatever other names they have: found once, as each of thousands of outputs asks for all."""
    return frozenset(one for each in inputs for one in _identities(each.path))


def _identities(path: Path) -> Iterator[Path | FileNumber]:
    """Where a file is, also by way of folders that are yet to be made, and its number on its device if it is there."""
    yield path.resolve()
    with suppress(OSError):
        there = path.stat()
        yield there.st_dev, there.st_ino
