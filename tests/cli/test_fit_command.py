"""`motionmend fit denoiser`."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend import samples
from motionmend.bodies.motion import Markers
from motionmend.io import read, write
from motionmend.models import load_model


@pytest.mark.slow
def test_the_same_clips_give_the_same_bytes(cli: Command, library: Path, tmp_path: Path) -> None:
    assert cli("fit", "denoiser", library / "amc", "-o", tmp_path / "two.mend", "--jobs", "2").code == 0
    assert (library / "amc.mend").read_bytes() == (tmp_path / "two.mend").read_bytes()  # learned by one process


def test_settings_reach_the_model(cli: Command, library: Path, tmp_path: Path) -> None:
    options = ["--model-fps", "24", "--window", "12", "--energy", "0.9", "--fps", "60", "--jobs", "1"]
    ran = cli("fit", "denoiser", library / "amc", "-o", tmp_path / "m.mend", *options, "--json")
    assert ran.code == 0
    facts = json.loads(ran.out)
    model = load_model(tmp_path / "m.mend")
    assert (model.settings.fps, model.settings.window, model.settings.energy) == (24, 12, 0.9)
    assert facts["settings"] == {"window": 12, "model_fps": 24, "energy": 0.9}
    assert (facts["clips"], facts["failed"], facts["failures"]) == (3, 0, [])
    assert facts["output"] == str(tmp_path / "m.mend")
    assert "120 Hz" not in ran.err


def test_a_bad_clip_is_told_and_left_out(cli: Command, library: Path, tmp_path: Path) -> None:
    clips = tmp_path / "clips"
    shutil.copytree(library / "amc", clips)
    (clips / "bad.amc").write_text("1\nroot 1 2\n")
    ran = cli("fit", "denoiser", clips, "-o", tmp_path / "some.mend", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "bad.amc" in ran.failures[0]
    assert (tmp_path / "some.mend").read_bytes() == (library / "amc.mend").read_bytes()


def test_without_a_good_clip_there_is_no_model(cli: Command, tmp_path: Path) -> None:
    (tmp_path / "bad.amc").touch()
    ran = cli("fit", "denoiser", tmp_path / "bad.amc", tmp_path / "none.c3d", "-o", tmp_path / "m.mend")
    assert ran.code == 1
    assert {"bad.amc", "none.c3d", "m.mend"} <= {word for line in ran.failures for word in _names(line)}
    assert files_below(tmp_path) == {"bad.amc"}


def _names(line: str) -> list[str]:
    return [word.strip(":,").rsplit("/", 1)[-1] for word in line.split()]


def test_clips_that_do_not_go_together_are_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    ran = cli("fit", "denoiser", library / "amc", library / "c3d", "-o", tmp_path / "m.mend", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert files_below(tmp_path) == set()


def test_a_model_is_not_overwritten_without_force(cli: Command, library: Path, tmp_path: Path) -> None:
    model = tmp_path / "m.mend"
    model.write_text("mine")
    command = ["fit", "denoiser", library / "amc", "-o", model, "--jobs", "1"]
    ran = cli(*command)
    assert (ran.code, len(ran.failures), model.read_text()) == (1, 1, "mine")
    assert cli(*command, "--force").code == 0
    assert load_model(model).clips == 3


def test_a_clip_too_short_for_a_window_is_named(cli: Command, library: Path, tmp_path: Path) -> None:
    short = samples.clip("walk", seconds=0.5, seed=1)
    write(tmp_path / "short.amc", short)
    clips = [tmp_path / "short.amc", library / "amc" / "walk_0.amc"]
    ran = cli("fit", "denoiser", *clips, "-o", tmp_path / "m.mend", "--jobs", "1", "--json")
    assert ran.code == 0
    assert json.loads(ran.out)["short"] == [str(tmp_path / "short.amc")]
    assert [line for line in ran.err.splitlines() if "note" in line and "short.amc" in line]
    alone = cli("fit", "denoiser", tmp_path / "short.amc", "-o", tmp_path / "n.mend", "--jobs", "1")
    assert alone.code == 1
    assert "n.mend not written" in alone.failures[0]
    assert "short.amc" in alone.err


@pytest.mark.slow
def test_clips_of_other_channels_are_named_with_what_differs(cli: Command, library: Path, tmp_path: Path) -> None:
    markers = read(library / "clean.c3d")
    assert isinstance(markers, Markers)
    few = Markers((*markers.names[1:], "TAIL"), np.roll(markers.positions, -1, axis=1), markers.fps, up=markers.up)
    write(tmp_path / "few.c3d", few)
    ran = cli("fit", "denoiser", library / "clean.c3d", tmp_path / "few.c3d", "-o", tmp_path / "m.mend")
    assert (ran.code, len(ran.failures)) == (1, 1)
    said = f"lacks {markers.names[0].upper()} and adds TAIL"
    assert f"{tmp_path / 'few.c3d'} does not go with {library / 'clean.c3d'}: " in ran.failures[0]
    assert said in ran.failures[0]
    out = tmp_path / "most.mend"
    ran = cli("fit", "denoiser", library / "c3d", tmp_path / "few.c3d", "-o", out, "--jobs", "1")
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert "few.c3d" in ran.failures[0]
    assert said in ran.failures[0]
    assert out.exists()


@pytest.mark.slow
def test_a_clip_that_is_spoiled_itself_is_repaired_first_and_named(cli: Command, library: Path, tmp_path: Path) -> None:
    shutil.copytree(library / "amc", tmp_path / "clips")
    bad = tmp_path / "clips" / "walk_1.amc"
    assert cli("corrupt", library / "amc" / "walk_1.amc", "-o", bad, "--noise", "3", "--force").code == 0
    ran = cli("fit", "denoiser", tmp_path / "clips", "-o", tmp_path / "m.mend", "--jobs", "1", "--json")
    assert ran.code == 0
    (told,) = json.loads(ran.out)["spoiled"]
    assert told["clip"] == str(bad)
    assert abs(told["noise"] - 3.0) < 0.3
    assert [line for line in ran.err.splitlines() if line.startswith(f"note: {bad}: noise of ")]
    assert any("repaired by what it shows itself" in note for note in load_model(tmp_path / "m.mend").notes)
    many = cli("fit", "denoiser", tmp_path / "clips", "-o", tmp_path / "n.mend", "--jobs", "2")
    assert many.code == 0
    assert (tmp_path / "m.mend").read_bytes() == (tmp_path / "n.mend").read_bytes()


@pytest.mark.slow
def test_why_clips_failed_stands_in_the_object_too(cli: Command, library: Path, tmp_path: Path) -> None:
    bad, none = tmp_path / "bad.bvh", tmp_path / "none.amc"
    bad.write_text("HIERARCHY\n")
    clips = [library / "amc", bad, none]
    ran = cli("fit", "denoiser", *clips, "-o", tmp_path / "m.mend", "--jobs", "1", "--json")
    assert ran.code == 1
    facts = json.loads(ran.out)
    assert facts["failed"] == len(ran.failures) == 2
    assert {one["input"] for one in facts["failures"]} == {str(bad), str(none)}
    for one in facts["failures"]:
        assert any(one["input"] in line and one["error"] in line for line in ran.failures)
