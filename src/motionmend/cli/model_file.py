"""The file that `fit` writes a model to."""

from pathlib import Path
from typing import Annotated, Any, TypeAlias

from cyclopts import Parameter

from ..errors import FileError, UsageError

ModelFile: TypeAlias = Annotated[Path, Parameter(name=["-o", "--out"], help="The model to write; ends in .mend.")]


def check_place(out: Path, force: bool) -> None:
    """Refuse a place that a model cannot be written to, before anything is learned.

    Raises
    ------
    UsageError : the name does not end in .mend.
    FileError : there is a file, and it is not to be overwritten.
    """
    if out.suffix.lower() != ".mend":
        raise UsageError(f"-o: a model's name ends in .mend, came {out}")
    if out.exists() and not force:
        raise FileError(f"{out} is there already: --force overwrites it")


def write_model(out: Path, model: Any) -> str:
    """Write a fitted model, and the folder that it is to lie in; gives the file's SHA-256."""
    from ..models import save_model

    out.parent.mkdir(parents=True, exist_ok=True)
    return save_model(out, model)
