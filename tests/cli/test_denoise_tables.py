"""`motionmend denoise` and `corrupt` of tables of joints."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import Command

from motionmend.bodies.motion import Motion
from motionmend.bodies.performer import LANDMARKS
from motionmend.bodies.postures import Postures
from motionmend.bodies.rig import motion_landmarks
from motionmend.io import read
from motionmend.io.joint_table import read_joint_table, write_joint_table
from motionmend.io.sensor import read_postures

AMC = "amc.mend"


def test_what_a_table_says_of_its_joints_stays_in_it(cli: Command, tmp_path: Path) -> None:
    rng, names, frames = np.random.default_rng(0), ("pelvis", "head", "l_wrist", "r_wrist"), 240
    clean = rng.normal(size=(1, 4, 3)) + 0.2 * np.sin(np.arange(frames) / 10)[:, None, None]
    seen = clean + rng.normal(0, 0.005, clean.shape)
    seen[60:66] = seen[120:200] = np.nan  # nobody, for a moment and for long
    seen[20:30, 2] = np.nan
    std = np.where(np.isfinite(seen).all(axis=2), 0.01, np.nan)
    seen[30:36, 3] += 0.5
    std[30:36, 3] = 0.2  # held where it was last
    state = rng.integers(0, 3, (frames, 4)).astype(np.uint8)
    given = Postures(names, seen, np.arange(frames) / 30, state=state, std=std, reliability=rng.random((frames, 4)))
    write_joint_table(tmp_path / "seen.csv", given)
    ran = cli("denoise", tmp_path / "seen.csv", "-o", tmp_path / "clean.csv")
    assert ran.code == 0
    found = read_joint_table(tmp_path / "clean.csv")
    np.testing.assert_array_equal(found.state, state)
    np.testing.assert_allclose(found.reliability, given.reliability, atol=1e-8)
    np.testing.assert_array_equal(found.times, read_joint_table(tmp_path / "seen.csv").times)
    assert found.present[:120].all()
    assert not found.present[145:175].any()
    assert found.std is not None
    np.testing.assert_array_equal(np.isfinite(found.std), found.present)
    assert (found.std[found.present] < 0.10).all()
    assert (found.std[given.present & (std < 0.1)] >= 0.01 - 1e-9).all()
    assert np.linalg.norm(found.positions[30:36, 3] - clean[30:36, 3], axis=1).max() < 0.05
    counts = json.loads((tmp_path / "clean.mend.json").read_text())["channels"]["r_wrist"]
    assert counts["left_open"] == int((~found.present[:, 3]).sum()) > 30
    assert "without anybody" in ran.err


def test_what_is_said_of_a_table_of_joints_is_what_stands_in_it(cli: Command, library: Path, tmp_path: Path) -> None:
    joints = sensed(library)
    std, held = np.full((joints.frames, len(joints.names)), 0.02), joints.names.index("l_wrist")
    std[:, held] = 0.3  # never seen, so that nothing tells where it is
    write_joint_table(tmp_path / "in.csv", replace(joints, std=std))
    ran = cli("denoise", tmp_path / "in.csv", "-o", tmp_path / "out.csv", "--max-std", "0.05")
    assert ran.code == 0
    table = read_joint_table(tmp_path / "out.csv")
    assert table.std is not None
    beside = json.loads((tmp_path / "out.mend.json").read_text())
    assert not table.present[:, held].any()
    for j, name in enumerate(table.names):
        mean = table.std[table.present[:, j], j].mean() if j != held else None
        assert beside["std"][name]["mean"] == (None if mean is None else pytest.approx(mean, rel=0.01))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["dropped", "no time", "semicolons", "tabs"])
@pytest.mark.parametrize("command", ["denoise", "corrupt"])
def test_tables_of_joints_are_taken_as_correct_takes_them(
    cli: Command, library: Path, tmp_path: Path, command: str, kind: str
) -> None:
    joints = sensed(library)
    kept = np.delete(np.arange(joints.frames), [10, 11, 25])
    dropped = replace(joints, positions=joints.positions[kept], times=joints.times[kept])
    write_joint_table(tmp_path / "in.csv", dropped if kind == "dropped" else joints)
    rows = [line.split(",") for line in (tmp_path / "in.csv").read_text().splitlines()]
    if kind == "no time":
        rows = [row[1:] for row in rows]
    between = {"semicolons": ";", "tabs": "\t"}.get(kind, ",")
    (tmp_path / "in.csv").write_text("".join(between.join(row) + "\n" for row in rows))
    ran = cli(command, tmp_path / "in.csv", "-o", tmp_path / "out.csv")
    assert ran.code == 0, ran.err
    table, given = read_joint_table(tmp_path / "out.csv"), read_postures(tmp_path / "in.csv")
    assert table.names == given.names
    assert np.allclose(table.times, given.times, atol=1e-6)
    assert np.nanmax(np.abs(table.positions - given.positions)) < 0.02
    said = {"dropped": "2 steps longer than 1.5 frames", "no time": "no times"}
    assert said.get(kind, "commas") in ran.err


def sensed(library: Path) -> Postures:
    """Joints of a walk as a sensor names them, at 30 Hz, a millimetre of noise."""
    motion = read(library / "clean.amc")
    assert isinstance(motion, Motion)
    at = motion_landmarks(motion)[::4]
    at = at + 0.001 * np.random.default_rng(0).normal(size=at.shape)
    return Postures(LANDMARKS, at, np.arange(len(at)) / 30)


@pytest.mark.slow
def test_a_table_s_deviations_are_missed_in_a_c3d(cli: Command, library: Path, tmp_path: Path) -> None:
    joints = sensed(library)
    write_joint_table(tmp_path / "in.csv", replace(joints, std=np.full((joints.frames, len(joints.names)), 0.02)))
    for command in ("denoise", "corrupt"):
        ran = cli(command, tmp_path / "in.csv", "-o", tmp_path / f"{command}.c3d", "--json")
        assert any("lacks deviations" in one for one in json.loads(ran.out)["warnings"])
        assert "lacks deviations" in ran.err


def test_that_a_file_may_be_cut_off_is_a_warning_and_no_guess(cli: Command, tmp_path: Path) -> None:
    rng, joints = np.random.default_rng(0), 25  # as KIMORE has a second Kinect's: x, y, z, state for each, no titles
    places = rng.normal(size=(1, joints, 3)) + 0.1 * np.sin(np.arange(40) / 10)[:, None, None]
    rows = np.concatenate([places, np.full((40, joints, 1), 2.0)], axis=2).reshape(40, -1)
    text = "".join(",".join(f"{value:.6g}" for value in row) + ",\n" for row in rows)
    (tmp_path / "whole.csv").write_text(text)
    cut = tmp_path / "cut.csv"
    cut.write_text(text[:-300])
    ran = [
        cli(*words, "--json")
        for words in (
            ("inspect", cut),
            ("denoise", cut, "--method", "gaussian", "-o", tmp_path / "clean.csv"),
            ("corrupt", cut, "-o", tmp_path / "spoilt.csv"),
            ("compare", tmp_path / "whole.csv", cut),
        )
    ]
    assert [one.code for one in ran] == [0] * 4
    for one in ran:
        said = json.loads(one.out)
        assert any("the file is cut off" in warning for warning in said["warnings"])
        assert not any("cut off" in guess for guess in said["guesses"])
    assert any("cut off" in warning for warning in json.loads((tmp_path / "clean.mend.json").read_text())["warnings"])
