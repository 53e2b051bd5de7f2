"""Depth recordings meant by what stands on the command line, and where their outputs belong."""

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..errors import FileError, UsageError
from .inputs import (
    NO_FILE,
    Input,
    Job,
    Refusal,
    closed_below,
    closed_to_us,
    ending,
    is_new,
    is_no_file,
    jobs_of,
    name_of,
    say_hidden,
    say_not_followed,
)
from .speech import say

FORMATS = ("csv", "bvh", "amc")
_WHAT = "a depth recording (a folder with camera.json and depth/, or a UTD-MHAD *_depth.mat)"


def gather_depth(given: Sequence[Path]) -> tuple[list[Input], list[Refusal]]:
    """All depth recordings meant by folders and files, in the order given and sorted within a folder; each once.

    Parameters
    ----------
    given : depth folders, files ending in .mat, and folders that are searched for both to any depth.

    Raises
    ------
    UsageError
        When nothing was given.
    """
    if not given:
        raise UsageError(f"{_WHAT} was wanted, none was given: name at least one FOLDER")
    inputs: list[Input] = []
    refused: list[Refusal] = []
    seen: dict[Path, Path] = {}
    for path in given:
        closed = closed_to_us(path)
        shut = closed_below(path) if closed is None and path.is_dir() else []
        refused += shut
        found = closed or _meant(path, several=len(given) > 1)
        if isinstance(found, Refusal):
            refused += [] if shut else [found]
            continue
        inputs += [one for one in found if is_new(one.path, seen)]
    return inputs, refused


def plan_depth(inputs: Sequence[Input], given: Sequence[Path], out: Path, form: str | None) -> list[Job]:
    """Where each output goes: OUT itself for one recording, a tree below OUT for several.

    Parameters
    ----------
    inputs : from `gather_depth(given)`.
    out : what -o names.
    form : of `FORMATS`; None takes the ending of OUT, else csv.

    Raises
    ------
    UsageError
        When OUT cannot be what is needed, or two recordings would share an output.
    """
    endings = [f".{one}" for one in FORMATS]
    single = len(given) == 1 and all(one.path == given[0] for one in inputs)
    if single and out.suffix and not out.is_dir():
        if ending(out) not in endings:
            raise UsageError(f"-o {out}: an ending of {', '.join(endings)} was wanted, came {out.suffix!r}")
        if form is not None and ending(out) != f".{form}":
            raise UsageError(f"-o {out}: its ending and --format {form} differ: leave one of them out")
        targets = [out] * len(inputs)
    else:
        if out.exists() and not out.is_dir():
            raise UsageError(f"-o {out}: a folder was wanted for several recordings, came a file")
        if not out.is_dir() and ending(out) in endings:
            raise UsageError(f"-o {out}: a folder was wanted for several recordings, came the name of a file")
        targets = [out / one.place.with_name(f"{one.place.name}.{form or FORMATS[0]}") for one in inputs]
    for target, count in Counter(map(os.path.normcase, targets)).items():
        if count > 1:
            raise UsageError(f"{count} recordings would all be written to {target}: give them apart")
    return jobs_of(inputs, targets)


def _meant(path: Path, *, several: bool) -> list[Input] | Refusal:
    """The recordings that one name on the command line stands for; a place has no ending."""
    from ..io.depth import looks_like_depth_folder

    if looks_like_depth_folder(path):
        return [Input(path, Path(name_of(path)))]
    if path.is_dir():
        top = Path(name_of(path)) if several else Path()
        found = [Input(one, top / _without_ending(one.relative_to(path))) for one in _below(path)]
        return found or Refusal(path, f"there is no camera.json in this folder: {_WHAT} was wanted")
    if not path.exists():
        return Refusal(path, "no such file or folder")
    if is_no_file(path):
        return Refusal(path, NO_FILE)
    if ending(path) != ".mat":
        return Refusal(path, f"{_WHAT} was wanted, came {path.suffix or 'a file without ending'!r}")
    return [Input(path, Path(path.stem))]


def _below(folder: Path) -> Iterator[Path]:
    """Depth folders and depth files below a folder, sorted; says which .mat files are something else."""
    from ..io.depth import looks_like_depth_folder

    within = sorted(folder.iterdir())
    hidden = [one for one in within if one.name.startswith(".")]
    say_hidden([one for one in hidden if ending(one) == ".mat"])
    for one in within:
        if one in hidden:
            continue
        if looks_like_depth_folder(one):
            yield one
        elif one.is_dir():
            if one.is_symlink():
                say_not_followed(one)
            elif closed_to_us(one) is None:
                yield from _below(one)
        elif ending(one) == ".mat":
            if not is_no_file(one) and _is_depth(one):
                yield one
            else:
                say(f"{one} is left out: no depth images in it")


def _is_depth(file: Path) -> bool:
    """Whether a .mat holds depth images; also True for one that cannot be opened, so that reading it says why."""
    from ..io.sensor import kind_of

    try:
        return file.name.lower().endswith("_depth.mat") or kind_of(file) == "depth"
    except FileError:
        return True


def _without_ending(place: Path) -> Path:
    return place.with_suffix("") if ending(place) == ".mat" else place
