"""`motionmend pipeline`: every kind of take all the way, and what is said of takes that cannot go."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend import samples
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.joint_sets import JOINT_SETS, KINECT20, correspondence
from motionmend.bodies.motion import Markers, Motion, Origin, Repaired
from motionmend.bodies.performer import LANDMARKS, landmarks
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import positions
from motionmend.bodies.surface import render
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.cli import main
from motionmend.cli.pipeline import as_in_table, as_markers, denoised
from motionmend.cli.pipeline_config import read_config
from motionmend.cli.takes import is_skeleton
from motionmend.correct import Corrector, Pair
from motionmend.errors import UsageError
from motionmend.io import read, write
from motionmend.io.depth_folder import write_depth_folder
from motionmend.io.joint_table import read_joint_table, write_joint_table
from motionmend.models import load_model, save_model

CAMERA = Camera(120, 90, 107.1, 107.1, 60.0, 45.0)


@pytest.fixture(scope="module")
def clip() -> Motion:
    return samples.clip("walk", seconds=2.0, seed=3)


@pytest.fixture(scope="module")
def beginning(clip: Motion) -> Motion:
    """Its first 0.7 s, for what is the same of any recording."""
    return clip.with_q(clip.q[:84])


@pytest.fixture(scope="module")
def sensor(clip: Motion) -> Postures:
    """The walk as a sensor might see it: noise, one jump, one joint missing for a while."""
    truth = positions(clip.skeleton, clip.q)[::4, correspondence(clip.skeleton.names, KINECT20.names)]
    seen = truth + np.random.default_rng(0).normal(0, 0.008, truth.shape)
    seen[30, 7] += 0.4
    state = np.full(truth.shape[:2], 2, np.uint8)
    seen[10:16, 15], state[10:16, 15] = np.nan, 0
    return Postures(KINECT20.names, seen, np.arange(len(truth)) / 30.0, state=state)


@pytest.fixture(scope="module")
def takes(beginning: Motion, sensor: Postures, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of a sensor's skeleton, markers and joint angles, and a corrector beside it; never write here."""
    folder = tmp_path_factory.mktemp("pipeline")
    (folder / "takes" / "day").mkdir(parents=True)
    write_joint_table(folder / "takes" / "seen.csv", sensor)
    write(folder / "takes" / "day" / "marked.c3d", samples.markers(beginning))
    write(folder / "takes" / "day" / "body.amc", beginning)
    clean = Postures(sensor.names, np.nan_to_num(sensor.positions), sensor.times)
    model = Corrector(points=30).fit([Pair(clean, clean.with_positions(clean.positions + 0.02))])
    save_model(folder / "sensor.mend", model)
    (folder / "all.toml").write_text('[correct]\nmodel = "sensor.mend"\n[denoise]\nmethod = "adaptive"\n')
    return folder


@pytest.mark.slow
def test_a_folder_of_takes_goes_all_the_way(cli: Command, takes: Path, sensor: Postures, tmp_path: Path) -> None:
    ran = cli(
        "pipeline", takes / "takes", "-o", tmp_path / "out", "--config", takes / "all.toml", "--json", "--jobs", "1"
    )
    assert (ran.code, ran.failures) == (0, [])
    said = [json.loads(line) for line in ran.out.splitlines()]
    kinds = {(Path(one["input"]).name, one["kind"], tuple(one["steps"])) for one in said}
    assert kinds == {
        ("seen.csv", "sensor", ("correct", "denoise")),
        ("marked.c3d", "recording", ("denoise",)),
        ("body.amc", "recording", ("denoise",)),
    }
    made = files_below(tmp_path / "out")
    assert {"seen.csv", "seen.mend.json", "day/marked.c3d", "day/body.amc", "day/marked.mend.json"} <= made
    table = read_joint_table(tmp_path / "out" / "seen.csv")
    assert table.names == sensor.names
    assert table.frames == sensor.frames
    assert np.isfinite(table.positions).all()
    assert table.std is not None
    assert table.reliability is not None
    assert np.array_equal(table.state, sensor.state)
    corrected = load_model(takes / "sensor.mend").correct(sensor)
    bends = [np.abs(np.diff(one.positions, n=2, axis=0)).mean() for one in (corrected, table)]
    assert bends[1] < 0.7 * bends[0]  # noise is gone
    beside = json.loads((tmp_path / "out" / "seen.mend.json").read_text())
    assert [step["step"] for step in beside["steps"]] == ["correct", "denoise"]
    assert beside["steps"][0]["model"]["file"] == "sensor.mend"
    assert sum(beside["channels"]["Head"].values()) == sensor.frames
    for j, name in enumerate(table.names):
        assert beside["std"][name]["mean"] == pytest.approx(table.std[:, j].mean(), rel=0.01)
    assert list(beside)[-1] == "seconds"


def test_what_a_repair_leaves_open_and_the_step_before_made_is_filled_as_unsure_as_that(clip: Motion) -> None:
    marked = samples.markers(clip)
    some = Postures(marked.names[:3], marked.positions[:9, :3], np.arange(9) / 30, std=np.full((9, 3), 0.01))
    std = np.array(some.std)
    std[:, 2] = 0.3
    held = replace(some, std=std)
    markers = as_markers(held)
    origin = np.where(markers.present, Origin.MEASURED, Origin.LEFT_OPEN).astype(np.uint8)
    repaired = Repaired(
        markers, origin, np.where(markers.present, 0.002, np.nan).astype(np.float32), np.ones((9, 3)), "adaptive"
    )
    written = denoised(held, repaired)
    told = as_in_table(repaired, written)
    assert (told.origin[:, 2] == Origin.FILLED).all()
    assert np.allclose(told.std, written.std)
    assert np.allclose(told.std[:, 2], 0.3)


@pytest.mark.slow
def test_a_frame_without_the_person_is_left_open_and_said_to_be(
    cli: Command, takes: Path, sensor: Postures, tmp_path: Path
) -> None:
    places, state = sensor.positions.copy(), np.array(sensor.state)
    places[20:24], state[20:24] = np.nan, 0
    write_joint_table(tmp_path / "seen.csv", Postures(sensor.names, places, sensor.times, state=state))
    ran = cli("pipeline", tmp_path / "seen.csv", "-m", takes / "sensor.mend", "-o", tmp_path / "o.csv", "--json")
    assert ran.code == 0, ran.err
    table = read_joint_table(tmp_path / "o.csv")
    assert np.flatnonzero(~table.present.any(axis=1)).tolist() == [20, 21, 22, 23]
    assert table.std is not None
    assert np.array_equal(np.isfinite(table.std), table.present)
    beside = json.loads((tmp_path / "o.mend.json").read_text())
    assert {counts["left_open"] for counts in beside["channels"].values()} == {4}
    assert beside["runs"]["Head"]["left_open"] == [[20, 4]]
    assert json.loads(ran.out)["counts"]["left_open"] == 4 * len(sensor.names)
    assert cli("report", tmp_path / "seen.csv", tmp_path / "o.csv", "-o", tmp_path / "o.html").code == 0
    page = (tmp_path / "o.html").read_text("utf-8")
    assert "o.csv: made from" in page
    assert f'class="left_open"><b>{4 * len(sensor.names)}</b>' in page


@pytest.mark.slow
def test_recordings_come_out_as_denoise_makes_them(cli: Command, takes: Path, tmp_path: Path) -> None:
    for name in ("marked.c3d", "body.amc"):
        take = takes / "takes" / "day" / name
        assert cli("pipeline", take, "-o", tmp_path / f"one_{name}").code == 0
        assert cli("denoise", take, "-o", tmp_path / f"two_{name}").code == 0
        assert (tmp_path / f"one_{name}").read_bytes() == (tmp_path / f"two_{name}").read_bytes()


@pytest.mark.slow
def test_a_denoiser_of_one_kind_of_takes_does_not_stop_the_others(cli: Command, takes: Path, tmp_path: Path) -> None:
    write(tmp_path / "clean.c3d", samples.markers(samples.clip("walk", seconds=1.5, seed=1)))
    denoiser = tmp_path / "markers.mend"
    assert cli("fit", "denoiser", tmp_path / "clean.c3d", "-o", denoiser, "--jobs", "1").code == 0
    models = ["-m", takes / "sensor.mend", "-m", denoiser]
    for name in ("table.csv", "angles.bvh"):
        out = tmp_path / name
        ran = cli("pipeline", takes / "takes" / "seen.csv", "-o", out, *models)
        assert ran.code == 0, ran.err
        assert "repaired without the model" in ran.err
        steps = json.loads(out.with_suffix(".mend.json").read_text())
        assert [step["step"] for step in steps["steps"]] == ["correct", "denoise"]
        assert steps["steps"][1]["model"] is None
    ran = cli("pipeline", takes / "takes" / "day", "-o", tmp_path / "out", *models, "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "body.amc" in ran.failures[0]
    assert (tmp_path / "out" / "marked.c3d").exists()


@pytest.mark.slow
def test_a_sensor_s_skeleton_becomes_joint_angles(cli: Command, takes: Path, tmp_path: Path) -> None:
    out = tmp_path / "seen.bvh"
    ran = cli("pipeline", takes / "takes" / "seen.csv", "-m", takes / "sensor.mend", "-o", out)
    assert ran.code == 0, ran.err
    motion = read(out)
    assert isinstance(motion, Motion)
    assert motion.frames == 60
    assert motion.fps == pytest.approx(30)
    told = json.loads(out.with_suffix(".mend.json").read_text())
    assert any("bones leave each joint alike" in warning for warning in told["warnings"])
    assert not any("bones" in guess for guess in told["guesses"])
    assert "warning" in next(line for line in ran.err.splitlines() if "bones leave each joint alike" in line)


@pytest.mark.slow
def test_what_is_guessed_of_a_sensor_s_recording_is_said_once(
    cli: Command, takes: Path, sensor: Postures, tmp_path: Path
) -> None:
    milliseconds = Postures(sensor.names, sensor.positions, 1000.0 * sensor.times, state=sensor.state)
    write_joint_table(tmp_path / "seen.csv", milliseconds)
    ran = cli("pipeline", tmp_path / "seen.csv", "-m", takes / "sensor.mend", "-o", tmp_path / "o.bvh")
    assert ran.code == 0, ran.err
    guesses = json.loads((tmp_path / "o.mend.json").read_text())["guesses"]
    assert sum("milliseconds" in guess for guess in guesses) == 1
    assert len(set(guesses)) == len(guesses)


@pytest.mark.slow
def test_what_is_there_stays_unless_forced_and_resume_skips(cli: Command, takes: Path, tmp_path: Path) -> None:
    command = ["pipeline", takes / "takes" / "seen.csv", "-m", takes / "sensor.mend", "-o", tmp_path / "seen.csv"]
    assert cli(*command).code == 0
    before = (tmp_path / "seen.csv").read_bytes()
    again = cli(*command)
    assert again.code == 1
    assert "--force" in again.failures[0]
    assert cli(*command, "--resume").code == 0
    assert cli(*command, "--force").code == 0
    assert (tmp_path / "seen.csv").read_bytes() == before


@pytest.mark.slow
def test_takes_of_one_name_keep_their_sidecars_apart(cli: Command, beginning: Motion, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    for name in ("walk.amc", "walk.bvh"):
        write(tmp_path / "in" / name, beginning)
    write(tmp_path / "in" / "marked.c3d", samples.markers(beginning))
    ran = cli("pipeline", tmp_path / "in", "-o", tmp_path / "out", "--jobs", "1")
    assert (ran.code, ran.failures) == (0, [])
    sidecars = {one.name: json.loads(one.read_text())["output"] for one in (tmp_path / "out").glob("*.mend.json")}
    assert sidecars == {
        "walk.amc.mend.json": "walk.amc",
        "walk.bvh.mend.json": "walk.bvh",
        "marked.mend.json": "marked.c3d",
    }


@pytest.mark.slow
def test_outputs_inside_the_folder_of_takes_are_no_takes(cli: Command, takes: Path, tmp_path: Path) -> None:
    (tmp_path / "takes").mkdir()
    (tmp_path / "takes" / "seen.csv").write_bytes((takes / "takes" / "seen.csv").read_bytes())
    command = ["pipeline", tmp_path / "takes", "-o", tmp_path / "takes" / "out", "-m", takes / "sensor.mend", "--json"]
    for more in ([], ["--force"]):
        ran = cli(*command, *more)
        assert ran.code == 0, ran.err
        assert len(ran.out.splitlines()) == 1


@pytest.mark.slow
def test_without_its_model_a_take_fails_and_the_others_are_done(cli: Command, takes: Path, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "notes.txt").write_text("not a take")
    given = [takes / "takes", tmp_path / "in", tmp_path / "none.c3d"]
    ran = cli("pipeline", *given, "-o", tmp_path / "out", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 3
    assert any("seen.csv" in line and "corrector" in line for line in ran.failures)
    assert any("none.c3d" in line for line in ran.failures)
    assert "notes.txt is left out" in ran.err
    assert {"takes/day/marked.c3d", "takes/day/body.amc"} <= files_below(tmp_path / "out")


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("[correct]\nmodle = 'x'\n", "correct.modle"),
        ("[track]\nfps = 30\n", "[track] takes model, skeleton, start, body, preset, terms"),
        ("[smooth]\nx = 1\n", "smooth"),
        ("fps = -1\n", "fps"),
        ('fps = "30"\n', "fps"),
        ("fps = inf\n", "fps"),
        ('[denoise]\nlag = "1"\n', "denoise.lag"),
        ('[correct]\nonline = "yes"\n', "correct.online"),
        ("format = 'fbx'\n", "format"),
        ("[denoise]\nmax_std = -1\n", "denoise.max_std"),
        ("[denoise]\nmethod = 'magic'\n", "bad.toml: --method"),
        ("track = 'people.mend'\n", "track: a section was wanted"),
        ("[correct\n", "TOML"),
    ],
)
def test_a_configuration_with_a_mistake_is_bad_usage(
    text: str, word: str, cli: Command, takes: Path, tmp_path: Path
) -> None:
    (tmp_path / "bad.toml").write_text(text)
    ran = cli("pipeline", takes / "takes", "-o", tmp_path / "out", "--config", tmp_path / "bad.toml")
    assert ran.code == 2
    assert len(ran.failures) == 1
    assert word in ran.failures[0]


def test_a_byte_order_mark_as_editors_write_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "t.toml").write_text("fps = 25\n[denoise]\nmethod = 'paper'\n", "utf-8-sig")
    assert read_config(tmp_path / "t.toml").fps == 25.0


def test_terms_are_a_list_or_a_text_with_commas_as_on_the_command_line(tmp_path: Path) -> None:
    for spelt in ('"surface, color"', '["surface", "color"]'):
        (tmp_path / "t.toml").write_text(f"[track]\nterms = {spelt}\n")
        assert read_config(tmp_path / "t.toml").track.terms == ("surface", "color")
    (tmp_path / "t.toml").write_text("[track]\nterms = 3\n")
    with pytest.raises(UsageError, match="terms"):
        read_config(tmp_path / "t.toml")


def test_bad_usage_and_models_that_are_none(cli: Command, takes: Path, tmp_path: Path) -> None:
    assert cli("pipeline", "-o", tmp_path / "out").code == 2
    two = ["-m", takes / "sensor.mend", "-m", takes / "sensor.mend"]
    assert cli("pipeline", takes / "takes", "-o", tmp_path / "out", *two).code == 2
    assert cli("pipeline", takes / "takes", "-o", tmp_path / "out", "-m", takes / "all.toml").code == 1
    assert cli("pipeline", takes / "takes", "-o", tmp_path / "out", "--config", tmp_path / "no.toml").code == 2
    assert cli("pipeline", takes / "takes", "-o", tmp_path / "out.csv").code == 2
    assert cli("pipeline", takes / "takes" / "seen.csv", "-o", tmp_path / "out.c3d").code == 2


@pytest.mark.slow
def test_a_model_on_the_command_line_goes_before_the_configuration_s_and_that_is_said(
    cli: Command, takes: Path, tmp_path: Path
) -> None:
    given = takes / "takes" / "seen.csv", "--config", takes / "all.toml", "--force", "-o", tmp_path / "seen.csv"
    (tmp_path / "mine.mend").write_bytes((takes / "sensor.mend").read_bytes())
    ran = cli("pipeline", *given, "-m", tmp_path / "mine.mend")
    said = f"{tmp_path / 'mine.mend'} is used (-m), not {takes / 'sensor.mend'} of --config"
    assert (ran.code, ran.err.splitlines().count(said)) == (0, 1)
    assert " is used (-m)" not in cli("pipeline", *given, "-m", takes / "sensor.mend").err


@pytest.mark.slow
def test_depth_is_tracked_and_denoised(cli: Command, clip: Motion, tmp_path: Path) -> None:
    write(tmp_path / "clip.amc", clip)
    assert main(["fit", "tracker", str(tmp_path / "clip.amc"), "-o", str(tmp_path / "t.mend"), "--images", "30"]) == 0
    body = performer_of(clip.skeleton)
    poses = poses_of(Motion(clip.skeleton, clip.q[:40:4], 30.0), body).poses
    up = clip.skeleton.up
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], -up)
    across /= np.linalg.norm(across)
    turn = np.array([across, -up, np.cross(across, -up)])
    seen = poses.moved(turn, np.array([0.0, -0.05, 3.0]) - turn @ poses.translation[0])
    frames = [
        DepthFrame(CAMERA, np.array(render(body, seen[t], CAMERA).depth, np.float32), None, t / 30.0) for t in range(10)
    ]
    write_depth_folder(tmp_path / "in" / "take", frames, 30.0)
    (tmp_path / "t.toml").write_text('[track]\nmodel = "t.mend"\nskeleton = "clip.asf"\n')
    ran = cli("pipeline", tmp_path / "in", "-o", tmp_path / "out", "--config", tmp_path / "t.toml")
    assert ran.code == 0, ran.err
    table = read_joint_table(tmp_path / "out" / "take.csv")
    assert table.names == LANDMARKS
    assert table.frames == 10
    assert table.std is not None
    beside = json.loads((tmp_path / "out" / "take.mend.json").read_text())
    assert [step["step"] for step in beside["steps"]] == ["track", "denoise"]

    joints = np.array([landmarks(body, seen[t]) for t in range(10)])
    write_joint_table(tmp_path / "start.csv", Postures(LANDMARKS, joints[:1], np.zeros(1)))
    (tmp_path / "s.toml").write_text(
        '[track]\nmodel = "t.mend"\nskeleton = "clip.asf"\nstart = "start.csv"\n[denoise]\nmethod = "none"\n'
    )
    ran = cli("pipeline", tmp_path / "in", "-o", tmp_path / "started", "--config", tmp_path / "s.toml")
    assert ran.code == 0, ran.err
    started = read_joint_table(tmp_path / "started" / "take.csv")
    assert np.linalg.norm(started.positions[0] - joints[0], axis=1).mean() < 0.05

    dark = (DepthFrame(CAMERA, np.full(frames[0].depth.shape, np.nan, np.float32), None, t / 30.0) for t in range(3))
    write_depth_folder(tmp_path / "in" / "dark", dark, 30.0)
    ran = cli("pipeline", tmp_path / "in", "-o", tmp_path / "two", "--config", tmp_path / "s.toml")
    assert (ran.code, len(ran.failures)) == (2, 1)
    assert "one depth recording" in ran.failures[0]
    (tmp_path / "c.toml").write_text('[track]\nmodel = "t.mend"\nterms = ["surface", "color"]\n')
    chained = cli("pipeline", tmp_path / "in", "-o", tmp_path / "again", "--config", tmp_path / "c.toml")
    alone = cli(
        "track", tmp_path / "in", "-o", tmp_path / "alone", "-m", tmp_path / "t.mend", "--terms", "surface,color"
    )
    assert chained.code == alone.code == 1
    assert len(alone.failures) == 1
    assert chained.failures == alone.failures  # which say why nobody was found
    said = [json.loads((tmp_path / out / "take.mend.json").read_text())["warnings"] for out in ("alone", "again")]
    assert any("no colour" in warning for warning in said[0])
    assert {f"track: {warning}" for warning in said[0]} <= set(said[1])


@pytest.mark.parametrize("names", [one.names for one in JOINT_SETS.values()], ids=list(JOINT_SETS))
def test_joints_of_sensors_are_a_skeleton(names: tuple[str, ...]) -> None:
    assert is_skeleton(names)


OF_SKIN = ["Shoulder", "Clavicle", "Bicep", "Elbow", "Wrist", "ASIS", "Thigh", "Knee", "Shank", "Ankle", "Heel", "Toe"]


@pytest.mark.slow
def test_markers_at_joints_are_no_skeleton_and_a_trc_of_them_is_only_denoised(
    cli: Command, beginning: Motion, tmp_path: Path
) -> None:
    """Gait laboratories name markers after the joints that they lie at."""
    names = tuple(f"{side}.{name}" for side in "RL" for name in OF_SKIN)
    assert not is_skeleton(names)
    assert not is_skeleton([name for name in names if "ASIS" not in name] + ["V.Sacral"])
    marked = samples.markers(beginning)
    write(tmp_path / "walk.trc", Markers(names, marked.positions[:, : len(names)], marked.fps, up=marked.up))
    for given, out in ((tmp_path / "walk.trc", tmp_path / "made.trc"), (tmp_path, tmp_path / "out")):
        ran = cli("pipeline", given, "-o", out, "--json", "--jobs", "1")
        assert ran.code == 0, ran.err
        first = json.loads(ran.out.splitlines()[0])
        assert (first["kind"], first["steps"]) == ("recording", ["denoise"])
    assert (tmp_path / "out" / "walk.trc").exists()


@pytest.mark.parametrize("name", ["none.csv", "note.csv"])
def test_what_is_no_take_is_a_failed_input_whatever_out_is_called(cli: Command, tmp_path: Path, name: str) -> None:
    (tmp_path / "note.csv").write_text("to do\n")
    ran = cli("pipeline", tmp_path / name, "-o", tmp_path / "out.csv", "--json")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert name in ran.failures[0]
    assert json.loads(ran.out)["input"] == str(tmp_path / name)
