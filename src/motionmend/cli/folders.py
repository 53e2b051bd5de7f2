"""Folders for outputs: made before the work begins, and gone after it where nothing came into them."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from .inputs import Input, Job, Refusal, identities, ready
from .options import Writing


@contextmanager
def new_folders() -> Iterator[Callable[[Path], None]]:
    """Makes folders, with those above them; of those that are new, what is empty in the end is removed."""
    new: list[Path] = []  # those above come first

    def make(folder: Path) -> None:
        new.extend(one for one in (*reversed(folder.parents), folder) if not one.exists())
        folder.mkdir(parents=True, exist_ok=True)

    try:
        yield make
    finally:
        for folder in reversed(new):
            with suppress(OSError):  # it holds something
                folder.rmdir()


def housed(job: Job, make: Callable[[Path], None]) -> Job | Refusal:
    """The job once there is a folder for its output, or why there cannot be one."""
    try:
        make(job.target.parent)
    except OSError as error:
        why = f"the folder {job.target.parent} cannot be made: {error.strerror or error}"
        return Refusal(job.source, f"{why}: choose another place with -o")
    return job


def ready_and_housed(
    planned: Sequence[Job],
    inputs: Sequence[Input],
    sidecars: Sequence[str],
    writing: Writing,
    make: Callable[[Path], None],
) -> tuple[list[Job], list[Refusal]]:
    """Planned jobs as they are to be done, with folders for their outputs, and those that cannot be."""
    jobs: list[Job] = []
    refused: list[Refusal] = []
    taken = identities(inputs)
    for one in planned:
        job = ready(one, taken, sidecars, force=writing.force, resume=writing.resume)
        if isinstance(job, Job):
            job = housed(job, make)
        if isinstance(job, Refusal):
            refused.append(job)
        else:
            jobs.append(job)
    return jobs, refused
