"""Fitted models to and from .mend files: the one place that knows both the rooms and the format."""

from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any

from .errors import FileError, UsageError

if TYPE_CHECKING:
    from .io.model import StoredModel

# Where the class of each kind of model is; it has `to_arrays` and `from_arrays`.
_CLASSES = {
    "denoiser": ("denoise", "DenoiserModel"),
    "tracker": ("track.model", "TrackerModel"),
    "corrector": ("correct.corrector", "CorrectorModel"),
}
KINDS = tuple(_CLASSES)


def save_model(path: str | PathLike[str], model: Any) -> str:
    """Write a fitted model to a file ending in .mend.

    Parameters
    ----------
    path : the file; its folder must be there. What was there before is replaced.
    model : a fitted model of one of KINDS.

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
    from .io import model as file

    kind = next((kind for kind, (_, name) in _CLASSES.items() if type(model).__name__ == name), None)
    if kind is None or type(model) is not _class(kind):
        raise UsageError(f"a fitted model can be saved, came {type(model).__name__}")
    arrays, header = model.to_arrays()
    return file.save_model(path, kind, arrays, header)


def load_model(path: str | PathLike[str], kind: str | None = None) -> Any:
    """Read a fitted model from a .mend file.

    Parameters
    ----------
    path : the file.
    kind : the one of KINDS that is wanted; any when None.

    Raises
    ------
    FileError
        When the file is no model, was changed since it was written, or is of a kind this version does not know.
    """
    from .io import model as file

    return restore(file.load_model(path), path, kind)


def restore(stored: "StoredModel", path: str | PathLike[str], kind: str | None = None) -> Any:
    """The fitted model in a file already read; `path` is named in the error.

    Parameters
    ----------
    stored : what the file holds.
    path : the file.
    kind : the one of KINDS that is wanted; any when None.

    Raises
    ------
    FileError
        When the model is of a kind this version does not know, or lacks something its kind needs.
    """
    if stored.kind not in KINDS:
        raise FileError(
            f"{path}: a model of kind {', '.join(KINDS)} was wanted, came {stored.kind!r}: update motionmend"
        )
    if kind is not None and stored.kind != kind:
        raise FileError(
            f"{path}: a {kind} was wanted, came a {stored.kind}: give the model that `motionmend fit {kind}` wrote"
        )
    try:
        return _class(stored.kind).from_arrays(stored.arrays, stored.header)
    except KeyError as missing:
        raise FileError(f"{path}: the {stored.kind} in it has no {missing}: fit it again with this version") from None


def _class(kind: str) -> Any:
    module, name = _CLASSES[kind]
    return getattr(import_module(f".{module}", __package__), name)
