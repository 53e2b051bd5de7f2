"""Our own table of markers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_files import standing

from motionmend.bodies.joint_sets import KINECT25
from motionmend.bodies.motion import Markers
from motionmend.errors import FileError
from motionmend.io import looks_meant, read
from motionmend.io.c3d import read_c3d
from motionmend.io.sensor import read_postures
from motionmend.io.table import read_table, write_table

PLAIN = (
    "time,LHEE_x,LHEE_y,LHEE_z,LFHD_x,LFHD_y,LFHD_z\n0,0.1,0.2,0.3,0,0,1.7\n0.02,,,,0,0,1.7\n0.04,0.1,0.2,0.3,0,0,1.7\n"
)


def written(folder: Path, text: str) -> Path:
    path = folder / "a.csv"
    path.write_text(text, newline="")
    return path


def test_reads_metres_seconds_and_blanks(tmp_path: Path) -> None:
    read = read_table(written(tmp_path, PLAIN))
    assert read.names == ("LHEE", "LFHD")
    assert read.fps == 50.0
    assert read.present.tolist() == [[True, True], [False, True], [True, True]]
    assert read.positions[0, 0].tolist() == [0.1, 0.2, 0.3]


def test_written_as_read(tmp_path: Path) -> None:
    write_table(tmp_path / "b.csv", read_table(written(tmp_path, PLAIN)))
    assert (tmp_path / "b.csv").read_text() == PLAIN


def test_nine_significant_digits_and_the_first_time(tmp_path: Path) -> None:
    text = (
        PLAIN.replace("0.1,", "0.123456789,")
        .replace("\n0,", "\n5,")
        .replace("0.02,", "5.02,")
        .replace("0.04,", "5.04,")
    )
    write_table(tmp_path / "b.csv", read_table(written(tmp_path, text)))
    assert (tmp_path / "b.csv").read_text() == text


@pytest.mark.parametrize("fps", [120.0, 119.88, 29.97, 30.0, 100.0, 1000.0, 60 / 1.001, 1 / 3])
@pytest.mark.parametrize("frames", [2, 3, 1000])
def test_rate_survives_the_rounding_of_times(tmp_path: Path, fps: float, frames: int) -> None:
    write_table(tmp_path / "a.csv", Markers(("m",), np.ones((frames, 1, 3)), fps))
    read = read_table(tmp_path / "a.csv")
    assert read.fps == pytest.approx(fps, rel=1e-7)
    assert not any("stray" in guess for guess in read.guesses)


@settings(max_examples=40)
@given(st.data(), st.integers(2, 5), st.integers(1, 4))
def test_round_trip(tmp_path_factory, draw, frames: int, count: int) -> None:
    numbers = st.floats(-1e6, 1e6, allow_nan=False)
    names = draw.draw(st.lists(st.text("ab_:, \"'é.-", min_size=1, max_size=5), min_size=count, max_size=count))
    names = [f"m{k}{name}e" for k, name in enumerate(names)]
    positions = np.array(draw.draw(st.lists(numbers, min_size=frames * count * 3, max_size=frames * count * 3)))
    positions = positions.reshape(frames, count, 3)
    positions[np.array(draw.draw(st.lists(st.booleans(), min_size=frames, max_size=frames)))] = np.nan
    made = Markers(tuple(names), positions, 120.0)
    path = tmp_path_factory.mktemp("table") / "a.csv"
    write_table(path, made)
    read = read_table(path)
    assert read.names == made.names
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, rtol=1e-8)


def test_a_real_recording_survives(data: Path, tmp_path: Path) -> None:
    made = read_c3d(data / "mocap" / "c3d" / "gt_squat.c3d")
    write_table(tmp_path / "a.csv", made)
    read = read_table(tmp_path / "a.csv")
    assert (read.names, read.fps, read.frames) == (made.names, made.fps, made.frames)
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, atol=1e-8)


def test_columns_beside_the_positions_come_through(tmp_path: Path) -> None:
    text = "time,head_x,head_y,head_z,head_std,head_reliability,head_state\n0,1,2,3,0.01,1,2\n0.1,1,2,3,0.01,1,1\n"
    read = read_table(written(tmp_path, text))
    assert read.names == ("head",)
    assert not any("beside" in guess for guess in read.guesses)
    write_table(tmp_path / "again.csv", read)
    assert (tmp_path / "again.csv").read_text() == text
    gone = replace(read, positions=np.array([read.positions[0], [[np.nan] * 3]]))
    write_table(tmp_path / "gap.csv", gone)
    assert (tmp_path / "gap.csv").read_text().splitlines()[-1] == "0.1,,,,,1,1"
    write_table(tmp_path / "half.csv", replace(read, positions=read.positions[:1]))
    assert "std" not in (tmp_path / "half.csv").read_text()


def test_columns_that_make_no_sense_beside_the_positions_are_said(tmp_path: Path) -> None:
    text = "time,head_x,head_y,head_z,head_state\n0,1,2,3,7\n0.1,1,2,3,2\n"
    assert any(
        "1 column beside" in guess and "_state" in guess for guess in read_table(written(tmp_path, text)).guesses
    )


def test_uneven_times(tmp_path: Path) -> None:
    wobbly = read_table(written(tmp_path, PLAIN.replace("0.02,", "0.0215,")))
    assert wobbly.fps == 50.0
    assert any("stray by up to 0.07 of a frame" in guess for guess in wobbly.guesses)
    with pytest.raises(FileError, match=r"row 2 is 0\.50 frames off; resample"):
        read_table(written(tmp_path, PLAIN.replace("0.02,", "0.03,")))


def test_one_row_needs_a_rate(tmp_path: Path) -> None:
    path = written(tmp_path, "time,a_x,a_y,a_z\n0,1,2,3\n")
    with pytest.raises(FileError, match="--fps"):
        read_table(path)
    read = read_table(path, 25.0)
    assert read.fps == 25.0
    assert any("25 Hz as given" in guess for guess in read.guesses)


BAD = {
    "empty": ("", "empty"),
    "other text": ("HIERARCHY\nROOT Hips\n", "the first title is 'HIERARCHY'"),
    "another table": ("time,a,b\n0,1,2\n", "column 2 is 'a'"),
    "a coordinate lacks": ("time,a_x,a_y\n0,1,2\n", "a lacks some"),
    "no markers": ("time\n0\n", "there is no marker"),
    "a title twice": ("time,a_x,a_x,a_y,a_z\n0,1,2,3,4\n", "two columns"),
    "no rows": (PLAIN.split("\n")[0], "ends before"),
    "a row too short": (PLAIN[:-6], "wanted 7 cells in line 4, came 6"),
    "a row too long": (PLAIN.replace("1.7\n", "1.7,9\n", 1), "came 8"),
    "a word": (PLAIN.replace("0.3,0", "x,0", 1), "'x' in line 2 is no number"),
    "a number as only Python spells it": (PLAIN.replace("0.3,0", "1_0,0", 1), "'1_0' in line 2 is no number"),
    "beyond all measure": (PLAIN.replace("0.3,0", "-1e200,0", 1), "absurdly large"),
    "first line is blank": ("\n" + PLAIN, "the first title is ''"),
    "infinite": (PLAIN.replace("0.3,0", "inf,0", 1), "infinite"),
    "a time lacks": (PLAIN.replace("\n0.02,", "\n,"), "time of row 2 is missing"),
    "times that stand still": (PLAIN.replace("0.02,", "0,").replace("0.04,", "0,"), "that rise"),
    "binary": ("time,a_x\0", "binary"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_tables_are_one_clear_line(tmp_path: Path, kind: str) -> None:
    text, why = BAD[kind]
    with pytest.raises(FileError, match=why) as caught:
        read_table(written(tmp_path, text))
    assert "\n" not in str(caught.value)
    assert "a.csv" in str(caught.value)


@settings(max_examples=150)
@given(st.data())
def test_damage_gives_a_value_or_one_line(tmp_path_factory, data) -> None:
    damaged = bytearray(PLAIN.encode())
    for _ in range(data.draw(st.integers(1, 3))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.csv"
    path.write_bytes(damaged)
    message = ""
    try:
        assert read_table(path).fps > 0
    except FileError as failure:
        message = str(failure)
    assert "\n" not in message


def test_nothing_to_write(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="needs markers and frames"):
        write_table(tmp_path / "a.csv", Markers((), np.empty((3, 0, 3)), 10.0))


@pytest.mark.parametrize("blank", ["", "\n"])
@pytest.mark.parametrize("ending", ["", ","])
def test_a_sensors_table_without_titles_is_read_as_correct_reads_it(tmp_path: Path, blank: str, ending: str) -> None:
    joints = standing(KINECT25, 12)
    rows = np.concatenate([joints, np.full((12, 25, 1), 2.0)], axis=2).reshape(12, 100)
    text = blank + "".join(",".join(f"{value:.6f}" for value in row) + ending + "\n" for row in rows)
    path = written(tmp_path, text)
    found, sensed = read_table(path, None), read_postures(path)
    assert found.names == sensed.names == KINECT25.names
    np.testing.assert_array_equal(found.positions, sensed.positions)
    assert any("no titles" in guess and "Kinect v2" in guess for guess in found.guesses)
    assert looks_meant(path)
    write_table(tmp_path / "again.csv", found)
    again = read_postures(tmp_path / "again.csv")
    assert again.names == KINECT25.names
    assert again.state is not None
    assert (again.state == 2).all()
    assert not looks_meant(written(tmp_path, "1,2,3\n4,5,6\n"))  # numbers, but nobody's joints


def test_a_sensors_text_says_what_to_do(tmp_path: Path) -> None:
    rows = np.concatenate([standing(KINECT25, 5), np.full((5, 25, 1), 2.0)], axis=2).reshape(5, 100)
    path = tmp_path / "take.txt"
    np.savetxt(path, rows, fmt="%.6f", delimiter=" ")
    with pytest.raises(FileError, match="motionmend correct"):
        read(path)
