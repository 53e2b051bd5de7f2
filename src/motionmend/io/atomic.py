"""Files that are whole or not there at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import FileError


@contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `path`, with the same ending, that takes its place when the block succeeds.

    When the block fails, nothing stays behind and a file that stood at `path` stays as it was. The temporary name
    starts with a dot, so that nobody takes it for a result while it is being written.

    Parameters
    ----------
    path : where the finished file belongs.

    Yields
    ------
    temporary : to be written by the block; not there yet.

    Raises
    ------
    FileError : the folder is not there, or the operating system refuses to write; whatever the block raises itself.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise FileError(f"{target}: cannot be written, there is no folder {target.parent}; make it first")
    if target.is_dir():
        raise FileError(f"{target}: cannot be written, it is a folder; name a file")
    temporary = target.with_name(f".{secrets.token_hex(6)}{target.suffix}")
    try:
        yield temporary
        os.replace(temporary, target)
    except OSError as failure:
        _remove(temporary)
        raise FileError(f"{target}: cannot be written: {failure.strerror or failure}") from failure
    except FileError as failure:  # of a writer that was given the temporary name: people know the other one
        _remove(temporary)
        raise FileError(str(failure).replace(str(temporary), str(target))) from failure
    except BaseException:
        _remove(temporary)
        raise


def _remove(temporary: Path) -> None:
    with suppress(OSError):  # where nothing can be written nothing can be removed, and the first failure tells why
        temporary.unlink(missing_ok=True)
