"""How every kernel is compiled: by numba, the machine code kept on disk."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from pickle import UnpicklingError
from typing import Any, TypeVar, cast

import numba
from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile `function` with numba and keep the machine code between runs.

    numba stores the code beside the source file or in the user's cache folder and refuses to decorate when it
    may write to neither, as in a read-only install run by an account without a home. Then the code goes to a
    folder of this user's own under the temporary folder, or, failing that too, is compiled anew in each run. So it is
    while the code cannot be stored, as on a full disk.
    The environment and numba's settings stay as they were. Kernels let other threads run, and divide as NumPy does: by
    zero too, to infinity or NaN.
    """
    try:
        return _kept(function)
    except RuntimeError as refusal:
        if "no locator available" not in str(refusal):
            raise
    folder = _private_folder()
    if folder is None:
        return cast(Function, njit(nogil=True, error_model="numpy")(function))
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)  # read once, while decorating
    try:
        return _kept(function)
    finally:
        config.CACHE_DIR = before


def _kept(function: Function) -> Function:
    kernel: Any = njit(cache=True, nogil=True, error_model="numpy")(function)
    cache = getattr(kernel, "_cache", None)
    if cache is not None:  # numba's own guard of what it stores and finds; none is there but on Windows
        cache._guard_against_spurious_io_errors = partial(_forgiving, cache)
    return cast(Function, kernel)


@contextmanager
def _forgiving(cache: Any) -> Iterator[None]:
    """Do without what cannot be stored or found; an index that is damaged, as by a loss of power, begins anew."""
    try:
        yield
    except OSError:
        pass
    except (EOFError, UnpicklingError):
        with suppress(OSError):
            cache._cache_file.flush()


def _private_folder() -> Path | None:
    """A folder only this user can write to: numba unpickles what it finds in its cache."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"motionmend-kernels-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        if hasattr(os, "getuid") and (status.st_uid != user or status.st_mode & 0o077):
            return None
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return None
    return folder
