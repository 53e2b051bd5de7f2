"""Tables and files of joints as recorders, spreadsheets and other programs spell them."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from sensor_files import azure, standing, table

from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25, UTDMHAD20
from motionmend.errors import FileError
from motionmend.io.clock_times import clock_seconds
from motionmend.io.sensor import looks_like_sensor, read_postures

PLACES = standing(KINECT25, 8).round(6)
STATES = np.random.default_rng(1).integers(1, 3, PLACES.shape[:2])
TIMES = np.arange(8) / 25


def told(
    path: Path,
    axes: str = "_{}",
    separator: str = ",",
    first: str = "time",
    state: str = "_state",
    joints: tuple[str, ...] = KINECT25.names,
    behind: bool = True,
) -> str:
    """A table with a title for each column; states in a block at the end, or each behind its joint's coordinates."""
    at = [KINECT25.names.index(one) for one in joints]
    rows = [[first], *([repr(float(t))] for t in TIMES)]
    for k in at:
        rows[0] += [KINECT25.names[k] + axes.format(axis) for axis in "xyz"]
        rows[0] += [] if behind else [KINECT25.names[k] + state]
        for t, row in enumerate(rows[1:]):
            row += [repr(float(value)) for value in PLACES[t, k]] + ([] if behind else [str(STATES[t, k])])
    for k in at if behind else ():
        rows[0].append(KINECT25.names[k] + state)
        for t, row in enumerate(rows[1:]):
            row.append(str(STATES[t, k]))
    text = "\n".join(separator.join(row) for row in rows) + "\n"
    path.write_text(text, "utf-8")
    return text


def is_whole(path: Path, joints: tuple[str, ...] = KINECT25.names) -> None:
    found = read_postures(path)
    at = [KINECT25.names.index(one) for one in joints]
    assert found.names == joints
    np.testing.assert_allclose(found.positions, PLACES[:, at], atol=1e-9)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)
    np.testing.assert_array_equal(found.state, STATES[:, at])


@pytest.mark.parametrize("behind", [True, False])
@pytest.mark.parametrize("state", ["_state", ".TrackingState", " tracked", "_Status"])
@pytest.mark.parametrize("axes", ["_{}", ".{}", "{}", " {} (m)", "_Pos{}", ".Position.{}"])
def test_titles_are_understood_as_recorders_spell_them(tmp_path: Path, axes: str, state: str, behind: bool) -> None:
    path = tmp_path / "take.csv"
    told(
        path, axes.replace("{}", "{0}").upper() if axes == "{}" else axes, first="Timestamp", state=state, behind=behind
    )
    is_whole(path)


@pytest.mark.parametrize("separator", ["\t", ";"])
@pytest.mark.parametrize("points", [True, False])
def test_spreadsheets_part_cells_and_decimals_otherwise(tmp_path: Path, separator: str, points: bool) -> None:
    path = tmp_path / "take.csv"
    text = told(path, separator=separator)
    path.write_text(text if points else text.replace(".", ","), "utf-8")
    is_whole(path)


def test_quotes_utf_16_and_gzip_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "take.csv"
    text = told(path)
    path.write_text("\n".join(",".join(f'"{c}"' for c in row.split(",")) for row in text.splitlines()) + "\n", "utf-8")
    is_whole(path)
    path.write_bytes(text.encode("utf-16"))
    is_whole(path)
    path = tmp_path / "take.csv.gz"
    path.write_bytes(gzip.compress(text.encode()))
    is_whole(path)


def test_a_part_of_the_joints_keeps_its_own_names(tmp_path: Path) -> None:
    some = tuple(name for name in KINECT25.names if "Hand" not in name and "Thumb" not in name)
    assert len(some) not in (20, 25, 32)
    told(tmp_path / "some.csv", separator=";", joints=some)
    is_whole(tmp_path / "some.csv", some)
    twenty = tuple(name for name in KINECT25.names if "Tip" not in name and "Thumb" not in name and name != "Neck")
    assert len(twenty) == len(KINECT20.names)
    told(tmp_path / "twenty.csv", separator=";", joints=twenty)  # as many as the first Kinect has, and not those
    is_whole(tmp_path / "twenty.csv", twenty)


def test_turns_beside_positions_are_no_joints(tmp_path: Path) -> None:
    rows = [line.split(",") for line in told(tmp_path / "take.csv", first="Timestamp").splitlines()]
    turns = [f"{name}_{kind}{axis}" for name in KINECT25.names for kind in ("q_", "Rot", "2D_") for axis in "XYZ"]
    rows = [rows[0] + turns, *(row + ["0.5"] * len(turns) for row in rows[1:])]
    (tmp_path / "take.csv").write_text("\n".join(map(",".join, rows)) + "\n", "utf-8")
    is_whole(tmp_path / "take.csv")


def test_what_else_is_measured_is_no_joint_and_said_to_be_left_out(tmp_path: Path) -> None:
    rows = [line.split(",") for line in told(tmp_path / "take.csv", first="Timestamp").splitlines()]
    gyro = [["gyroX", "gyroY", "gyroZ"], *[["50", "-20", "80"]] * len(PLACES)]
    rows = [[row[0], *more, *row[1:]] for row, more in zip(rows, gyro, strict=True)]
    (tmp_path / "take.csv").write_text("\n".join(map(",".join, rows)) + "\n", "utf-8")
    is_whole(tmp_path / "take.csv")
    assert any("gyro" in one for one in read_postures(tmp_path / "take.csv").guesses)


def test_a_joint_that_lacks_a_coordinate_is_not_left_out_silently(tmp_path: Path) -> None:
    text = told(tmp_path / "take.csv").replace("Neck_x", "Head_x")
    (tmp_path / "take.csv").write_text(text, "utf-8")
    with pytest.raises(FileError, match=r"take\.csv"):
        read_postures(tmp_path / "take.csv")


def test_states_in_words_are_states(tmp_path: Path) -> None:
    words = np.array(["NotTracked", "Inferred", "Tracked"])[STATES]
    lines = [
        ";".join(f"{x};{y};{z};{w}".replace(".", ",") for (x, y, z), w in zip(places, row, strict=True))
        for places, row in zip(PLACES, words, strict=True)
    ]
    (tmp_path / "take.csv").write_text("\n".join(lines) + "\n", "utf-8")
    found = read_postures(tmp_path / "take.csv")
    np.testing.assert_array_equal(found.state, STATES)
    np.testing.assert_allclose(found.positions, PLACES)


def test_blanks_between_numbers_with_decimal_commas(tmp_path: Path) -> None:
    lines = [" ".join(str(value).replace(".", ",") for value in row.ravel()) for row in PLACES]
    (tmp_path / "take.txt").write_text("\n".join(lines) + "\n", "utf-8")
    np.testing.assert_allclose(read_postures(tmp_path / "take.txt").positions, PLACES)


@pytest.mark.parametrize("before", [0, 1, 2])
def test_the_floor_behind_joints_without_titles_is_passed_over(tmp_path: Path, before: int) -> None:
    rows = np.concatenate([PLACES, STATES[:, :, None]], axis=2).reshape(len(PLACES), -1)
    stamps = 330_000.0 * np.arange(len(rows))[:, None]
    rows = np.hstack([*(stamps, np.arange(len(rows))[:, None])[:before], rows, np.full((len(rows), 4), 0.5)])
    np.savetxt(tmp_path / "take.skl", rows, fmt="%.6f", delimiter="\t")
    found = read_postures(tmp_path / "take.skl")
    np.testing.assert_allclose(found.positions, PLACES)
    np.testing.assert_array_equal(found.state, STATES)
    assert found.fps == pytest.approx(1 / 0.033 if before else 30.0)


@pytest.mark.parametrize("unit", [1e-3, 1e-6, 1e-7, 1e-9])
def test_times_of_our_own_table_may_be_of_another_unit(tmp_path: Path, unit: float) -> None:
    text = told(tmp_path / "take.csv")
    for t in reversed(TIMES.tolist()):
        text = text.replace(f"\n{t!r},", f"\n{round(t / unit)},")
    (tmp_path / "take.csv").write_text(text, "utf-8")
    is_whole(tmp_path / "take.csv")
    assert any("times were taken as" in one for one in read_postures(tmp_path / "take.csv").guesses)


def test_a_joint_of_which_no_state_is_told_is_not_untracked(tmp_path: Path) -> None:
    rows = [line.split(",") for line in told(tmp_path / "take.csv").splitlines()]
    at = rows[0].index("Neck_state")
    rows = [row[:at] + row[at + 1 :] for row in rows]
    for name in ("time", "Timestamp"):
        rows[0][0] = name
        (tmp_path / "take.csv").write_text("\n".join(map(",".join, rows)) + "\n", "utf-8")
        state = read_postures(tmp_path / "take.csv").state
        assert state is not None
        assert (state[:, KINECT25.names.index("Neck")] == 2).all()


@pytest.mark.parametrize("axes", [(0, 1, 2), (2, 0, 1), (2, 1, 0), (1, 0, 2)])
def test_a_utd_mhad_array_may_be_turned_about(tmp_path: Path, axes: tuple[int, int, int]) -> None:
    places = standing(UTDMHAD20, 7)
    savemat(tmp_path / "a.mat", {"d_skel": np.moveaxis(places, 0, 2).transpose(axes)})
    np.testing.assert_allclose(read_postures(tmp_path / "a.mat").positions, places)


def test_a_single_frame_of_utd_mhad_has_two_axes(tmp_path: Path) -> None:
    places = standing(UTDMHAD20, 1)
    savemat(tmp_path / "a.mat", {"d_skel": places[0]})
    np.testing.assert_allclose(read_postures(tmp_path / "a.mat").positions, places)


@pytest.mark.parametrize("key", ["confidence_level", "joint_confidence_level", "joint_confidences"])
def test_azure_confidences_may_have_any_key(tmp_path: Path, key: str) -> None:
    path = azure(tmp_path / "a.json", {1: standing(AZURE32, 3)}, [0, 33_333, 66_667])
    content = json.loads(path.read_text("utf-8"))
    levels = [k % 3 for k in range(32)]
    for frame in content["frames"]:
        frame["bodies"][0]["body_confidence"] = 0.9  # of the person, not of joints
        frame["bodies"][0][key] = levels
    path.write_text(json.dumps(content), "utf-8")
    np.testing.assert_array_equal(read_postures(path).state, [levels] * 3)


def test_times_of_azure_bodies_that_do_not_rise_are_not_given_out(tmp_path: Path) -> None:
    found = read_postures(azure(tmp_path / "a.json", {1: standing(AZURE32, 3)}, [66_667, 33_333, 0]))
    np.testing.assert_allclose(found.times, [0, 1 / 30, 2 / 30])
    assert any("do not rise: took 30 Hz" in one for one in found.warnings)


def test_a_time_that_an_azure_frame_lacks_is_interpolated_and_said(tmp_path: Path) -> None:
    path = azure(tmp_path / "a.json", {1: standing(AZURE32, 4)}, [0, 200_000, 400_000, 600_000])
    path.write_text(path.read_text("utf-8").replace("400000", "null"), "utf-8")
    found = read_postures(path)
    np.testing.assert_allclose(found.times, [0.0, 0.2, 0.4, 0.6])
    assert any("interpolated" in one for one in found.warnings)


def test_high_confidence_in_a_table_of_azure_kinects_is_tracked(tmp_path: Path) -> None:
    levels = np.arange(4 * 32).reshape(4, 32) % 4
    path = table(tmp_path / "a.csv", standing(AZURE32, 4), levels.astype(float), None)
    np.testing.assert_array_equal(read_postures(path).state, np.minimum(levels, 2))


def test_a_trc_with_decimal_commas_has_its_rate_and_places(tmp_path: Path) -> None:
    names = ["RHip", "LHip", "Neck", "Head", "RWrist"]
    rows = [
        "\t".join([str(t + 1), f"{t / 60:.5f}", *(f"{x:.6f}" for x in PLACES[t, :5].ravel())]).replace(".", ",")
        for t in range(8)
    ]
    head = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        "60,0\t60,0\t8\t5\tm",
        "Frame#\tTime\t" + "\t\t\t".join(names),
        "\t\t" + "\t".join(f"{axis}{k}" for k in range(1, 6) for axis in "XYZ"),
        "",
    ]
    (tmp_path / "a.trc").write_text("\n".join(head + rows) + "\n", "utf-8")
    found = read_postures(tmp_path / "a.trc")
    np.testing.assert_allclose(found.positions, PLACES[:, :5])
    assert found.fps == pytest.approx(60, rel=1e-3)


def test_turns_of_joints_are_no_recording_and_left_out_of_a_folder(tmp_path: Path) -> None:
    """KIMORE's JointOrientation has as many columns as its JointPosition."""
    turns = np.random.default_rng(4).normal(size=(6, 25, 4))
    turns /= np.linalg.norm(turns, axis=2, keepdims=True)
    turns[:, [3, 15, 19, 21, 22]] = 0.0
    path = tmp_path / "JointOrientationExercise1.csv"
    path.write_text("".join(",".join(f"{x:.7g}" for x in row.ravel()) + ",\n" for row in turns), "utf-8")
    assert not looks_like_sensor(path)
    with pytest.raises(FileError, match="turned"):
        read_postures(path)


def test_cells_of_a_mat_file_are_refused_before_they_are_read(tmp_path: Path) -> None:
    """Damaged ones make scipy read beyond the end of memory, which no message survives."""
    inside = np.empty((1, 1), dtype=object)
    inside[0, 0] = standing(UTDMHAD20, 3)
    savemat(tmp_path / "a.mat", {"d_skel": inside})
    with pytest.raises(FileError, match=r"a\.mat.*of cell"):
        read_postures(tmp_path / "a.mat")


@pytest.mark.parametrize("clock", ["time", "frame", ""])
@pytest.mark.parametrize("title", ["bodyId", "Tracking ID", "player", "body_index"])
def test_a_row_for_each_body_gives_one_person_and_says_so(tmp_path: Path, clock: str, title: str) -> None:
    rows = [line.split(",") for line in told(tmp_path / "take.csv", first="Timestamp").splitlines()]
    there = np.array([True] * 5 + [not clock] + [True] * 2)  # without a clock nothing tells of a frame that lacks one
    mixed = [[*([clock] if clock else []), title, *rows[0][1:]]]
    for t, row in enumerate(rows[1:]):
        first = {"time": [row[0]], "frame": [str(t)], "": []}[clock]
        other = [str(float(v) + 1.5) for v in row[1:76]] + ["2"] * 25
        if there[t]:  # numbers that are alike as far as a number in a computer goes
            mixed.append([*first, "72057594037944738", *row[1:]])
        if t > 1 or not clock:
            mixed.append([*first, "72057594037944739", *other])
    (tmp_path / "take.csv").write_text("\n".join(map(",".join, mixed)) + "\n", "utf-8")
    found = read_postures(tmp_path / "take.csv")
    np.testing.assert_allclose(found.positions, np.where(there[:, None, None], PLACES, np.nan))
    np.testing.assert_array_equal(found.state, np.where(there[:, None], STATES, 0))
    assert any("2 bodies: took 72057594037944738" in one for one in found.guesses)
    assert not found.warnings
    if clock == "time":
        np.testing.assert_allclose(found.times, TIMES)


def test_one_body_whose_times_stand_still_keeps_all_its_rows(tmp_path: Path) -> None:
    rows = [line.split(",") for line in told(tmp_path / "take.csv", first="Timestamp").splitlines()]
    rows = [["body", *rows[0]], *(["A", repr(0.04 * (t // 2)), *row[1:]] for t, row in enumerate(rows[1:]))]
    (tmp_path / "take.csv").write_text("\n".join(map(",".join, rows)) + "\n", "utf-8")
    np.testing.assert_allclose(read_postures(tmp_path / "take.csv").positions, PLACES)


@pytest.mark.parametrize("fps", [None, 15.0])
def test_numbers_of_frames_before_joints_without_titles_are_no_seconds(tmp_path: Path, fps: float | None) -> None:
    numbers = np.array([3, 4, 5, 7, 8, 9, 10, 11])
    np.savetxt(tmp_path / "take.csv", np.hstack([numbers[:, None], PLACES.reshape(8, -1)]), fmt="%.6f", delimiter=",")
    found = read_postures(tmp_path / "take.csv", fps=fps)
    np.testing.assert_allclose(found.times, (numbers - 3) / (fps or 30.0))
    assert any("counts frames" in one for one in found.guesses)


def test_azure_frames_of_nobody_may_lack_bodies(tmp_path: Path) -> None:
    path = azure(tmp_path / "a.json", {1: standing(AZURE32, 4)}, [0, 33_333, 66_667, 100_000])
    content = json.loads(path.read_text("utf-8"))
    del content["frames"][1]["bodies"]
    content["frames"][1]["num_bodies"] = 0
    content["frames"][2] |= {"bodies": None, "num_bodies": 0}
    path.write_text(json.dumps(content), "utf-8")
    found = read_postures(path)
    np.testing.assert_array_equal(found.present.all(axis=1), [True, False, False, True])
    assert not found.warnings
    content["frames"][1]["num_bodies"] = 1
    path.write_text(json.dumps(content), "utf-8")
    with pytest.raises(FileError, match=r"a\.json"):
        read_postures(path)


def test_an_azure_frame_without_a_stamp_does_not_take_the_others_theirs(tmp_path: Path) -> None:
    path = azure(tmp_path / "a.json", {1: standing(AZURE32, 4)}, [0, 66_667, 133_333, 200_000])
    content = json.loads(path.read_text("utf-8"))
    del content["frames"][2]["timestamp_usec"]
    path.write_text(json.dumps(content), "utf-8")
    found = read_postures(path)
    np.testing.assert_allclose(found.times, np.arange(4) / 15, atol=1e-5)
    assert any("1 time stamps are no numbers" in one for one in found.warnings)


@pytest.mark.parametrize(("unit", "name"), [(60.0, "minutes"), (3600.0, "hours"), (86400.0, "days")])
def test_times_may_be_of_a_longer_unit_than_a_second(tmp_path: Path, unit: float, name: str) -> None:
    text = told(tmp_path / "take.csv", first="Timestamp")
    for t in reversed(TIMES.tolist()):
        text = text.replace(f"\n{t!r},", f"\n{738_000.0 + t / unit!r},")
    (tmp_path / "take.csv").write_text(text, "utf-8")
    found = read_postures(tmp_path / "take.csv")
    np.testing.assert_allclose(np.diff(found.times), np.diff(TIMES), atol=1e-4)
    assert any(f"times were taken as {name}: 25 Hz" in one for one in found.guesses)


@pytest.mark.parametrize("first", ["time", "Timestamp"])
@pytest.mark.parametrize(
    "written",
    ["23:59:59.{:02.0f}", "2024-02-29T23:59:59.{:02.0f}", "2024-02-29 23:59:59.{:02.0f}Z", "23:59:59:{:02.0f}"],
)
def test_times_may_be_written_as_a_clock_shows_them(tmp_path: Path, first: str, written: str) -> None:
    path = tmp_path / "take.csv"
    rows = told(path, first=first).splitlines()
    stamps = [written.format(100.0 * t) for t in TIMES]
    path.write_text(
        "\n".join([rows[0], *(a + "," + r.partition(",")[2] for a, r in zip(stamps, rows[1:], strict=True))]) + "\n"
    )
    found = read_postures(path)
    np.testing.assert_allclose(found.times, 86399.0 + TIMES, atol=1e-6)
    np.testing.assert_allclose(found.positions, PLACES, atol=1e-9)
    assert found.guesses == ("times are those of a clock: taken as seconds since midnight",)


def test_a_clock_that_passes_midnight_goes_on() -> None:
    assert clock_seconds(["23:59:59.5", "0:00:00.5", "00:00:01"]) == [86399.5, 86400.5, 86401.0]
    assert clock_seconds(["2023-12-31 23:59:59.5", "2024-01-01 00:00:00.5"]) == [86399.5, 86400.5]
    assert clock_seconds(["12:00:00", "noon"]) is clock_seconds(["2023-02-31 12:00:00"]) is clock_seconds([]) is None


@pytest.mark.parametrize(
    ("title", "words"),
    [("Exercise", "squat"), ("label", "2"), ("Date", "2024-05-01"), ("HandLeftState", "Open"), ("IsTracked", "True")],
)
@pytest.mark.parametrize("behind", [True, False])
def test_words_in_columns_of_no_joint_are_passed_over(tmp_path: Path, title: str, words: str, behind: bool) -> None:
    path = tmp_path / "take.csv"
    rows = [row.split(",") for row in told(path, state="TrackingState").splitlines()]
    rows = [[cell for cell, name in zip(row, rows[0], strict=True) if "Tracking" not in name] for row in rows]
    for k, row in enumerate(rows):
        row.insert(len(row) if behind else 0, words if k else title)
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    found = read_postures(path)
    assert found.names == KINECT25.names
    assert found.state is None
    np.testing.assert_allclose(found.positions, PLACES, atol=1e-9)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)


def test_words_among_coordinates_are_still_refused(tmp_path: Path) -> None:
    path = tmp_path / "take.csv"
    lines = told(path, first="Timestamp").splitlines()
    path.write_text("\n".join([*lines[:3], lines[3].replace(lines[3].split(",")[5], "squat"), *lines[4:]]) + "\n")
    with pytest.raises(FileError, match="'squat' in line 4 is no number"):
        read_postures(path)


@pytest.mark.parametrize("first", ["time", "Timestamp"])
def test_times_that_count_frames_are_a_warning(tmp_path: Path, first: str) -> None:
    path = tmp_path / "take.csv"
    lines = told(path, first=first).splitlines()
    counted = [f"{k}," + line.partition(",")[2] for k, line in enumerate(lines[1:], 1)]
    path.write_text("\n".join([lines[0], *counted]) + "\n")
    found = read_postures(path)
    np.testing.assert_array_equal(found.times, np.arange(1.0, 9.0))
    assert any("do they count frames?" in one for one in found.warnings)
    told(path, first=first)
    assert not any("count" in one for one in read_postures(path).warnings)


@pytest.mark.parametrize(
    "axes", ["{1}_{0}", "pos{1}_{0}", "{0}[{1}]", "{0} ({1})", "{0}_{1}_m", "{0}:{1}", "Position {1} {0}"]
)
def test_an_axis_may_stand_before_its_joint_or_in_brackets(tmp_path: Path, axes: str) -> None:
    path = tmp_path / "take.csv"
    rows = told(path, axes="|{}").splitlines()
    titles = [axes.format(*one.split("|")) if "|" in one else one for one in rows[0].split(",")]
    path.write_text("\n".join([",".join(titles), *rows[1:]]) + "\n")
    is_whole(path)
    assert not read_postures(path).guesses


@pytest.mark.parametrize("number", ["joint{0}_{1}", "Joint {0} {1}", "J{0}_{1}"])
def test_numbered_joints_stand_in_the_order_of_the_sensors_sdk_and_it_is_said(tmp_path: Path, number: str) -> None:
    path = tmp_path / "take.csv"
    rows = [row.split(",")[:76] for row in told(path).splitlines()]
    rows[0][1:] = [number.format(k, axis) for k in range(25) for axis in "xyz"]
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    found = read_postures(path)
    assert found.names == KINECT25.names
    np.testing.assert_allclose(found.positions, PLACES, atol=1e-9)
    assert any("took the order of the sensor's SDK" in one for one in found.guesses)


def test_numbered_points_are_not_taken_for_joints(tmp_path: Path) -> None:
    path = tmp_path / "markers.csv"
    rows = [row.split(",")[:76] for row in told(path).splitlines()]
    rows[0][1:] = [f"{axis}{k}" for k in range(25) for axis in "XYZ"]
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    assert not looks_like_sensor(path)
