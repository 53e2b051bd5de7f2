"""ACCAD's marker text, plain and in a zip."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

from motionmend.errors import FileError
from motionmend.io.accad import read_accad
from motionmend.io.c3d import read_c3d, write_c3d
from motionmend.io.table import read_table, write_table
from motionmend.io.trc import read_trc, write_trc

TITLES = "Field\tTime\tS:LANK:X\tS:LANK:Y\tS:LANK:Z\tS:LFHD:X\tS:LFHD:Y\tS:LFHD:Z"
ROWS = (
    "1\t0.0000\t100\t200\t90\t100\t200\t1700\r\n"
    "2\t0.0083\t-9999.99\t-9999.99\t-9999.99\t101\t200\t1700\r\n"
    "3\t0.0167\t102\t200\t90\t\t\t\r\n"
)
PLAIN = f"{TITLES}\r\n{ROWS}"


def written(folder: Path, text: str, name: str = "a.txt") -> Path:
    path = folder / name
    path.write_text(text, newline="")
    return path


def zipped(folder: Path, files: dict[str, str]) -> Path:
    path = folder / "a.ZIP"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def test_reads_names_rate_metres_and_what_is_missing(tmp_path: Path) -> None:
    read = read_accad(written(tmp_path, PLAIN))
    assert read.names == ("S:LANK", "S:LFHD")
    assert read.fps == pytest.approx(120, rel=0.01)
    assert read.present.tolist() == [[True, True], [False, True], [True, False]]
    np.testing.assert_allclose(read.positions[0], [[0.1, 0.2, 0.09], [0.1, 0.2, 1.7]])
    assert any("the unit is missing: took mm" in guess for guess in read.guesses)


def test_text_and_zip_are_the_same(tmp_path: Path) -> None:
    plain = read_accad(written(tmp_path, PLAIN))
    packed = read_accad(zipped(tmp_path, {"walk.TXT": PLAIN, "__MACOSX/._walk.txt": "x", "notes.doc": "y"}))
    np.testing.assert_array_equal(packed.positions, plain.positions)
    assert packed.names == plain.names


@pytest.mark.parametrize(
    ("name", "frames", "missing"), [("quickwalkTXT", 307, 0.0144), ("run1TXT", 217, 0.0167), ("sprintTXT", 265, 0.0033)]
)
def test_real_recordings(data: Path, tmp_path: Path, name: str, frames: int, missing: float) -> None:
    read = read_accad(data / "mocap" / "accad_txt" / f"{name}.ZIP")
    assert read.positions.shape == (frames, 41, 3)
    assert read.fps == 120.0
    assert (~read.present).mean() == pytest.approx(missing, abs=1e-4)
    assert read.up.tolist() == [0, 0, 1]
    lowest, highest = np.nanmin(read.positions, axis=(0, 1)), np.nanmax(read.positions, axis=(0, 1))
    assert -0.1 < lowest[2] < 0.15
    assert 1.5 < highest[2] < 1.9
    for ending, write, back in ((".csv", write_table, read_table), (".trc", write_trc, read_trc)):
        write(tmp_path / f"a{ending}", read)
        again = back(tmp_path / f"a{ending}")
        assert (again.names, again.fps) == (read.names, read.fps)
        np.testing.assert_array_equal(again.present, read.present)
        np.testing.assert_allclose(again.positions, read.positions, atol=1e-8)
    write_c3d(tmp_path / "a.c3d", read)
    again = read_c3d(tmp_path / "a.c3d")
    assert (again.names, again.fps) == (read.names, read.fps)
    np.testing.assert_array_equal(again.present, read.present)
    np.testing.assert_allclose(again.positions, read.positions, atol=2e-7)


BAD = {
    "empty": ("", "empty"),
    "other text": ("some notes\n", "wanted ACCAD marker text with titles Field, Time"),
    "titles only": (TITLES, "ends before"),
    "an axis lacks": (PLAIN.replace("\tS:LFHD:Z", ""), "starts otherwise"),
    "axes mixed up": (PLAIN.replace("LANK:Y", "LANK:Q"), "columns 3 to 5"),
    "a marker twice": (PLAIN.replace("LFHD", "LANK"), "a name of its own"),
    "cut in a row": (PLAIN[:-12], "wanted 8 cells in line 4"),
    "a word": (PLAIN.replace("101", "1o1"), "'1o1' in line 3"),
    "one row": (f"{TITLES}\n" + ROWS.split("\n")[0], "--fps"),
    "uneven": (PLAIN.replace("0.0083", "0.0130"), "resample"),
    "binary": ("Field\tTime\0", "binary"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_texts_are_one_clear_line(tmp_path: Path, kind: str) -> None:
    text, why = BAD[kind]
    with pytest.raises(FileError, match=why) as caught:
        read_accad(written(tmp_path, text))
    assert "\n" not in str(caught.value)
    assert "a.txt" in str(caught.value)


def test_bad_zips_are_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"one \.txt in it, came 2"):
        read_accad(zipped(tmp_path, {"a.txt": PLAIN, "b.txt": PLAIN}))
    with pytest.raises(FileError, match="came 0"):
        read_accad(zipped(tmp_path, {"a.bin": PLAIN}))
    path = zipped(tmp_path, {"a.txt": PLAIN * 20})
    whole = path.read_bytes()
    for size in range(0, len(whole), 7):
        path.write_bytes(whole[:size])
        with pytest.raises(FileError, match="cannot unpack"):
            read_accad(path)
    refused = 0
    for at in range(0, len(whole), 3):
        damaged = bytearray(whole)
        damaged[at] ^= 0xFF
        path.write_bytes(damaged)
        try:
            read_accad(path)
        except FileError:
            refused += 1
    assert refused > 10
    path.write_text("no zip at all")
    with pytest.raises(FileError, match="cannot unpack"):
        read_accad(path)
