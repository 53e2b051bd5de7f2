"""What a command says, and where."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.batch import Failure
from motionmend.cli.output import exit_code, tell_failure, tell_guesses
from motionmend.cli.speech import json_line, plain

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)


@pytest.mark.slow
@given(st.dictionaries(st.text(), JSON, max_size=4))
def test_json_is_one_line_and_reads_back(facts: dict[str, object]) -> None:
    line = json_line(facts)
    assert "\n" not in line
    assert line.isascii()
    assert json.loads(line) == facts


def test_what_json_lacks_becomes_plain() -> None:
    values = {"a": np.float64("nan"), "b": np.array([1.0, np.inf]), "c": Path("x"), "d": np.int64(3), "e": (True, None)}
    assert plain(values) == {"a": None, "b": [1.0, None], "c": "x", "d": 3, "e": [True, None]}


def test_a_failure_names_its_file_once(capsys: pytest.CaptureFixture[str]) -> None:
    tell_failure(Path("takes/bad.amc"), Failure("FileError", "is empty", ""), as_json=False, debug=False)
    tell_failure(Path("takes/bad.amc"), Failure("FileError", "takes/bad.amc: is empty", ""), as_json=False, debug=False)
    said = capsys.readouterr()
    assert said.err.splitlines() == ["motionmend: takes/bad.amc: is empty"] * 2
    assert said.out == ""


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("takes/folder", "no recording in this folder"),
        ("folder", "no recording in this folder"),
        ("dep/depth", "a depth recording (a folder with camera.json and depth/) was wanted"),
        ("camera.json", "there is no old_camera.json"),
        ("a/walk.bvh", "b/walk.bvh: cannot be written"),
    ],
)
def test_a_name_that_stands_there_for_something_else_does_not_count(capsys, path, message) -> None:
    tell_failure(Path(path), Failure("FileError", message, ""), as_json=False, debug=False)
    assert capsys.readouterr().err == f"motionmend: {path}: {message}\n"


def test_a_failure_of_the_file_held_against_begins_with_that_one(capsys: pytest.CaptureFixture[str]) -> None:
    failed = Failure("FileError", "truth.txt: is empty", "")
    tell_failure(Path("other.csv"), failed, as_json=True, debug=False, also=Path("truth.txt"))
    said = capsys.readouterr()
    assert said.err == "motionmend: truth.txt: is empty\n"
    assert json.loads(said.out) == {"input": "other.csv", "error": "truth.txt: is empty"}


def test_an_error_in_json_does_not_repeat_its_input(capsys: pytest.CaptureFixture[str]) -> None:
    tell_failure(Path("a/bad.amc"), Failure("FileError", "a/bad.amc: is empty", ""), as_json=True, debug=False)
    assert json.loads(capsys.readouterr().out) == {"input": "a/bad.amc", "error": "is empty"}


def test_a_failure_with_json_is_an_object_and_with_debug_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    tell_failure(Path("bad.amc"), Failure("FileError", "is empty", "Traceback ...\nhere\n"), as_json=True, debug=True)
    said = capsys.readouterr()
    assert json.loads(said.out) == {"input": "bad.amc", "error": "is empty"}
    assert "here" in said.err


def test_one_guess_for_many_files_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    tell_guesses({"120 Hz": [Path("a.amc"), Path("b.amc")], "y is up": [Path("b.amc")]})
    assert capsys.readouterr().err.splitlines() == [
        "guess (2 files, a.amc first): 120 Hz",
        "guess (b.amc): y is up",
    ]


def test_usage_by_which_something_was_done_was_not_bad() -> None:
    wrong = Failure("UsageError", "y", "")
    assert (exit_code([wrong]), exit_code([wrong], done=1), exit_code([], done=1)) == (2, 1, 0)


def test_bad_usage_outweighs_a_failed_input() -> None:
    failed, wrong = Failure("FileError", "x", ""), Failure("UsageError", "y", "")
    assert exit_code([]) == 0
    assert exit_code([failed]) == 1
    assert exit_code([failed, wrong]) == 2
