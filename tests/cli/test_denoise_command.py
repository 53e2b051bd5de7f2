"""`motionmend denoise` from files to files."""

import hashlib
import json
import shutil
import struct
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend.bodies.motion import Markers, Motion
from motionmend.cli import main
from motionmend.io import read, write

AMC = "amc.mend"


def without_seconds(sidecar: Path) -> dict[str, object]:
    facts = json.loads(sidecar.read_text("utf-8"))
    assert list(facts)[-1] == "seconds"
    del facts["seconds"]
    return facts


@pytest.fixture(scope="module")
def mended(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both takes repaired by their models, as clean.amc and clean.c3d, each in a folder of its kind; look, no more."""
    folder = tmp_path_factory.mktemp("mended")
    for kind in ("amc", "c3d"):
        made = folder / kind / f"clean.{kind}"
        assert (
            main(["denoise", str(library / f"take.{kind}"), "-m", str(library / f"{kind}.mend"), "-o", str(made)]) == 0
        )
    return folder


@pytest.fixture(scope="module")
def short(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two thirds of a second of both takes, for what is the same of any recording; never write here."""
    folder = tmp_path_factory.mktemp("short")
    angles, markers = read(library / "take.amc"), read(library / "take.c3d")
    assert isinstance(angles, Motion)
    assert isinstance(markers, Markers)
    write(folder / "take.amc", replace(angles, q=angles.q[:80]))
    write(folder / "take.c3d", replace(markers, positions=markers.positions[:80], residuals=None, source=None))
    return folder


@pytest.mark.slow
def test_rate_frames_and_channels_come_through(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("denoise", library / "take.amc", "-m", library / AMC, "-o", tmp_path / "new" / "clean.amc")
    assert (ran.code, ran.out) == (0, "")
    taken, mended = read(library / "take.amc"), read(tmp_path / "new" / "clean.amc")
    assert (mended.frames, mended.fps, mended.channels) == (taken.frames, taken.fps, taken.channels)
    assert mended.present.all()
    assert {"clean.amc", "clean.mend.json"} <= files_below(tmp_path / "new")


@pytest.mark.slow
def test_the_sidecar_accounts_for_every_sample(library: Path, mended: Path) -> None:
    facts = without_seconds(mended / "c3d" / "clean.mend.json")
    taken, made = read(library / "take.c3d"), read(mended / "c3d" / "clean.c3d")
    assert (facts["input"], facts["frames"], facts["fps"]) == ("take.c3d", taken.frames, taken.fps)
    assert facts["model"]["file"] == "c3d.mend"
    assert facts["model"]["sha256"] == hashlib.sha256((library / "c3d.mend").read_bytes()).hexdigest()
    assert list(facts["channels"]) == list(taken.channels)
    for c, (name, counts) in enumerate(facts["channels"].items()):
        missing = int((~taken.present[:, c]).sum())
        assert sum(counts.values()) == taken.frames
        assert counts["filled"] + counts["left_open"] == missing
        for origin, runs in facts["runs"].get(name, {}).items():
            assert sum(frames for _, frames, *_ in runs) == counts[origin]
            assert all(np.size(std) in (1, frames) for _, frames, *std in runs if std)
        assert int((~made.present[:, c]).sum()) == counts["left_open"]
        assert facts["std"][name]["unit"] == "m"
    assert facts["counts"]["filled"] > 0


@pytest.mark.slow
def test_the_repair_is_better_than_the_take(cli: Command, library: Path, mended: Path) -> None:
    errors = [
        json.loads(cli("compare", library / "clean.amc", other, "--json").out)["rms_deg"]
        for other in (library / "take.amc", mended / "amc" / "clean.amc")
    ]
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.slow
def test_a_folder_in_is_the_same_tree_out_and_a_bad_file_harms_no_other(
    cli: Command, library: Path, takes: Path, tmp_path: Path
) -> None:
    whole = (library / "take.amc").read_bytes()
    (takes / "cut.amc").write_bytes(whole[: 2 * len(whole) // 3 - 5])
    (takes / "day2" / "empty.amc").touch()
    (takes / "day2" / "text.amc").write_text("to be or not to be\n")
    (takes / "none.c3d").write_bytes(b"\x00" * 600)
    ran = cli("denoise", takes, "-m", library / AMC, "-o", tmp_path / "out", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 4
    for name in ("cut.amc", "empty.amc", "text.amc", "none.c3d"):
        assert sum(name in line for line in ran.err.splitlines()) == 1
    made = {name for name in files_below(tmp_path / "out") if not name.endswith(".asf")}
    assert made == {"take.amc", "take.mend.json", "day2/clean.amc", "day2/clean.mend.json"}


@pytest.mark.slow
def test_jobs_do_not_change_a_byte(cli: Command, library: Path, short: Path, tmp_path: Path) -> None:
    for place in (tmp_path / "in" / "day2", tmp_path / "in"):
        shutil.copytree(short, place, ignore=shutil.ignore_patterns("*.c3d"), dirs_exist_ok=True)
    given = ["denoise", tmp_path / "in", "-m", library / AMC, "--report", "--json"]
    for jobs in ("1", "2"):
        ran = cli(*given, "-o", tmp_path / jobs, "--jobs", jobs)
        assert ran.code == 0
        said = [Path(json.loads(line)["output"]) for line in ran.out.splitlines()]
        assert said == [tmp_path / jobs / "day2" / "take.amc", tmp_path / jobs / "take.amc"]
    one, two = files_below(tmp_path / "1"), files_below(tmp_path / "2")
    assert one == two
    assert sum(name.endswith(".report.html") for name in one) == 2
    for name in one:
        if name.endswith(".mend.json"):
            assert without_seconds(tmp_path / "1" / name) == without_seconds(tmp_path / "2" / name)
        else:
            assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes(), name


def test_nothing_is_overwritten_without_force(cli: Command, library: Path, tmp_path: Path) -> None:
    out = tmp_path / "clean.amc"
    out.write_text("mine")
    refused = cli("denoise", library / "take.amc", "--method", "linear", "-o", out)
    assert refused.code == 1
    assert len(refused.failures) == 1
    assert "clean.amc" in refused.err
    assert (out.read_text(), files_below(tmp_path)) == ("mine", {"clean.amc"})
    forced = cli("denoise", library / "take.amc", "--method", "linear", "-o", out, "--force")
    assert forced.code == 0
    assert read(out).frames == read(library / "take.amc").frames


def test_resume_does_what_is_left(cli: Command, library: Path, takes: Path, tmp_path: Path) -> None:
    command = ["denoise", takes, "--method", "linear", "-o", tmp_path / "out", "--jobs", "1"]
    assert cli(*command).code == 0
    kept, lost = tmp_path / "out" / "take.amc", tmp_path / "out" / "day2" / "clean.amc"
    before = kept.stat().st_mtime_ns
    content = lost.read_bytes()
    lost.unlink()
    assert cli(*command).code == 1
    ran = cli(*command, "--resume", "--json")
    assert ran.code == 0
    said = [json.loads(line) for line in ran.out.splitlines()]
    assert [one.get("skipped", False) for one in said] == [False, True]
    assert kept.stat().st_mtime_ns == before
    assert lost.read_bytes() == content


def test_resume_does_again_what_has_lost_its_record(cli: Command, library: Path, tmp_path: Path) -> None:
    command = ["denoise", library / "take.amc", "--method", "linear", "-o", tmp_path / "out.amc"]
    assert cli(*command).code == 0
    record, content = tmp_path / "out.mend.json", (tmp_path / "out.amc").read_bytes()
    record.unlink()
    ran = cli(*command, "--resume", "--json")
    assert ran.code == 0
    assert not json.loads(ran.out).get("skipped", False)
    assert json.loads(record.read_text())["method"] == "linear"
    assert (tmp_path / "out.amc").read_bytes() == content
    assert json.loads(cli(*command, "--resume", "--json").out)["skipped"]


def test_an_input_is_never_its_own_output(cli: Command, takes: Path) -> None:
    before = {name: (takes / name).read_bytes() for name in files_below(takes)}
    for arguments in (
        [takes, "-o", takes],
        [takes / "take.amc", "-o", takes / "take.amc"],
        [takes / "take.amc", "-o", takes],
        [takes, takes / "take.amc", "-o", takes.parent],
    ):
        ran = cli("denoise", *arguments, "--method", "linear", "--force", "--jobs", "1")
        assert ran.code == 1
        assert "input" in ran.err
    assert {name: (takes / name).read_bytes() for name in files_below(takes)} == before


def test_outputs_inside_the_folder_are_not_taken_for_inputs(cli: Command, takes: Path) -> None:
    command = ["denoise", takes, "--method", "linear", "-o", takes / "out", "--jobs", "1"]
    assert cli(*command).code == 0
    made = files_below(takes)
    ran = cli(*command, "--force")
    assert ran.code == 0
    assert "left out" in ran.err
    assert files_below(takes) == made


@pytest.mark.slow
def test_json_is_pure_and_one_object_for_each_input(cli: Command, library: Path, takes: Path, tmp_path: Path) -> None:
    (takes / "bad.amc").touch()
    ran = cli("denoise", takes, takes / "none.amc", "-m", library / AMC, "-o", tmp_path / "out", "--json")
    assert ran.code == 1
    said = {Path(one["input"]).name: one for one in map(json.loads, ran.out.splitlines())}
    assert set(said) == {"none.amc", "bad.amc", "take.amc", "clean.amc"}
    assert "error" in said["bad.amc"]
    done = said["take.amc"]
    assert set(done["seconds"]) == {"startup", "read", "repair", "write", "total"}
    assert done["seconds"]["total"] >= done["seconds"]["repair"] > 0
    assert done["frame_ms"]["mean"] == pytest.approx(1000 * done["seconds"]["repair"] / done["frames"])
    assert done["frame_ms"] == dict.fromkeys(("mean", "median", "p95", "max"), done["frame_ms"]["mean"])
    assert done["output"] == str(tmp_path / "out" / "takes" / "take.amc")
    assert sum(done["counts"].values()) == done["frames"] * 62
    assert isinstance(done["warnings"], list)


def test_a_model_of_other_channels_is_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    for take, model in (("take.c3d", AMC), ("take.amc", "c3d.mend")):
        ran = cli("denoise", library / take, "-m", library / model, "-o", tmp_path / take)
        assert ran.code == 1
        assert len(ran.failures) == 1
        assert take in ran.failures[0]
    assert files_below(tmp_path) == set()


def test_markers_of_another_set_are_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    taken = read(library / "take.c3d")
    assert isinstance(taken, Markers)
    strange = tuple(f"OTHER{m}" for m in range(len(taken.names)))
    write(tmp_path / "strange.c3d", Markers(strange, taken.positions, taken.fps))
    ran = cli("denoise", tmp_path / "strange.c3d", "-m", library / "c3d.mend", "-o", tmp_path / "out.c3d")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "strange.c3d" in ran.err
    assert files_below(tmp_path) == {"strange.c3d"}


def test_an_amc_with_another_number_of_channels_is_one_line(cli: Command, takes: Path, tmp_path: Path) -> None:
    text = (takes / "take.amc").read_text()
    lines = text.splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("root "))
    lines[first] += " 0.5"
    (takes / "wide.amc").write_text("\n".join(lines) + "\n")
    ran = cli("denoise", takes / "wide.amc", "--method", "linear", "-o", tmp_path / "wide.amc")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "wide.amc" in ran.err


def test_missing_samples_of_an_amc_are_filled(cli: Command, takes: Path, tmp_path: Path) -> None:
    lines = (takes / "take.amc").read_text().splitlines()
    at = [n for n, line in enumerate(lines) if line.startswith("head ")][10:20]
    for n in at:
        lines[n] = "head nan nan nan"
    (takes / "gaps.amc").write_text("\n".join(lines) + "\n")
    assert cli("denoise", takes / "gaps.amc", "--method", "spline", "-o", tmp_path / "filled.amc").code == 0
    facts = json.loads((tmp_path / "filled.mend.json").read_text())
    assert facts["channels"]["head.rx"]["filled"] >= 10
    assert np.isfinite(read(tmp_path / "filled.amc").present).all()


@pytest.mark.parametrize("damage", ["flip", "cut", "empty", "text", "absent"])
def test_a_damaged_model_is_one_line(cli: Command, library: Path, tmp_path: Path, damage: str) -> None:
    content = bytearray((library / AMC).read_bytes())
    content[len(content) // 2] ^= 1
    model = tmp_path / "broken.mend"
    if damage == "flip":
        model.write_bytes(content)
    elif damage == "cut":
        model.write_bytes(content[: len(content) // 2])
    elif damage != "absent":
        model.write_bytes(b"a model\n" if damage == "text" else b"")
    ran = cli("denoise", library / "take.amc", "-m", model, "-o", tmp_path / "clean.amc")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "broken.mend" in ran.err
    assert "clean.amc" not in files_below(tmp_path)


def test_what_a_format_cannot_hold_is_refused(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("denoise", library / "take.amc", "--method", "linear", "-o", tmp_path / "clean.c3d")
    assert ran.code == 2
    assert files_below(tmp_path) == set()


def test_a_folder_that_holds_nothing_is_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    (tmp_path / "nothing").mkdir()
    ran = cli("denoise", tmp_path / "nothing", "-m", library / AMC, "-o", tmp_path / "out")
    assert ran.code == 1
    assert len(ran.failures) == 1


def test_a_guess_is_told_and_kept(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("denoise", library / "take.amc", "--method", "linear", "-o", tmp_path / "a.amc")
    assert "120 Hz" in ran.err
    assert any("120 Hz" in guess for guess in without_seconds(tmp_path / "a.mend.json")["guesses"])
    ran = cli("denoise", library / "take.amc", "--method", "linear", "-o", tmp_path / "b.amc", "--fps", "60")
    assert "120 Hz" not in ran.err
    assert without_seconds(tmp_path / "b.mend.json")["fps"] == 60


@pytest.mark.slow
@pytest.mark.parametrize("robust", ["tukey", "square"])
def test_options_stand_in_the_sidecar(cli: Command, library: Path, short: Path, tmp_path: Path, robust: str) -> None:
    command = ["denoise", short / "take.amc", "-m", library / AMC, "--robust", robust, "--footskate"]
    command += ["--max-std", "25"]
    assert cli(*command, "-o", tmp_path / "a.amc").code == 0
    options = without_seconds(tmp_path / "a.mend.json")["options"]
    told = {"method": "adaptive", "robust": robust, "max_std": 25.0, "lag": None, "footskate": True}
    assert options == told | {"fps": None, "skeleton": None}


@pytest.mark.slow
def test_what_is_filled_but_hardly_known_is_said_unless_a_limit_leaves_it_open(
    cli: Command, library: Path, tmp_path: Path
) -> None:
    taken = read(library / "take.amc")
    assert isinstance(taken, Motion)
    legs = [c for c, name in enumerate(taken.channels) if name.startswith(("lfemur", "ltibia", "lfoot"))]
    q = taken.q.copy()
    q[np.ix_(range(taken.frames // 3, taken.frames // 3 + int(taken.fps)), legs)] = np.nan
    write(tmp_path / "gone.amc", replace(taken, q=q))
    ran = cli("denoise", tmp_path / "gone.amc", "-o", tmp_path / "all.amc", "--report")
    (said,) = [one for one in without_seconds(tmp_path / "all.mend.json")["warnings"] if "less sure than 10 deg" in one]
    assert said in " ".join(ran.err.split())
    assert "lfemur" in said
    page = (tmp_path / "all.report.html").read_text()
    assert all(escape(one) in page for one in without_seconds(tmp_path / "all.mend.json")["warnings"])
    assert cli("denoise", tmp_path / "gone.amc", "-o", tmp_path / "some.amc", "--max-std", "5").code == 0
    held = without_seconds(tmp_path / "some.mend.json")["warnings"]
    assert not any("less sure" in one for one in held)


@pytest.mark.slow
def test_the_default_says_what_it_found_in_the_recording(
    cli: Command, library: Path, mended: Path, tmp_path: Path
) -> None:
    for kind, unit, told in (("amc", "deg", 2.0), ("c3d", "m", 0.005)):  # the noise `library` put in
        facts = without_seconds(mended / kind / "clean.mend.json")
        assert facts["method"] == "adaptive"
        assert list(facts["noise"]) == list(facts["channels"])
        of_kind = [found for found in facts["noise"].values() if found["unit"] == unit]
        assert 0.5 * told < np.median([found["value"] for found in of_kind]) < 1.5 * told
        assert 0.02 < np.mean([found["outliers"] for found in of_kind]) < 0.08
    assert cli("denoise", library / "take.amc", "--method", "linear", "-o", tmp_path / "filled.amc").code == 0
    assert without_seconds(tmp_path / "filled.mend.json")["noise"] is None


@pytest.mark.slow
def test_without_a_model_a_recording_is_repaired_by_what_it_shows(cli: Command, library: Path, tmp_path: Path) -> None:
    assert cli("denoise", library / "take.amc", "-o", tmp_path / "clean.amc").code == 0
    facts = without_seconds(tmp_path / "clean.mend.json")
    assert (facts["method"], facts["model"]) == ("adaptive", None)
    errors = [
        json.loads(cli("compare", library / "clean.amc", other, "--json").out)["rms_deg"]
        for other in (library / "take.amc", tmp_path / "clean.amc")
    ]
    assert errors[1] < 0.8 * errors[0]


@pytest.mark.slow
def test_a_lag_gives_what_a_live_repair_gives_and_says_how_late(
    cli: Command, library: Path, short: Path, tmp_path: Path
) -> None:
    from motionmend.denoise.fixed_lag import FixedLag, joined
    from motionmend.denoise.fixed_lag import finish as finish_live
    from motionmend.denoise.fixed_lag import start as start_live
    from motionmend.denoise.fixed_lag import step as step_live
    from motionmend.models import load_model

    long = read(library / "take.amc")
    assert isinstance(long, Motion)
    write(tmp_path / "take.amc", replace(long, q=long.q[:100]))
    taken, out = read(tmp_path / "take.amc"), tmp_path / "live.amc"
    assert isinstance(taken, Motion)
    ran = cli("denoise", tmp_path / "take.amc", "-m", library / AMC, "-o", out, "--lag", "0.4", "--json")
    assert ran.code == 0
    said, facts = json.loads(ran.out), without_seconds(tmp_path / "live.mend.json")
    # the last of the frames given out together waits for the lag, the first for the others too
    assert said["latency_s"] == pytest.approx((round(0.4 * taken.fps) + round(0.25 * taken.fps) - 1) / taken.fps)
    assert (facts["latency_s"], facts["options"]["lag"]) == (said["latency_s"], 0.4)
    state, pieces = start_live(load_model(library / AMC), taken, FixedLag(0.4)), []
    for frame in taken.q:
        state, finished = step_live(state, frame)
        pieces += finished
    last = finish_live(state)
    assert last is not None
    live = joined(taken, [*pieces, last])
    write(tmp_path / "again.amc", live.recording, repaired=live)
    assert out.read_bytes() == (tmp_path / "again.amc").read_bytes()
    told = cli("denoise", short / "take.amc", "-m", library / AMC, "-o", out, "--lag", "0.4", "--force")
    assert f"given out {said['latency_s']:.2f} s late" in told.err


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "unit"), [("amc", "deg"), ("c3d", "m")])
def test_what_would_be_less_sure_than_the_limit_stays_open(
    cli: Command, library: Path, tmp_path: Path, kind: str, unit: str
) -> None:
    taken = read(library / f"take.{kind}")
    gone = np.s_[50:110, 25 if kind == "c3d" else 6 :]  # half a second of 1.25; each marker's gap is work of its own
    if isinstance(taken, Markers):
        positions = taken.positions[:150].copy()
        positions[gone] = np.nan
        taken = replace(taken, positions=positions, residuals=None, source=None)
    else:
        q = taken.q[:150].copy()
        q[gone] = np.nan
        taken = replace(taken, q=q)
    write(tmp_path / f"gone.{kind}", taken)
    command = ["denoise", tmp_path / f"gone.{kind}", "-m", library / f"{kind}.mend"]
    assert cli(*command, "-o", tmp_path / f"all.{kind}").code == 0
    free = without_seconds(tmp_path / "all.mend.json")
    filled = [
        std
        for name, runs in free["runs"].items()
        if free["std"][name]["unit"] == unit
        for _, _, std in runs.get("filled", [])
    ]
    limit = float(np.median(np.concatenate([np.ravel(std) for std in filled])))  # about half are less sure
    ran = cli(*command, "-o", tmp_path / f"some.{kind}", "--max-std", str(limit))
    assert ran.code == 0
    assert "above the limit" in ran.err
    held = without_seconds(tmp_path / "some.mend.json")
    before, after = read(tmp_path / f"all.{kind}"), read(tmp_path / f"some.{kind}")
    lost = before.present & ~after.present
    assert lost.any()
    assert not lost[taken.present].any()
    for c, (name, counts) in enumerate(held["channels"].items()):
        assert counts["left_open"] == int((~after.present[:, c]).sum())
        opened = np.zeros(taken.frames, dtype=bool)
        for first, frames, *_ in held["runs"].get(name, {}).get("left_open", []):
            opened[first : first + frames] = True
        assert (opened == ~after.present[:, c]).all()
        if held["std"][name]["unit"] == unit:
            filled = held["runs"].get(name, {}).get("filled", [])
            assert max((np.max(std) for _, _, std in filled), default=0.0) <= 1.001 * limit
        else:
            assert counts == free["channels"][name]


@pytest.mark.slow
def test_a_real_walk_of_a_known_person(cli: Command, data: Path, tmp_path: Path) -> None:
    clips = sorted((data / "mocap" / "amc" / "07").glob("07_0[2-4].amc"))
    assert cli("fit", "denoiser", *clips, "-o", tmp_path / "walk.mend", "--jobs", "1").code == 0
    truth = data / "mocap" / "amc" / "07" / "07_01.amc"
    shutil.copy(truth.with_name("07.asf"), tmp_path)
    spoiled = tmp_path / "07_spoiled.amc"
    assert cli("corrupt", truth, "-o", spoiled, "--noise", "3", "--outliers", "10", "--gaps", "5").code == 0
    assert cli("denoise", spoiled, "-m", tmp_path / "walk.mend", "-o", tmp_path / "07_mended.amc").code == 0
    before, after = (
        json.loads(cli("compare", truth, other, "--json").out)["rms_deg"]
        for other in (spoiled, tmp_path / "07_mended.amc")
    )
    assert after < 0.35 * before


@pytest.mark.slow
def test_an_amc_written_stays_readable_when_another_persons_comes_to_lie_beside_it(
    cli: Command, takes: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert cli("denoise", takes / "take.amc", "--method", "linear", "-o", out / "first.amc").code == 0
    assert cli("denoise", takes / "take.amc", "--method", "linear", "-o", out / "second.amc").code == 0
    (out / "other.asf").write_text((out / "first.asf").read_text().replace(":name ", ":name other"))
    assert cli("inspect", out / "first.amc", out / "second.amc").code == 0


@pytest.mark.slow
def test_a_recording_without_a_sample_is_left_open_whole(cli: Command, library: Path, tmp_path: Path) -> None:
    clean = read(library / "clean.c3d")
    assert isinstance(clean, Markers)
    write(tmp_path / "gone.c3d", replace(clean, positions=np.full_like(clean.positions, np.nan)))
    ran = cli("denoise", tmp_path / "gone.c3d", "-m", library / "c3d.mend", "-o", tmp_path / "out.c3d")
    assert ran.code == 0
    assert "100 % left open" in ran.err


def test_seconds_begin_with_the_process(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("denoise", library / "take.c3d", "--method", "linear", "-o", tmp_path / "out.c3d", "--json")
    seconds = json.loads(ran.out)["seconds"]
    assert set(seconds) == {"startup", "read", "repair", "write", "total"}
    assert seconds["startup"] > 0
    assert seconds["total"] == pytest.approx(sum(seconds[name] for name in ("startup", "read", "repair", "write")))


@pytest.mark.slow
@pytest.mark.parametrize("command", ["denoise", "corrupt", "pipeline"])
def test_what_the_output_cannot_hold_is_said_and_by_which_number_frames_are_counted(
    cli: Command, short: Path, tmp_path: Path, command: str
) -> None:
    raw = bytearray((short / "take.c3d").read_bytes())
    first, last = struct.unpack_from("<2H", raw, 6)
    struct.pack_into("<2H", raw, 6, first + 500, last + 500)
    (tmp_path / "in.c3d").write_bytes(raw)
    for ending in ("trc", "c3d"):
        out = tmp_path / f"{ending}_out.{ending}"
        assert cli(command, tmp_path / "in.c3d", "-o", out).code == 0
        record = "corrupt" if command == "corrupt" else "mend"
        assert json.loads(out.with_suffix(f".{record}.json").read_text())["first_frame"] == first + 500
    said = json.loads(cli("inspect", tmp_path / "in.c3d", "--json").out)
    assert said["first_frame"] == first + 500
