"""`motionmend demo`: the first thing a new user runs, in a process of its own as a user would."""

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from commands import Command


@pytest.mark.slow
def test_the_demo_repairs_what_it_spoils_within_a_minute(tmp_path: Path) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-m", "motionmend", "demo", "--out", "shown"], cwd=tmp_path, capture_output=True, text=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode == 0, done.stderr
    # the processor's seconds: on an idle machine no fewer than the wall clock's, and the same on a busy one
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 60
    rows = [line for line in done.stdout.splitlines() if "->" in line]
    assert [row.split(",")[0] for row in rows] == ["joint angles", "joint angles", "markers"]
    for kind in ("amc", "bvh", "c3d"):
        folder = tmp_path / "shown" / kind
        for name in ("clean", "spoiled", "repaired"):
            assert (folder / f"{name}.{kind}").stat().st_size > 0
        assert json.loads((folder / "repaired.mend.json").read_text())["counts"]["filled"] > 0
    for name in ("curves.png", "skeletons.png"):
        assert (tmp_path / "shown" / name).read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "shown" / "report.html").is_file()
    for row in rows:
        before, after = row.split("->")[-2].split()[-1], row.split("->")[-1].split()[0]
        assert float(before) > float(after)  # share of missing samples
    errors = [float(word) for word in rows[0].replace("->", " ").split() if word.replace(".", "").isdigit()]
    assert errors[1] < 0.5 * errors[0]  # degrees
    assert errors[3] < 0.5 * errors[2]  # centimetres


@pytest.mark.slow
def test_programs_get_one_object_a_recording(cli: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionmend.cli.demo.FORMATS", ("c3d",))
    monkeypatch.setattr("motionmend.cli.demo.LEARNED", (("walk", 0), ("walk", 1)))
    monkeypatch.setattr("motionmend.cli.demo.SECONDS", 1.0)
    ran = cli("demo", "--out", tmp_path / "shown", "--json")
    assert ran.code == 0, ran.err
    facts = json.loads(ran.out)
    assert facts["output"] == str(tmp_path / "shown" / "c3d" / "repaired.c3d")
    assert facts["after"]["mean_cm"] < facts["before"]["mean_cm"]
    assert facts["before"]["rms_deg"] is None


def test_a_folder_with_something_in_it_is_left_alone(cli: Command, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").touch()
    ran = cli("demo", "--out", tmp_path)
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
