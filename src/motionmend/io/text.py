"""Text files and the words in them."""

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import FileError

LARGEST = 1e9  # in any unit of length or angle; what is larger is damage, and its square may have no end
ABSURD = 1e30  # the same where clocks may stand as well, which count in ticks of 100 ns
_NO_NUMBER = re.compile(r"[-+]?(?:nan\(\w*\)|1\.#(?:IND|[QS]NAN)\w*)", re.IGNORECASE)
PIECE = 1 << 22  # bytes of a long text that are in memory at a time


@dataclass(frozen=True)
class Text:
    """A text file that is read a piece at a time, so that a long one is never all in memory.

    Attributes
    ----------
    path, wanted : the file, and what it should be, for messages.
    encoding : UTF-8, or Latin-1 as old programs write.
    newline : what ends its lines.
    ended : whether the last one is.
    """

    path: Path
    wanted: str
    encoding: str
    newline: bytes
    ended: bool

    def pieces(self, after: int = 0) -> Iterator[str]:
        """The text from its beginning, or after so many characters, whole lines each time.

        Raises
        ------
        FileError : the file cannot be read any more.
        """
        for piece in self._whole_lines():
            if len(piece) > after:
                yield piece[after:]
            after = max(0, after - len(piece))

    def _whole_lines(self) -> Iterator[str]:
        rest = b""
        for raw in _raw_pieces(self.path, self.wanted):
            lines, end, rest = (rest + raw).rpartition(self.newline)
            if end:
                yield self._decoded(lines + end)
        if rest:
            yield self._decoded(rest)

    def _decoded(self, raw: bytes) -> str:
        text = raw.decode(self.encoding)
        return text if self.newline == b"\n" else text.replace("\r", "\n")


def open_text(path: str | Path, wanted: str) -> Text:
    """A text file to be read a piece at a time; it is gone through once to see what it is.

    Line ends are as they are, but for those of old programs that are a carriage return alone.

    Parameters
    ----------
    path : the file.
    wanted : what it should be, for the message, such as "a BVH file".

    Raises
    ------
    FileError : when the file cannot be opened, is empty or is not text.
    """
    decoder = codecs.getincrementaldecoder("utf-8")()
    encoding, breaks, blank, last = "utf-8", False, True, b""
    for raw in _raw_pieces(path, wanted):
        if b"\0" in raw:
            raise FileError(f"{path}: wanted {wanted}, came binary data; check the file's ending")
        breaks, blank, last = breaks or b"\n" in raw, blank and not raw.strip(), raw
        try:
            decoder.decode(raw)
        except UnicodeDecodeError:
            encoding = "latin-1"
            decoder.reset()
    try:
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        encoding = "latin-1"
    if blank:
        raise FileError(f"{path}: wanted {wanted}, came an empty file; get a complete copy")
    newline = b"\n" if breaks else b"\r"
    return Text(Path(path), wanted, encoding, newline, last.endswith(newline))


def _raw_pieces(path: str | Path, wanted: str) -> Iterator[bytes]:
    try:
        with Path(path).open("rb") as file:
            while raw := file.read(PIECE):
                yield raw
    except OSError as failure:
        raise FileError(f"{path}: wanted {wanted}, cannot open it: {failure.strerror}; check the path") from None


def read_text(path: str | Path, wanted: str) -> str:
    """The whole of a file that is never long; see `open_text`."""
    return "".join(open_text(path, wanted).pieces())


def shown(token: str) -> str:
    """A piece of a broken file, fit to stand in a one-line message."""
    cut = token if len(token) <= 24 else token[:24] + "…"
    return ascii(cut) if any(not c.isprintable() for c in cut) else f"'{cut}'"


def finite(token: str) -> float:
    """The number `token` spells; NaN for `nan`, and for what Windows programs write instead, `-nan(ind)` or `-1.#IND`.

    Raises
    ------
    ValueError : for anything else, also for `inf`, beyond `LARGEST` and for Python's own `1_000`.
    """
    value = float("nan" if _NO_NUMBER.fullmatch(token) else token)
    if abs(value) > LARGEST or "_" in token:
        raise ValueError(token)
    return value
