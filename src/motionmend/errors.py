"""The few kinds of failure, and how messages count. Each is one line: what was wanted, what came, what to do."""

from collections.abc import Sequence


class MotionMendError(Exception):
    """Any failure the user can do something about; the command line prints it as one line and exits with 1."""


class FileError(MotionMendError):
    """A file that cannot be read or written as what its ending promises."""


class MismatchError(MotionMendError):
    """Two things that do not belong together: a model and a recording, a truth and its copy."""


class UsageError(MotionMendError):
    """A call that makes no sense whatever the data; the command line exits with 2."""


def counted(number: int, noun: str) -> str:
    """A number before its noun as a message says it: 1 frame, 2 frames.

    Parameters
    ----------
    number : how many.
    noun : one of them; an s makes it several.
    """
    return f"{number} {noun}{'s'[: number != 1]}"


def few(names: Sequence[str], most: int = 4) -> str:
    """Names for a message: the first so many, and how many more there are.

    Parameters
    ----------
    names : in the order in which they are told.
    most : that are.
    """
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def one_line(text: str) -> str:
    """A message on one line, though a file's name in it holds a line's end; its other blanks stay, as in names.

    Parameters
    ----------
    text : of any number of lines.
    """
    return " ".join(filter(None, map(str.strip, text.splitlines())))


def interrupt_in(error: BaseException) -> KeyboardInterrupt | None:
    """Ctrl-C that came upon compiled code, which hands it on as the cause of an error of its own; None if it was none.

    Parameters
    ----------
    error : whatever was raised.
    """
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, KeyboardInterrupt):
            return cause
        cause = cause.__cause__
    return None
