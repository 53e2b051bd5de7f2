"""Readers of sensor skeletons: what was written comes back, whatever the format; what is broken is said."""

import csv
import gzip
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat
from sensor_files import azure, ntu, places_of, standing, table, uiprmd

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25, UIPRMD22, UTDMHAD20, JointSet
from motionmend.bodies.postures import Postures
from motionmend.errors import FileError, UsageError
from motionmend.io.joint_table import write_joint_table
from motionmend.io.sensor import SENSOR_ENDINGS, kind_of, looks_like_sensor, read_postures
from motionmend.io.uiprmd import joints_in_room, read_uiprmd_markers

TICK = 330_000  # 100 ns, the second Kinect's usual step


@pytest.mark.slow
@given(
    st.sampled_from([KINECT20, KINECT25, AZURE32]),
    st.integers(2, 6),
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.sampled_from([("\t", ""), (",", ","), (";", ""), (" ", "")]),
)
def test_a_kinect_table_gives_back_what_was_written(
    tmp_path_factory: pytest.TempPathFactory,
    joints: JointSet,
    frames: int,
    stated: bool,
    timed: bool,
    titled: bool,
    written: tuple[str, str],
) -> None:
    path = tmp_path_factory.mktemp("table") / "take.csv"
    places = standing(joints, frames)
    states = np.random.default_rng(frames).integers(0, 3, places.shape[:2]).astype(float) if stated else None
    if states is not None:
        states[:, 0] = 2
    stamps = [5e9 + t * TICK for t in range(frames)] if timed else None
    separator, tail = written
    table(path, places, states, stamps, joints.names if titled else None, separator, tail)
    found = read_postures(path)
    assert found.names == joints.names
    np.testing.assert_allclose(found.positions, places, rtol=0, atol=1e-12)
    if stated:
        np.testing.assert_array_equal(found.state, states)
    else:
        assert found.state is None
    wanted = [t * TICK * 1e-7 for t in range(frames)] if timed else [t / 30 for t in range(frames)]
    np.testing.assert_allclose(found.times - found.times[0], wanted, atol=1e-6)


@pytest.mark.parametrize(("unit", "step"), [(1.0, 0.033), (1e-3, 33), (1e-6, 33_333), (1e-7, 333_333)])
def test_time_stamps_are_seconds_whatever_their_unit(tmp_path: Path, unit: float, step: float) -> None:
    stamps = [1000 * step + step * t for t in range(5)]
    found = read_postures(table(tmp_path / "a.csv", standing(KINECT25, 5), np.full((5, 25), 2.0), stamps))
    np.testing.assert_allclose(found.times, np.array(stamps) * unit)


@pytest.mark.parametrize(("unit", "word"), [(1.0, None), (100.0, "centimetres"), (1000.0, "millimetres")])
def test_a_body_of_impossible_size_tells_the_unit(tmp_path: Path, unit: float, word: str | None) -> None:
    places = standing(KINECT25, 5)
    found = read_postures(table(tmp_path / "a.csv", places * unit, np.full((5, 25), 2.0), None))
    np.testing.assert_allclose(found.positions, places, rtol=1e-12)
    assert any("taken as" in guess and str(word) in guess for guess in found.guesses) == (word is not None)


def test_scrambled_titles_do_not_move_the_joints(tmp_path: Path) -> None:
    places, rng = standing(KINECT25, 20), np.random.default_rng(3)
    titles = list(rng.permutation(KINECT25.names))
    found = read_postures(table(tmp_path / "a.skl", places, np.full((20, 25), 2.0), None, titles, "\t"))
    assert found.names == KINECT25.names
    np.testing.assert_allclose(found.positions, places)
    assert any("titles" in guess for guess in found.guesses)


def test_titles_that_fit_the_body_better_are_believed(tmp_path: Path) -> None:
    places, rng = standing(KINECT25, 20), np.random.default_rng(3)
    order = rng.permutation(25)
    titles = [KINECT25.names[k] for k in order]
    found = read_postures(table(tmp_path / "a.skl", places[:, order], np.full((20, 25), 2.0), None, titles, "\t"))
    assert found.names == tuple(titles)


def test_blank_lines_are_passed_over_and_empty_frames_stay_empty(tmp_path: Path) -> None:
    places, states = standing(KINECT25, 6), np.full((6, 25), 2.0)
    places[2], states[2] = 0.0, 0
    path = table(tmp_path / "JointPositionExercise1.csv", places, states, None, tail=",")
    lines = path.read_text().splitlines()
    path.write_text("\n\n\n" + "\n".join([*lines[:3], "", *lines[3:]]) + "\n")
    found = read_postures(path)
    assert found.frames == 6
    assert np.isnan(found.positions[2]).all()
    assert np.isfinite(np.delete(found.positions, 2, axis=0)).all()


def test_the_body_seen_longest_is_taken_from_an_ntu_file(tmp_path: Path) -> None:
    first, second = standing(KINECT25, 8, 1), standing(KINECT25, 8, 2)
    first[5:] = np.nan
    second[0] = np.nan
    states = np.random.default_rng(0).integers(1, 3, (8, 25)).astype(float)
    found = read_postures(ntu(tmp_path / "S001.skeleton", {"72057": (first, states), "9": (second, states)}, 8))
    np.testing.assert_allclose(found.positions, second)
    assert np.isnan(found.positions[0]).all()
    assert found.state is not None
    np.testing.assert_array_equal(found.state[1:], states[1:])
    assert any("2 bodies: took 9" in guess and "7 of 8" in guess for guess in found.guesses)


def test_the_body_seen_longest_is_taken_from_azure_bodies(tmp_path: Path) -> None:
    one, other = standing(AZURE32, 5, 1), standing(AZURE32, 5, 2)
    one[1:3] = np.nan
    found = read_postures(azure(tmp_path / "a.json", {1: one, 2: other}, [33_333 * t + 500_000 for t in range(5)]))
    assert found.names == AZURE32.names
    np.testing.assert_allclose(found.positions, other, atol=1e-12)
    np.testing.assert_allclose(found.times, 0.5 + np.arange(5) * 0.033333)
    assert any("took 2" in guess for guess in found.guesses)


@pytest.mark.parametrize("kind", ["ntu", "azure"])
def test_who_is_numbered_anew_is_one_person(tmp_path: Path, kind: str) -> None:
    """Also after a moment out of sight, and beside somebody else who is there for longer than each part."""
    joints = KINECT25 if kind == "ntu" else AZURE32
    whole, frames = standing(joints, 60, 1), 60
    whole[20:25] = np.nan
    spans = {1: slice(0, 20), 2: slice(25, 40), 3: slice(40, 60)}
    parts = {one: np.full_like(whole, np.nan) for one in spans}
    for one, span in spans.items():
        parts[one][span] = whole[span]
    other = standing(joints, 60, 2) + np.array([1.5, 0.0, 0.0])
    other[40:] = np.nan
    bodies = {9: other, **parts}
    if kind == "ntu":
        states = np.full(whole.shape[:2], 2.0)
        found = read_postures(
            ntu(tmp_path / "a.skeleton", {str(k): (one, states) for k, one in bodies.items()}, frames)
        )
    else:
        found = read_postures(azure(tmp_path / "a.json", bodies, [33_333 * t for t in range(frames)]))
    np.testing.assert_allclose(found.positions, whole, atol=1e-12)
    assert any("1, 2, 3 for one person" in guess for guess in found.guesses)
    assert any("2 people" in guess and "55 of 60" in guess for guess in found.guesses)


def test_who_comes_elsewhere_is_somebody_else(tmp_path: Path) -> None:
    first, second = standing(AZURE32, 30, 1), standing(AZURE32, 30, 1) + np.array([1.0, 0.0, 0.0])
    first[18:], second[:18] = np.nan, np.nan
    found = read_postures(azure(tmp_path / "a.json", {1: first, 2: second}, [33_333 * t for t in range(30)]))
    np.testing.assert_allclose(found.positions, first, atol=1e-12)
    assert any("2 bodies: took 1" in guess for guess in found.guesses)


@pytest.mark.parametrize("wrapped", [False, True])
def test_confidences_of_azure_recorders_are_states(tmp_path: Path, wrapped: bool) -> None:
    path = azure(tmp_path / "a.json", {1: standing(AZURE32, 3, 1)}, [33_333 * t for t in range(3)])
    content = json.loads(path.read_text())
    levels = np.arange(32) % 4
    for frame in content["frames"]:
        frame["bodies"][0]["joint_confidence"] = [[int(level)] if wrapped else int(level) for level in levels]
    path.write_text(json.dumps(content))
    found = read_postures(path)
    assert found.state is not None
    np.testing.assert_array_equal(found.state, np.tile(np.minimum(levels, 2), (3, 1)))


def test_utd_mhad_is_read_in_the_data_sets_order(tmp_path: Path) -> None:
    places = standing(UTDMHAD20, 7)
    savemat(tmp_path / "a1_s1_t1_skeleton.mat", {"d_skel": np.moveaxis(places, 0, 2)})
    found = read_postures(tmp_path / "a1_s1_t1_skeleton.mat")
    assert found.names == UTDMHAD20.names
    np.testing.assert_allclose(found.positions, places)


@given(st.integers(0, 2**32 - 1))
def test_forward_kinematics_of_uiprmd_agrees_with_its_plain_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    local, angles = rng.normal(size=(3, 22, 3)), rng.uniform(-4, 4, (3, 22, 3))
    plain = np.array([places_of(*frame) for frame in zip(local, angles, strict=True)])
    np.testing.assert_allclose(joints_in_room(local, angles), plain, atol=1e-12)


@pytest.mark.parametrize("zipped", [True, False])
def test_uiprmd_positions_are_read_with_the_angles_beside_them(
    tmp_path: Path, zipped: bool, rng: np.random.Generator
) -> None:
    local, angles = rng.normal(scale=20, size=(5, 22, 3)).round(6), rng.uniform(-180, 180, (5, 22, 3)).round(6)
    path = uiprmd(tmp_path, local, angles, zipped)
    found = read_postures(path)
    assert found.names == UIPRMD22.names
    np.testing.assert_allclose(found.positions, joints_in_room(local / 100, np.radians(angles)), atol=1e-9)
    angles_file = next((tmp_path / "Kinect" / "Angles").iterdir())
    assert not looks_like_sensor(angles_file)
    with pytest.raises(FileError, match="give the Positions file"):
        read_postures(angles_file)
    angles_file.unlink()
    with pytest.raises(FileError, match="angles that go with these positions"):
        read_postures(path)


def test_angles_of_another_length_are_refused(tmp_path: Path, rng: np.random.Generator) -> None:
    path = uiprmd(tmp_path, rng.normal(size=(5, 22, 3)), rng.normal(size=(5, 22, 3)), zipped=False)
    angles = tmp_path / "Kinect" / "Angles" / "m01_s01_e01_angles.txt"
    angles.write_text("".join(angles.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(FileError, match="4 rows of 66"):
        read_postures(path)


def test_markers_at_the_origin_are_missing(tmp_path: Path, rng: np.random.Generator) -> None:
    values = rng.normal(size=(4, 117)) * 1000
    values[1, 3:6] = 0
    path = tmp_path / "m01_s01_e01_positions.txt"
    path.write_text("".join(",".join(f"{v:.6f}" for v in row) + "\n" for row in values))
    assert kind_of(path) == "uiprmd markers"
    found = read_uiprmd_markers(path)
    assert np.argwhere(~found.present).tolist() == [[1, 1]]
    np.testing.assert_allclose(found.positions[0], values[0].reshape(39, 3) / 1000, atol=1e-9)


def test_a_trc_of_pose2sim_gives_its_own_times(tmp_path: Path) -> None:
    places = standing(KINECT20, 4)
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        "60\t60\t4\t3\tm\t60\t0\t4",
        "Frame#\tTime\tHip\t\t\tRHip\t\t\tRKnee\t\t\t",
        "\t\t" + "\t".join(f"{axis}{k}" for k in (1, 2, 3) for axis in "XYZ"),
    ]
    for t in range(4):
        cells = [str(t + 1), f"{0.5 + t / 60:.6f}", *(f"{v:.6f}" for v in places[t, :3].ravel())]
        lines.append("\t".join(cells))
    (tmp_path / "a.trc").write_text("\n".join(lines) + "\n")
    found = read_postures(tmp_path / "a.trc")
    assert found.names == ("Hip", "RHip", "RKnee")
    np.testing.assert_allclose(found.times, 0.5 + np.arange(4) / 60, atol=1e-6)
    np.testing.assert_allclose(found.positions, places[:, :3], atol=1e-6)


@pytest.mark.parametrize("missing", [False, True])
def test_dropped_frames_of_a_trc_take_their_time(tmp_path: Path, missing: bool) -> None:
    """Where a time is missing the rate counts."""
    steps = np.array([0, 1, 3, 4, 154, 155])
    lines = ["DataRate\tNumFrames\tUnits", "30\t6\tm", "Frame#\tTime\tHip\t\t\tKnee", ""]
    for t, step in enumerate(steps):
        time = "" if missing and t == 3 else f"{step / 30:.6f}"
        lines.append(f"{t + 1}\t{time}\t0.1\t0.9\t2.0\t0.1\t{0.4 + t / 100}\t2.0")
    (tmp_path / "a.trc").write_text("\n".join(lines) + "\n")
    found = read_postures(tmp_path / "a.trc")
    np.testing.assert_allclose(found.times, np.arange(6) / 30 if missing else steps / 30, atol=1e-6)
    assert any("DataRate says" in guess for guess in found.guesses) == missing


def joints_over_time(path: Path, times: Sequence[float], places: Floats) -> Path:
    """A table of joints."""
    write_joint_table(path, Postures(KINECT25.names, places, np.array(times)))
    return path


@pytest.mark.parametrize(
    ("times", "kept", "said"),
    [
        ([2.0, 2.0, 2.0], [0.0, 1 / 30, 2 / 30], "the times do not rise: took 30 Hz"),
        ([0.0, 0.1, 0.1], [0.0, 0.1, 0.1], "1 of 3 times are those of the row before"),
        ([0.0, 0.1, 0.05], [0.0, 0.1, 0.05], "the time goes back 1 times"),
        ([0.0, 0.1, 0.2], [0.0, 0.1, 0.2], None),
    ],
)
def test_times_of_a_table_that_do_not_rise_are_told(
    tmp_path: Path, times: list[float], kept: list[float], said: str | None
) -> None:
    found = read_postures(joints_over_time(tmp_path / "a.csv", times, standing(KINECT25, 3)))
    np.testing.assert_allclose(found.times, kept)
    warned = found.warnings
    assert warned == () if said is None else any(said in one for one in warned)


@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_the_joint_from_which_all_others_are_given_is_there(tmp_path: Path, unit: float) -> None:
    """Skeletons are often given from the pelvis; a sensor stands nowhere inside of a body."""
    places = standing(KINECT25, 4)
    places -= places[:, :1]
    path = tmp_path / "a.csv"
    titles = ["Timestamp", *(f"{name}_{axis}" for name in KINECT25.names for axis in "XYZ")]
    rows = np.column_stack([np.arange(4) / 30.0, unit * places.reshape(4, -1)])
    np.savetxt(path, rows, "%.6f", delimiter=",", header=",".join(titles), comments="")
    found = read_postures(path)
    assert found.present.all()
    np.testing.assert_allclose(found.positions, places, atol=1e-6)
    plain = read_postures(joints_over_time(path, [0.0, 0.1, 0.2, 0.3], places))
    assert plain.present.all()
    assert not plain.guesses


def test_joints_of_a_table_that_are_at_the_sensor_are_missing(tmp_path: Path) -> None:
    places = standing(KINECT25, 4)
    places[1:3, 5] = 0.0
    found = read_postures(joints_over_time(tmp_path / "a.csv", [0.0, 0.1, 0.2, 0.3], places))
    assert found.present.sum() == 4 * 25 - 2
    assert not found.present[1:3, 5].any()
    assert any("2 positions at exactly (0, 0, 0)" in guess for guess in found.guesses)


def what_is_said_of(path: Path) -> tuple[str, ...]:
    """Why a file is refused, or what it is warned of."""
    try:
        return read_postures(path).warnings
    except FileError as error:
        return (str(error),) if path.name in str(error) else ()


def whole_files(folder: Path) -> dict[str, Path]:
    """One good file of each format."""
    places, states = standing(KINECT25, 9), np.full((9, 25), 2.0)
    savemat(folder / "a_skeleton.mat", {"d_skel": np.moveaxis(standing(UTDMHAD20, 9), 0, 2)})
    rng = np.random.default_rng(0)
    return {
        "skl": table(folder / "a.skl", places, states, [33.0 * t for t in range(9)], KINECT25.names, "\t"),
        "laban": table(folder / "laban.csv", places, states, [TICK * t for t in range(9)], tail=","),
        "ntu": ntu(folder / "a.skeleton", {"1": (places, states)}, 9),
        "azure": azure(folder / "a.json", {1: standing(AZURE32, 9)}, [33_333 * t for t in range(9)]),
        "mat": folder / "a_skeleton.mat",
        "uiprmd": uiprmd(folder, rng.normal(size=(9, 22, 3)), rng.normal(size=(9, 22, 3)), zipped=True),
        "uiprmd text": uiprmd(folder / "plain", rng.normal(size=(9, 22, 3)), rng.normal(size=(9, 22, 3)), zipped=False),
    }


@pytest.mark.parametrize("kind", ["skl", "laban", "ntu", "azure", "mat", "uiprmd", "uiprmd text"])
def test_a_rate_that_is_given_is_used_or_said_not_to_be(tmp_path: Path, kind: str) -> None:
    path = whole_files(tmp_path)[kind]
    own = read_postures(path)
    given = read_postures(path, fps=50.0)
    used = kind not in ("skl", "laban", "azure")
    np.testing.assert_allclose(given.times, np.arange(9) / 50.0 if used else own.times)
    assert any("were not used" in guess for guess in given.guesses) != used
    assert not any("were not used" in guess for guess in own.guesses)


@pytest.mark.parametrize("share", [0.35, 0.8, 0.99])
@pytest.mark.parametrize("kind", ["skl", "laban", "ntu", "azure", "mat", "uiprmd", "uiprmd text"])
def test_a_file_that_was_cut_off_is_refused_or_carries_a_warning(tmp_path: Path, kind: str, share: float) -> None:
    path = whole_files(tmp_path)[kind]
    assert read_postures(path).frames == 9
    assert read_postures(path).warnings == ()
    raw = path.read_bytes()
    path.write_bytes(raw[: int(share * len(raw))])
    said = what_is_said_of(path)
    assert said
    assert all("\n" not in one for one in said)


@pytest.mark.parametrize(
    "content", [b"", b"   \n", b"\0\1\2" * 40, b"hello world\n", b"{", b"[1, 2]", b"1,2,3\n4,5,6\n"]
)
@pytest.mark.parametrize("ending", SENSOR_ENDINGS)
def test_what_is_no_recording_is_one_line_that_names_the_file(tmp_path: Path, ending: str, content: bytes) -> None:
    path = tmp_path / f"odd{ending}"
    path.write_bytes(content)
    with pytest.raises(FileError) as refused:
        read_postures(path)
    assert "odd" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_row_of_another_length_in_the_middle_is_refused(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", standing(KINECT25, 5), np.full((5, 25), 2.0), None)
    lines = path.read_text().splitlines()
    lines[2] = lines[2].rsplit(",", 3)[0]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(FileError, match="line 3"):
        read_postures(path)


def test_words_for_no_number_are_missing_joints(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", standing(KINECT25, 5), np.full((5, 25), 2.0), None)
    lines = path.read_text().splitlines()
    cells = lines[1].split(",")
    cells[0:3] = ["-1.#IND", "NaN", "-inf"]
    lines[1] = ",".join(cells)
    cells = lines[2].split(",")
    cells[4:7] = ["0.1", "1e200", "-3e9"]  # what no sensor saw
    lines[2] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    found = read_postures(path)
    assert np.argwhere(~found.present).tolist() == [[1, 0], [2, 1]]
    assert found.warnings == ("1 position infinite or absurdly far away: taken as missing",)


def test_nobody_in_it_is_a_failure(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", np.zeros((5, 25, 3)), np.zeros((5, 25)), None)
    with pytest.raises(FileError, match="nobody"):
        read_postures(path)


def test_a_rate_that_is_none_is_bad_usage(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", standing(KINECT25, 5), None, None)
    with pytest.raises(UsageError):
        read_postures(path, fps=0)
    np.testing.assert_allclose(read_postures(path, fps=15).times, np.arange(5) / 15)


def test_other_json_is_no_recording_but_broken_json_is_told(tmp_path: Path) -> None:
    (tmp_path / "x.mend.json").write_text(json.dumps({"version": "1", "frames": 5}))
    (tmp_path / "cut.json").write_text('{"joint_names": ["PELVIS"], "frames": [{"bodies": [')
    assert not looks_like_sensor(tmp_path / "x.mend.json")
    assert looks_like_sensor(tmp_path / "cut.json")


@pytest.mark.slow
def test_every_real_recording_is_read_as_its_index_says(data: Path) -> None:
    folder = data / "kinect"
    if not folder.is_dir():
        pytest.skip("no folder kinect in MOTIONMEND_DATA")
    with (folder / "index.csv").open() as lines:
        index = {row["file"]: row for row in csv.DictReader(lines)}
    counted: Counter[str] = Counter()
    for name, row in index.items():
        path = folder / name
        if (
            not path.is_file()
            or {"Angles", "Vicon", "Depth"} & set(path.parts)
            or not path.name.endswith(SENSOR_ENDINGS)
        ):
            continue
        crowd = name.split("/")[0]
        if (crowd in ("uiprmd", "utdmhad") and counted[crowd] >= 12) or not looks_like_sensor(path):
            continue
        found = read_postures(path)
        assert found.frames == int(row["frames"]), name
        assert abs(found.fps - float(row["fps"])) < 0.05 * found.fps, name
        bones = np.linalg.norm(np.diff(found.positions[:, :2], axis=1), axis=2)
        assert 0.02 < np.nanmedian(bones) < 1.0, name  # metres
        counted[crowd] += 1
    assert len(counted) >= 4
    assert counted.total() > 30


def test_ankles_stay_planted_in_a_squat(data: Path) -> None:
    files = sorted((data / "kinect" / "uiprmd" / "Kinect" / "Positions").glob("m01_*.gz"))[:10]
    if not files:
        pytest.skip("no UI-PRMD squats in MOTIONMEND_DATA")
    ankles = [UIPRMD22.names.index("LFoot"), UIPRMD22.names.index("RFoot")]
    stray = [read_postures(file).positions[:, ankles].std(axis=0) for file in files]
    assert np.median(np.linalg.norm(stray, axis=2)) < 0.04


def test_a_gzip_of_any_text_is_read(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", standing(KINECT25, 5), np.full((5, 25), 2.0), None)
    packed = tmp_path / "b.csv.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    np.testing.assert_array_equal(read_postures(packed).positions, read_postures(path).positions)


@pytest.mark.parametrize("nobody", [0.0, np.nan])
def test_a_recording_of_nobody_is_refused(tmp_path: Path, nobody: float) -> None:
    empty = np.full((4, len(KINECT20.names), 3), nobody)
    write_joint_table(tmp_path / "empty.csv", Postures(KINECT20.names, empty, np.arange(4) / 30.0))
    with pytest.raises(FileError, match="nobody is in it"):
        read_postures(tmp_path / "empty.csv")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("times", [[0.0], [0.0, 0.0, 0.0], [2.0, 1.0, 0.0]])
def test_times_that_do_not_rise_have_no_rate(times: list[float]) -> None:
    assert np.isnan(Postures(("head",), np.ones((len(times), 1, 3)), np.array(times)).fps)
