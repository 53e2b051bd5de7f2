"""`motionmend compare`."""

import json
import shutil
from pathlib import Path

from commands import Command


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
