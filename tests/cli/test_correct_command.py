"""`motionmend fit corrector` and `motionmend correct`: what is written, how it is named, and what is said of failures.

The sensor is made from the samples: a walk's joints at 30 Hz, each off by a bias of its own, beside the walk itself as
.bvh in axes of its own.
"""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend import read, samples, write
from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT25, correspondence, mirrored, parents
from motionmend.bodies.motion import Motion
from motionmend.bodies.postures import Postures
from motionmend.bodies.truth_joints import joints_of_motion
from motionmend.correct.pairs import at_times
from motionmend.errors import FileError
from motionmend.io.joint_table import read_joint_table, write_joint_table
from motionmend.models import load_model

LAG = 0.5  # s the truth starts earlier


def sensed(clip: Motion, seed: int) -> Postures:
    """What a second Kinect might say of a clip: 25 joints at 30 Hz, biased and noisy; joints without a counterpart lie
    beside the joint they hang from."""
    truth = joints_of_motion(clip)
    times = np.arange(0, truth.times[-1] - LAG, 1 / 30)
    rows = correspondence(truth.names, KINECT25.names)
    places = at_times(truth.positions, truth.times, times + LAG)
    found = np.where(rows[None, :, None] >= 0, places[:, np.maximum(rows, 0)], np.nan)
    above = parents(KINECT25.names)
    for _ in range(4):
        for k in np.flatnonzero(np.isnan(found[0, :, 0])):
            found[:, k] = found[:, above[k]] + [0.0, -0.05, 0.02]
    bias = np.random.default_rng(7).normal(scale=0.03, size=(25, 3))
    noise = np.random.default_rng(seed).normal(scale=0.004, size=found.shape)
    return Postures(KINECT25.names, found + bias + noise, times, state=np.full(found.shape[:2], 2))


def laban(path: Path, postures: Postures) -> Path:
    """A recording as a table of the second Kinect without titles: ticks, then x, y, z and state of each joint."""
    assert postures.state is not None
    lines = []
    for time, xyz, state in zip(postures.times, postures.positions, postures.state, strict=True):
        cells = [f"{x:.6f},{y:.6f},{z:.6f},{s}" for (x, y, z), s in zip(np.nan_to_num(xyz), state, strict=True)]
        lines.append(f"{int(9e9 + time * 1e7)},{','.join(cells)},")
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="session")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A list of three pairs, a model, and a recording of a fourth walk; never write here."""
    from motionmend.cli import main

    folder = tmp_path_factory.mktemp("taught")
    rows = ["sensor,truth,offset_s"]
    for seed in range(4):
        clip = samples.clip("walk", seconds=3.0, seed=seed)
        postures = sensed(clip, seed)
        laban(folder / f"walk_{seed}.csv", postures)
        write(folder / f"walk_{seed}.bvh", clip)
        start = float(postures.times[0] + int(9e9) * 1e-7)
        if seed < 3:
            rows.append(f"walk_{seed}.csv,walk_{seed}.bvh,{LAG - start if seed else ''}")
    (folder / "pairs.csv").write_text("\n".join(rows) + "\n")
    assert main(["fit", "corrector", str(folder / "pairs.csv"), "-o", str(folder / "m.mend"), "--jobs", "1"]) == 0
    return folder


def error(postures: Postures, clip: Motion) -> float:
    """Mean distance from the clip's joints, m, at the sensor's times from its first frame on."""
    truth = joints_of_motion(clip)
    rows = correspondence(truth.names, KINECT25.names)
    paired = np.flatnonzero(rows >= 0)
    right = at_times(truth.positions, truth.times, postures.times - postures.times[0] + LAG)[:, rows[paired]]
    apart: Floats = np.linalg.norm(postures.positions[:, paired] - right, axis=2)
    return float(np.nanmean(apart))


def test_a_walk_nobody_learned_from_comes_nearer_to_the_truth(cli: Command, taught: Path, tmp_path: Path) -> None:
    out = tmp_path / "fixed.csv"
    ran = cli("correct", taught / "walk_3.csv", "-m", taught / "m.mend", "-o", out, "--json", "--jobs", "1")
    assert ran.code == 0
    clip = samples.clip("walk", seconds=3.0, seed=3)
    raw, fixed = sensed(clip, 3), read_joint_table(out)
    assert error(fixed, clip) < 0.8 * error(raw, clip)
    assert fixed.names == KINECT25.names
    assert fixed.frames == raw.frames
    np.testing.assert_allclose(fixed.times, 900 + raw.times, atol=1e-5)
    assert fixed.reliability is not None
    assert fixed.std is not None
    assert ((fixed.reliability >= 0) & (fixed.reliability <= 1)).all()
    facts = json.loads(ran.out)
    assert {"input", "output", "frames", "seconds", "frame_ms", "counts"} <= facts.keys()
    assert facts["frames"] == raw.frames
    assert {"median", "p50", "p95", "max"} <= facts["frame_ms"].keys()
    assert facts["counts"]["tracked"] == raw.frames * 25
    beside = json.loads((tmp_path / "fixed.mend.json").read_text())
    assert beside["output"] == "fixed.csv"
    assert beside["model"]["file"] == "m.mend"
    assert set(beside["channels"]) == set(KINECT25.names)
    for kind in ("measured", "repaired", "filled", "left_open"):
        assert facts["counts"][kind] == sum(one[kind] for one in beside["channels"].values())
    assert facts["counts"]["repaired"] > 0
    assert (beside["iterations"], beside["cost"]) == (0, [])
    assert list(beside)[-1] == "seconds"


@pytest.mark.slow
def test_fit_says_what_it_did(cli: Command, taught: Path, tmp_path: Path) -> None:
    ran = cli("fit", "corrector", taught / "pairs.csv", "-o", tmp_path / "m.mend", "--json", "--jobs", "2")
    assert ran.code == 0
    facts = json.loads(ran.out)
    assert facts["pairs"] == 3
    estimated = facts["offsets_s"][str(taught / "walk_0.csv")]
    assert estimated == pytest.approx(LAG - 900, abs=0.03)
    assert (tmp_path / "m.mend").read_bytes() == (taught / "m.mend").read_bytes()  # whatever --jobs is
    assert load_model(tmp_path / "m.mend", "corrector").names == KINECT25.names
    (unit,) = [line for line in ran.err.splitlines() if "no length unit" in line]
    assert "walk_0.bvh first" in unit  # which it was supposed of, not the sensor's file beside it
    again = cli("fit", "corrector", taught / "pairs.csv", "-o", tmp_path / "m.mend")
    assert again.code == 1
    assert "--force" in again.failures[0]


@pytest.mark.slow
def test_a_pair_that_is_named_twice_is_told(cli: Command, taught: Path, tmp_path: Path) -> None:
    rows = [f"{taught}/walk_{seed}.csv,{taught}/walk_{seed}.bvh" for seed in (0, 1, 0)]
    (tmp_path / "pairs.csv").write_text("\n".join(["sensor,truth", *rows]) + "\n")
    ran = cli("fit", "corrector", tmp_path / "pairs.csv", "-o", tmp_path / "m.mend", "--jobs", "1", "--json")
    assert ran.code == 0, ran.err
    (said,) = [line for line in ran.err.splitlines() if "counts twice" in line]
    assert "line 4 names the pair of line 2 again" in said
    assert any("line 4" in warning for warning in json.loads(ran.out)["warnings"])


@pytest.mark.slow
def test_bad_rows_are_told_and_the_others_learned_from(cli: Command, taught: Path, tmp_path: Path) -> None:
    for file in taught.glob("walk_*"):
        shutil.copy(file, tmp_path)
    clip = samples.clip("run", seconds=3.0, seed=5)
    write(tmp_path / "other.bvh", clip)
    (tmp_path / "cut.csv").write_text("1,2,3\n")
    rows = ["truth,sensor,note"] + [f"walk_{k}.bvh,walk_{k}.csv,fine" for k in range(3)]
    rows += ["walk_0.bvh,cut.csv,", "none.bvh,walk_1.csv,", ""]
    (tmp_path / "pairs.csv").write_text("\n".join(rows))
    ran = cli("fit", "corrector", tmp_path / "pairs.csv", "-o", tmp_path / "m.mend", "--jobs", "1", "--json")
    assert ran.code == 1
    assert len(ran.failures) == 2
    assert any("cut.csv" in line for line in ran.failures)
    assert any("none.bvh" in line for line in ran.failures)
    assert json.loads(ran.out)["pairs"] == 3


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", "empty"),
        ("a,b,c\n1,2,3\n", "titles"),
        ("sensor,truth,offset_s\n", "none"),
        ("sensor,truth,offset_s\na.csv,b.bvh,soon\n", "line 2"),
        ("sensor,truth,offset_s\na.csv,,0\n", "line 2"),
        ("sensor,truth,offset_s\na.csv,b.bvh,0\n", "a.csv"),
    ],
)
def test_a_list_that_is_none_is_one_line(cli: Command, tmp_path: Path, text: str, wanted: str) -> None:
    (tmp_path / "pairs.csv").write_text(text)
    ran = cli("fit", "corrector", tmp_path / "pairs.csv", "-o", tmp_path / "m.mend", "--jobs", "1")
    assert ran.code == 1
    assert wanted in ran.err
    assert not (tmp_path / "m.mend").exists()
    assert all(line.startswith("motionmend: ") for line in ran.err.splitlines())


@pytest.mark.slow
def test_a_folder_gives_its_tree_and_names_without_endings(cli: Command, taught: Path, tmp_path: Path) -> None:
    takes = tmp_path / "takes"
    (takes / "day").mkdir(parents=True)
    shutil.copy(taught / "walk_3.csv", takes / "day" / "x_positions.csv")
    shutil.copy(taught / "walk_3.csv", takes / "a.csv")
    shutil.copy(taught / "walk_3.csv", takes / "a.skl")
    (takes / "odd.json").write_text('{"not": "ours"}')
    (takes / "broken.skl").write_text("hello\n")
    (takes / "photo.png").write_bytes(b"x")
    ran = cli("correct", takes, "-m", taught / "m.mend", "-o", tmp_path / "out", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "broken.skl" in ran.failures[0]
    assert "odd.json" in ran.err
    tables = {name for name in files_below(tmp_path / "out") if not name.endswith(".mend.json")}
    assert tables == {"day/x_positions.csv", "a.csv.csv", "a.skl.csv"}


def test_nothing_is_overwritten_and_resume_skips(cli: Command, taught: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.csv"
    first = cli("correct", taught / "walk_3.csv", "-m", taught / "m.mend", "-o", out)
    written = out.read_bytes()
    again = cli("correct", taught / "walk_3.csv", "-m", taught / "m.mend", "-o", out)
    resumed = cli("correct", taught / "walk_3.csv", "-m", taught / "m.mend", "-o", out, "--resume")
    forced = cli("correct", taught / "walk_3.csv", "-m", taught / "m.mend", "-o", out, "--force")
    assert [first.code, again.code, resumed.code, forced.code] == [0, 1, 0, 0]
    assert "--force" in again.failures[0]
    assert out.read_bytes() == written


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["bvh", "amc"])
def test_joint_angles_hold_the_same_joints(cli: Command, taught: Path, tmp_path: Path, ending: str) -> None:
    from motionmend.bodies.skeleton import positions

    options = ["-m", taught / "m.mend", "--jobs", "1"]
    assert cli("correct", taught / "walk_3.csv", "-o", tmp_path / f"a.{ending}", *options).code == 0
    assert cli("correct", taught / "walk_3.csv", "-o", tmp_path / "a.csv", *options).code == 0
    motion, table = read(tmp_path / f"a.{ending}"), read_joint_table(tmp_path / "a.csv")
    assert isinstance(motion, Motion)
    places = positions(motion.skeleton, motion.q)
    wrists = [table.names.index(name) for name in ("WristLeft", "AnkleRight", "Neck", "KneeLeft")]
    apart = np.linalg.norm(places[:, :, None] - table.positions[:, None, wrists], axis=3)
    assert (np.median(apart, axis=0).min(axis=0) < 0.03).all()  # some joint of the skeleton is where each of them is
    assert motion.frames == table.frames


@pytest.mark.slow
def test_a_frame_without_the_person_stays_empty(cli: Command, taught: Path, tmp_path: Path) -> None:
    postures = sensed(samples.clip("walk", seconds=3.0, seed=3), 3)
    places, state = postures.positions.copy(), np.full(postures.positions.shape[:2], 2)
    places[10:14], state[10:14] = np.nan, 0
    broken = Postures(postures.names, places, postures.times, state=state)
    laban(tmp_path / "a.csv", broken)
    write_joint_table(tmp_path / "b.csv", broken)
    for name in ("a", "b"):
        out = tmp_path / "out" / f"{name}.csv"
        ran = cli("correct", tmp_path / f"{name}.csv", "-m", taught / "m.mend", "-o", out, "--json", "--jobs", "1")
        assert ran.code == 0
        found = read_joint_table(out)
        assert np.flatnonzero(~found.present.any(axis=1)).tolist() == [10, 11, 12, 13]
        assert found.std is not None
        assert np.array_equal(np.isfinite(found.std), found.present)
        assert json.loads(ran.out)["counts"]["empty_frames"] == 4


def test_sides_that_were_confused_are_told(cli: Command, taught: Path, tmp_path: Path) -> None:
    postures = sensed(samples.clip("walk", seconds=3.0, seed=3), 3)
    places = postures.positions.copy()
    places[30:40] = places[30:40][:, mirrored(postures.names)]
    laban(tmp_path / "a.csv", postures.with_positions(places))
    ran = cli("correct", tmp_path / "a.csv", "-m", taught / "m.mend", "-o", tmp_path / "b.csv", "--json", "--jobs", "1")
    assert ran.code == 0
    said = json.loads((tmp_path / "b.mend.json").read_text())
    told = {*said["swapped_frames"], *said["refused_frames"]}
    assert len(told & set(range(30, 40))) >= 8
    assert len(told - set(range(28, 42))) <= 3
    assert json.loads(ran.out)["refused_frames"] == said["refused_frames"]


def test_bad_usage_is_two(cli: Command, taught: Path, tmp_path: Path) -> None:
    one = ["correct", taught / "walk_3.csv", "-m", taught / "m.mend"]
    assert cli(*one, "-o", tmp_path / "a.csv", "--method", "magic").code == 2
    assert cli(*one, "-o", tmp_path / "a.xyz").code == 2
    assert cli(*one, "-o", tmp_path / "a.csv", "--format", "docx").code == 2
    assert cli(*one, "-o", tmp_path / "a.csv", "--format", "bvh").code == 2
    assert cli("correct", taught / "walk_3.csv", "-o", tmp_path / "a.csv").code == 2
    assert cli("fit", "corrector", taught / "pairs.csv", "-o", tmp_path / "m.bin").code == 2
    assert files_below(tmp_path) == set()


def test_another_model_and_another_recording_are_failures(
    cli: Command, taught: Path, library: Path, tmp_path: Path
) -> None:
    wrong = cli("correct", taught / "walk_3.csv", "-m", library / "amc.mend", "-o", tmp_path / "a.csv")
    assert wrong.code == 1
    assert "amc.mend" in wrong.failures[0]
    assert "corrector" in wrong.failures[0]
    markers = cli("correct", library / "clean.c3d", "-m", taught / "m.mend", "-o", tmp_path / "a.csv")
    assert markers.code == 1
    assert "clean.c3d" in markers.failures[0]
    for name, rest in (("a.csv", "_x,b_y"), ("b.csv", "time,p_x,p_y,p_z\n0,1,2,3\n")):
        (tmp_path / name).write_text(rest)
        ran = cli("correct", tmp_path / name, "-m", taught / "m.mend", "-o", tmp_path / "out.csv")
        assert ran.code == 1
        assert name in ran.failures[0]
    assert not (tmp_path / "out.csv").exists()


def test_inspect_knows_sensors_and_correctors(cli: Command, taught: Path) -> None:
    ran = cli("inspect", taught / "walk_3.csv", taught / "m.mend", "--json", "--jobs", "1")
    assert ran.code == 0
    sensor, model = (json.loads(line) for line in ran.out.splitlines())
    assert sensor["kind"] == "joints"
    assert sensor["share_inferred"] == 0
    assert sensor["swaps"] == []
    assert 0 < sensor["bone_variation"] < 0.3
    assert model["model"] == "corrector"
    assert model["pairs"] == 3


def test_a_report_shows_a_sensors_recording(cli: Command, taught: Path, tmp_path: Path) -> None:
    ran = cli("report", taught / "walk_3.csv", "-o", tmp_path / "r.html")
    assert ran.code == 0
    assert "SpineBase" in (tmp_path / "r.html").read_text()


def test_a_single_frame_becomes_joint_angles_at_the_rate_supposed(cli: Command, taught: Path, tmp_path: Path) -> None:
    postures = sensed(samples.clip("walk", seconds=1.0, seed=3), 3)
    one = Postures(postures.names, postures.positions[:1], postures.times[:1])
    write_joint_table(tmp_path / "one.csv", one)
    for given, rate in (([], 30.0), (["--fps", "50"], 50.0)):
        out = tmp_path / f"one{rate:g}.bvh"
        assert cli("correct", tmp_path / "one.csv", "-m", taught / "m.mend", "-o", out, *given).code == 0
        motion = read(out)
        assert (motion.frames, motion.fps) == (1, pytest.approx(rate))


def test_a_record_that_cannot_be_written_takes_its_output_along(
    cli: Command, taught: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise FileError("o.mend.json: cannot be written: No space left on device")

    write_joint_table(tmp_path / "a.csv", sensed(samples.clip("walk", seconds=1.0, seed=3), 3))
    monkeypatch.setattr("motionmend.cli.correct.write_json", full)
    ran = cli("correct", tmp_path / "a.csv", "-m", taught / "m.mend", "-o", tmp_path / "out" / "o.csv")
    assert ran.code == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("units", "said"), [(1000.0, "is it millimetres?"), (100.0, "is it centimetres?"), (0.001, "in another unit?")]
)
@pytest.mark.parametrize("away", [0.0, 2.5])
def test_a_table_in_other_units_fails_in_one_line(
    cli: Command, taught: Path, tmp_path: Path, units: float, said: str, away: float
) -> None:
    """Wherever the body is."""
    postures = sensed(samples.clip("walk", seconds=3.0, seed=3), 3)
    where = (postures.positions + np.array([0.0, 0.0, away])) * units
    write_joint_table(tmp_path / "wrong.csv", replace(postures, positions=where))
    for command in ("correct", "pipeline"):
        ran = cli(command, tmp_path / "wrong.csv", "-m", taught / "m.mend", "-o", tmp_path / "out.csv", "--jobs", "1")
        assert ran.code == 1
        (line,) = ran.failures
        assert "wrong.csv" in line
        assert said in line
        assert not (tmp_path / "out.csv").exists()


def test_a_recording_of_which_nothing_can_be_corrected_fails(cli: Command, taught: Path, tmp_path: Path) -> None:
    """Somebody a kilometre away."""
    postures = sensed(samples.clip("walk", seconds=3.0, seed=3), 3)
    write_joint_table(tmp_path / "far.csv", replace(postures, positions=postures.positions + np.array([0.0, 0.0, 1e3])))
    ran = cli("correct", tmp_path / "far.csv", "-m", taught / "m.mend", "-o", tmp_path / "out.csv", "--jobs", "1")
    assert ran.code == 1
    (line,) = ran.failures
    assert "far.csv" in line
    assert not (tmp_path / "out.csv").exists()
