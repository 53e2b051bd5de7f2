"""Models as files: arrays and a JSON header in the safetensors format, with a hash over both.

Nothing in such a file is ever executed on loading. The safetensors metadata hold one entry, `motionmend`: a JSON
object with `kind`, `version` (of this format), `header` (whatever the model's room needs) and `sha256`, the hash over
those three and over the name, type, shape and bytes of each array. safetensors itself notices a cut-off file but not
a flipped byte; that hash does. It cannot be that of the file it stands in: what is told of a model is the SHA-256 of
the file's bytes, as `sha256sum` gives it.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, UsageError
from .atomic import atomic

ENDING = ".mend"
VERSION = 1
_KEY = "motionmend"


@dataclass(frozen=True, eq=False)
class StoredModel:
    """What a model file holds: its kind, read-only arrays, the JSON header; and the SHA-256 of the file's bytes."""

    kind: str
    arrays: Mapping[str, NDArray[Any]]
    header: Mapping[str, Any]
    sha256: str


def save_model(
    path: str | os.PathLike[str], kind: str, arrays: Mapping[str, NDArray[Any]], header: Mapping[str, Any]
) -> str:
    """Write a model file; the same arguments give the same bytes.

    Parameters
    ----------
    path : ends in .mend.
    kind : which room's model, e.g. "denoiser".
    arrays : numeric or boolean arrays of any shape, by name.
    header : everything else; JSON values only, no NaN.

    Returns
    -------
    sha256 : of the file's bytes, in hexadecimal.

    Raises
    ------
    UsageError : another ending, an array of objects or strings, or a header that JSON cannot hold.
    FileError : the file cannot be written.
    """
    from safetensors.numpy import save

    if Path(path).suffix.lower() != ENDING:
        raise UsageError(f"{path}: a model file ends in {ENDING}; name it so")
    for name, array in arrays.items():
        if np.asarray(array).dtype.kind not in "biuf":
            raise UsageError(
                f"a model holds numbers and truth values, array '{name}' is of type {np.asarray(array).dtype}"
            )
    little = {name: _little_endian(array) for name, array in arrays.items()}
    stated: dict[str, Any] = {"kind": kind, "version": VERSION}
    try:
        stated["header"] = json.loads(_canonical(dict(header)))  # as it will come back: lists, keys that are text
        digest = _digest(stated, little)
    except (TypeError, ValueError) as failure:
        raise UsageError(f"a model's header holds JSON values only: {failure}") from None
    content = save(little, {_KEY: _canonical({**stated, "sha256": digest})})
    with atomic(path) as temporary:
        temporary.write_bytes(content)
    return hashlib.sha256(content).hexdigest()


def load_model(path: str | os.PathLike[str]) -> StoredModel:
    """Read a model file and check its hash.

    Parameters
    ----------
    path : a file that `save_model` wrote.

    Returns
    -------
    model : as it was saved.

    Raises
    ------
    FileError : not there, not a model file of ours, or damaged.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        content = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(
            f"{path}: wanted a {ENDING} model, cannot open it: {failure.strerror}; check the path"
        ) from None
    not_ours = f"{path}: wanted a model file ({ENDING}), this is none; fit one with `motionmend fit`"
    try:
        arrays = load(content)
        size = int.from_bytes(content[:8], "little")
        stated = json.loads(json.loads(content[8 : 8 + size])["__metadata__"][_KEY])
        digest = stated.pop("sha256")
        whole = digest == _digest(stated, arrays)
    except (SafetensorError, ValueError, TypeError, KeyError, AttributeError):
        raise FileError(not_ours if _KEY.encode() not in content[:4096] else _damaged(path)) from None
    if not whole:
        raise FileError(_damaged(path))
    if stated["version"] != VERSION:
        raise FileError(
            f"{path}: wanted a model of format {VERSION}, came format {stated['version']}; update motionmend"
        )
    for array in arrays.values():
        array.flags.writeable = False
    return StoredModel(stated["kind"], arrays, stated["header"], hashlib.sha256(content).hexdigest())


def _damaged(path: str | os.PathLike[str]) -> str:
    return f"{path}: wanted an intact model, its content does not match its SHA-256; copy it again or fit it anew"


def _little_endian(array: NDArray[Any]) -> NDArray[Any]:
    # safetensors stores memory as it lies, so the order of bytes and of axes must be settled here.
    values = np.asarray(array)
    return np.ascontiguousarray(values, values.dtype.newbyteorder("<")).reshape(values.shape)


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _digest(stated: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> str:
    total = hashlib.sha256(_canonical(stated).encode())
    for name in sorted(arrays):
        array = arrays[name]
        total.update(_canonical([name, array.dtype.str, list(array.shape)]).encode())
        total.update(array.tobytes())
    return total.hexdigest()
