"""C3D files: what is read, what is kept, what is said about a repair. ezc3d and py-c3d check us wherever they can."""

import struct
import warnings
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin, Repaired
from motionmend.errors import FileError, MismatchError
from motionmend.io.c3d import read_c3d, write_c3d
from motionmend.io.c3d_chain import INTEGER, REAL, write_chain
from motionmend.io.c3d_layout import BLOCK, MIPS, Layout, frames_of, parse

FILES = (
    "cmu_02_01",
    "cmu_02_05",
    "cmu_05_13",
    "cmu_135_02",
    "emory_SoccerHeader",
    "gt_squat",
    "hdm05_bd_01-02_01_120",
    "hdm05_bd_05-01_01_120",
    "sfu_0005_SideSkip001",
    "sfu_0018_Moonwalk001",
)
STORES_INTEGERS = "cmu_05_13"
PY_C3D_REFUSES = ("cmu_05_13",)  # "inconsistent analog rate": it asks for a rate of channels that are not there
SHORT = ("cmu_02_01", "cmu_05_13", "emory_SoccerHeader", "sfu_0005_SideSkip001")


def real(data: Path, name: str) -> Path:
    return data / "mocap" / "c3d" / f"{name}.c3d"


def markers(positions: np.ndarray, fps: float = 100.0, **other) -> Markers:
    return Markers(tuple(f"M{k}" for k in range(positions.shape[1])), positions, fps, **other)


def some_markers(rng: np.random.Generator, frames: int = 20, count: int = 5) -> Markers:
    positions = rng.normal(size=(frames, count, 3)) * 0.3 + [0.0, 0.0, 1.0]
    positions[rng.random((frames, count)) < 0.1] = np.nan
    return markers(positions)


def repaired(recording: Markers, origin: np.ndarray, method: str = "paper") -> Repaired[Markers]:
    shape = origin.shape
    return Repaired(recording, origin, np.zeros(shape), np.ones(shape), method)


def gap_and_fill(source: Markers, rng: np.random.Generator) -> tuple[Markers, Repaired[Markers]]:
    """A made-up repair: gaps filled, some samples replaced, some left open; every other sample moved by a hair."""
    positions = source.positions + rng.normal(size=source.positions.shape) * 1e-4
    origin = np.where(source.present, Origin.MEASURED, Origin.FILLED)
    origin[rng.random(origin.shape) < 0.01] = Origin.REPAIRED
    origin[5:9, 1] = Origin.LEFT_OPEN
    positions[~np.isfinite(positions)] = 0.5
    positions[origin == Origin.LEFT_OPEN] = np.nan
    changed = source.with_positions(positions)
    return changed, repaired(changed, origin)


def values_of(c3d: ezc3d.c3d, group: str, name: str) -> np.ndarray:
    """An INTEGER or REAL parameter as ezc3d gives it, with its continuations, 16 bits without sign."""
    parts, k = [], 1
    while (title := name if k == 1 else f"{name}{k}") in c3d["parameters"][group]:
        parts.append(np.atleast_2d(c3d["parameters"][group][title]["value"]))
        k += 1
    return np.concatenate(parts, axis=1).astype(np.int64) % 65_536


# ---- reading


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


def test_real_gaps_are_missing(data: Path) -> None:
    read = read_c3d(real(data, "sfu_0018_Moonwalk001"))
    assert (~read.present).mean() == pytest.approx(0.0301, abs=1e-4)


def test_contradicting_file_is_one_clear_line(data: Path) -> None:
    with pytest.raises(FileError, match=r"golfswing.*agrees with itself, POINT:DATA_START is 0 and the header says 7"):
        read_c3d(real(data, "c3dorg_golfswing"))


def written_by_ezc3d(path: Path, points: np.ndarray, labels: list[str], unit: str = "mm", **lists: list[str]) -> Path:
    """A file from the other library; (T, P, 3) points in its unit."""
    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    c3d["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = labels[:255]
    if len(labels) > 255:
        c3d.add_parameter("POINT", "LABELS2", labels[255:])
    for name, listed in lists.items():
        c3d.add_parameter("POINT", name, listed)
    four = np.ones((4, points.shape[1], points.shape[0]))
    four[:3] = points.T
    c3d["data"]["points"] = four
    c3d.write(str(path))
    return path


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("Millimeters", 0.001)])
def test_units_are_converted_there_and_back(tmp_path: Path, rng, unit: str, metres: float) -> None:
    points = rng.normal(size=(4, 3, 3)) + 3
    path = written_by_ezc3d(tmp_path / "a.c3d", points, ["a", "b", "c"], unit)
    read = read_c3d(path)
    np.testing.assert_allclose(read.positions, points * metres, rtol=1e-6)
    assert not any("UNITS" in guess for guess in read.guesses)
    write_c3d(tmp_path / "b.c3d", read.with_positions(read.positions * 2))
    np.testing.assert_allclose(ezc3d.c3d(str(tmp_path / "b.c3d"))["data"]["points"][:3].T, points * 2, rtol=1e-6)


@pytest.mark.parametrize("metres", [0.001, 0.01, 1.0])
def test_unknown_unit_is_guessed_and_said(tmp_path: Path, rng, metres: float) -> None:
    body = rng.random((6, 8, 3)) * [0.5, 0.4, 1.7]
    read = read_c3d(written_by_ezc3d(tmp_path / "a.c3d", body / metres, [f"m{k}" for k in range(8)], "furlong"))
    np.testing.assert_allclose(read.positions, body, rtol=1e-5)
    assert any("'furlong'" in guess for guess in read.guesses)


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
def test_longer_than_the_format_is_refused(tmp_path: Path, frames: int) -> None:
    points = np.ones((frames, 1, 3)) * np.arange(1, frames + 1)[:, None, None]
    path = written_by_ezc3d(tmp_path / "long.c3d", points, ["a"])
    with pytest.raises(FileError, match=rf"{frames} frames, the header 65535"):
        read_c3d(path)
    made = markers(np.ones((frames, 1, 3)))
    with pytest.raises(FileError, match=rf"up to 65535 frames, came {frames}"):
        write_c3d(tmp_path / "out.c3d", made)
    assert not (tmp_path / "out.c3d").exists()


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


# ---- writing into a copy


@pytest.mark.parametrize("name", FILES)
def test_unchanged_markers_give_the_same_file(data: Path, tmp_path: Path, name: str) -> None:
    read = read_c3d(real(data, name))
    write_c3d(tmp_path / "a.c3d", read)
    if name != STORES_INTEGERS:
        assert (tmp_path / "a.c3d").read_bytes() == real(data, name).read_bytes()
        return
    again = read_c3d(tmp_path / "a.c3d")
    np.testing.assert_array_equal(again.positions, read.positions)
    np.testing.assert_array_equal(again.residuals, read.residuals)
    compare_all_but_markers(ezc3d.c3d(str(real(data, name))), ezc3d.c3d(str(tmp_path / "a.c3d")), read)
    write_c3d(tmp_path / "b.c3d", again)
    assert (tmp_path / "b.c3d").read_bytes() == (tmp_path / "a.c3d").read_bytes()


def compare_all_but_markers(before: ezc3d.c3d, after: ezc3d.c3d, read: Markers) -> None:
    """Every parameter, event, analog sample, mask and unchosen point is as it was; only a group of ours is new."""
    old, new = before["parameters"], after["parameters"]
    assert set(new) - {"MOTIONMEND"} == set(old)
    for group in old:
        assert list(new[group]) == list(old[group])
        for name, parameter in old[group].items():
            if name in ("SCALE", "DATA_START") and group == "POINT":
                assert np.abs(new[group][name]["value"]) > 0
            elif name == "__METADATA__":
                assert new[group][name] == parameter
            else:
                assert new[group][name]["type"] == parameter["type"]
                assert new[group][name]["description"] == parameter["description"]
                assert new[group][name]["is_locked"] == parameter["is_locked"]
                assert np.shape(new[group][name]["value"]) == np.shape(parameter["value"])
                assert np.array_equal(new[group][name]["value"], parameter["value"])
    assert abs(new["POINT"]["SCALE"]["value"][0]) == abs(old["POINT"]["SCALE"]["value"][0])
    assert new["POINT"]["SCALE"]["value"][0] < 0
    for part in ("points", "analogs", "events"):
        assert before["header"][part] == after["header"][part]
    np.testing.assert_array_equal(before["data"]["analogs"], after["data"]["analogs"])
    others = np.setdiff1d(np.arange(len(read.source.labels)), read.source.markers)
    for part in ("residuals", "camera_masks"):
        was, now = before["data"]["meta_points"][part], after["data"]["meta_points"][part]
        np.testing.assert_array_equal(was[:, others], now[:, others])
    now, was = after["data"]["points"][:3, others], before["data"]["points"][:3, others]
    np.testing.assert_allclose(now, was, rtol=1e-6)


def py_c3d(path: Path) -> np.ndarray:
    """(T, P, 5) of the second reader: x, y, z in the file's unit, residual, cameras."""
    import c3d

    with warnings.catch_warnings(), path.open("rb") as handle:
        warnings.simplefilter("ignore")
        return np.array([points for _, points, _ in c3d.Reader(handle).read_frames()])


@pytest.mark.parametrize("name", FILES)
def test_a_repair_changes_markers_and_nothing_else(data: Path, tmp_path: Path, rng, name: str) -> None:
    source = real(data, name)
    read = read_c3d(source)
    changed, outcome = gap_and_fill(read, rng)
    out = tmp_path / "out.c3d"
    write_c3d(out, changed, outcome)
    before, after = ezc3d.c3d(str(source)), ezc3d.c3d(str(out))
    compare_all_but_markers(before, after, read)

    chosen = list(read.source.markers)
    np.testing.assert_allclose(after["data"]["points"][:3, chosen].T, changed.positions * 1000, rtol=1e-6, atol=1e-6)
    residuals = after["data"]["meta_points"]["residuals"][0, chosen].T
    np.testing.assert_array_equal(residuals < 0, ~changed.present)
    replaced = np.isin(outcome.origin, (Origin.FILLED, Origin.REPAIRED))
    assert (residuals[replaced] == 0).all()
    np.testing.assert_array_equal(
        after["data"]["meta_points"]["camera_masks"][:, chosen].transpose(0, 2, 1)[:, outcome.origin == 0],
        before["data"]["meta_points"]["camera_masks"][:, chosen].transpose(0, 2, 1)[:, outcome.origin == 0],
    )

    again = read_c3d(out)
    assert again.names == read.names
    np.testing.assert_array_equal(again.present, changed.present)
    np.testing.assert_allclose(again.positions, changed.positions, atol=1e-6)
    kept = outcome.origin == Origin.MEASURED
    np.testing.assert_array_equal(again.residuals[kept], read.residuals[kept])
    if name not in PY_C3D_REFUSES:
        second = py_c3d(out)[:, chosen]
        np.testing.assert_array_equal(second[:, :, 3] < 0, ~changed.present)
        np.testing.assert_allclose(second[changed.present][:, :3], changed.positions[changed.present] * 1000, rtol=1e-5)
        assert (second[~changed.present][:, :3] == 0).all()
        assert (second[replaced][:, 3:] == 0).all()


def test_missing_points_stay_missing(tmp_path: Path, rng) -> None:
    made = some_markers(rng)
    write_c3d(tmp_path / "a.c3d", made)
    holed = made.with_positions(np.where(rng.random((20, 5, 1)) < 0.3, np.nan, made.positions))
    write_c3d(tmp_path / "b.c3d", read_c3d(tmp_path / "a.c3d").with_positions(holed.positions))
    theirs = ezc3d.c3d(str(tmp_path / "b.c3d"))["data"]
    np.testing.assert_array_equal(np.isnan(theirs["points"][0].T), ~holed.present)
    np.testing.assert_array_equal(theirs["meta_points"]["residuals"][0].T < 0, ~holed.present)
    np.testing.assert_array_equal(read_c3d(tmp_path / "b.c3d").present, holed.present)


@pytest.mark.parametrize("how", ["nan", "residual", "zero"])
def test_every_way_to_be_missing(tmp_path: Path, rng, how: str) -> None:
    path = tmp_path / "a.c3d"
    write_c3d(path, markers(rng.normal(size=(4, 3, 3))))
    raw = bytearray(path.read_bytes())
    at = parse(bytes(raw), "a").data_at + 4 * 4  # frame 1, second point
    words = {"nan": [np.nan] * 3 + [0], "residual": [1, 2, 3, -1], "zero": [0, 0, 0, 0]}[how]
    struct.pack_into("<4f", raw, at, *words)
    path.write_bytes(raw)
    read = read_c3d(path)
    assert not read.present[0, 1]
    assert read.present.sum() == 11
    assert read.residuals[0, 1] == -1


def test_counts_and_ranges_are_listed(tmp_path: Path, rng) -> None:
    made = some_markers(rng, frames=40)
    write_c3d(tmp_path / "a.c3d", made)
    read = read_c3d(tmp_path / "a.c3d")
    origin = np.zeros((40, 5), np.uint8)
    origin[3:7, 1] = origin[10, 1] = origin[38:, 4] = Origin.FILLED
    origin[20:22, 1] = Origin.REPAIRED
    origin[0:2, 2] = Origin.LEFT_OPEN
    whole = np.where(origin[:, :, None] == Origin.LEFT_OPEN, np.nan, np.nan_to_num(read.positions, nan=0.5))
    changed = read.with_positions(whole)
    write_c3d(tmp_path / "b.c3d", changed, repaired(changed, origin, "adaptive"))
    listed = ezc3d.c3d(str(tmp_path / "b.c3d"))["parameters"]["MOTIONMEND"]
    assert listed["METHOD"]["value"] == ["adaptive"]
    assert listed["VERSION"]["value"] == [1]
    assert listed["JOINED"]["value"].tolist() == [0, 0]
    assert listed["LABELS"]["value"] == ["M1", "M2", "M4"]
    assert listed["POINTS"]["value"].tolist() == [2, 3, 5]
    assert listed["COUNTS"]["value"].T.tolist() == [[5, 2, 0], [0, 0, 2], [2, 0, 0]]
    assert listed["FILLED"]["value"].T.tolist() == [[2, 4, 7], [2, 11, 11], [5, 39, 40]]
    assert listed["REPAIRED"]["value"].T.tolist() == [[2, 21, 22]]
    assert all(listed[name]["type"] == 2 for name in ("VERSION", "POINTS", "COUNTS", "FILLED", "REPAIRED", "JOINED"))
    again = read_c3d(tmp_path / "b.c3d")
    assert any("7 samples were filled and 2 replaced by an earlier repair" in guess for guess in again.guesses)


def test_a_second_repair_keeps_what_the_first_filled(tmp_path: Path, rng) -> None:
    made = some_markers(rng).with_positions(rng.normal(size=(20, 5, 3)))
    write_c3d(tmp_path / "a.c3d", made)
    first = np.zeros((20, 5), np.uint8)
    first[2:5, 0] = first[:, 3] = Origin.FILLED
    read = read_c3d(tmp_path / "a.c3d")
    write_c3d(tmp_path / "b.c3d", read, repaired(read, first))
    second = np.zeros((20, 5), np.uint8)
    second[4:7, 0] = Origin.REPAIRED
    read = read_c3d(tmp_path / "b.c3d")
    assert read.names == made.names, "a marker that was filled throughout is still a marker"
    write_c3d(tmp_path / "c.c3d", read, repaired(read, second))
    listed = ezc3d.c3d(str(tmp_path / "c.c3d"))
    assert values_of(listed, "MOTIONMEND", "FILLED").T.tolist() == [[1, 3, 4], [4, 1, 20]]
    assert values_of(listed, "MOTIONMEND", "REPAIRED").T.tolist() == [[1, 5, 7]]
    write_c3d(tmp_path / "d.c3d", read_c3d(tmp_path / "c.c3d"))
    assert (tmp_path / "d.c3d").read_bytes() == (tmp_path / "c.c3d").read_bytes()


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.001, 0.05, 0.5]), st.sampled_from([70, 4000, 60_000]))
def test_any_listing_reads_back_and_fits(tmp_path_factory, seed: int, share: float, frames: int) -> None:
    rng = np.random.default_rng(seed)
    folder = tmp_path_factory.mktemp("listing")
    made = markers(np.ones((frames, 3, 3)))
    origin = np.where(rng.random((frames, 3)) < share, rng.integers(1, 3, size=(frames, 3)), 0).astype(np.uint8)
    write_c3d(folder / "a.c3d", made, repaired(made, origin))
    said = f"{(origin == 2).sum()} samples were filled and {(origin == 1).sum()} replaced"
    assert any(said in guess for guess in read_c3d(folder / "a.c3d").guesses) or not origin.any()
    listed = ezc3d.c3d(str(folder / "a.c3d"))
    joined = values_of(listed, "MOTIONMEND", "JOINED")[0]
    touched = (origin > 0).any(axis=0)
    counts = np.array([(origin == kind).sum(axis=0)[touched] for kind in (2, 1, 3)])
    if touched.any():
        np.testing.assert_array_equal(values_of(listed, "MOTIONMEND", "COUNTS"), counts % 65_536)
    for name, kind, gap in (("FILLED", 2, joined[0]), ("REPAIRED", 1, joined[1])):
        found = np.zeros_like(origin, bool)
        for point, first, last in values_of(listed, "MOTIONMEND", name).T:
            found[first - 1 : last, point - 1] = True
        assert found[origin == kind].all()
        if gap == 0:
            np.testing.assert_array_equal(found, origin == kind)
        else:
            assert runs_of(found & (origin != kind)) <= gap
    assert joined[1] == 0 or frames > 1000
    assert joined[0] == 0 or joined[1] > frames / 2, "what was filled is listed exactly as long as possible"


def test_joined_ranges_take_nothing_from_measured_samples(tmp_path: Path, rng) -> None:
    frames = 60_000
    made = markers(np.ones((frames, 3, 3)), residuals=np.full((frames, 3), 0.001))
    write_c3d(tmp_path / "a.c3d", made)
    read = read_c3d(tmp_path / "a.c3d")
    origin = (rng.random((frames, 3)) < 0.2).astype(np.uint8)
    write_c3d(tmp_path / "b.c3d", read, repaired(read, origin))
    again = read_c3d(tmp_path / "b.c3d")
    assert values_of(ezc3d.c3d(str(tmp_path / "b.c3d")), "MOTIONMEND", "JOINED")[0, 1] > 0
    np.testing.assert_array_equal(again.residuals > 0, origin == Origin.MEASURED)
    write_c3d(tmp_path / "c.c3d", again, repaired(again, np.zeros_like(origin)))
    np.testing.assert_array_equal(read_c3d(tmp_path / "c.c3d").residuals, again.residuals)


def runs_of(flags: np.ndarray) -> int:
    """Length of the longest run of True down a column."""
    longest = run = np.zeros(flags.shape[1], int)
    for row in flags:
        run = (run + 1) * row
        longest = np.maximum(longest, run)
    return int(longest.max())


def test_markers_that_are_not_those_of_the_file_are_refused(tmp_path: Path, rng) -> None:
    write_c3d(tmp_path / "a.c3d", some_markers(rng))
    read = read_c3d(tmp_path / "a.c3d")
    for other in (
        replace(read, positions=read.positions[:10], residuals=None),
        replace(read, names=("X", *read.names[1:])),
        replace(read, fps=50.0),
    ):
        with pytest.raises(MismatchError, match="source=None"):
            write_c3d(tmp_path / "b.c3d", other)
    write_c3d(tmp_path / "b.c3d", replace(read, fps=50.0, source=None))
    assert read_c3d(tmp_path / "b.c3d").fps == 50.0


def test_sections_behind_the_parameters_move_along(data: Path, tmp_path: Path, rng) -> None:
    """A file whose parameters fill their blocks to the last byte, with a section of rotations behind the points."""
    path = tmp_path / "a.c3d"
    c3d = ezc3d.c3d(str(real(data, "cmu_02_01")))
    c3d["data"]["rotations"] = rng.normal(size=(4, 4, 2, 343))
    c3d.add_parameter("ROTATION", "LABELS", ["pelvis", "femur"])
    c3d.write(str(path))
    read = read_c3d(path)
    changed, outcome = gap_and_fill(read, rng)
    write_c3d(tmp_path / "b.c3d", changed, outcome)
    before, after = ezc3d.c3d(str(path)), ezc3d.c3d(str(tmp_path / "b.c3d"))
    assert after["parameters"]["POINT"]["DATA_START"]["value"] > before["parameters"]["POINT"]["DATA_START"]["value"]
    np.testing.assert_array_equal(after["data"]["rotations"], before["data"]["rotations"])
    np.testing.assert_allclose(after["data"]["points"][:3].T, changed.positions * 1000, rtol=1e-6, atol=1e-6)


def test_parameters_without_room_are_one_clear_line(tmp_path: Path, rng) -> None:
    made = replace(some_markers(rng, count=500), names=tuple(f"{k:03d}" + "x" * 250 for k in range(500)))
    write_c3d(tmp_path / "a.c3d", made)
    read = read_c3d(tmp_path / "a.c3d")
    assert read.names == made.names
    with pytest.raises(FileError, match="no room to list"):
        write_c3d(tmp_path / "b.c3d", read, repaired(read, np.full((20, 500), Origin.FILLED)))
    with pytest.raises(FileError, match="has 255"):
        write_c3d(
            tmp_path / "b.c3d", replace(some_markers(rng, count=520), names=tuple(f"{k:0255d}" for k in range(520)))
        )


def as_mips(raw: bytes) -> bytes:
    """An Intel file in the byte order of MIPS."""
    layout, big = parse(raw, "intel"), Layout(MIPS)
    swapped = [
        replace(r, values=np.frombuffer(r.values, f"<u{r.kind}").astype(f">u{r.kind}").tobytes())
        if r.kind in (INTEGER, REAL)
        else r
        for r in layout.records
    ]
    header = bytearray(raw[:BLOCK])
    for at, size in ((2, 2), (4, 2), (6, 2), (8, 2), (10, 2), (12, 4), (16, 2), (18, 2), (20, 4)):
        header[at : at + size] = header[at : at + size][::-1]
    section = bytes([1, 0x50, raw[BLOCK + 2], MIPS]) + write_chain(swapped, big.order)
    data = np.frombuffer(raw, "<u4", offset=layout.data_at).astype(">u4").tobytes()
    return bytes(header) + section.ljust(layout.data_at - BLOCK, b"\0") + data


def test_the_byte_order_of_mips(tmp_path: Path, rng) -> None:
    made = some_markers(rng)
    write_c3d(tmp_path / "intel.c3d", made)
    path = tmp_path / "mips.c3d"
    path.write_bytes(as_mips((tmp_path / "intel.c3d").read_bytes()))
    read = read_c3d(path)
    np.testing.assert_allclose(read.positions, made.positions, atol=1e-6)
    assert read.fps == made.fps
    changed, outcome = gap_and_fill(read, rng)
    write_c3d(tmp_path / "out.c3d", changed, outcome)
    np.testing.assert_allclose(read_c3d(tmp_path / "out.c3d").positions, changed.positions, atol=1e-6)
    second = py_c3d(tmp_path / "out.c3d")
    np.testing.assert_allclose(second[changed.present][:, :3], changed.positions[changed.present] * 1000, rtol=1e-4)


# ---- new files


numbers = st.floats(-20, 20, allow_nan=False, width=32)
names = st.text(
    st.characters(codec="utf-8", exclude_categories=("C", "Z"), exclude_characters="*:"), min_size=1, max_size=8
)


@settings(max_examples=40)
@given(st.data(), st.integers(1, 6), st.integers(1, 4), st.sampled_from([119.88, 100.0, 29.97, 1 / 3, 1000.0]))
def test_new_files_give_back_what_was_written(tmp_path_factory, draw, frames: int, count: int, fps: float) -> None:
    labels = draw.draw(st.lists(names, min_size=count, max_size=count, unique=True))
    positions = np.array(draw.draw(st.lists(numbers, min_size=frames * count * 3, max_size=frames * count * 3)))
    positions = positions.reshape(frames, count, 3)
    positions[np.array(draw.draw(st.lists(st.booleans(), min_size=frames, max_size=frames)))] = np.nan
    # "_m" at the end: a label that ends in "Moment" or "Force" is that of a computed point, and is read as one.
    made = Markers(tuple(f"k{label}_m" for label in labels), positions, fps, up=np.array([0.0, 1.0, 0.0]))
    folder = tmp_path_factory.mktemp("new")
    write_c3d(folder / "a.c3d", made)
    read = read_c3d(folder / "a.c3d")
    assert read.names == made.names
    assert read.fps == pytest.approx(fps, rel=1e-7)
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, rtol=1e-6, atol=2e-9)
    write_c3d(folder / "b.c3d", made)
    assert (folder / "a.c3d").read_bytes() == (folder / "b.c3d").read_bytes()


def test_new_files_are_read_by_others(tmp_path: Path, rng) -> None:
    made = replace(some_markers(rng, count=300), up=np.array([0.0, 1.0, 0.0]))
    write_c3d(tmp_path / "a.c3d", made)
    theirs = ezc3d.c3d(str(tmp_path / "a.c3d"))
    np.testing.assert_allclose(theirs["data"]["points"][:3].T, made.positions * 1000, rtol=1e-6)
    assert theirs["parameters"]["POINT"]["UNITS"]["value"] == ["mm"]
    assert theirs["parameters"]["POINT"]["Y_SCREEN"]["value"] == ["+Y"]
    assert theirs["parameters"]["POINT"]["USED"]["value"] == [300]
    second = py_c3d(tmp_path / "a.c3d")
    np.testing.assert_array_equal(second[:, :, 3] < 0, ~made.present)
    np.testing.assert_allclose(second[made.present][:, :3], made.positions[made.present] * 1000, rtol=1e-6)


def test_residuals_are_written(tmp_path: Path, rng) -> None:
    made = markers(rng.normal(size=(5, 2, 3)), residuals=np.full((5, 2), 0.0012))
    write_c3d(tmp_path / "a.c3d", made)
    np.testing.assert_allclose(read_c3d(tmp_path / "a.c3d").residuals, 0.0012, atol=1e-8)
    np.testing.assert_allclose(py_c3d(tmp_path / "a.c3d")[:, :, 3], 1.2, atol=1e-6)


# ---- bad files


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
