"""Folders for outputs come and go."""

from pathlib import Path

import pytest
from commands import Command, files_below

from motionmend.cli.folders import housed, new_folders
from motionmend.cli.inputs import Job, Refusal


def folders_below(folder: Path) -> set[str]:
    return {one.relative_to(folder).as_posix() for one in folder.rglob("*") if one.is_dir()}


def test_new_folders_go_where_nothing_came_into_them(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    with new_folders() as make:
        for name in ("out", "out/a/b", "out/c", "mine", "mine/d"):
            make(tmp_path / name)
        (tmp_path / "out" / "c" / "take.amc").touch()
        assert folders_below(tmp_path) == {"out", "out/a", "out/a/b", "out/c", "mine", "mine/d"}
    assert folders_below(tmp_path) == {"out", "out/c", "mine"}


def test_they_go_whatever_ends_the_work(tmp_path: Path) -> None:
    def interrupted() -> None:
        with new_folders() as make:
            make(tmp_path / "out" / "a")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert folders_below(tmp_path) == set()


def test_a_folder_that_cannot_be_made_is_a_refusal_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with new_folders() as make:
        target = tmp_path / "file" / "a" / "x.amc"
        refused = housed(Job(tmp_path / "x.amc", target, target.with_suffix("")), make)
    assert isinstance(refused, Refusal)
    assert str(target.parent) in refused.reason
    assert files_below(tmp_path) == {"file"}


@pytest.mark.parametrize("command", ["denoise", "corrupt", "pipeline"])
def test_where_every_input_fails_no_folder_stays(cli: Command, tmp_path: Path, command: str) -> None:
    takes = tmp_path / "takes" / "day"
    takes.mkdir(parents=True)
    for name in ("a", "b"):
        (takes / f"{name}.c3d").write_bytes(b"\x00" * 600)
    ran = cli(command, tmp_path / "takes", "-o", tmp_path / "new" / "out", "--jobs", "1")
    assert (ran.code, len(ran.failures)) == (1, 2)
    assert folders_below(tmp_path) == {"takes", "takes/day"}
    (tmp_path / "mine").mkdir()
    cli(command, tmp_path / "takes", "-o", tmp_path / "mine", "--jobs", "1")
    assert folders_below(tmp_path) == {"takes", "takes/day", "mine"}
