"""`motionmend corrupt`."""

import json
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend.bodies.motion import Markers, Motion
from motionmend.io import read


def masks(sidecar: Path, key: str, frames: int, names: tuple[str, ...]) -> np.ndarray:
    """(T, C) the mask that the runs of a .corrupt.json describe."""
    runs = json.loads(sidecar.read_text())[key]
    mask = np.zeros((frames, len(names)), dtype=bool)
    for name, stretches in runs.items():
        for first, count in stretches:
            mask[first : first + count, names.index(name)] = True
    return mask


def test_the_masks_are_those_of_the_recording(cli: Command, library: Path, tmp_path: Path) -> None:
    command = ["corrupt", library / "clean.c3d", "-o", tmp_path / "bad.c3d", "--outliers", "0.1", "--gaps", "0.2"]
    ran = cli(*command)
    assert (ran.code, ran.out) == (0, "")
    clean, bad = read(library / "clean.c3d"), read(tmp_path / "bad.c3d")
    assert isinstance(clean, Markers)
    assert isinstance(bad, Markers)
    missing = masks(tmp_path / "bad.corrupt.json", "missing_runs", clean.frames, clean.names)
    assert (missing == ~bad.present).all()
    assert missing.mean() == pytest.approx(0.2, abs=0.02)
    outlier = masks(tmp_path / "bad.corrupt.json", "outlier_runs", clean.frames, clean.names)
    moved = np.linalg.norm(bad.positions - clean.positions, axis=2) > 0.04
    assert (outlier == moved).all()


def test_noise_is_in_degrees_for_angles_and_metres_for_markers(cli: Command, library: Path, tmp_path: Path) -> None:
    assert cli("corrupt", library / "clean.amc", "-o", tmp_path / "bad.amc", "--noise", "3").code == 0
    assert cli("corrupt", library / "clean.c3d", "-o", tmp_path / "bad.c3d", "--noise", "0.02").code == 0
    clean, bad = read(library / "clean.amc"), read(tmp_path / "bad.amc")
    assert isinstance(clean, Motion)
    assert isinstance(bad, Motion)
    turns = clean.skeleton.dof_kind == 0
    assert np.degrees(np.std((bad.q - clean.q)[:, turns])) == pytest.approx(3.0, rel=0.05)
    assert np.std((bad.q - clean.q)[:, ~turns]) == pytest.approx(0.03, rel=0.1)
    points, noisy = read(library / "clean.c3d"), read(tmp_path / "bad.c3d")
    assert isinstance(points, Markers)
    assert isinstance(noisy, Markers)
    assert np.nanstd(noisy.positions - points.positions) == pytest.approx(0.02, rel=0.05)


def test_metres_of_noise_are_said_to_be_so(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("corrupt", library / "clean.c3d", "-o", tmp_path / "bad.c3d", "--noise", "5", "--json")
    assert ran.code == 0
    assert "took 5 m, more than a limb; 0.005 would be 5 mm" in ran.err
    assert json.loads(ran.out)["warnings"]
    ran = cli("corrupt", library / "clean.amc", "-o", tmp_path / "bad.amc", "--noise", "5", "--json")
    assert json.loads(ran.out)["warnings"] == []


@pytest.mark.parametrize(("given", "said", "share"), [("0.1", "fraction, 10 %", 0.1), ("10", "percentage, 10 %", 0.1)])
def test_it_says_whether_a_share_is_a_fraction_or_a_percentage(
    cli: Command, library: Path, tmp_path: Path, given: str, said: str, share: float
) -> None:
    ran = cli("corrupt", library / "clean.amc", "-o", tmp_path / "bad.amc", "--outliers", given)
    assert said in ran.err
    assert json.loads((tmp_path / "bad.corrupt.json").read_text())["options"]["outliers"] == pytest.approx(share)


def test_dropped_names_are_gone_and_unknown_ones_are_bad_usage(cli: Command, library: Path, tmp_path: Path) -> None:
    names = read(library / "clean.c3d").channels[:2]
    assert cli("corrupt", library / "clean.c3d", "-o", tmp_path / "bad.c3d", "--drop", *names).code == 0
    facts = json.loads((tmp_path / "bad.corrupt.json").read_text())
    assert facts["missing_runs"] == {name: [[0, facts["frames"]]] for name in names}
    ran = cli("corrupt", library / "clean.c3d", "-o", tmp_path / "other.c3d", "--drop", "NOBODY")
    assert ran.code == 2
    assert "NOBODY" in ran.err
    assert files_below(tmp_path) == {"bad.c3d", "bad.corrupt.json"}


def test_a_seed_is_all_that_tells_two_runs_apart(cli: Command, library: Path, tmp_path: Path) -> None:
    for name, seed in (("a", "3"), ("b", "3"), ("c", "4")):
        options = ["--noise", "1", "--outliers", "5", "--gaps", "5", "--seed", seed]
        assert cli("corrupt", library / "clean.amc", "-o", tmp_path / name / "bad.amc", *options).code == 0
    a, b, c = ((tmp_path / name / "bad.amc").read_bytes() for name in "abc")
    assert a == b != c
    assert (tmp_path / "a/bad.corrupt.json").read_bytes() == (tmp_path / "b/bad.corrupt.json").read_bytes()


def test_a_folder_that_cannot_be_made_fails_its_input_alone(cli: Command, takes: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "day2").write_text("in the way")
    ran = cli("corrupt", takes, "-o", out, "--noise", "1", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "clean.amc" in ran.failures[0]
    assert (out / "take.amc").exists()


def test_negative_noise_is_bad_usage_in_the_unit_given(cli: Command, takes: Path, tmp_path: Path) -> None:
    ran = cli("corrupt", takes / "take.amc", "-o", tmp_path / "new" / "x.amc", "--noise", "-3")
    assert ran.code == 2
    assert "-3" in ran.failures[0]
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_options_that_suit_some_of_the_inputs_fail_the_others_alone_each_in_its_turn(
    cli: Command, library: Path, tmp_path: Path
) -> None:
    given = [library / "clean.amc", tmp_path / "nowhere.c3d", library / "clean.c3d", tmp_path / "gone.c3d"]
    ran = cli("corrupt", *given, "-o", tmp_path / "out", "--drop", "LFHD", "--json", "--jobs", "2")
    said = [json.loads(line) for line in ran.out.splitlines()]
    assert [one["input"] for one in said] == [str(path) for path in given]
    assert ["error" in one for one in said] == [True, True, False, True]
    assert (ran.code, len(ran.failures)) == (1, 3)
    assert cli("corrupt", given[0], "-o", tmp_path / "o.amc", "--drop", "LFHD").code == 2
