"""`motionmend compare`."""

import json
import shutil
from pathlib import Path

import numpy as np
from commands import Command

from motionmend import samples
from motionmend.bodies.joint_sets import JOINT_SETS, correspondence
from motionmend.bodies.motion import Markers, Motion
from motionmend.bodies.performer import LANDMARKS
from motionmend.bodies.posed_skeleton import motion_of
from motionmend.bodies.postures import Postures
from motionmend.bodies.rig import motion_landmarks
from motionmend.bodies.truth_joints import joints_of_motion
from motionmend.io import read, write
from motionmend.io.joint_table import read_joint_table, write_joint_table
from skeletons import turned_otherwise


def test_a_recording_is_itself(cli: Command, library: Path) -> None:
    facts = json.loads(cli("compare", library / "clean.amc", library / "clean.amc", "--json").out)
    assert (facts["rms_deg"], facts["mean_cm"], facts["missing"]["samples"]) == (0, 0, 0)
    assert facts["input"] == str(library / "clean.amc")


def test_the_text_holds_the_main_numbers(cli: Command, library: Path) -> None:
    ran = cli("compare", library / "clean.c3d", library / "take.c3d")
    assert ran.code == 0
    facts = json.loads(cli("compare", library / "clean.c3d", library / "take.c3d", "--json").out)
    assert f"{facts['mean_cm']:.3g} cm" in ran.out
    assert f"{facts['missing']['samples']} samples" in ran.out
    assert "body angles" not in ran.out


def test_the_same_motion_in_another_order_of_rotations_is_the_same(cli: Command, tmp_path: Path) -> None:
    motion = samples.clip("walk", seconds=1.0, fps=30.0, seed=2)
    joints = [motion.skeleton.names.index(name) for name in ("lhumerus", "rfemur")]
    write(tmp_path / "one.amc", motion)
    write(tmp_path / "other.amc", turned_otherwise(motion, joints))
    ran = cli("compare", tmp_path / "one.amc", tmp_path / "other.amc", "--json")
    found = json.loads(ran.out)
    assert found["mean_cm"] < 1e-3
    assert found["rms_deg"] < 1e-2
    assert any("another order" in note for note in found["notes"])


def test_two_folders_are_compared_file_by_file(cli: Command, takes: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    shutil.copytree(takes, other)
    (other / "day2" / "clean.amc").rename(other / "day2" / "new.amc")
    ran = cli("compare", takes, other, "--json", "--jobs", "1")
    assert ran.code == 1
    said = [json.loads(line) for line in ran.out.splitlines()]
    done = [one for one in said if "rms_deg" in one]
    assert [Path(one["input"]).name for one in done] == ["take.amc"]
    assert len(ran.failures) == 2
    assert any("clean.amc" in line for line in ran.failures)
    assert any("new.amc" in line for line in ran.failures)


def test_what_cannot_be_compared_is_one_line(cli: Command, library: Path, takes: Path) -> None:
    kinds = cli("compare", library / "clean.amc", library / "clean.c3d")
    assert (kinds.code, len(kinds.failures)) == (1, 1)
    assert "clean.c3d" in kinds.failures[0]
    lengths = cli("compare", library / "clean.amc", library / "amc" / "walk_0.amc")
    assert (lengths.code, len(lengths.failures)) == (1, 1)
    assert cli("compare", library / "clean.amc", takes).code == 2


def joints(path: Path, shift: float, frames: int = 20, std: float | None = None, fps: float = 30.0) -> Path:
    rng = np.random.default_rng(0)
    xyz = rng.normal(size=(1, 3, 3)) + 0.1 * np.sin(6.0 * np.arange(frames) / fps)[:, None, None]
    spread = None if std is None else np.full((frames, 3), std)
    names = ("pelvis", "head", "l_wrist")
    write_joint_table(path, Postures(names, xyz + np.array([shift, 0.0, 0.0]), np.arange(frames) / fps, std=spread))
    return path


def test_tables_of_joints(cli: Command, tmp_path: Path) -> None:
    truth, other = joints(tmp_path / "truth.csv", 0.0), joints(tmp_path / "other.csv", 0.03, std=0.01)
    facts = json.loads(cli("compare", truth, other, "--json").out)
    assert facts["kind"] == "joints"
    assert (facts["rms_deg"], facts["foot_skate_cm_s"]) == (None, {"truth": None, "other": None})
    assert round(facts["mean_cm"], 6) == round(facts["p95_cm"], 6) == 3
    assert (facts["share_above_15cm"], facts["missing"]["samples"]) == (0, 0)
    assert set(facts["mean_cm_by_joint"]) == {"pelvis", "head", "l_wrist"}
    ran = cli("compare", truth, other)
    assert ran.code == 0
    assert "3 cm" in ran.out
    assert "0 %" in ran.out


def test_tables_of_other_rates_are_compared_in_time_and_that_is_said(cli: Command, tmp_path: Path) -> None:
    truth, other = joints(tmp_path / "truth.csv", 0.0, 40), joints(tmp_path / "other.csv", 0.03, 40, fps=60.0)
    for pair in ((truth, other), (other, truth)):
        facts = json.loads(cli("compare", *pair, "--json").out)
        assert abs(facts["mean_cm"] - 3) < 0.3
        assert round(facts["fps"]) == 30
        assert "40 rows at" in facts["notes"][0]
    assert "compared at 40 times" in cli("compare", truth, other).out


def test_a_table_in_other_units_is_said(cli: Command, tmp_path: Path) -> None:
    truth, other = joints(tmp_path / "truth.csv", 0.0), joints(tmp_path / "other.csv", 0.03)
    assert json.loads(cli("compare", truth, other, "--json").out)["warnings"] == []
    table = read_joint_table(other)
    write_joint_table(tmp_path / "mm.csv", table.with_positions(1000.0 * table.positions))
    (said,) = json.loads(cli("compare", truth, tmp_path / "mm.csv", "--json").out)["warnings"]
    assert said.startswith("mm.csv: metres were wanted")
    assert "millimetres?" in said


def test_what_was_supposed_of_one_file_has_its_name(cli: Command, library: Path, tmp_path: Path) -> None:
    motion = read(library / "clean.amc")
    assert isinstance(motion, Motion)
    write(tmp_path / "truth.bvh", motion)
    write_joint_table(tmp_path / "seen.csv", Postures(LANDMARKS, motion_landmarks(motion), np.arange(motion.frames)))
    guesses = json.loads(cli("compare", tmp_path / "truth.bvh", tmp_path / "seen.csv", "--json").out)["guesses"]
    assert any("unit of length" in one for one in guesses)
    assert all(one.startswith("truth.bvh: ") for one in guesses)
    both = json.loads(cli("compare", tmp_path / "truth.bvh", tmp_path / "truth.bvh", "--json").out)["guesses"]
    assert guesses == [f"truth.bvh: {one}" for one in both]


def test_a_folder_of_tables(cli: Command, tmp_path: Path) -> None:
    for folder, shift in (("truth", 0.0), ("other", 0.2)):
        (tmp_path / folder).mkdir()
        joints(tmp_path / folder / "a.csv", shift)
        (tmp_path / folder / "a.mend.json").write_text("{}")
    ran = cli("compare", tmp_path / "truth", tmp_path / "other", "--json")
    assert ran.code == 0
    assert json.loads(ran.out)["share_above_15cm"] == 1


def test_joints_against_joint_angles(cli: Command, library: Path, tmp_path: Path) -> None:
    motion = read(library / "clean.amc")
    assert isinstance(motion, Motion)
    turned = motion_landmarks(motion)[::4] @ np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]) + [0.1, 0.2, 3.0]
    write_joint_table(tmp_path / "seen.csv", Postures(LANDMARKS, turned, np.arange(len(turned)) / 30))
    facts = json.loads(cli("compare", library / "clean.amc", tmp_path / "seen.csv", "--json").out)
    assert facts["kind"] == "joints"
    assert facts["mean_cm"] < 0.01
    assert any("rigid" in note for note in facts["notes"])


def test_an_amc_and_the_bvh_made_of_it_are_compared_by_their_joints(
    cli: Command, library: Path, tmp_path: Path
) -> None:
    for name in ("clean", "take"):
        write(tmp_path / f"{name}.bvh", read(library / f"{name}.amc"))
    same = json.loads(cli("compare", library / "clean.amc", tmp_path / "clean.bvh", "--json").out)
    assert (same["kind"], same["missing"]["samples"]) == ("joints", 0)
    assert max(same["mean_cm"], same["rms_deg"]) < 1e-4
    direct = json.loads(cli("compare", library / "clean.amc", library / "take.amc", "--json").out)
    facts = json.loads(cli("compare", library / "clean.amc", tmp_path / "take.bvh", "--json").out)
    assert abs(facts["mean_cm"] - direct["mean_cm"]) < 1e-3 * direct["mean_cm"]
    assert direct["rms_deg"] < facts["rms_deg"] < 2 * direct["rms_deg"]  # a joint has up to three channels
    assert set(facts["mean_cm_by_joint"]) == set(direct["mean_cm_by_joint"])
    ran = cli("compare", library / "clean.amc", tmp_path / "take.bvh")
    assert ran.code == 0
    assert "note" in ran.out
    assert "joints of the same name" in ran.out
    assert f"{facts['rms_deg']:.3g} degrees" in ran.out


def test_joints_are_not_compared_with_angles(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("compare", library / "clean.c3d", joints(tmp_path / "other.csv", 0.0))
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert "other.csv" in ran.failures[0] or "clean.c3d" in ran.failures[0]


def test_a_table_and_the_angles_made_of_it_are_compared_joint_by_joint(cli: Command, library: Path, tmp_path: Path):
    """All joints of a sensor, by name: those of the tracker alone lie elsewhere on a body, or are not there."""
    sets = JOINT_SETS["kinect25"]
    moved = read(library / "clean.amc")
    assert isinstance(moved, Motion)
    seen = joints_of_motion(moved)
    at = seen.positions[::8, correspondence(seen.names, sets.names)]
    lacking = correspondence(seen.names, sets.names) < 0
    at[:, lacking] = at[:, [sets.names.index("HandLeft")]] + 0.05 * np.arange(1, lacking.sum() + 1)[:, None]
    table = Postures(sets.names, at, np.arange(len(at)) / 15)
    write_joint_table(tmp_path / "seen.csv", table)
    write(tmp_path / "seen.bvh", motion_of(table))
    for pair in (("seen.csv", "seen.bvh"), ("seen.bvh", "seen.csv")):
        facts = json.loads(cli("compare", *(tmp_path / name for name in pair), "--json").out)
        assert set(facts["mean_cm_by_joint"]) == set(sets.names)
        assert facts["missing"]["samples"] == 0
        assert facts["mean_cm"] < 3.0
        assert not any("mean" in note for note in facts["notes"])


def test_markers_that_are_more_or_fewer_than_the_truths(cli: Command, library: Path, tmp_path: Path) -> None:
    whole = read(library / "clean.c3d")
    assert isinstance(whole, Markers)
    names = (*(name.lower() for name in whole.names[:30]), "stick")
    write(tmp_path / "other.c3d", Markers(names, whole.positions[:, :31], whole.fps, up=whole.up))
    ran = cli("compare", library / "clean.c3d", tmp_path / "other.c3d", "--json")
    facts = json.loads(ran.out)
    assert (ran.code, facts["missing"]["samples"], facts["unknown"]) == (0, 11 * whole.frames, ["stick"])
    assert "stick" in ran.err


def test_the_optical_markers_of_uiprmd_are_a_truth(cli: Command, data: Path, tmp_path: Path) -> None:
    place = data / "kinect/uiprmd"
    name = "m01_s03_e02_positions.txt.gz"
    truth, sensor = place / "Vicon/Positions" / name, place / "Kinect/Positions" / name
    facts = json.loads(cli("compare", truth, sensor, "--json").out)
    assert 2 < facts["mean_cm"] < 15
    assert any("rigid" in note for note in facts["notes"])


def test_a_truth_that_cannot_be_read_stands_in_front_of_its_line(cli: Command, tmp_path: Path) -> None:
    (tmp_path / "bad.txt").write_text("hello\n")
    ran = cli("compare", tmp_path / "bad.txt", joints(tmp_path / "other.csv", 0.0), "--json")
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert ran.failures[0].startswith(f"motionmend: {tmp_path / 'bad.txt'}: ")
    assert json.loads(ran.out)["input"] == str(tmp_path / "other.csv")
