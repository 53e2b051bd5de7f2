"""Names that cannot be looked at, and folders that may not be read: said, and everything else is done."""

import ctypes
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import Command, Ran, files_below

from motionmend import samples
from motionmend.cli.depth_inputs import gather_depth
from motionmend.io import write

LONG = "x" * 300 + ".bvh"  # no system holds such a name
MORE = {"inspect": [], "denoise": ["--method", "gaussian"], "pipeline": []}


@contextmanager
def closed_within(folder: Path) -> Iterator[Path]:
    for place in ("takes", "takes/closed"):
        (folder / place).mkdir()
        write(folder / place / "walk.bvh", samples.clip("walk", seconds=1, seed=1))
    (folder / "takes/closed").chmod(0)
    yield folder / "takes"
    (folder / "takes/closed").chmod(0o755)


@pytest.fixture
def takes(tmp_path: Path) -> Iterator[Path]:
    """A folder with a take, and a folder with another one that nobody may read."""
    with closed_within(tmp_path) as folder:
        yield folder


def no_more_than_others() -> None:
    """From the next program on, root may read no more than anybody else (capabilities 1 and 2 of Linux)."""
    for capability in (1, 2):
        ctypes.CDLL(None).prctl(24, capability, 0, 0, 0)


ALL = """
import contextlib, io, json, sys
from motionmend.cli import main
for arguments in json.loads(sys.argv[1]):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(arguments)
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""


@pytest.fixture(scope="module")
def as_anybody(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, dict[str, Ran]]]:
    """A folder of takes, and what commands say of it to whom it is closed; one process gives up its rights for all."""
    with closed_within(tmp_path_factory.mktemp("anybody")) as takes:
        (takes / "pairs.csv").write_text("sensor,truth,offset_s\nclosed/a.csv,closed/b.bvh,\n")
        asked: dict[str, list[object]] = {"fit": ["fit", "corrector", takes / "pairs.csv", "-o", takes / "m.mend"]}
        for name, more in MORE.items():
            into = [] if name == "inspect" else ["-o", takes.parent / name]
            asked[name] = [name, takes, "--json", *more, *into]
        told = json.dumps([[str(word) for word in words] for words in asked.values()])
        command = [sys.executable, "-c", ALL, told]
        found = subprocess.run(command, capture_output=True, text=True, preexec_fn=no_more_than_others, check=False)
        assert found.returncode == 0, found.stderr
        lines = (json.loads(line) for line in found.stdout.splitlines())
        yield takes, {name: Ran(*line) for name, line in zip(asked, lines, strict=True)}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="gives up rights as Linux has them")
@pytest.mark.parametrize("command", ["inspect", "denoise", "pipeline"])
def test_a_folder_that_may_not_be_read_is_a_failure_and_the_others_are_done(
    as_anybody: tuple[Path, dict[str, Ran]], command: str
) -> None:
    takes, said = as_anybody
    out, ran = takes.parent / command, said[command]
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert str(takes / "closed") in ran.failures[0]
    assert "ermission" in ran.failures[0]
    told = [json.loads(line) for line in ran.out.splitlines()]
    assert [one["input"] for one in told if "error" in one] == [str(takes / "closed")]
    assert [one["input"] for one in told if "error" not in one] == [str(takes / "walk.bvh")]
    assert (out / "walk.bvh").exists() == (command != "inspect")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="gives up rights as Linux has them")
def test_a_pair_in_a_closed_folder_is_no_defect_of_the_program(as_anybody: tuple[Path, dict[str, Ran]]) -> None:
    takes, said = as_anybody
    ran = said["fit"]
    assert ran.code == 1
    assert f"{takes}/closed/a.csv: Permission denied" in ran.err
    assert "unexpected" not in ran.err


@pytest.mark.slow
@pytest.mark.parametrize("command", ["inspect", "denoise", "pipeline"])
def test_a_name_no_system_holds_fails_alone(takes: Path, cli: Command, command: str) -> None:
    out = takes.parent / "out"
    into = [] if command == "inspect" else ["-o", out]
    ran = cli(command, takes / LONG, takes / "walk.bvh", "--json", "--jobs", "1", *MORE[command], *into)
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "too long" in ran.failures[0]
    told = [json.loads(line) for line in ran.out.splitlines()]
    assert [Path(one["input"]).name for one in told] == [LONG, "walk.bvh"]
    assert ["error" in one for one in told] == [True, False]


@pytest.mark.parametrize("command", ["inspect", "denoise", "compare"])
def test_a_name_no_system_holds_is_told_in_json_when_it_is_alone(takes: Path, cli: Command, command: str) -> None:
    into = {"denoise": ["-o", takes / "o.bvh"], "compare": [takes / "walk.bvh"]}.get(command, [])
    ran = cli(command, takes / LONG, *into, "--json")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "too long" in json.loads(ran.out)["error"]


def test_what_beside_an_output_would_have_too_long_a_name_fails_alone(takes: Path, cli: Command) -> None:
    name = "x" * 248 + ".bvh"  # holds; what belongs beside it does not
    (takes / name).write_bytes((takes / "walk.bvh").read_bytes())
    (takes / "out").mkdir()
    ran = cli("denoise", takes / name, takes / "walk.bvh", "-o", takes / "out", "--method", "gaussian", "--jobs", "1")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert name in ran.failures[0]
    assert files_below(takes / "out") == {"walk.bvh", "walk.mend.json"}


def test_depth_beside_a_name_no_system_holds_is_found(takes: Path) -> None:
    (takes / "seen").mkdir()
    (takes / "seen" / "camera.json").write_text("{}")
    inputs, refused = gather_depth([takes / LONG, takes / "seen"])
    assert [one.path for one in inputs] == [takes / "seen"]
    assert [one.path for one in refused] == [takes / LONG]
