"""C3D files written into a copy of their source: what is kept, what is said about a repair."""

import struct
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from c3d_files import (
    FILES,
    PY_C3D_REFUSES,
    STORES_INTEGERS,
    gap_and_fill,
    markers,
    py_c3d,
    real,
    repaired,
    some_markers,
    values_of,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin
from motionmend.errors import FileError, MismatchError
from motionmend.io.c3d import read_c3d, write_c3d
from motionmend.io.c3d_chain import INTEGER, REAL, write_chain
from motionmend.io.c3d_layout import BLOCK, MIPS, Layout, parse


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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
