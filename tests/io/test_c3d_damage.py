"""C3D files that are damaged, cut or no C3D at all: a value or one line, never anything else."""

import struct
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from c3d_files import (
    gap_and_fill,
    written_by_ezc3d,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers
from motionmend.errors import FileError
from motionmend.io.c3d import read_c3d, write_c3d
from motionmend.io.c3d_fresh import METRES
from motionmend.io.c3d_layout import BLOCK, parse


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> bytes:
    """A file with everything in it: analog samples, events, a listing of ours."""
    rng, tmp_path = np.random.default_rng(7), tmp_path_factory.mktemp("small")
    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    c3d["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = ["LANK", "LFHD", "*3"]
    c3d["parameters"]["ANALOG"]["RATE"]["value"] = [200.0]
    c3d["parameters"]["ANALOG"]["LABELS"]["value"] = ["Fx", "Fz"]
    c3d["data"]["points"] = rng.normal(size=(4, 3, 30)) * 100
    c3d["data"]["analogs"] = rng.normal(size=(1, 2, 60))
    c3d.add_event([0.1, 0.0], context="Left", label="Foot Strike")
    c3d.write(str(tmp_path / "small.c3d"))
    read = read_c3d(tmp_path / "small.c3d")
    write_c3d(tmp_path / "small.c3d", *gap_and_fill(read, rng))
    return (tmp_path / "small.c3d").read_bytes()


def refusal(path: Path) -> str:
    """Why the file is not read, or "" when it is; anything but a value or one line is a failure of the test."""
    try:
        read_c3d(path)
    except FileError as failure:
        return str(failure)
    return ""


def is_one_line(message: str, path: Path) -> bool:
    return "\n" not in message and path.name in message and len(message) < 300


def test_every_cut_is_noticed(tmp_path: Path, small: bytes) -> None:
    path = tmp_path / "cut.c3d"
    layout = parse(small, "small")
    last = layout.data_at + 30 * layout.stride
    for size in [*range(0, last, 97), last - 1]:
        path.write_bytes(small[:size])
        assert is_one_line(refusal(path), path), f"{size} of {last} bytes"
    path.write_bytes(small[:last])
    assert refusal(path) == "", "only the padding is gone"


@pytest.mark.slow
@settings(max_examples=300)
@given(st.data())
def test_damage_gives_a_value_or_one_line(small: bytes, tmp_path_factory, data) -> None:
    damaged = bytearray(small)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, parse(small, "small").data_at - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.c3d"
    path.write_bytes(damaged)
    why = refusal(path)
    assert why == "" or is_one_line(why, path)
    if not why:
        read = read_c3d(path)
        write_c3d(path.with_name("rewritten.c3d"), read)
        np.testing.assert_array_equal(read_c3d(path.with_name("rewritten.c3d")).present, read.present)


def huge_header() -> bytes:
    header = bytearray(2 * BLOCK)
    struct.pack_into("<BB5HfHHf", header, 0, 2, 0x50, 65_535, 65_535, 1, 65_535, 0, -1.0, 3, 1, 100.0)
    header[BLOCK : BLOCK + 4] = 1, 0x50, 1, 84
    return bytes(header)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "not those of one"),
        (b"HIERARCHY\nROOT Hips\n" * 100, "not those of one"),
        (bytes(4096), "not those of one"),
        (b"\x02\x50" + bytes(200), "not those of one"),
        (b"\x02\x50" + bytes(510), "cut off"),
        (b"\x02\x50" + bytes(5000), "processor"),
        (b"\xff" * 5000, "not those of one"),
        (huge_header(), "POINT:"),
    ],
)
def test_what_is_no_c3d_file(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / "bad.c3d"
    path.write_bytes(content)
    with pytest.raises(FileError, match=why):
        read_c3d(path)


def test_more_promised_than_held(tmp_path: Path, small: bytes) -> None:
    raw = bytearray(small)
    struct.pack_into("<H", raw, 8, 5000)
    (tmp_path / "a.c3d").write_bytes(raw)
    with pytest.raises(FileError, match=r"promises 5000 frames, the file holds 3\d"):
        read_c3d(tmp_path / "a.c3d")


def test_no_frames_no_points(tmp_path: Path, small: bytes, rng) -> None:
    raw = bytearray(small)
    struct.pack_into("<H", raw, 8, 0)
    (tmp_path / "a.c3d").write_bytes(raw)
    with pytest.raises(FileError, match="promises 0"):
        read_c3d(tmp_path / "a.c3d")
    empty = Markers((), np.empty((3, 0, 3)), 100.0)
    with pytest.raises(FileError, match="needs markers and frames"):
        write_c3d(tmp_path / "b.c3d", empty)
    unlabelled = written_by_ezc3d(tmp_path / "c.c3d", rng.normal(size=(4, 2, 3)), ["*1", "*2"])
    with pytest.raises(FileError, match="wanted labelled markers"):
        read_c3d(unlabelled)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("damage", [1e30, -2e9, np.inf, np.nan])
def test_what_no_camera_saw_is_missing(tmp_path: Path, rng, damage: float) -> None:
    path, positions = tmp_path / "far.c3d", rng.normal(size=(6, 3, 3))
    write_c3d(path, Markers(("A", "B", "C"), positions, 100.0))
    raw = bytearray(path.read_bytes())
    at = raw.index(struct.pack("<f", np.float32(positions[2, 1, 0] / METRES)))
    raw[at : at + 4] = struct.pack("<f", damage)
    path.write_bytes(raw)
    read = read_c3d(path)
    assert np.argwhere(~read.present).tolist() == [[2, 1]]
    assert any("1 positions beyond 1e+09" in said for said in read.guesses) == (not np.isnan(damage))
    write_c3d(path, read)
    assert np.argwhere(~read_c3d(path).present).tolist() == [[2, 1]]
