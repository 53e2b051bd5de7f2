"""TRC files: read leniently, written as OpenSim wants them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers
from motionmend.errors import FileError
from motionmend.io.c3d import read_c3d
from motionmend.io.trc import read_trc, write_trc

KEYS = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
VALUES = "100\t200\t3\t2\tmm\t100\t7\t3"
TITLES = "Frame#\tTime\tLHEE\t\t\tLFHD\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
HEAD = f"PathFileType\t4\t(X/Y/Z)\twalk.trc\n{KEYS}\n{VALUES}\n{TITLES}"
ROWS = "7\t0.06\t1\t2\t3\t400\t500\t1700\n8\t0.07\t\t\t\t401\t500\t1700\n9\t0.08\t3\t2\t3\t402\t500\t1700\n"


def written(folder: Path, text: str, name: str = "a.trc") -> Path:
    path = folder / name
    path.write_text(text, newline="")
    return path


def test_reads_positions_in_metres_and_what_is_missing(tmp_path: Path) -> None:
    read = read_trc(written(tmp_path, HEAD + ROWS))
    assert read.names == ("LHEE", "LFHD")
    assert read.fps == 100.0
    assert read.present.tolist() == [[True, True], [False, True], [True, True]]
    np.testing.assert_allclose(read.positions[2], [[0.003, 0.002, 0.003], [0.402, 0.5, 1.7]])
    assert read.up.tolist() == [0, 0, 1]


LENIENT = {
    "windows line ends": (HEAD + ROWS).replace("\n", "\r\n"),
    "an empty line before the rows": HEAD + "\n" + ROWS,
    "a line of tabs before the rows": HEAD + "\t\t\t\n" + ROWS,
    "numbering from 5": (HEAD + ROWS).replace("X1\tY1\tZ1\tX2\tY2\tZ2", "X5\tY5\tZ5\tX6\tY6\tZ6"),
    "no coordinate line": (HEAD + ROWS).replace("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n", ""),
    "seven keys": (HEAD + ROWS).replace("\tOrigNumFrames", "").replace("7\t3\nFrame", "7\nFrame"),
    "the word NaN": (HEAD + ROWS).replace("\t\t\t\t401", "\tNaN\tnan\tNaN\t401"),
    "one coordinate blank": (HEAD + ROWS).replace("\t\t\t\t401", "\t1\t\t3\t401"),
    "zeros": (HEAD + ROWS).replace("\t\t\t\t401", "\t0\t0.0\t0.000\t401"),
    "blanks of spaces": (HEAD + ROWS).replace("\t\t\t\t401", "\t  \t \t \t401"),
    "a tab behind every row": (HEAD + ROWS).replace("1700\n", "1700\t\n"),
    "no line end at the end": (HEAD + ROWS)[:-1],
    "empty lines at the end": HEAD + ROWS + "\n\n",
    "names without gaps between": (HEAD + ROWS).replace("LHEE\t\t\tLFHD\t\t", "LHEE\tLFHD"),
    "padded header": (HEAD + ROWS).replace("DataRate\tCam", "DataRate\t\tCam").replace("100\t200", "100\t\t200"),
    "a byte order mark": "\ufeff" + HEAD + ROWS,
}


@pytest.mark.parametrize("variant", LENIENT)
def test_reads_what_other_programs_write(tmp_path: Path, variant: str) -> None:
    wanted = read_trc(written(tmp_path, HEAD + ROWS, "plain.trc"))
    read = read_trc(written(tmp_path, LENIENT[variant]))
    assert read.names == wanted.names
    assert read.fps == wanted.fps
    np.testing.assert_array_equal(read.positions, wanted.positions)
    assert any("(0, 0, 0)" in guess for guess in read.guesses) == (variant == "zeros")


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("meters", 1.0)])
def test_units(tmp_path: Path, unit: str, metres: float) -> None:
    read = read_trc(written(tmp_path, (HEAD + ROWS).replace("\tmm\t", f"\t{unit}\t")))
    np.testing.assert_allclose(read.positions[0, 1], np.array([400, 500, 1700]) * metres)


def test_unknown_unit_is_said(tmp_path: Path) -> None:
    read = read_trc(written(tmp_path, (HEAD + ROWS).replace("\tmm\t", "\tells\t")))
    assert any("Units is 'ells': took mm" in guess for guess in read.guesses)


def test_rate_from_the_times_when_the_header_has_none(tmp_path: Path) -> None:
    read = read_trc(written(tmp_path, (HEAD + ROWS).replace("\n100\t", "\n0\t")))
    assert read.fps == 100.0
    assert any("100 Hz from the times" in guess for guess in read.guesses)


def test_times_count_where_the_header_says_another_rate(tmp_path: Path) -> None:
    """Who keeps every tenth frame seldom writes the new rate into the header; OpenSim goes by the times."""
    read = read_trc(written(tmp_path, (HEAD + ROWS).replace("\n100\t", "\n25\t")))
    assert read.fps == 100.0
    assert any("DataRate says 25 Hz, the times span 0.02 s: took 100 Hz" in guess for guess in read.guesses)
    write_trc(tmp_path / "b.trc", read)
    again = read_trc(tmp_path / "b.trc")
    assert again.fps == 100.0
    assert not any("DataRate" in guess for guess in again.guesses)


@pytest.mark.parametrize("times", [("0", "0", "0"), ("0", "0.05", "0.06"), ("", "0.05", "0.1")])
def test_the_header_counts_where_times_are_no_rate(tmp_path: Path, times: tuple[str, ...]) -> None:
    rows = ROWS.replace("0.06", times[0]).replace("0.07", times[1]).replace("0.08", times[2])
    assert read_trc(written(tmp_path, HEAD.replace("\n100\t", "\n250\t") + rows)).fps == 250.0


def test_a_part_cut_out_of_a_longer_recording_is_read_and_said(tmp_path: Path) -> None:
    """Its frames begin later than the header has it, which a file that is cut off at its end does not explain."""
    read = read_trc(
        written(
            tmp_path, (HEAD + ROWS).replace("mm\t100\t7\t3", "mm\t100\t1\t900").replace("\t3\t2\tmm", "\t900\t2\tmm")
        )
    )
    assert read.frames == 3
    assert any("the header says 900 frames from 1 on, the rows are 7 to 9" in guess for guess in read.guesses)
    write_trc(tmp_path / "b.trc", read)
    assert read_trc(tmp_path / "b.trc").frames == 3


def test_first_frame_unit_and_original_rate_come_back(tmp_path: Path) -> None:
    read = read_trc(written(tmp_path, (HEAD + ROWS).replace("\tmm\t100", "\tcm\t400")))
    write_trc(tmp_path / "b.trc", read)
    lines = (tmp_path / "b.trc").read_text().split("\n")
    assert lines[0] == "PathFileType\t4\t(X/Y/Z)\tb.trc"
    assert lines[1].split("\t") == KEYS.split("\t")
    assert lines[2].split("\t") == ["100", "200", "3", "2", "cm", "400", "7", "3"]
    assert [line.split("\t")[:2] for line in lines[6:9]] == [["7", "0.06"], ["8", "0.07"], ["9", "0.08"]]
    write_trc(tmp_path / "c.trc", read_trc(tmp_path / "b.trc"))
    assert (tmp_path / "c.trc").read_text().replace("c.trc", "b.trc") == (tmp_path / "b.trc").read_text()


def test_written_as_opensim_reads_it(tmp_path: Path, rng) -> None:
    """OpenSim splits at tabs and drops one empty cell at the end of a line; every row must then have 2 + 3M cells."""
    positions = rng.normal(size=(4, 3, 3))
    positions[1, 2] = positions[2, 0] = np.nan
    write_trc(tmp_path / "a.trc", Markers(("A", "B b", "C"), positions, 119.88))
    lines = (tmp_path / "a.trc").read_text().split("\n")
    assert lines[1].split("\t") == KEYS.split("\t")
    assert lines[2].split("\t") == ["119.88", "119.88", "4", "3", "mm", "119.88", "1", "4"]
    assert [cell for cell in lines[3].split("\t") if cell] == ["Frame#", "Time", "A", "B b", "C"]
    assert [cell for cell in lines[4].split("\t") if cell] == [f"{axis}{k}" for k in (1, 2, 3) for axis in "XYZ"]
    assert lines[5] == ""
    for k, line in enumerate(lines[6:10]):
        cells = line.split("\t")
        assert cells.pop() == ""
        assert len(cells) == 11
        assert cells[0] == str(k + 1)
        values = np.array([float(cell) if cell else np.nan for cell in cells[2:]]).reshape(3, 3)
        np.testing.assert_allclose(values, positions[k] * 1000, rtol=1e-8)
    assert lines[10:] == [""]


@settings(max_examples=40)
@given(st.data(), st.integers(1, 5), st.integers(1, 4), st.sampled_from([119.88, 100.0, 29.97, 1000.0, 50.0]))
def test_round_trip(tmp_path_factory, draw, frames: int, count: int, fps: float) -> None:
    numbers = st.floats(-50, 50, allow_nan=False)
    positions = np.array(draw.draw(st.lists(numbers, min_size=frames * count * 3, max_size=frames * count * 3)))
    positions = positions.reshape(frames, count, 3)
    positions[np.array(draw.draw(st.lists(st.booleans(), min_size=frames, max_size=frames)))] = np.nan
    made = Markers(tuple(f"m {k}" for k in range(count)), positions, fps)
    path = tmp_path_factory.mktemp("trc") / "a.trc"
    write_trc(path, made)
    read = read_trc(path)
    assert read.names == made.names
    assert read.fps == fps
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, rtol=1e-8, atol=2e-9)


@pytest.mark.parametrize("name", ["cmu_02_01", "sfu_0018_Moonwalk001"])
def test_real_recordings_survive(data: Path, tmp_path: Path, name: str) -> None:
    made = read_c3d(data / "mocap" / "c3d" / f"{name}.c3d")
    write_trc(tmp_path / "a.trc", made)
    read = read_trc(tmp_path / "a.trc")
    assert (read.names, read.fps, read.frames) == (made.names, made.fps, made.frames)
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, atol=1e-8)
    np.testing.assert_array_equal(read.up, made.up)


BAD = {
    "empty": ("", "empty"),
    "blank": ("\n \n", "empty"),
    "other text": ("HIERARCHY\nROOT Hips\n", "Frame#"),
    "binary": ("Frame#\0\x01", "binary"),
    "header only": (HEAD, "ends before"),
    "fewer rows than promised": (HEAD + ROWS[: ROWS.index("9\t")], "promises 3 frames, the file holds 2"),
    "cut in a row": (HEAD + ROWS[:-12], "wanted 8 cells in line 8, came 6"),
    "a word": (HEAD + ROWS.replace("402", "4o2"), "'4o2' in line 8 is no number"),
    "infinite": (HEAD + ROWS.replace("402", "inf"), "line 8 is infinite"),
    "too many cells": (HEAD + ROWS.replace("\t1700\n8", "\t1700\t5\n8"), "wanted 8 cells in line 6, came 9"),
    "spaces for tabs": (HEAD + ROWS.replace("\t", " "), "ends before"),
    "no names": ((HEAD + ROWS).replace("LHEE\t\t\tLFHD", "\t\t\t"), "wanted marker names"),
    "a name twice": ((HEAD + ROWS).replace("LFHD", "LHEE"), "two columns"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_one_clear_line(tmp_path: Path, kind: str) -> None:
    text, why = BAD[kind]
    with pytest.raises(FileError, match=why) as caught:
        read_trc(written(tmp_path, text))
    assert "\n" not in str(caught.value)
    assert "a.trc" in str(caught.value)


def test_every_cut_is_noticed_or_said(tmp_path: Path) -> None:
    whole = HEAD + ROWS
    last_cell = len(whole) - len("1700\n")
    for size in range(last_cell):
        with pytest.raises(FileError):
            read_trc(written(tmp_path, whole[:size]))
    for size in range(last_cell, len(whole)):
        assert any("no line break" in said for said in read_trc(written(tmp_path, whole[:size])).warnings)
    assert not any("no line break" in said for said in read_trc(written(tmp_path, whole)).warnings)


@pytest.mark.slow
@settings(max_examples=150)
@given(st.data())
def test_damage_gives_a_value_or_one_line(tmp_path_factory, data) -> None:
    damaged = bytearray((HEAD + ROWS).encode())
    for _ in range(data.draw(st.integers(1, 3))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.trc"
    path.write_bytes(damaged)
    message = ""
    try:
        assert read_trc(path).fps > 0
    except FileError as failure:
        message = str(failure)
    assert "\n" not in message


def test_names_a_trc_file_cannot_hold(tmp_path: Path, rng) -> None:
    made = Markers(("a", "b\tc"), rng.normal(size=(2, 2, 3)), 10.0)
    with pytest.raises(FileError, match="cannot hold the marker name"):
        write_trc(tmp_path / "a.trc", made)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileError, match="needs markers and frames"):
        write_trc(tmp_path / "a.trc", replace(made, names=(), positions=np.empty((2, 0, 3))))


def test_positions_beyond_all_measure_are_missing_and_said(tmp_path: Path, rng) -> None:
    path = tmp_path / "far.trc"
    write_trc(path, Markers(("A", "B"), rng.normal(size=(6, 2, 3)), 100.0))
    lines = path.read_text().splitlines()
    cells = lines[8].split("\t")
    cells[5] = "-1e12"
    path.write_text("\n".join([*lines[:8], "\t".join(cells), *lines[9:], ""]))
    read = read_trc(path)
    assert np.argwhere(~read.present).tolist() == [[2, 1]]
    assert any("1 positions beyond 1e+09 were taken as missing" in guess for guess in read.guesses)
