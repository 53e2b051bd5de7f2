"""`motionmend fit tracker` and `motionmend track`, on folders drawn of a sample clip."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from drawn_people import in_room, picture
from motionmend import load_model, samples
from motionmend.arrays import Floats
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.motion import Motion
from motionmend.bodies.performer import LANDMARKS, landmarks, standing
from motionmend.bodies.postures import Postures
from motionmend.bodies.surface import render
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.cli import main
from motionmend.cli.following import follow
from motionmend.cli.track import Follow, _skeleton
from motionmend.io import write
from motionmend.io.body_file import read_body
from motionmend.io.depth import read_depth
from motionmend.io.depth_folder import write_depth_folder
from motionmend.io.depth_recording import quarter_turned, turned_round
from motionmend.io.joint_table import read_joint_table, write_joint_table
from motionmend.track.recording import in_hindsight
from motionmend.track.settings import settings_of

CAMERA = Camera(160, 120, 142.8, 142.8, 80.0, 60.0)
FRAMES, FPS = 12, 30.0


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model, the .asf of who is filmed, a depth folder of them with its truth and start; never write here."""
    folder = tmp_path_factory.mktemp("studio")
    clip = samples.clip("reach", seconds=3.0, seed=4)
    write(folder / "clip.amc", clip)
    assert main(["fit", "tracker", str(folder / "clip.amc"), "-o", str(folder / "m.mend"), "--images", "150"]) == 0
    body = performer_of(clip.skeleton)
    step = round(clip.fps / FPS)
    poses = poses_of(Motion(clip.skeleton, clip.q[: FRAMES * step : step], FPS), body).poses
    turn = _towards_camera(clip.skeleton.up)
    seen = poses.moved(turn, np.array([0.0, -0.05, 3.0]) - turn @ poses.translation[0])
    frames = [
        DepthFrame(CAMERA, np.array(render(body, seen[t], CAMERA).depth, np.float32), None, t / FPS)
        for t in range(FRAMES)
    ]
    truth = Postures(LANDMARKS, np.array([landmarks(body, seen[t]) for t in range(FRAMES)]), np.arange(FRAMES) / FPS)
    write_depth_folder(folder / "take", frames, FPS)
    write_joint_table(folder / "truth.csv", truth)
    write_joint_table(folder / "start.csv", Postures(LANDMARKS, truth.positions[:1], truth.times[:1]))
    return folder


def _towards_camera(up: np.ndarray) -> np.ndarray:
    """A rotation that brings `up` to the camera's -y."""
    other = np.eye(3)[int(np.argmin(np.abs(up)))]
    x = np.cross(other, -up) / np.linalg.norm(np.cross(other, -up))
    return np.array([x, -up, np.cross(x, -up)])


def error_cm(cli: Command, studio: Path, made: Path) -> float:
    return float(json.loads(cli("compare", studio / "truth.csv", made, "--json").out)["mean_cm_counting_missing"])


def test_a_known_body_from_a_known_pose(cli: Command, studio: Path, tmp_path: Path) -> None:
    out = tmp_path / "take.csv"
    known = ["--skeleton", studio / "clip.asf", "--start", studio / "start.csv"]
    ran = cli("track", studio / "take", "-m", studio / "m.mend", *known, "-o", out, "--json")
    assert ran.code == 0, ran.err
    (line,) = ran.out.splitlines()
    facts = json.loads(line)
    assert (facts["frames"], facts["lost"], facts["output"]) == (FRAMES, 0, str(out))
    assert set(facts["seconds"]) >= {"startup", "read", "track", "write", "total"}
    assert set(facts["frame_ms"]) == {"median", "p95", "max"}
    assert facts["frame_ms"]["median"] <= facts["frame_ms"]["p95"] <= facts["frame_ms"]["max"]
    parts = sum(facts["seconds"][name] for name in ("startup", "read", "track", "write"))
    assert parts <= facts["seconds"]["total"] + 0.05
    assert 0.0 < facts["seconds"]["stages"]["hindsight"] < facts["seconds"]["track"]
    table = read_joint_table(out)
    assert table.names == LANDMARKS
    np.testing.assert_allclose(table.times, np.arange(FRAMES) / FPS, atol=1e-6)
    assert table.std is not None
    assert (table.std < 0.10).mean() > 0.9
    assert out.read_text().splitlines()[0].startswith("time,pelvis_x,pelvis_y,pelvis_z,chest_x")
    assert error_cm(cli, studio, out) < 3.0
    beside = json.loads((tmp_path / "take.mend.json").read_text())
    assert beside["output"] == "take.csv"
    assert set(beside["channels"]) == set(LANDMARKS)
    assert beside["model"]["file"] == "m.mend"
    assert sum(beside["channels"]["l_wrist"].values()) == FRAMES
    assert list(beside)[-1] == "seconds"


@pytest.mark.slow
def test_the_person_is_found_and_the_same_input_gives_the_same_bytes(
    cli: Command, studio: Path, tmp_path: Path
) -> None:
    given = ["track", studio / "take", "-m", studio / "m.mend", "--skeleton", studio / "clip.asf"]
    for name in ("a", "b"):
        assert cli(*given, "-o", tmp_path / name).code == 0
    first, second = (tmp_path / name / "take.csv" for name in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()
    facts = [json.loads((tmp_path / name / "take.mend.json").read_text()) for name in ("a", "b")]
    assert [one.pop("seconds") is not None for one in facts] == [True, True]
    assert facts[0] == facts[1]
    assert error_cm(cli, studio, first) < 12.0


def test_a_frame_without_the_person_is_said_to_be_so(cli: Command, studio: Path, tmp_path: Path) -> None:
    shutil.copytree(studio / "take", tmp_path / "take")
    for number in (5, 6):
        blank = [DepthFrame(CAMERA, np.full((120, 160), np.nan, np.float32))]
        write_depth_folder(tmp_path / "blank", blank, FPS)
        shutil.copy(tmp_path / "blank/depth/000000.png", tmp_path / f"take/depth/{number:06d}.png")
    (tmp_path / "take/depth/Thumbs.db").touch()
    known = ["--skeleton", studio / "clip.asf", "--start", studio / "start.csv"]
    ran = cli("track", tmp_path / "take", "-m", studio / "m.mend", *known, "-o", tmp_path / "o.csv", "--json")
    assert ran.code == 0
    assert json.loads(ran.out)["lost"] >= 2
    assert any("Thumbs.db" in warning for warning in json.loads(ran.out)["warnings"])
    table = read_joint_table(tmp_path / "o.csv")
    assert table.frames == FRAMES
    assert not table.present[5:7].any()
    assert table.present[:5].all()
    beside = json.loads((tmp_path / "o.mend.json").read_text())
    assert beside["runs"]["empty"] == [[5, 2]]
    assert all(runs["left_open"] == [[5, 2]] for runs in beside["joint_runs"].values())
    for name, counts in beside["channels"].items():
        for kind in ("filled", "left_open"):
            assert sum(run[1] for run in beside["joint_runs"][name].get(kind, [])) == counts[kind]
    assert cli("report", tmp_path / "o.csv", "-o", tmp_path / "o.html").code == 0
    page = (tmp_path / "o.html").read_text("utf-8")
    assert "o.csv: tracked from" in page
    assert f'class="left_open"><b>{beside["counts"]["left_open"]}</b>' in page


def test_frames_in_which_furniture_was_followed_are_named(studio: Path) -> None:
    model, recording, settings = load_model(studio / "m.mend"), read_depth(studio / "take"), settings_of()
    body = performer_of(samples.clip("reach", seconds=3.0, seed=4).skeleton)
    start = read_joint_table(studio / "start.csv").positions[0]
    found = follow(model, settings, recording, body, start)
    assert not found.mistaken.any()
    task = Follow("default", settings.terms, 0.0)
    assert not any("furniture" in said for said in task.warnings(recording, found))
    mistaken = np.isin(np.arange(FRAMES), [0, 1, 2, 7])
    (said,) = (one for one in task.warnings(recording, replace(found, mistaken=mistaken)) if "furniture" in one)
    assert "frames 0 to 2, 7 to 7 are left empty" in said


@pytest.mark.slow
def test_a_box_nearer_than_who_walks_is_furniture_and_that_is_said(cli: Command, studio: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    poses = [standing((x, 0.1, 2.9)) for x in np.linspace(-1.0, 0.2, FRAMES)]
    frames = []
    for k, pose in enumerate(poses):
        depth = np.array(in_room(picture(pose, CAMERA, rng=rng), rng=rng).depth)
        box = np.full((60, 48), 1.9) + 0.04 * (np.arange(48) // 2 % 2) + rng.normal(0, 0.005, (60, 48))
        depth[60:, 112:] = np.fmin(depth[60:, 112:], box.astype(np.float32))
        frames.append(DepthFrame(CAMERA, depth, None, k / FPS))
    write_depth_folder(tmp_path / "take", frames, FPS)
    ran = cli("track", tmp_path / "take", "-m", studio / "m.mend", "-o", tmp_path / "o.csv", "--json")
    assert ran.code == 0, ran.err
    assert any("taken for furniture" in warning for warning in json.loads(ran.out)["warnings"])
    pelvis = read_joint_table(tmp_path / "o.csv").positions[:, 0]
    assert np.linalg.norm(pelvis - [pose.translation for pose in poses], axis=1).max() < 0.3


@pytest.mark.slow
def test_a_blank_first_image_costs_itself_alone_and_is_said(cli: Command, studio: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frames = []
    for k, x in enumerate(np.linspace(-0.3, 0.3, FRAMES)):
        depth = in_room(picture(standing((x, 0.1, 2.9)), CAMERA, rng=rng), rng=rng).depth
        frames.append(DepthFrame(CAMERA, np.full(depth.shape, np.nan) if k == 0 else depth, None, k / FPS))
    write_depth_folder(tmp_path / "take", frames, FPS)
    ran = cli("track", tmp_path / "take", "-m", studio / "m.mend", "-o", tmp_path / "o.csv", "--json")
    assert ran.code == 0, ran.err
    facts = json.loads(ran.out)
    assert facts["lost"] == 1
    (said,) = (warning for warning in facts["warnings"] if "blank or damaged" in warning)
    assert "frames 0 to 0 " in said
    assert read_joint_table(tmp_path / "o.csv").present[1:].all()


@pytest.mark.slow
def test_a_body_is_measured_once_and_used_again(cli: Command, studio: Path, tmp_path: Path) -> None:
    body = tmp_path / "people" / "new" / "body.json"
    given = ["track", studio / "take", "-m", studio / "m.mend", "--body", body, "--start", studio / "start.csv"]
    assert cli(*given, "-o", tmp_path / "a.csv").code == 0
    stored = body.read_bytes()
    read_body(body)
    assert cli(*given, "-o", tmp_path / "b.csv").code == 0
    assert body.read_bytes() == stored
    lengths = [json.loads((tmp_path / f"{name}.mend.json").read_text())["bone_lengths_m"] for name in "ab"]
    assert lengths[0] == lengths[1]


@pytest.mark.slow
def test_a_start_that_is_not_where_the_person_is_is_said(cli: Command, studio: Path, tmp_path: Path) -> None:
    start = read_joint_table(studio / "start.csv")
    upright = start.positions * np.array([1.0, -1.0, 1.0])  # y up, as sensors' skeletons have it
    write_joint_table(tmp_path / "up.csv", Postures(LANDMARKS, upright, start.times))
    given = ["track", studio / "take", "-m", studio / "m.mend", "--skeleton", studio / "clip.asf", "--json"]
    for name, where, doubted in (("fine", studio / "start.csv", False), ("up", tmp_path / "up.csv", True)):
        ran = cli(*given, "--start", where, "-o", tmp_path / f"{name}_tracked.csv")
        assert ran.code == 0
        warnings = json.loads(ran.out)["warnings"]
        assert any("--start are" in one and "not believed" in one for one in warnings) == doubted
        assert json.loads((tmp_path / f"{name}_tracked.mend.json").read_text())["warnings"] == warnings


def test_a_damaged_colour_image_fails_only_who_looks_at_colour(cli: Command, studio: Path, tmp_path: Path) -> None:
    shutil.copytree(studio / "take", tmp_path / "take")
    (tmp_path / "take" / "color").mkdir()
    (tmp_path / "take" / "color" / "000003.png").write_bytes(b"no image")
    given = "track", tmp_path / "take", "-m", studio / "m.mend", "--skeleton", studio / "clip.asf"
    given += "--start", studio / "start.csv", "--force", "-o", tmp_path / "o.csv"
    assert cli(*given).code == 0
    looked = cli(*given, "--terms", "surface,color")
    assert (looked.code, len(looked.failures)) == (1, 1)
    assert "000003.png" in looked.failures[0]


def test_a_start_where_nobody_is_is_said(cli: Command, studio: Path, tmp_path: Path) -> None:
    take = read_depth(studio / "take")
    empty = DepthFrame(CAMERA, np.full((120, 160), np.nan, np.float32), None, 0.0)
    frames = [empty, *(replace(take.frame(k), time=(k + 1) / FPS) for k in range(FRAMES - 1))]
    write_depth_folder(tmp_path / "late", frames, FPS)
    known = ["--skeleton", studio / "clip.asf", "--start", studio / "start.csv"]
    ran = cli("track", tmp_path / "late", "-m", studio / "m.mend", *known, "-o", tmp_path / "o.csv", "--json")
    assert ran.code == 0
    assert any("nobody was found in frame 0" in one for one in json.loads(ran.out)["warnings"])


@pytest.mark.slow
def test_what_was_supposed_of_the_skeleton_is_said(cli: Command, studio: Path, tmp_path: Path) -> None:
    text = (studio / "clip.asf").read_text()
    unsaid = "\n".join(line for line in text.splitlines() if "metres per length unit" not in line)
    (tmp_path / "unsaid.asf").write_text(unsaid)
    given = ["track", studio / "take", "-m", studio / "m.mend", "--start", studio / "start.csv", "--json"]
    ran = cli(*given, "--skeleton", tmp_path / "unsaid.asf", "-o", tmp_path / "o.csv")
    assert ran.code == 0
    guesses = json.loads(ran.out)["guesses"]
    assert any(one.startswith("unsaid.asf: length") and "unit of length" in one for one in guesses)
    assert json.loads((tmp_path / "o.mend.json").read_text())["guesses"] == guesses
    assert "unit of length" in ran.err
    for unit, named in ((1.0, "nobody was found"), (400.0, "tiny.asf: a performer's")):
        (tmp_path / "tiny.asf").write_text(unsaid.replace("length 0.45", f"length {unit}"))
        failed = cli(*given[:4], "--skeleton", tmp_path / "tiny.asf", "-o", tmp_path / "t.csv")
        assert (failed.code, len(failed.failures)) == (1, 1)
        assert named in failed.failures[0]
        assert "lengths may be wrong" in failed.failures[0]


def test_of_a_recording_given_as_skeleton_all_but_its_rate_is_said(tmp_path: Path) -> None:
    clip = samples.clip("walk", seconds=0.2)
    for ending in ("amc", "bvh"):
        write(tmp_path / f"at_120Hz.{ending}", clip)
    acclaim = (tmp_path / "at_120Hz.asf").read_text().splitlines()
    unsaid = "\n".join(line for line in acclaim if "metres per length unit" not in line)
    (tmp_path / "at_120Hz.asf").write_text(unsaid)
    bvh = (tmp_path / "at_120Hz.bvh").read_text()
    (tmp_path / "at_120Hz.bvh").write_text(re.sub(r"Frame Time: \S+", "Frame Time: 0.0083", bvh))
    for ending, first in (("amc", "at_120Hz.asf: length"), ("bvh", "at_120Hz.bvh: no length unit")):
        skeleton, supposed = _skeleton(tmp_path / f"at_120Hz.{ending}")
        assert len(skeleton.dof_names) > 50
        assert supposed[0].startswith(first)
        assert not any("rate" in one or "Frame Time" in one for one in supposed)


@pytest.mark.slow
def test_the_first_recording_with_somebody_in_it_gives_the_body(cli: Command, studio: Path, tmp_path: Path) -> None:
    nobody = (DepthFrame(CAMERA, np.full((120, 160), np.nan, np.float32), None, t / FPS) for t in range(3))
    write_depth_folder(tmp_path / "in" / "a_nobody", nobody, FPS)
    for name in ("b", "c"):
        shutil.copytree(studio / "take", tmp_path / "in" / name)
    given = ["track", tmp_path / "in", "-m", studio / "m.mend", "--body", tmp_path / "b.json", "--jobs", "2"]
    ran = cli(*given, "-o", tmp_path / "out")
    assert ran.code == 1
    assert len(ran.failures) == 1
    read_body(tmp_path / "b.json")
    facts = [json.loads((tmp_path / "out" / f"{name}.mend.json").read_text()) for name in "bc"]
    assert facts[0]["bone_lengths_m"] == facts[1]["bone_lengths_m"]


def test_a_mirrored_recording_keeps_the_persons_left_and_right(cli: Command, studio: Path, tmp_path: Path) -> None:
    plain = read_depth(studio / "take")
    mirrored = (turned_round(frame) for frame in plain)
    write_depth_folder(tmp_path / "take", mirrored, FPS)
    camera = json.loads((tmp_path / "take/camera.json").read_text())
    (tmp_path / "take/camera.json").write_text(json.dumps({**camera, "mirrored": True}))
    first = read_joint_table(studio / "start.csv")
    flip = np.array([-1.0, 1.0, 1.0])
    write_joint_table(tmp_path / "start.csv", first.with_positions(first.positions * flip))
    given = ["-m", studio / "m.mend", "--skeleton", studio / "clip.asf"]
    for place, start, out in ((tmp_path, tmp_path, "m.csv"), (studio, studio, "p.csv")):
        ran = cli("track", place / "take", *given, "--start", start / "start.csv", "-o", tmp_path / out)
        assert ran.code == 0
    one, other = (read_joint_table(tmp_path / name).positions for name in ("m.csv", "p.csv"))
    np.testing.assert_allclose(one * flip, other, atol=1e-3)


def test_a_camera_on_its_side_gives_the_same_joints_turned(cli: Command, studio: Path, tmp_path: Path) -> None:
    write_depth_folder(tmp_path / "take", (quarter_turned(frame) for frame in read_depth(studio / "take")), FPS)
    camera = json.loads((tmp_path / "take/camera.json").read_text())
    (tmp_path / "take/camera.json").write_text(json.dumps({**camera, "up": "right"}))
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # rows: (x, y, z) becomes (-y, x, z)
    first = read_joint_table(studio / "start.csv")
    write_joint_table(tmp_path / "start.csv", first.with_positions(first.positions @ turn))
    given = ["-m", studio / "m.mend", "--skeleton", studio / "clip.asf"]
    for place, start, out in ((tmp_path, tmp_path, "t.csv"), (studio, studio, "p.csv")):
        ran = cli("track", place / "take", *given, "--start", start / "start.csv", "-o", tmp_path / out)
        assert ran.code == 0
    one, other = (read_joint_table(tmp_path / name).positions for name in ("t.csv", "p.csv"))
    np.testing.assert_allclose(one, other @ turn, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["bvh", "amc"])
def test_joint_angles_say_the_same_as_joints(cli: Command, studio: Path, tmp_path: Path, form: str) -> None:
    known = ["--skeleton", studio / "clip.asf", "--start", studio / "start.csv"]
    given = ["track", studio / "take", "-m", studio / "m.mend", *known, "--format"]
    assert cli(*given, form, "-o", tmp_path / "angles").code == 0
    assert cli(*given, "csv", "-o", tmp_path / "joints").code == 0
    ran = cli("compare", tmp_path / "joints" / "take.csv", tmp_path / "angles" / f"take.{form}", "--json")
    facts = json.loads(ran.out)
    assert facts["frames"] == FRAMES
    assert facts["mean_cm"] < 1.0
    made = tmp_path / "angles" / f"take.{form}"
    for number, given in enumerate([[made], [studio / "take", made]]):
        ran = cli("report", *given, "-o", tmp_path / f"page{number}.html")
        assert ran.code == 0, ran.err
        assert "tracked from" in (tmp_path / f"page{number}.html").read_text("utf-8")


def bad_copy(studio: Path, folder: Path, kind: str) -> Path:
    place = folder / kind
    shutil.copytree(studio / "take", place)
    image = place / "depth/000003.png"
    if kind == "no_camera":
        (place / "camera.json").unlink()
    elif kind == "cut_off":
        image.write_bytes(image.read_bytes()[:200])
    elif kind == "missing_number":
        image.unlink()
    else:
        blank = [DepthFrame(CAMERA, np.full((120, 160), np.nan, np.float32))] * FRAMES
        write_depth_folder(place, (DepthFrame(CAMERA, b.depth, None, k / FPS) for k, b in enumerate(blank)), FPS)
    return place


def test_bad_folders_are_a_line_each_and_the_others_are_done(cli: Command, studio: Path, tmp_path: Path) -> None:
    kinds = ("no_camera", "cut_off", "missing_number", "all_zero")
    bad = [bad_copy(studio, tmp_path / "in", kind) for kind in kinds]
    known = ["-m", studio / "m.mend", "--skeleton", studio / "clip.asf"]
    ran = cli("track", *bad, studio / "take", *known, "-o", tmp_path / "out", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == len(kinds)
    for kind in kinds:
        assert sum(kind in line for line in ran.failures) == 1, kind
    assert files_below(tmp_path / "out") == {"take.csv", "take.mend.json"}
    assert any("nobody" in line for line in ran.failures)
    assert cli("track", *bad, *known, "-o", tmp_path / "new" / "out", "--jobs", "1").code == 1
    assert not (tmp_path / "new").exists()


def test_nothing_is_overwritten_and_what_is_finished_is_skipped(cli: Command, studio: Path, tmp_path: Path) -> None:
    out = tmp_path / "take.csv"
    out.write_text("mine")
    (tmp_path / "take.mend.json").write_text("{}")
    given = ["track", studio / "take", "-m", studio / "m.mend", "-o", out]
    ran = cli(*given)
    assert (ran.code, out.read_text()) == (1, "mine")
    assert "--force" in ran.failures[0]
    ran = cli(*given, "--resume", "--json")
    assert (ran.code, out.read_text()) == (0, "mine")
    assert json.loads(ran.out)["skipped"]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--terms", "surface,magic"], "--terms"),
        (["--terms", "color,edge"], "chooses among its matches"),
        (["--preset", "best"], "--preset"),
        (["--format", "fbx"], "--format"),
        (["-o", "x.txt"], ".csv"),
    ],
)
def test_bad_usage(cli: Command, studio: Path, more: list[str], said: str) -> None:
    ran = cli("track", studio / "take", "-m", studio / "m.mend", *([] if "-o" in more else ["-o", "x.csv"]), *more)
    assert ran.code == 2
    assert said in ran.failures[0]


def test_what_is_no_start_no_model_no_body(cli: Command, studio: Path, library: Path, tmp_path: Path) -> None:
    (tmp_path / "start.csv").write_text("time,nose_x,nose_y,nose_z\n0,1,2,3\n")
    (tmp_path / "body.json").write_text("{}")
    shutil.copy(studio / "truth.csv", tmp_path / "rows.csv")  # more than one row
    columns = ",".join(f"{joint}_{axis}" for joint in ("head", "pelvis", "l_knee") for axis in "xyz")
    (tmp_path / "mm.csv").write_text(f"time,{columns}\n0,0,-800,3000,0,0,3000,150,400,2900\n")
    (tmp_path / "behind.csv").write_text(f"time,{columns}\n0,0,-0.8,-3,0,0,-3,0.15,0.4,-3.1\n")
    given = ["track", studio / "take", "-o", tmp_path / "o.csv"]
    for more, said in (
        (["-m", studio / "m.mend", "--start", tmp_path / "start.csv"], "start.csv"),
        (["-m", studio / "m.mend", "--start", tmp_path / "mm.csv"], "mm.csv: joints in m were wanted"),
        (["-m", studio / "m.mend", "--start", tmp_path / "behind.csv"], "behind.csv: joints before the camera were"),
        (["-m", studio / "m.mend", "--skeleton", studio / "truth.csv"], "truth.csv: wanted a skeleton (.asf or .bvh)"),
        (
            ["-m", studio / "m.mend", "--start", tmp_path / "rows.csv"],
            f"rows.csv: one row was wanted, the pose of frame 0, came {FRAMES}",
        ),
        (["-m", studio / "m.mend", "--body", tmp_path / "body.json"], "body.json"),
        (["-m", studio / "m.mend", "--body", tmp_path / "body.json" / "a" / "b.json"], "b.json: its folder"),
        (["-m", library / "amc.mend"], "amc.mend"),
        (["-m", tmp_path / "none.mend"], "none.mend"),
    ):
        ran = cli(*given, *more)
        assert (ran.code, len(ran.failures)) == (1, 1)
        assert said in ran.failures[0]
    assert not (tmp_path / "o.csv").exists()


def test_a_folder_that_is_not_there_or_holds_nothing(cli: Command, studio: Path, tmp_path: Path) -> None:
    (tmp_path / "w").mkdir()
    for place in (tmp_path / "none", tmp_path / "w"):
        ran = cli("track", place, "-m", studio / "m.mend", "-o", tmp_path / "o.csv")
        assert (ran.code, len(ran.failures)) == (1, 1)
        assert str(place) in ran.failures[0]


def test_the_model_is_told_of(cli: Command, studio: Path) -> None:
    facts = json.loads(cli("inspect", studio / "m.mend", "--json").out)
    assert (facts["kind"], facts["model"], facts["detector"]) == ("model", "tracker", True)
    assert facts["poses"] > 50


@pytest.mark.slow
def test_fit_leaves_out_what_it_cannot_use(cli: Command, studio: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.amc").write_text("nothing")
    out = tmp_path / "m.mend"
    ran = cli("fit", "tracker", studio / "clip.amc", tmp_path / "bad.amc", "-o", out, "--images", "0", "--json")
    assert (ran.code, len(ran.failures)) == (1, 1)
    facts = json.loads(ran.out)
    assert (facts["kind"], facts["clips"], facts["failed"]) == ("tracker", 1, 1)
    assert [one["input"] for one in facts["failures"]] == [str(tmp_path / "bad.amc")]
    assert facts["failures"][0]["error"] in ran.failures[0]
    assert out.exists()
    again = cli("fit", "tracker", studio / "clip.amc", "-o", out, "--images", "0")
    assert again.code == 1
    assert "--force" in again.failures[0]
    first = out.read_bytes()
    assert cli("fit", "tracker", studio / "clip.amc", "-o", out, "--images", "0", "--force").code == 0
    assert out.read_bytes() == first


def test_doubt_about_front_and_back_goes_where_it_was_settled_later_and_stays_where_it_was_right():
    settled = np.full((12, 16), 0.02)
    std = settled.copy()
    std[1:4, 5:9] = std[5:7, 5:9] = std[9:, 5:9] = 0.2
    ahead = np.tile([0.0, 0.0, -1.0], (12, 1))
    ahead[7:] *= -1.0  # the other reading was taken
    changed = np.where((std > settled).any(axis=1), 0.5, 0.0)
    told = in_hindsight(std, settled, np.zeros((12, 16, 3)), ahead, np.ones(12, bool), changed)
    np.testing.assert_array_equal(told[:5], settled[:5])
    np.testing.assert_array_equal(told[5:], std[5:])


def test_what_is_known_of_front_and_back_in_the_end_goes_for_all_frames_of_that_reading():
    settled, places = np.full((9, 16), 0.02), np.zeros((9, 16, 3))
    places[:, [LANDMARKS.index("l_wrist"), LANDMARKS.index("r_wrist")], 0] = 0.3, -0.3
    ahead, wrist = np.tile([0.0, 0.0, -1.0], (9, 1)), LANDMARKS.index("l_wrist")
    seen = np.ones(9, bool)

    def told(*changed: float) -> Floats:
        share = np.array(changed)[:, None]
        std = np.hypot(settled, np.sqrt(share * (1.0 - share)) * (np.arange(16) == wrist) * 0.6 / np.sqrt(3.0))
        return in_hindsight(std, settled, places, ahead, seen, np.array(changed))[:, wrist]

    sure_later = told(0.4, 0.4, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(sure_later, 0.02)
    unsure_later = told(0.0, 0.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1)
    np.testing.assert_allclose(unsure_later, np.hypot(0.02, 0.3 * 0.6 / np.sqrt(3.0)))
    seen[3] = False  # of who comes back nothing is known of before
    np.testing.assert_allclose(told(*[0.0] * 4, *[0.1] * 5)[:3], 0.02)
    seen[3] = True
    ahead[5:] *= -1.0  # the other reading was taken: that before is as likely wrong as right
    np.testing.assert_allclose(told(*[0.01] * 9)[:5], np.hypot(0.02, 0.5 * 0.6 / np.sqrt(3.0)))
    assert told(*[0.01] * 9)[5:].max() < 0.05
