"""Text a piece at a time: nothing is lost where pieces meet, and what is wrong is said as of the whole."""

import numpy as np
import pytest
from acclaim_files import ASF, FRAMES, HEADER
from biovision_files import TEXT
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.errors import FileError
from motionmend.io import read, text
from motionmend.io.text import open_text

LINES = st.lists(st.text(st.characters(exclude_characters="\n\r\0"), max_size=9), min_size=1, max_size=9)


@given(
    LINES,
    st.sampled_from(["\n", "\r\n", "\r"]),
    st.booleans(),
    st.sampled_from(["utf-8", "latin-1"]),
    st.integers(1, 40),
)
@settings(max_examples=100)
def test_the_pieces_are_the_text(tmp_path_factory, lines, newline, ended, encoding, size):
    whole = newline.join(lines) + newline * ended
    raw = whole.encode(encoding, errors="replace")
    path = tmp_path_factory.mktemp("text") / "some.txt"
    path.write_bytes(raw)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(text, "PIECE", size)
        if not raw.strip():
            with pytest.raises(FileError, match="empty file"):
                open_text(path, "some text")
            return
        found = open_text(path, "some text")
        pieces = list(found.pieces())
        later = list(found.pieces(after=5))
    try:
        wanted = raw.decode("utf-8")
    except UnicodeDecodeError:
        wanted = raw.decode("latin-1")
    if b"\n" not in raw:
        wanted = wanted.replace("\r", "\n")
    assert "".join(pieces) == wanted
    assert "".join(later) == wanted[5:]
    assert all(piece.endswith("\n") for piece in pieces[:-1])
    assert all(pieces)
    assert found.ended == wanted.endswith("\n")


@pytest.mark.parametrize("size", [1, 24, 100])
@pytest.mark.parametrize(
    ("name", "whole"),
    [
        ("small.amc", HEADER + FRAMES),
        ("small.amc", "\ufeff" + HEADER + FRAMES.replace("\n2\n", "\n# between\n2\n")),
        ("small.amc", (HEADER + FRAMES).replace("\n", "\r")),
        ("small.bvh", TEXT),
        ("small.bvh", TEXT.replace("\n", "\r\n")),
        ("small.bvh", TEXT.replace("\n", "\r").rstrip("\r")),
    ],
)
def test_a_recording_in_pieces_is_the_recording(tmp_path, monkeypatch, name, whole, size):
    (tmp_path / "small.asf").write_text(ASF)
    path = tmp_path / name
    path.write_bytes(whole.encode())
    once = read(path)
    monkeypatch.setattr(text, "PIECE", size)
    again = read(path)
    np.testing.assert_array_equal(again.q, once.q)
    assert (again.fps, again.guesses) == (once.fps, once.guesses)
    for field in ("header", "bones", "comments", "before", "between", "frame_time"):
        assert getattr(again.source, field, None) == getattr(once.source, field, None)
