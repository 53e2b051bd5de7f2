"""What running a command gives back."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Ran:
    """Exit code, standard output and standard error of one command."""

    code: int
    out: str
    err: str

    @property
    def failures(self) -> list[str]:
        """Lines of standard error that tell of a failure."""
        return [line for line in self.err.splitlines() if line.startswith("motionmend: ")]


Command = Callable[..., Ran]


def files_below(folder: Path) -> set[str]:
    """Names of all files below a folder, hidden ones included."""
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
