"""Text files and the words in them."""

from pathlib import Path

from ..errors import FileError


def read_text(path: str | Path, wanted: str) -> str:
    """The whole file as text, line ends as they are; what is no UTF-8 is taken for Latin-1, as old programs write.

    Parameters
    ----------
    path : the file.
    wanted : what it should be, for the message, such as "a BVH file".

    Raises
    ------
    FileError : when the file cannot be opened, is empty or is not text.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(f"{path}: wanted {wanted}, cannot open it: {failure.strerror}; check the path") from None
    if not raw.strip():
        raise FileError(f"{path}: wanted {wanted}, came an empty file; get a complete copy")
    if b"\0" in raw:
        raise FileError(f"{path}: wanted {wanted}, came binary data; check the file's ending")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def shown(token: str) -> str:
    """A piece of a broken file, fit to stand in a one-line message."""
    cut = token if len(token) <= 24 else token[:24] + "…"
    return ascii(cut) if any(not c.isprintable() for c in cut) else f"'{cut}'"


def finite(token: str) -> float:
    """The number `token` spells; NaN for `nan`.

    Raises
    ------
    ValueError : for anything else, also for `inf` and for Python's own `1_000`.
    """
    value = float(token)
    if value in (float("inf"), float("-inf")) or "_" in token:
        raise ValueError(token)
    return value
