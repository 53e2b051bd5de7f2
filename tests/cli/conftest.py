"""Recordings, a model and a way to run commands, for the tests of the command line."""

import os
import shutil
from pathlib import Path

import pytest
from commands import Command, Ran

from motionmend import samples
from motionmend.cli import main
from motionmend.io import write


@pytest.fixture
def cli(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """Runs the command line in this process as on a machine with one core: one worker, unless `--jobs` says more."""
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # a worker's start costs more than most of these do

    def run(*arguments: str | Path) -> Ran:
        capfd.readouterr()
        code = main([str(argument) for argument in arguments])
        said = capfd.readouterr()
        assert "Traceback" not in said.err
        return Ran(code, said.out, said.err)

    return run


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Clips of a walk as .amc and as .c3d, a model of each kind, and a spoiled take of each; never write here."""
    folder = tmp_path_factory.mktemp("library")
    for kind in ("amc", "c3d"):
        clips = folder / kind
        clips.mkdir()
        for seed in range(3):
            clip = samples.clip("walk", seconds=2.5, seed=seed)
            write(clips / f"walk_{seed}.{kind}", samples.markers(clip) if kind == "c3d" else clip)
        taken = samples.clip("walk", seconds=2.0, seed=9)
        write(folder / f"clean.{kind}", samples.markers(taken) if kind == "c3d" else taken)
        noise = "2" if kind == "amc" else "0.005"
        spoil = ["--noise", noise, "--outliers", "0.05", "--gaps", "0.05", "--jobs", "1"]
        assert main(["corrupt", str(folder / f"clean.{kind}"), "-o", str(folder / f"take.{kind}"), *spoil]) == 0
        assert main(["fit", "denoiser", str(clips), "-o", str(folder / f"{kind}.mend"), "--jobs", "1"]) == 0
    return folder


@pytest.fixture
def takes(library: Path, tmp_path: Path) -> Path:
    """A folder with two good recordings at two depths."""
    folder = tmp_path / "takes"
    (folder / "day2").mkdir(parents=True)
    for place in (folder, folder / "day2"):
        shutil.copy(library / "clean.asf", place / "body.asf")
    shutil.copy(library / "take.amc", folder / "take.amc")
    shutil.copy(library / "clean.amc", folder / "day2" / "clean.amc")
    return folder
