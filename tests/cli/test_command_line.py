"""Exit codes, help and usage, without any recording."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from motionmend import __version__, cli, samples
from motionmend.cli import COMMANDS as KNOWN
from motionmend.cli import main
from motionmend.cli.options import Working
from motionmend.io import write

COMMANDS = ("demo", "inspect", "denoise", "corrupt", "compare", "report", "reproduce", "fit", "fit denoiser")


def run(capsys: pytest.CaptureFixture[str], words: str) -> tuple[int, str, str]:
    code = main(words.split())
    said = capsys.readouterr()
    return code, said.out, said.err


@pytest.mark.parametrize(("asked", "cores", "width"), [(None, 6, 6), (None, None, 1), (3, 6, 3)])
def test_as_many_processes_as_cores_unless_asked_otherwise(
    monkeypatch: pytest.MonkeyPatch, asked: int | None, cores: int | None, width: int
) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    assert Working(jobs=asked).width == width


@pytest.mark.parametrize(
    ("words", "where"),
    [
        (["inspect", ""], "a name"),
        (["inspect", "a.amc", ""], "a name"),
        (["denoise", "a.amc", "-o", ""], "-o: something"),
        (["denoise", "a.amc", "--out="], "--out: something"),
        (["compare", "", "a.amc"], "a name"),
    ],
)
def test_an_empty_argument_is_not_the_folder_one_stands_in(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    words: list[str],
    where: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    write("a.amc", samples.clip("walk", seconds=0.5, seed=0))
    before = sorted(tmp_path.rglob("*"))
    assert main(words) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        f"motionmend: {where} was wanted, came an empty argument: is it a variable of the shell that is not set?\n"
    )
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("given", ["1.5", "1e1", "two"])
def test_what_is_no_whole_number_is_not_made_one(capsys: pytest.CaptureFixture[str], given: str) -> None:
    code, out, err = run(capsys, f"inspect --jobs {given} nowhere.amc")
    assert (code, out) == (2, "")
    assert f'--jobs: a whole number was wanted, came "{given}".' in err


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "--version") == (0, f"{__version__}\n", "")


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_is_everywhere(capsys: pytest.CaptureFixture[str], command: str) -> None:
    code, out, err = run(capsys, f"{command} --help")
    assert (code, err) == (0, "")
    assert f"Usage: motionmend {command}".strip() in out


@pytest.mark.slow
@pytest.mark.parametrize("words", KNOWN, ids=" ".join)
def test_every_command_can_be_asked_where_a_failure_arose(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...]
) -> None:
    _, out, _ = run(capsys, f"{' '.join(words)} --help")
    assert "--debug" in out


@pytest.mark.parametrize("command", COMMANDS[:-2] + COMMANDS[-1:])
def test_every_option_says_what_it_is(capsys: pytest.CaptureFixture[str], command: str) -> None:
    _, out, _ = run(capsys, f"{command} --help")
    options = [line.strip("│ *\n") for line in out.splitlines() if re.match(r"│ (\*  |   )?(-|[A-Z]+ )", line)]
    assert options
    for option in options:
        assert re.search(r"\S {2,}\S", option), f"{command}: {option!r} has no text"


@pytest.mark.parametrize(
    ("command", "option", "unit"),
    [
        ("denoise", "--fps", "Hz"),
        ("fit denoiser", "--model-fps", "Hz"),
        ("fit denoiser", "--window", "frames"),
        ("fit denoiser", "--energy", "[Ss]hare"),
        ("corrupt", "--noise", "degrees"),
        ("corrupt", "--outliers", "percentage"),
        ("corrupt", "--gaps", "fraction"),
    ],
)
def test_help_states_units(capsys: pytest.CaptureFixture[str], command: str, option: str, unit: str) -> None:
    _, out, _ = run(capsys, f"{command} --help")
    text = out[out.index(option) :]
    following = re.search(r"\n│ [ *]* --", text)
    assert re.search(unit, text[: following.start()] if following else text)


@pytest.mark.parametrize(
    "words",
    [
        "",
        "fit",
        "nonsense",
        "denoise",
        "denoise a.amc",
        "denoise -o b.amc",
        "denoise a.amc -o b.amc --colour red",
        "denoise a.amc -o b.amc --method magic",
        "denoise a.amc -o b.amc --method linear --robust magic",
        "denoise a.amc -o b.amc --method paper",
        "denoise a.amc -o b.amc --lag 1",
        "denoise a.amc -o b.amc --method linear --max-std -1",
        "denoise a.amc -m a.mend -o b.amc --lag -1",
        "denoise a.amc -m a.mend -o b.amc --lag inf",
        "denoise a.amc -m a.mend -o b.amc --lag 1 --method paper",
        "denoise a.amc -m a.mend -o b.amc --lag 1 --footskate",
        "denoise a.amc -o b.amc --jobs many",
        "denoise a.amc -o b.fbx --method linear",
        "corrupt a.amc -o b.amc --outliers 150",
        "corrupt a.amc -o b.amc --gaps -1",
        "compare a.amc",
        "inspect",
        "inspect --jobs",
        "inspect a.amc --fps 0",
        "fit denoiser a.amc -o b.mend --fps -30",
        "fit tracker a.amc -o b.mend --fps nan",
        "correct a.csv -m a.mend -o b.csv --fps 0",
        "report a.amc -o b.png",
        "fit denoiser a.amc -o b.npz",
        "fit denoiser a.amc",
        "fit denoiser a.amc -o b.mend --window 1",
    ],
)
def test_bad_usage_is_2_and_says_why(capsys: pytest.CaptureFixture[str], words: str, tmp_path: Path) -> None:
    code, out, err = run(capsys, words)
    assert code == 2
    assert out == ""
    assert err
    assert "Traceback" not in err


def test_an_unknown_method_lists_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    from motionmend.denoise import METHODS

    _, _, err = run(capsys, "denoise a.amc -o b.amc --method magic")
    assert len(err.splitlines()) == 1
    assert all(method in err for method in METHODS)


@pytest.mark.parametrize("later", ["sing", "fit voice"])
def test_commands_that_are_not_there_are_absent(capsys: pytest.CaptureFixture[str], later: str) -> None:
    code, _, err = run(capsys, later)
    assert code == 2
    assert "Unknown command" in err
    assert later.split()[-1] not in run(capsys, "--help")[1].split()


@pytest.mark.parametrize(
    "command", ["inspect", "report -o p.html", "denoise --method linear -o x.amc", "compare b.amc"]
)
def test_a_file_that_is_not_there_is_1_and_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, f"{command} missing.amc")
    assert code == 1
    assert out == ""
    assert "missing.amc" in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("handed_on", [False, True])
def test_an_interrupt_is_130_and_one_line(
    handed_on: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from motionmend import io

    def interrupted(*_: object, **__: object) -> None:
        if handed_on:  # as compiled code does
            raise SystemError("returned a result with an exception set") from KeyboardInterrupt()
        raise KeyboardInterrupt

    (tmp_path / "a.amc").touch()
    monkeypatch.setattr(io, "read", interrupted)
    assert main(["inspect", str(tmp_path / "a.amc")]) == 130
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_an_interrupt_while_a_command_is_imported_is_one_too(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:  # as the import of compiled code hands it on
        raise ImportError("initialization failed") from KeyboardInterrupt()

    monkeypatch.setattr(cli, "import_module", interrupted)
    assert main(["inspect", "a.amc"]) == 130
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize("module", ["motionmend.cli", "motionmend.cli.inspect"])
def test_an_interrupt_of_text_that_is_executed_ends_with_130_and_by_no_signal(tmp_path: Path, module: str) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "class Interrupting:\n"
        "    @staticmethod\n"
        "    def find_spec(name, *_):\n"
        f"        exec('raise KeyboardInterrupt') if name == {module!r} else None\n"
        "sys.meta_path.insert(0, Interrupting)\n"
    )
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "motionmend", "inspect", "a.amc"]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": path})
    assert (ran.returncode, len(ran.stderr.splitlines())) == (130, 1)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_of_what_cannot_fail_ends_it_all_the_same(tmp_path: Path, number: int, code: int) -> None:
    """Callbacks of the compiler, and what is cleared away: Python goes on behind them as if there had been none."""
    (tmp_path / "sitecustomize.py").write_text(
        "import signal, sys, time\n"
        "class Cleared:\n"
        "    def __del__(self):\n"
        f"        signal.raise_signal({int(number)})\n"
        "class Interrupting:\n"
        "    @staticmethod\n"
        "    def find_spec(name, *_):\n"
        "        if name == 'motionmend.cli.inspect':\n"
        "            Cleared()\n"
        "            time.sleep(20)\n"
        "sys.meta_path.insert(0, Interrupting)\n"
    )
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "motionmend", "inspect", "a.amc"]
    began = time.monotonic()
    ran = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": path})
    assert (ran.returncode, len(ran.stderr.splitlines())) == (code, 1)
    assert time.monotonic() - began < 15


@pytest.mark.parametrize("command", ["denoise", "correct", "track", "pipeline"])
def test_a_model_that_is_missing_or_broken_fails_each_input_in_json_too(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.mend").write_text("no model")
    for model in ("missing.mend", "broken.mend"):
        code, out, err = run(capsys, f"{command} a.amc b -m {model} -o out --json")
        said = [json.loads(line) for line in out.splitlines()]
        assert (code, [one.pop("input") for one in said]) == (1, ["a.amc", "b"])
        assert said == [{"error": err.removeprefix("motionmend: ").rstrip()}] * 2
        assert model in err


@pytest.mark.parametrize("command", ["fit denoiser x.amc", "fit tracker x.amc", "fit corrector x.csv"])
def test_a_model_that_cannot_be_fitted_is_one_object_in_json(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, f"{command} -o m.mend --json")
    said = {"output": "m.mend", "error": err.splitlines()[-1].removeprefix("motionmend: ")}
    assert (code, json.loads(out)) == (1, said)


def test_bad_usage_is_no_input_s_failure_and_no_object(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "denoise a.amc -o b.amc --method magic --json")
    assert (code, out) == (2, "")


def test_only_commands_with_resume_speak_of_it(capsys: pytest.CaptureFixture[str], monkeypatch, tmp_path: Path) -> None:
    from motionmend import io

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    (tmp_path / "a.amc").touch()
    monkeypatch.setattr(io, "read", interrupted)
    for command, resumes in (("inspect", False), ("corrupt", True), ("denoise", True)):
        more = [] if command == "inspect" else ["-o", str(tmp_path / "b.amc")]
        assert main([command, str(tmp_path / "a.amc"), *more]) == 130
        assert ("--resume" in capsys.readouterr().err) == resumes


def test_what_the_system_refuses_is_said_with_its_name(capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    from motionmend.cli import demo

    def refused(*_: object, **__: object) -> None:
        raise OSError(30, "Read-only file system", "there/demo")

    monkeypatch.setattr(demo, "demo", refused)
    assert main(["demo"]) == 1
    assert capsys.readouterr().err == "motionmend: there/demo: Read-only file system\n"


def test_a_defect_is_1_and_its_traceback_needs_debug(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from motionmend import io

    def defective(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by zero")

    (tmp_path / "a.amc").touch()
    monkeypatch.setattr(io, "read", defective)
    assert main(["inspect", str(tmp_path / "a.amc")]) == 1
    assert capsys.readouterr().err.splitlines() == [
        f"motionmend: {tmp_path / 'a.amc'}: unexpected ZeroDivisionError: by zero"
    ]
    assert main(["inspect", str(tmp_path / "a.amc"), "--debug"]) == 1
    assert "in defective" in capsys.readouterr().err


@pytest.mark.slow
def test_the_installed_program_and_the_module_are_one() -> None:
    program = Path(sys.executable).with_name("motionmend")
    for command in ([str(program)], [sys.executable, "-m", "motionmend"]):
        done = subprocess.run([*command, "nonsense"], capture_output=True, text=True)
        assert done.returncode == 2
        assert done.stdout == ""
        assert len(done.stderr.splitlines()) == 1


def test_a_reader_that_leaves_ends_it_quietly(tmp_path: Path) -> None:
    command = f"{sys.executable} -m motionmend --help | true"
    done = subprocess.run(command, shell=True, capture_output=True, text=True)
    assert done.stderr == ""


@pytest.mark.slow
def test_a_program_that_is_asked_to_end_clears_away_and_says_so(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    for name, seconds in (("0", 1.0), ("1", 20.0)):  # when the first is there, the second has seconds to go
        write(tmp_path / "in" / f"{name}.bvh", samples.clip("walk", seconds=seconds, seed=1))
    given = ["denoise", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--jobs", "1"]
    running = subprocess.Popen([sys.executable, "-m", "motionmend", *given], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not list(tmp_path.glob("out/*.mend.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    running.terminate()
    _, said = running.communicate(timeout=60)
    assert running.returncode == 143
    assert "interrupted" in said.splitlines()[-1]
    assert all(not name.startswith(".") for name in (path.name for path in (tmp_path / "out").iterdir()))


@pytest.fixture(scope="module")
def long_take(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording that takes a while to write; never write here."""
    take = tmp_path_factory.mktemp("long") / "take.bvh"
    motion = samples.clip("walk", seconds=5.0, seed=1)
    write(take, motion.with_q(np.tile(motion.q, (8, 1))))
    return take


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="terminals of Unix")
@pytest.mark.parametrize("ignored", [False, True])
def test_a_terminal_that_closes_leaves_nothing_half_written(tmp_path: Path, long_take: Path, ignored: bool) -> None:
    """Unless it is told not to mind, as by nohup."""
    given = ["corrupt", str(long_take), "-o", str(tmp_path / "out" / "o.bvh"), "--noise", "1"]
    running = subprocess.Popen(
        [sys.executable, "-m", "motionmend", *given],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN if ignored else signal.SIG_DFL),
    )
    while not list(tmp_path.glob("out/.*")):  # it is being written
        assert running.poll() is None
        time.sleep(0.001)
    running.send_signal(signal.SIGHUP)
    _, said = running.communicate(timeout=60)
    assert running.returncode == (0 if ignored else 129)
    assert ("interrupted" in said.splitlines()[-1]) != ignored
    assert sorted(path.name for path in tmp_path.glob("out/*")) == (["o.bvh", "o.corrupt.json"] if ignored else [])


@pytest.mark.slow
def test_a_name_that_the_encoding_lacks_is_spelt(tmp_path: Path) -> None:
    write(tmp_path / "mädchen.bvh", samples.clip("walk", seconds=1.0, seed=1))
    done = subprocess.run(
        [sys.executable, "-m", "motionmend", "inspect", str(tmp_path / "mädchen.bvh")],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 0, done.stderr
    assert r"m\xe4dchen.bvh" in done.stdout


def test_a_name_of_two_lines_still_fails_in_one(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["inspect", str(tmp_path / "two\nlines.bvh")]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_what_is_said_of_a_name_of_two_lines_stays_one(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    clip = tmp_path / "two  blanks\nand a line.bvh"
    write(clip, samples.clip("walk", seconds=1))
    assert main(["denoise", str(clip), "--method", "gaussian", "-o", str(tmp_path / "out.bvh")]) == 0
    said = capsys.readouterr().err.splitlines()
    assert len(said) >= 2
    assert all("two  blanks and a line.bvh" in line for line in said)


def test_blanks_in_a_name_stay_and_it_is_named_once(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    clip = tmp_path / "two  blanks.bvh"
    clip.write_text("HIERARCHY\nROOT")
    assert main(["inspect", str(clip)]) == 1
    assert capsys.readouterr().err.count("two  blanks.bvh") == 1
    assert main(["denoise", str(clip), "-m", str(tmp_path / "no  such.mend"), "-o", str(tmp_path / "out.bvh")]) == 1
    assert "no  such.mend" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="a shell that closes streams")
@pytest.mark.parametrize("closed", ["2>&-", "<&- >&- 2>&-"])
def test_streams_that_the_caller_closed_cost_no_output(closed: str, tmp_path: Path) -> None:
    """What is opened next had their numbers, and processes that were started had another's line for their errors."""
    takes = tmp_path / "takes"
    takes.mkdir()
    for name in ("a.bvh", "b.bvh"):
        write(takes / name, samples.clip("walk", seconds=0.5))
    command = f'"{sys.executable}" -m motionmend corrupt takes -o out --noise 1 --jobs 2 {closed}'
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, timeout=60, check=False)
    assert done.returncode == 0
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        "a.bvh",
        "a.corrupt.json",
        "b.bvh",
        "b.corrupt.json",
    ]
