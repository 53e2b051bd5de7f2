"""Options that several commands share, each with its unit and its default in the help text."""

import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from types import ModuleType
from typing import Annotated, TypeAlias

from cyclopts import Parameter, Token


def check_rate(_type: object, value: float | None) -> None:
    """Refuse what is no frame rate in Hz, as bad usage.

    Raises
    ------
    ValueError : it is 0 or below, or not finite.
    """
    if value is not None and not 0 < value < inf:
        raise ValueError("A frame rate above 0 Hz was wanted.")


def _whole(_type: object, tokens: Sequence[Token]) -> int:
    """A whole number; what has a point or an exponent is none and is not rounded."""
    given = tokens[0].value
    if not re.fullmatch(r"[+-]?[0-9]+", given.strip()):
        raise ValueError(f'a whole number was wanted, came "{given}".')
    return int(given)


Whole: TypeAlias = Annotated[int, Parameter(converter=_whole)]
Files: TypeAlias = Annotated[
    Path, Parameter(help="Recordings, or folders that are searched for them to any depth.", negative="")
]
Out: TypeAlias = Annotated[
    Path,
    Parameter(name=["-o", "--out"], help="The output for one input file; a folder for several or for a folder."),
]
Rate: TypeAlias = Annotated[
    float | None,
    Parameter(
        help="Rate in Hz of files that carry none (when not given 120 for .amc, 30 for sensors).", validator=check_rate
    ),
]
SkeletonFile: TypeAlias = Annotated[
    Path | None,
    Parameter(help="The .asf that goes with .amc files; otherwise it is looked for beside each."),
]
AsJson: TypeAlias = Annotated[
    bool,
    Parameter(
        name="--json", show_default=False, help="Print one JSON object per input on stdout and nothing else there."
    ),
]
Force: TypeAlias = Annotated[bool, Parameter(show_default=False, help="Overwrite outputs that are there.")]
Debug: TypeAlias = Annotated[bool, Parameter(show_default=False, help="Show where in the program a failure arose.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Working:
    """How a command goes through its inputs."""

    jobs: Annotated[Whole | None, Parameter(help="Processes to use; the default is the number of cores.")] = None
    cluster: Annotated[
        str | None,
        Parameter(help="Address of a Dask scheduler to use instead, such as tcp://127.0.0.1:8786."),
    ] = None
    debug: Debug = False

    @property
    def width(self) -> int:
        """Processes to use."""
        return self.jobs if self.jobs is not None else (os.cpu_count() or 1)

    def idle(self, count: int) -> bool:
        """Whether each of so many inputs may have two of this machine's processors to itself.

        Never where somebody else's script called the command: another process would run that script again.
        """
        return self.cluster is None and 2 * count <= self.width and _is_command(sys.modules["__main__"])

    def reachable(self, path: Path) -> Path:
        """The path as every worker finds it: those of a cluster run in other folders."""
        return path if self.cluster is None else path.absolute()


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Writing:
    """What a command does about outputs that are there already."""

    force: Force = False
    resume: Annotated[bool, Parameter(show_default=False, help="Skip inputs whose output is there and finished.")] = (
        False
    )


WORKING, WRITING = Working(), Writing()  # what holds when nothing is said


def _is_command(main: ModuleType) -> bool:
    """Whether a process that was started with a module is `motionmend`, by its name or by `python -m`."""
    spec = getattr(main, "__spec__", None)
    if spec is not None:
        return bool(spec.name.partition(".")[0] == "motionmend")
    return Path(getattr(main, "__file__", None) or "").stem == "motionmend"
