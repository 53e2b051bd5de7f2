"""Fitted models to and from .mend files: the one place that knows both the rooms and the format."""

from os import PathLike
from typing import TYPE_CHECKING

from .errors import FileError, UsageError

if TYPE_CHECKING:
    from .denoise import DenoiserModel
    from .io.model import StoredModel

KINDS = ("denoiser",)


def save_model(path: str | PathLike[str], model: "DenoiserModel") -> str:
    """Write a fitted model to a file ending in .mend.

    Parameters
    ----------
    path : the file; its folder must be there. What was there before is replaced.
    model : a fitted denoiser.

    Returns
    -------
    The SHA-256 of what was written, in hexadecimal, as `StoredModel.sha256` gives it.

    Raises
    ------
    UsageError
        When `model` is no fitted model.
    FileError
        When the file cannot be written.
    """
    from .denoise import DenoiserModel
    from .io import model as file

    if not isinstance(model, DenoiserModel):
        raise UsageError(f"a fitted model can be saved, came {type(model).__name__}")
    arrays, header = model.to_arrays()
    return file.save_model(path, "denoiser", arrays, header)


def load_model(path: str | PathLike[str]) -> "DenoiserModel":
    """Read a fitted model from a .mend file.

    Raises
    ------
    FileError
        When the file is no model, was changed since it was written, or is of a kind this version does not know.
    """
    from .io import model as file

    return restore(file.load_model(path), path)


def restore(stored: "StoredModel", path: str | PathLike[str]) -> "DenoiserModel":
    """The fitted model in a file already read; `path` is named in the error.

    Raises
    ------
    FileError
        When the model is of a kind this version does not know, or lacks something its kind needs.
    """
    from .denoise import DenoiserModel

    if stored.kind not in KINDS:
        raise FileError(
            f"{path}: a model of kind {', '.join(KINDS)} was wanted, came {stored.kind!r}: update motionmend"
        )
    try:
        return DenoiserModel.from_arrays(stored.arrays, stored.header)
    except KeyError as missing:
        raise FileError(f"{path}: the {stored.kind} in it has no {missing}: fit it again with this version") from None
