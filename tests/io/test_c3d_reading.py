"""C3D files read: every value, unit, event and computed point, as ezc3d and py-c3d see them too."""

import re
import struct
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from c3d_files import (
    FILES,
    PY_C3D_REFUSES,
    markers,
    py_c3d,
    real,
    some_markers,
    written_by_ezc3d,
)

from motionmend.bodies.motion import Origin, Repaired
from motionmend.errors import FileError
from motionmend.io.c3d import read_c3d, write_c3d
from motionmend.io.c3d_layout import frames_of, parse
from motionmend.io.conversion import first_frame


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_reads_what_ezc3d_reads(data: Path, name: str) -> None:
    path = real(data, name)
    raw = path.read_bytes()
    layout = parse(raw, name)
    frames, _ = frames_of(raw, layout, name)
    ours = layout.coordinates(layout.rows(raw, frames)).astype(float)
    theirs = ezc3d.c3d(str(path))["data"]["points"][:3].T
    missing = layout.fourth_words(layout.rows(raw, frames)) < 0
    ours[missing] = np.nan
    np.testing.assert_allclose(ours, theirs, rtol=1e-6)
    read = read_c3d(path)
    chosen = list(read.source.markers)
    np.testing.assert_allclose(read.positions, theirs[:, chosen] * 0.001, rtol=1e-6)
    assert read.fps == ezc3d.c3d(str(path))["parameters"]["POINT"]["RATE"]["value"][0]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(FILES) - set(PY_C3D_REFUSES)))
def test_residuals_are_those_of_the_standard(data: Path, name: str) -> None:
    read = read_c3d(real(data, name))
    theirs = py_c3d(real(data, name))[:, list(read.source.markers), 3]
    known = theirs >= 0
    np.testing.assert_array_equal(read.residuals >= 0, read.present)
    np.testing.assert_allclose(read.residuals[known & read.present], theirs[known & read.present] * 0.001, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "markers", "up", "said"),
    [
        ("cmu_02_01", 41, "z", ""),
        ("cmu_05_13", 41, "z", "289 of 330 points set aside as computed"),
        ("hdm05_bd_01-02_01_120", 41, "z", "3 of 44 points set aside as without a label (*0, *1, *2)"),
        ("sfu_0018_Moonwalk001", 53, "y", "up is taken as +y"),
        ("gt_squat", 53, "y", "up is taken as +y"),
        ("emory_SoccerHeader", 39, "y", ""),
    ],
)
def test_markers_of_real_files(data: Path, name: str, markers: int, up: str, said: str) -> None:
    read = read_c3d(real(data, name))
    assert len(read.names) == markers
    assert read.up["xyz".index(up)] == 1.0
    assert any(said in guess for guess in read.guesses) or not said
    assert 1.0 < np.nanmax(read.positions[0] @ read.up) < 2.5, "metres, and the head is up"


@pytest.mark.parametrize("name", ["cmu_02_01", "cmu_05_13"])
def test_whole_steps_are_said(data: Path, name: str) -> None:
    """What was an integer comes back as a real number: a file that looks otherwise than it did is said to."""
    said = [guess for guess in read_c3d(real(data, name)).guesses if "whole steps of" in guess]
    assert said == (
        ["the file holds whole steps of 0.0957 mm: what is written of it are real numbers"] * (name == "cmu_05_13")
    )


def test_real_gaps_are_missing(data: Path) -> None:
    read = read_c3d(real(data, "sfu_0018_Moonwalk001"))
    assert (~read.present).mean() == pytest.approx(0.0301, abs=1e-4)


def test_points_are_where_the_header_says_when_the_parameters_do_not(data: Path, tmp_path: Path) -> None:
    path = real(data, "c3dorg_golfswing")
    read = read_c3d(path)
    assert "POINT:DATA_START is 0: took the points from where the header says" in read.guesses
    assert read.positions.shape == (514, 29, 3)
    assert read.present.all()
    assert np.abs(np.diff(read.positions, axis=0)).max() < 0.2, "m: markers move, they do not jump"
    write_c3d(tmp_path / "again.c3d", read)
    np.testing.assert_array_equal(read_c3d(tmp_path / "again.c3d").positions, read.positions)


def test_contradicting_file_is_one_clear_line(data: Path, tmp_path: Path) -> None:
    raw = bytearray(real(data, "c3dorg_golfswing").read_bytes())
    at = raw.index(b"DATA_START") + len(b"DATA_START") + 4
    raw[at] = 9
    (tmp_path / "other.c3d").write_bytes(raw)
    with pytest.raises(FileError, match=r"other.*agrees with itself, POINT:DATA_START is 9 and the header says 7"):
        read_c3d(tmp_path / "other.c3d")


@pytest.mark.parametrize(
    ("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("Millimeters", 0.001), ("ft", 0.3048), ("dm", 0.1)]
)
def test_units_are_converted_there_and_back(tmp_path: Path, rng, unit: str, metres: float) -> None:
    points = (rng.normal(size=(4, 3, 3)) + 3) / metres
    path = written_by_ezc3d(tmp_path / "a.c3d", points, ["a", "b", "c"], unit)
    read = read_c3d(path)
    np.testing.assert_allclose(read.positions, points * metres, rtol=1e-6)
    assert not any("UNITS" in guess for guess in read.guesses)
    write_c3d(tmp_path / "b.c3d", read.with_positions(read.positions * 2))
    np.testing.assert_allclose(ezc3d.c3d(str(tmp_path / "b.c3d"))["data"]["points"][:3].T, points * 2, rtol=1e-6)


@pytest.mark.parametrize("stored", ["cmu_05_13", "cmu_02_01"])  # integers and floats
def test_a_scale_that_only_the_header_states_is_taken_and_said(data: Path, tmp_path: Path, stored: str) -> None:
    raw = real(data, stored).read_bytes()
    at = re.search(rb"[\x05\xfb].SCALE", raw, re.DOTALL).start()
    group = struct.unpack_from("b", raw, re.search(rb"[\x05\xfb].POINT", raw, re.DOTALL).start() + 1)[0]
    assert raw[at + 1] == -group  # that of the points
    (tmp_path / "a.c3d").write_bytes(raw[: at + 2] + b"OTHER" + raw[at + 7 :])
    read, known = read_c3d(tmp_path / "a.c3d"), read_c3d(real(data, stored))
    np.testing.assert_array_equal(read.positions, known.positions)
    assert any("POINT:SCALE is missing" in guess for guess in read.guesses)
    write_c3d(tmp_path / "b.c3d", read.with_positions(read.positions * 1.5))
    np.testing.assert_allclose(read_c3d(tmp_path / "b.c3d").positions, known.positions * 1.5, rtol=1e-6)


@pytest.mark.parametrize("metres", [0.001, 0.01, 1.0])
def test_unknown_unit_is_guessed_and_said(tmp_path: Path, rng, metres: float) -> None:
    body = rng.random((6, 8, 3)) * [0.5, 0.4, 1.7]
    read = read_c3d(written_by_ezc3d(tmp_path / "a.c3d", body / metres, [f"m{k}" for k in range(8)], "furlong"))
    np.testing.assert_allclose(read.positions, body, rtol=1e-5)
    assert any("'furlong'" in guess for guess in read.guesses)


@pytest.mark.parametrize(("stated", "metres"), [("mm", 1.0), ("m", 0.001)])
def test_a_unit_that_makes_no_person_is_kept_and_said(tmp_path: Path, rng, stated: str, metres: float) -> None:
    points = rng.random((6, 8, 3)) * [0.5, 0.4, 1.7] / metres
    read = read_c3d(written_by_ezc3d(tmp_path / "a.c3d", points, [f"m{k}" for k in range(8)], stated))
    np.testing.assert_allclose(read.positions, points * (0.001 if stated == "mm" else 1.0), rtol=1e-5)
    assert any(f"is {stated}" in guess and "no person's size" in guess for guess in read.guesses)


def test_more_than_255_points_keep_their_names(tmp_path: Path, rng) -> None:
    labels = [f"p{k}" for k in range(300)]
    points = rng.normal(size=(3, 300, 3)) * 100
    read = read_c3d(written_by_ezc3d(tmp_path / "a.c3d", points, labels))
    assert list(read.names) == labels
    np.testing.assert_allclose(read.positions, points * 0.001, rtol=1e-5)


def test_what_is_no_marker_is_set_aside_and_kept(tmp_path: Path, rng) -> None:
    labels = [
        "S:LANK",
        "S:LHipAngles",
        "*7",
        "S:RANK",
        "PELO",
        "PELA",
        "PELL",
        "PELP",
        "uname*3",
        "odd",
        "",
        "LHJC",
        "RPOP",
    ]
    points = rng.normal(size=(5, len(labels), 3)) * 100
    path = written_by_ezc3d(tmp_path / "a.c3d", points, labels, ANGLES=["S:LHipAngles"], SCALARS=["odd"])
    read = read_c3d(path)
    assert read.names == ("S:LANK", "S:RANK", "RPOP")
    assert any("7 of 13 points set aside as computed" in guess for guess in read.guesses)
    assert any("3 of 13 points set aside as without a label" in guess for guess in read.guesses)
    write_c3d(tmp_path / "b.c3d", read.with_positions(read.positions + 0.1))
    after = ezc3d.c3d(str(tmp_path / "b.c3d"))["data"]["points"][:3].T
    others = [k for k in range(len(labels)) if k not in read.source.markers]
    np.testing.assert_allclose(after[:, others], points[:, others], rtol=1e-6)
    np.testing.assert_allclose(
        after[:, list(read.source.markers)], points[:, list(read.source.markers)] + 100, rtol=1e-5
    )


def test_a_marker_between_seen_ones_is_a_marker_whatever_its_residuals(tmp_path: Path, rng) -> None:
    made = replace(some_markers(rng, count=4), residuals=np.tile([0.001, 0.0, 0.001, 0.0], (20, 1)))
    made = made.with_positions(np.nan_to_num(made.positions, nan=0.3))
    write_c3d(tmp_path / "a.c3d", made)
    assert read_c3d(tmp_path / "a.c3d").names == ("M0", "M1", "M2")


def test_same_label_twice_is_told_apart(tmp_path: Path, rng) -> None:
    read = read_c3d(written_by_ezc3d(tmp_path / "a.c3d", rng.normal(size=(3, 3, 3)), ["a", "a", "b"], "m"))
    assert read.names == ("a", "a#2", "b")
    assert any("more than once" in guess for guess in read.guesses)
    write_c3d(tmp_path / "b.c3d", read)
    assert (tmp_path / "b.c3d").read_bytes() == (tmp_path / "a.c3d").read_bytes()


@pytest.mark.parametrize("frames", [65_536, 70_000, 131_073])
def test_longer_than_the_header_counts_is_refused_where_nothing_says_how_long(tmp_path: Path, frames: int) -> None:
    points = np.ones((frames, 1, 3)) * np.arange(1, frames + 1)[:, None, None]
    path = written_by_ezc3d(tmp_path / "long.c3d", points, ["a"])
    with pytest.raises(FileError, match=rf"{frames} frames, the header 65535"):
        read_c3d(path)


@pytest.mark.slow
@pytest.mark.parametrize("frames", [65_536, 70_000, 131_073])
@pytest.mark.parametrize("header", ["as far as it counts", "run over"])
@pytest.mark.parametrize("lacking", ["", "ACTUAL_END_FIELD", "LONG_FRAMES"])
def test_longer_than_the_header_counts_is_whole_where_a_parameter_says_how_long(
    tmp_path: Path, frames: int, header: str, lacking: str
) -> None:
    positions = np.ones((frames, 1, 3)) * np.arange(1, frames + 1)[:, None, None]
    write_c3d(tmp_path / "a.c3d", markers(positions))
    raw = (tmp_path / "a.c3d").read_bytes()
    if header == "run over":
        raw = raw[:8] + struct.pack("<H", frames % 65_536) + raw[10:]
    (tmp_path / "a.c3d").write_bytes(raw.replace(lacking.encode(), b"X" * len(lacking)) if lacking else raw)
    read = read_c3d(tmp_path / "a.c3d")
    np.testing.assert_allclose(read.positions, positions, rtol=1e-6)
    origin = np.zeros((frames, 1), np.uint8)
    origin[40_000:40_010] = origin[frames - 9 :] = Origin.FILLED
    write_c3d(tmp_path / "b.c3d", read, Repaired(read, origin, origin * 0.0, origin * 0.0, "linear"))
    again = read_c3d(tmp_path / "b.c3d")
    np.testing.assert_array_equal(again.positions, read.positions)
    assert any("19 samples were filled" in guess for guess in again.guesses)
    parameter = parse((tmp_path / "b.c3d").read_bytes(), "b").find("MOTIONMEND", "FILLED")
    assert parameter is not None
    assert np.frombuffer(parameter.values, "<f4").tolist() == [1, 40_001, 40_010, 1, frames - 8, frames]


@pytest.mark.parametrize("first", [65_530, 70_001, 131_060])
@pytest.mark.parametrize("header", ["as far as it counts", "run over"])
def test_a_piece_of_a_long_trial_is_whole(tmp_path: Path, rng, first: int, header: str) -> None:
    path, recording = tmp_path / "a.c3d", some_markers(rng)
    write_c3d(path, recording)
    raw, numbers = bytearray(path.read_bytes()), (first, first + recording.frames - 1)
    for name, number in zip((b"ACTUAL_START_FIELD", b"ACTUAL_END_FIELD"), numbers, strict=True):
        at = raw.index(name) + len(name) + 5  # behind the way to the next, type and dimension
        raw[at : at + 4] = struct.pack("<HH", number % 65_536, number // 65_536)
    shown = [number % 65_536 if header == "run over" else min(number, 65_535) for number in numbers]
    raw[6:10] = struct.pack("<HH", *shown)
    path.write_bytes(raw)
    read = read_c3d(path)
    assert (read.frames, first_frame(read)) == (recording.frames, first)
    assert not any("frame" in guess for guess in read.guesses)
    np.testing.assert_allclose(read.positions, recording.positions, rtol=1e-6)
    write_c3d(tmp_path / "b.c3d", read)
    assert (tmp_path / "b.c3d").read_bytes() == bytes(raw)


@pytest.mark.slow
def test_a_second_reader_sees_all_of_a_long_file(tmp_path: Path) -> None:
    positions = np.ones((70_000, 1, 3)) * np.arange(1, 70_001)[:, None, None]
    write_c3d(tmp_path / "a.c3d", markers(positions))
    theirs = py_c3d(tmp_path / "a.c3d")[:, :, :3]
    assert len(theirs) == 70_000
    np.testing.assert_allclose(theirs / 1000, positions, rtol=1e-6)
    trial = ezc3d.c3d(str(tmp_path / "a.c3d"))["parameters"]["TRIAL"]["ACTUAL_END_FIELD"]["value"]
    assert (np.asarray(trial).ravel() % 65_536).tolist() == [70_000 - 65_536, 1]


def test_what_a_parameter_promises_beyond_the_header_has_to_be_there(tmp_path: Path) -> None:
    positions = np.ones((70_000, 1, 3)) * np.arange(1, 70_001)[:, None, None]
    write_c3d(tmp_path / "a.c3d", markers(positions))
    (tmp_path / "a.c3d").write_bytes((tmp_path / "a.c3d").read_bytes()[:-100_000])
    with pytest.raises(FileError, match="70000 frames, the header 65535"):
        read_c3d(tmp_path / "a.c3d")


@pytest.mark.parametrize("frames", [32_768, 65_535])
def test_the_longest_files_are_whole(tmp_path: Path, frames: int) -> None:
    positions = np.ones((frames, 1, 3)) * np.arange(1, frames + 1)[:, None, None]
    write_c3d(tmp_path / "a.c3d", markers(positions))
    assert read_c3d(tmp_path / "a.c3d").frames == frames
    theirs = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["points"][0, 0]
    theirs = theirs[:frames]  # at 65,535 ezc3d takes the zeros of the last block for frames
    np.testing.assert_allclose(theirs, positions[:, 0, 0] * 1000, rtol=1e-6)


def test_promises_beyond_the_format_are_refused(tmp_path: Path, rng) -> None:
    path = written_by_ezc3d(tmp_path / "a.c3d", rng.normal(size=(4, 2, 3)), ["a", "b"], LONG_FRAMES=[70_000.0])
    with pytest.raises(FileError, match="LONG_FRAMES says 70000 frames, the header 4"):
        read_c3d(path)


def test_file_without_a_rate(tmp_path: Path, rng) -> None:
    path = tmp_path / "a.c3d"
    write_c3d(path, some_markers(rng))
    raw = path.read_bytes()
    path.write_bytes(raw.replace(struct.pack("<f", 100.0), bytes(4)))
    with pytest.raises(FileError, match="--fps"):
        read_c3d(path)
    read = read_c3d(path, 50.0)
    assert read.fps == 50.0
    assert any("50 Hz as given" in guess for guess in read.guesses)


def test_a_file_that_is_cut_off_says_what_to_do_wherever_it_ends(rng: np.random.Generator, tmp_path: Path) -> None:
    write_c3d(tmp_path / "whole.c3d", some_markers(rng))
    whole = (tmp_path / "whole.c3d").read_bytes()
    for kept in range(600, len(whole) - 512, 100):  # the last block is filled up
        (tmp_path / "cut.c3d").write_bytes(whole[:kept])
        with pytest.raises(FileError, match="get a complete copy"):
            read_c3d(tmp_path / "cut.c3d")
