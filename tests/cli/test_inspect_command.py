"""`motionmend inspect`."""

import contextlib
import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from commands import Command

from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.motion import Markers
from motionmend.bodies.postures import Postures
from motionmend.io import read, write
from motionmend.io.depth_folder import write_depth_folder
from motionmend.io.joint_table import write_joint_table


def test_joint_angles(cli: Command, library: Path) -> None:
    ran = cli("inspect", library / "take.amc", "--json")
    assert ran.code == 0
    facts = json.loads(ran.out)
    assert (facts["kind"], facts["format"], facts["fps"], facts["frames"]) == ("motion", "amc", 120, 240)
    assert facts["duration"] == pytest.approx(2.0)
    assert len(facts["channels"]) == 62
    assert "lfemur" in facts["joints"]
    assert 0.04 < facts["share_missing"] < 0.06
    assert set(facts["missing"]) == set(facts["channels"])
    assert facts["units"]["angle"] == "deg"
    assert any("120 Hz" in guess for guess in facts["guesses"])
    assert "120 Hz" in ran.err


def test_markers(cli: Command, library: Path) -> None:
    facts = json.loads(cli("inspect", library / "take.c3d", "--json").out)
    assert (facts["kind"], facts["fps"], facts["frames"]) == ("markers", 120, 240)
    assert len(facts["markers"]) == 41
    assert 0.04 < facts["share_missing"] < 0.06


def test_a_stated_rate_stands_and_another_that_is_given_is_told_of(cli: Command, takes: Path, tmp_path: Path) -> None:
    stated = takes / "stated.amc"
    stated.write_text(":SAMPLES-PER-SECOND 60\n" + (takes / "take.amc").read_text())
    assert cli("denoise", stated, "-o", tmp_path / "x.amc", "--fps", "30", "--method", "linear").code == 0
    for file in (stated, tmp_path / "x.amc"):
        ran = cli("inspect", file, "--fps", "30", "--json")
        facts = json.loads(ran.out)
        assert (facts["fps"], facts["duration"]) == (60, 4)
        assert "30 Hz given were not used" in ran.err
    assert json.loads(cli("inspect", takes / "take.amc", "--fps", "30", "--json").out)["fps"] == 30


def test_euler_jumps_are_found_where_they_were_put(cli: Command, takes: Path) -> None:
    lines = (takes / "day2" / "clean.amc").read_text().splitlines()
    feet = [n for n, line in enumerate(lines) if line.startswith("head ")]
    for n in feet[100:]:
        name, *angles = lines[n].split()
        lines[n] = " ".join([name, *(f"{float(angle) + 360:.6f}" for angle in angles)])
    (takes / "turned.amc").write_text("\n".join(lines) + "\n")
    facts = json.loads(cli("inspect", takes / "turned.amc", "--json").out)
    head = [jump for jump in facts["jumps"] if jump["channel"].startswith("head.")]
    assert [(jump["frame"], jump["wrap"]) for jump in head] == [(100, True)] * 3
    assert any("full turn" in warning for warning in facts["warnings"])


def test_a_skeleton_and_a_model(cli: Command, library: Path) -> None:
    skeleton = next(library.glob("*.asf"))
    ran = cli("inspect", skeleton, library / "amc.mend", "--json", "--jobs", "1")
    assert ran.code == 0
    body, model = (json.loads(line) for line in ran.out.splitlines())
    assert (body["kind"], body["dofs"]) == ("skeleton", 62)
    assert body["units"]["file_length_in_m"] > 0
    assert (model["kind"], model["model"], model["clips"], model["window"]) == ("model", "denoiser", 3, 20)
    assert len(model["channels"]) == 62


def test_the_text_has_the_facts_and_no_markup(cli: Command, library: Path) -> None:
    ran = cli("inspect", library / "take.amc", library / "amc.mend", "--jobs", "1")
    assert ran.code == 0
    rows = dict(line.split(maxsplit=1) for line in ran.out.split("\n\n")[0].splitlines() if line[0] != " ")
    assert rows["rate"] == "120 Hz"
    assert rows["frames"] == "240 (2.00 s)"
    assert rows["channels"].startswith("62: root.tx")
    assert "\x1b" not in ran.out
    assert "[" not in ran.out.split("\n\n")[1]


def test_a_bad_file_does_not_hide_a_good_one(cli: Command, library: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.c3d").write_bytes(b"\x02P nothing")
    ran = cli("inspect", tmp_path / "bad.c3d", library / "take.c3d", "--json", "--jobs", "1")
    assert ran.code == 1
    bad, good = (json.loads(line) for line in ran.out.splitlines())
    assert set(bad) == {"input", "error"}
    assert good["kind"] == "markers"
    assert len(ran.failures) == 1
    assert "bad.c3d" in ran.failures[0]


@pytest.mark.slow
def test_a_bar_on_the_terminal_leaves_the_results_alone(library: Path) -> None:
    terminal, its_end = pty.openpty()
    command = [sys.executable, "-m", "motionmend", "inspect", str(library / "amc"), "--json", "--jobs", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=its_end, text=True) as running:
        os.close(its_end)
        assert running.stdout is not None
        lines = running.stdout.read().splitlines()
        shown = b""
        with contextlib.suppress(OSError):  # how the end of a terminal is told
            while chunk := os.read(terminal, 65536):
                shown += chunk
    os.close(terminal)
    assert running.returncode == 0
    kinds = [json.loads(line)["kind"] for line in lines]
    assert (kinds.count("motion"), set(kinds)) == (3, {"motion", "skeleton"})
    assert b"100%" in shown


@pytest.mark.slow
def test_every_real_recording_can_be_looked_at(cli: Command, data: Path) -> None:
    given = [data / "mocap" / "c3d", data / "mocap" / "bvh", data / "mocap" / "amc" / "09"]
    ran = cli("inspect", *given, "--json", "--jobs", "2")
    facts = [json.loads(line) for line in ran.out.splitlines()]
    assert len(facts) == 11 + 9 + 11 + 1
    assert not any("error" in one for one in facts)
    assert (ran.code, len(ran.failures)) == (0, 0)
    assert {one["kind"] for one in facts if "kind" in one} == {"markers", "motion", "skeleton"}


def test_a_depth_folder_alone_and_within_another(cli: Command, tmp_path: Path) -> None:
    camera = Camera(16, 12, 14.0, 14.0, 8.0, 6.0)
    images = [np.full((12, 16), np.nan, np.float32), np.full((12, 16), 2.5, np.float32)]
    folder = tmp_path / "takes" / "one"
    write_depth_folder(folder, [DepthFrame(camera, image, None, k / 30) for k, image in enumerate(images)], 30.0)
    for given in (folder, tmp_path / "takes"):
        ran = cli("inspect", given, "--json")
        assert ran.code == 0
        (line,) = ran.out.splitlines()
        facts = json.loads(line)
        assert (facts["kind"], facts["frames"], facts["share_missing"]) == ("depth", 2, 0.5)
        assert facts["camera"]["width"] == 16
        assert any("no return" in warning for warning in facts["warnings"])
    (folder / "color").mkdir()
    assert "color/ holds no images" in json.loads(cli("inspect", folder, "--json").out)["warnings"][0]
    assert "16 x 12" in cli("inspect", folder).out
    write_depth_folder(
        tmp_path / "lapse", [DepthFrame(camera, images[1], None, t) for t in (0.0, 0.1, 0.2, 0.7, 0.8)], 10.0
    )
    (said,) = json.loads(cli("inspect", tmp_path / "lapse", "--json").out)["warnings"]
    assert said.startswith("1 step in time longer than 1.5 frames, up to 0.5 s")
    (folder / "camera.json").unlink()
    ran = cli("inspect", folder)
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert "camera.json" in ran.failures[0]


def test_a_table_of_joints(cli: Command, tmp_path: Path) -> None:
    xyz = np.zeros((5, 2, 3))
    xyz[2:] += 3.0
    xyz[4] = np.nan
    write_joint_table(tmp_path / "a.csv", Postures(("head", "l_wrist"), xyz, np.arange(5) / 30, std=np.ones((5, 2))))
    facts = json.loads(cli("inspect", tmp_path / "a.csv", "--json").out)
    assert (facts["kind"], facts["joints"], facts["beside"]) == ("joints", ["head", "l_wrist"], ["std"])
    assert facts["share_missing"] == pytest.approx(0.2)
    assert [one["name"] for one in facts["suspicious"]] == ["head", "l_wrist"]
    assert any("without any joint" in warning for warning in facts["warnings"])


@pytest.mark.slow
def test_a_folder_has_the_joints_of_every_sensor_and_leaves_out_what_goes_with_other_files(
    cli: Command, data: Path
) -> None:
    kinect = data / "kinect"
    ran = cli("inspect", kinect / "ist_rgbd")  # pictures as .mat, each useless by itself
    assert len(ran.failures) == 1
    assert "no recording in this folder" in ran.failures[0]
    tables = [path for path in sorted(kinect.rglob("*.csv")) if path.name != "index.csv"]
    assert tables
    for folder in {path.parent for path in tables}:
        said = cli("inspect", folder, "--json")
        assert {Path(json.loads(line)["input"]).name for line in said.out.splitlines() if line} >= {
            path.name for path in tables if path.parent == folder
        }


def test_jumps_of_joints_and_markers_are_found_where_they_were_put(cli: Command, library: Path, tmp_path: Path) -> None:
    for name, ending in (("head", ".csv"), ("LFHD", ".c3d")):
        calm = Postures(("pelvis", "head", "l_wrist"), np.ones((20, 3, 3)), np.arange(20) / 30)
        if ending == ".csv":
            moved = np.array(calm.positions)
            moved[7, 1] += 1.0
            write_joint_table(tmp_path / "in.csv", calm.with_positions(moved))
        else:
            marked = read(library / "clean.c3d")
            assert isinstance(marked, Markers)
            moved = np.array(marked.positions)
            moved[7, marked.names.index(name)] += 1.0
            write(tmp_path / "in.c3d", marked.with_positions(moved))
        facts = json.loads(cli("inspect", tmp_path / f"in{ending}", "--json").out)
        assert [(jump["channel"], jump["frame"]) for jump in facts["jumps"]] == [(name, 7), (name, 8)]
        assert not any("60 degrees" in one for one in facts["warnings"])


def test_every_recording_has_the_key(cli: Command, tmp_path: Path) -> None:
    camera = Camera(8, 6, 7.0, 7.0, 4.0, 3.0)
    frames = [DepthFrame(camera, np.full((6, 8), 2.0, np.float32), None, k / 30) for k in range(3)]
    write_depth_folder(tmp_path / "take", frames, 30.0)
    assert json.loads(cli("inspect", tmp_path / "take", "--json").out)["jumps"] == []
