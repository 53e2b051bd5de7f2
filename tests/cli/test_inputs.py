"""From the words on a command line to files in and files out."""

import json
import os
import time
import zipfile
from pathlib import Path

import pytest

from motionmend.cli.depth_inputs import gather_depth
from motionmend.cli.folders import ready_and_housed
from motionmend.cli.inputs import Input, Job, Refusal, gather, identities, plan, ready
from motionmend.cli.options import Writing
from motionmend.cli.takes import gather_takes
from motionmend.errors import UsageError

ENDINGS = (".amc", ".c3d")


@pytest.fixture
def takes(tmp_path: Path) -> Path:
    """A folder with recordings at two depths, and other things."""
    folder = tmp_path / "takes"
    for name in ("b.amc", "A.C3D", "day1/b.amc", "day1/deep/c.c3d", ".hidden.amc", ".git/x.amc", "b.asf", "notes.txt"):
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    return folder


def places(inputs: list[Input]) -> list[str]:
    return [one.place.as_posix() for one in inputs]


def test_a_folder_is_searched_to_any_depth_for_known_endings(takes: Path) -> None:
    inputs, refused = gather([takes], ENDINGS)
    assert places(inputs) == ["A.C3D", "b.amc", "day1/b.amc", "day1/deep/c.c3d"]
    assert refused == []


def test_what_a_dot_hides_is_left_out_and_said(takes: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert places(gather([takes / ".hidden.amc"], ENDINGS)[0]) == [".hidden.amc"]
    assert capsys.readouterr().err == ""
    gather([takes], ENDINGS)
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert "left out" in said[0]
    assert str(takes / ".git" / "x.amc") in said[0]
    assert "1 more" in said[0]


def test_what_is_no_file_is_refused_unread_and_links_to_folders_are_not_followed(
    takes: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (takes / "gone.amc").symlink_to("nowhere.amc")
    (takes / "linked.amc").symlink_to("b.amc")
    (takes / "day1" / "loop").symlink_to(takes)
    os.mkfifo(takes / "day1" / "pipe.csv")
    inputs, refused = gather([takes], (*ENDINGS, ".csv"))
    assert places(inputs) == ["A.C3D", "b.amc", "day1/b.amc", "day1/deep/c.c3d", "gone.amc"]
    assert [refusal.path for refusal in refused] == [takes / "day1" / "pipe.csv"]
    said = [line for line in capsys.readouterr().err.splitlines() if "link" in line]
    assert said == [
        f"{takes / 'day1' / 'loop'} is left out: a link to a folder; give it by name to take what is in it",
        f"{takes / 'linked.amc'} is left out: the same as {takes / 'b.amc'}",
    ]
    again, _ = gather([takes / "b.amc", *[takes / "b.amc"] * 2, takes], ENDINGS)
    assert [one.path for one in again].count(takes / "b.amc") == 1
    assert f"{takes / 'b.amc'} is left out" not in capsys.readouterr().err  # by its own name
    assert len(gather([takes / "day1" / "loop"], ENDINGS)[0]) == 5


def test_depth_and_takes_below_a_folder_that_links_to_itself_are_found_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "z" / "depth").mkdir(parents=True)
    (tmp_path / "linked").symlink_to("z")  # a recording by itself
    (tmp_path / "loop").symlink_to(".")
    os.mkfifo(tmp_path / "clip_depth.mat")
    (tmp_path / ".clip_depth.mat").touch()
    assert places(gather_depth([tmp_path])[0]) == ["linked"]
    assert places([take for take, _ in gather_takes([tmp_path], tmp_path / "out")[0]]) == ["linked"]
    said = capsys.readouterr().err.splitlines()
    assert [line.partition(": ")[0] for line in said] == 2 * [
        f"{tmp_path / '.clip_depth.mat'} is left out",
        f"{tmp_path / 'clip_depth.mat'} is left out",
        f"{tmp_path / 'loop'} is left out",
        f"{tmp_path / 'z'} is left out",
    ]


def test_several_folders_keep_their_names(takes: Path) -> None:
    inputs, _ = gather([takes / "day1" / "deep", takes / "b.amc"], ENDINGS)
    assert places(inputs) == ["deep/c.c3d", "b.amc"]


def test_a_depth_folder_lies_where_it_lay(tmp_path: Path) -> None:
    (tmp_path / "day" / "day" / "depth").mkdir(parents=True)
    (tmp_path / "other" / "depth").mkdir(parents=True)
    for given, placed in (
        (["."], ["day/day", "other"]),
        (["day", "other"], ["day/day", "other"]),
        (["day"], ["day"]),
        (["day/day"], ["day"]),
    ):
        folders = [tmp_path / one for one in given]
        assert places(gather_depth(folders)[0]) == placed
        assert places([take for take, _ in gather_takes(folders, tmp_path / "out")[0]]) == placed


def test_a_link_keeps_its_own_name_and_a_point_means_the_folder_there(
    takes: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (takes / "today").symlink_to("day1")
    inputs, _ = gather([takes / "today", takes / "b.amc"], ENDINGS)
    assert places(inputs) == ["today/b.amc", "today/deep/c.c3d", "b.amc"]
    monkeypatch.chdir(takes / "day1" / "deep")
    assert places(gather([Path(), Path("../b.amc")], ENDINGS)[0]) == ["deep/c.c3d", "b.amc"]
    assert places(gather([Path(".."), Path("../../b.amc")], ENDINGS)[0])[0] == "day1/b.amc"


def test_what_is_given_twice_is_done_once(takes: Path) -> None:
    inputs, _ = gather([takes / "b.amc", takes, takes / "day1" / ".." / "b.amc"], ENDINGS)
    assert [one.path.name for one in inputs].count("b.amc") == 2
    assert places(inputs)[0] == "b.amc"


@pytest.mark.parametrize(
    ("name", "reason"),
    [("none.amc", "no such file"), ("notes.txt", "ending"), ("b.asf", "skeleton"), ("empty", "no recording in this")],
)
def test_what_cannot_be_worked_on_is_refused_by_name(takes: Path, name: str, reason: str) -> None:
    (takes / "empty").mkdir()
    inputs, refused = gather([takes / name], ENDINGS)
    assert inputs == []
    assert refused[0].path == takes / name
    assert reason in refused[0].reason
    assert "\n" not in refused[0].reason


def test_nothing_given_is_bad_usage() -> None:
    with pytest.raises(UsageError, match="FILE"):
        gather([], ENDINGS)


def test_one_file_goes_to_the_name_given(takes: Path) -> None:
    given = [takes / "b.amc"]
    out = takes.parent / "sub" / "clean.amc"
    jobs = plan(gather(given, ENDINGS)[0], given, out, ENDINGS, ".c3d")
    assert jobs == [Job(given[0], out, out.with_suffix(""))]
    assert jobs[0].beside(".mend.json") == out.parent / "clean.mend.json"


@pytest.mark.parametrize("exists", [True, False])
def test_one_file_goes_into_a_folder(takes: Path, exists: bool) -> None:
    out = takes.parent / "out"
    if exists:
        out.mkdir()
    given = [takes / "b.amc"]
    assert [job.target for job in plan(gather(given, ENDINGS)[0], given, out, ENDINGS, ".c3d")] == [out / "b.amc"]


def test_a_folder_becomes_the_same_tree(takes: Path) -> None:
    out = takes.parent / "out"
    jobs = plan(gather([takes], ENDINGS)[0], [takes], out, ENDINGS, ".c3d")
    assert [job.target.relative_to(out).as_posix() for job in jobs] == [
        "A.C3D",
        "b.amc",
        "day1/b.amc",
        "day1/deep/c.c3d",
    ]


def test_what_cannot_be_written_as_it_is_gets_another_ending(takes: Path) -> None:
    inputs, _ = gather([takes], (*ENDINGS, ".txt"), meant=lambda _: True)
    jobs = plan(inputs, [takes], takes.parent / "out", ENDINGS, ".c3d")
    assert [job.target.name for job in jobs if job.source.suffix == ".txt"] == ["notes.c3d"]


def test_two_formats_of_one_name_keep_their_sidecars_apart(takes: Path) -> None:
    (takes / "b.c3d").touch()
    jobs = plan(gather([takes], ENDINGS)[0], [takes], Path("out"), ENDINGS, ".c3d")
    sidecars = {job.beside(".mend.json").as_posix() for job in jobs}
    assert {"out/b.amc.mend.json", "out/b.c3d.mend.json", "out/day1/b.mend.json"} <= sidecars
    assert len(sidecars) == len(jobs)


def test_a_name_with_points_keeps_them() -> None:
    job = plan([Input(Path("07.v2.amc"), Path("07.v2.amc"))], [Path("07.v2.amc")], Path("out"), ENDINGS, ".c3d")[0]
    assert job.beside(".mend.json") == Path("out/07.v2.mend.json")


def test_outputs_that_would_meet_are_bad_usage(takes: Path) -> None:
    given = [takes / "b.amc", takes / "day1" / "b.amc"]
    with pytest.raises(UsageError, match=r"b\.amc"):
        plan(gather(given, ENDINGS)[0], given, takes.parent / "out", ENDINGS, ".c3d")


@pytest.mark.parametrize("out", ["clean.amc", "there.txt"])
def test_several_inputs_need_a_folder(takes: Path, out: str) -> None:
    (takes.parent / "there.txt").touch()
    with pytest.raises(UsageError, match="folder"):
        plan(gather([takes], ENDINGS)[0], [takes], takes.parent / out, ENDINGS, ".c3d")


def test_of_a_sensors_skeleton_it_is_said_how_it_becomes_a_table(takes: Path) -> None:
    (takes / "gait.skl").write_text("x")
    refused = gather([takes / "gait.skl"], ENDINGS)[1]
    assert [one.path.name for one in refused] == ["gait.skl"]
    assert "motionmend correct" in refused[0].reason


def test_an_ending_that_cannot_be_written_is_bad_usage(takes: Path) -> None:
    given = [takes / "b.amc"]
    with pytest.raises(UsageError, match=r"\.fbx"):
        plan(gather(given, ENDINGS)[0], given, Path("clean.fbx"), ENDINGS, ".c3d")


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("resume", [False, True])
def test_what_is_there_is_kept_forced_or_resumed(takes: Path, force: bool, resume: bool) -> None:
    inputs = identities([Input(takes / "b.amc", Path("b.amc"))])
    job = Job(takes / "b.amc", takes / "out.amc", takes / "out")
    fresh = ready(job, inputs, [".mend.json"], force=force, resume=resume)
    assert fresh == job
    (takes / "out.mend.json").write_text("{}")
    sidecar = ready(job, inputs, [".mend.json"], force=force, resume=resume)
    assert sidecar == job if force or resume else isinstance(sidecar, Refusal)
    (takes / "out.amc").touch()  # by a copy that was cut off, say
    emptied = ready(job, inputs, [".mend.json"], force=force, resume=resume)
    assert emptied == job if force or resume else isinstance(emptied, Refusal)
    (takes / "out.amc").write_text("done")
    again = ready(job, inputs, [".mend.json"], force=force, resume=resume)
    if resume:
        assert isinstance(again, Job)
        assert again.finished
    elif force:
        assert again == job
    else:
        assert isinstance(again, Refusal)
        assert "--force" in again.reason


def test_an_input_is_never_an_output_whatever_is_forced(takes: Path) -> None:
    inputs = identities([Input(takes / "b.amc", Path("b.amc")), Input(takes / "A.C3D", Path("A.C3D"))])
    (takes / "linked.amc").hardlink_to(takes / "b.amc")
    (takes / "pointing.amc").symlink_to(takes / "A.C3D")
    within = takes / "b.amc", takes / "day1" / ".." / "A.C3D", takes / "new" / ".." / "b.amc"
    for target in (*within, takes / "linked.amc", takes / "pointing.amc"):
        job = Job(takes / "b.amc", target, target.with_suffix(""))
        refused = ready(job, inputs, [], force=True, resume=True)
        assert isinstance(refused, Refusal)
        assert "input" in refused.reason


@pytest.mark.slow
def test_thousands_of_files_are_planned_in_no_time(tmp_path: Path) -> None:
    """Each output asked the disk for all inputs: 1,500 files took minutes before the first was read."""
    inputs = [Input(tmp_path / f"{k}.csv", Path(f"{k}.csv")) for k in range(3000)]
    jobs = [Job(one.path, tmp_path / "out" / one.place, tmp_path / "out" / one.place.stem) for one in inputs]
    begun = time.perf_counter()
    made, refused = ready_and_housed(jobs, inputs, [".mend.json"], Writing(), lambda folder: None)
    assert time.perf_counter() - begun < 10.0
    assert (len(made), len(refused)) == (3000, 0)


def test_a_sidecar_of_another_format_is_left_to_its_owner(takes: Path) -> None:
    inputs = identities([Input(takes / "b.amc", Path("b.amc"))])
    job = Job(takes / "b.amc", takes / "out.amc", takes / "out")
    for owner, beside in (("out.c3d", "out.amc.mend.json"), ("out.amc", "out.mend.json")):
        (takes / "out.mend.json").write_text(json.dumps({"output": owner}))
        made = ready(job, inputs, [".mend.json"], force=True, resume=False)
        assert isinstance(made, Job)
        assert made.beside(".mend.json").name == beside


def test_what_only_shares_an_ending_with_recordings_is_left_out_of_a_folder_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    titles = "Field\tTime\ta:X\ta:Y\ta:Z\n1\t0.0\t1\t2\t3\n"
    (tmp_path / "take.txt").write_text(titles)
    (tmp_path / "README.txt").write_text("Field notes of the third day\n")
    (tmp_path / "index.csv").write_text("file,subject\ntake,7\n")
    (tmp_path / "empty.csv").touch()  # cannot be told from a recording that was cut off
    (tmp_path / "broken.zip").write_bytes(b"PK\3\4 cut off")
    for name in ("take", "README"):
        with zipfile.ZipFile(tmp_path / f"{name}.zip", "w") as archive:
            archive.write(tmp_path / f"{name}.txt", f"{name}.txt")
    inputs, refused = gather([tmp_path], (".txt", ".zip", ".csv"))
    assert places(inputs) == ["broken.zip", "empty.csv", "take.txt", "take.zip"]
    assert refused == []
    (said,) = capsys.readouterr().err.splitlines()  # not a line for each
    assert said.startswith(f"{tmp_path}: 3 files are left out (README.txt, README.zip, index.csv): ")
    (tmp_path / "day").mkdir()
    (tmp_path / "day" / "notes.txt").write_text("Field notes of the fourth day\n")
    gather([tmp_path / "day"], (".txt",))
    assert f"{tmp_path / 'day' / 'notes.txt'} is left out: " in capsys.readouterr().err
    for number in range(12):
        (tmp_path / "day" / f"junk{number}.txt").write_text("Field notes\n")
    gather([tmp_path / "day"], (".txt",))
    (said,) = capsys.readouterr().err.splitlines()
    assert all(f"junk{number}.txt" in said for number in range(12))
    named, _ = gather([tmp_path / "README.txt"], (".txt",))
    assert places(named) == ["README.txt"]  # who names a file wants to hear what is wrong with it
