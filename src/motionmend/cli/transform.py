"""What `denoise` and `corrupt` share: recordings in, recordings of the same shape out, a file beside each."""

import json
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..batch import Task
from ..errors import counted
from .folders import new_folders, ready_and_housed
from .inputs import Input, Job, gather, plan
from .options import Working, Writing
from .output import Done, work
from .speech import json_line, say

OTHERWISE = ".c3d"  # what a recording becomes whose own format can only be read


def transform(
    task: Task[Job, Done],
    files: Sequence[Path],
    out: Path,
    *,
    sidecars: Sequence[str],
    as_json: bool,
    working: Working,
    writing: Writing,
    forms: "Forms | None" = None,
) -> int:
    """Run a task on every recording and write what it makes; return the exit code.

    Parameters
    ----------
    task : reads `job.source`, writes `job.target` and its sidecars.
    files, out : as on the command line.
    sidecars : endings of the files beside each output.
    forms : what is read and written; joint angles and markers when None.
    """
    from ..io import READABLE, WRITABLE

    forms = forms or Forms(READABLE, WRITABLE, OTHERWISE)
    files, out = [working.reachable(file) for file in files], working.reachable(out)
    inputs, refused = gather(files, forms.readable, forms.what, forms.meant)
    inputs = _without(out, inputs, files)
    with new_folders() as make:
        planned = plan(forms.placed(inputs), files, out, forms.writable, forms.otherwise)
        jobs, barred = ready_and_housed(planned, inputs, sidecars, writing, make)
        refused = [*refused, *barred]
        return work(_Once(task), jobs, name=_source, working=working, as_json=as_json, refused=refused, given=files)


@dataclass(frozen=True)
class Forms:
    """What a command reads and writes.

    Attributes
    ----------
    readable, writable : endings, lower case with the dot.
    otherwise : the ending of an output whose input's own cannot be written.
    what : what one such recording is called.
    meant : whether a file found in a folder is one; `io.looks_meant` when None.
    placed : gives each input the place its output has below a folder.
    """

    readable: Collection[str]
    writable: Collection[str]
    otherwise: str
    what: str = "recording"
    meant: Callable[[Path], bool] | None = None
    placed: Callable[[list[Input]], list[Input]] = list


@dataclass(frozen=True)
class _Once:
    """The task, but for jobs that are finished."""

    task: Task[Job, Done]

    def __call__(self, job: Job, /) -> Done:
        if not job.finished:
            return self.task(job)
        facts = {"input": job.source, "output": job.target, "skipped": True}
        return Done(facts, line=f"{job.source}: {job.target} is there already, skipped")


def write_json(path: Path, facts: Mapping[str, Any]) -> None:
    """Write facts as JSON for people and programs: one entry a line, long lists kept on theirs."""
    from ..io.atomic import atomic

    with atomic(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        for number, (key, value) in enumerate(facts.items()):
            file.write(",\n  " if number else "{\n  ")
            file.writelines(_entry(key, value))
        file.write("\n}\n")


def _entry(key: str, value: Any) -> Iterator[str]:
    """An entry of a JSON object; what is a mapping itself is gone through, so that it need not be there as a whole."""
    if not isinstance(value, Mapping):
        yield json_line({key: value})[1:-1]
        return
    yield f"{json.dumps(key)}: {{"
    for number, (name, inner) in enumerate(value.items()):
        yield f"{', ' if number else ''}{json_line({name: inner})[1:-1]}"
    yield "}"


def _without(out: Path, inputs: list[Input], files: Sequence[Path]) -> list[Input]:
    """The inputs; where OUT lies inside a folder that was searched, without what lies below OUT."""
    whole = out.resolve()
    if not any(os.path.isdir(folder) and folder.resolve() in whole.parents for folder in files):
        return inputs
    kept = [one for one in inputs if one.path in files or whole not in one.path.resolve().parents]
    if len(kept) < len(inputs):
        left = counted(len(inputs) - len(kept), "recording")
        say(f"{left} below {out} left out: outputs")
    return kept


def _source(job: Job) -> Path:
    return job.source
