"""`motionmend reproduce` hands over to the scripts of a source checkout."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from motionmend.cli import main

SCRIPTS = """
def run(ids, data, out, *, on_done):
    out.mkdir()
    (out / "REPORT.md").write_text(f"{list(ids)} {data}")
    results = [{"id": id, "met": True, "as_expected": id != "BAD", "ours": "3 of 4"} for id in ids]
    for result in results:
        on_done(result)
    return results
"""


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with `papers/`, two levels above the current one."""
    (tmp_path / "papers").mkdir()
    (tmp_path / "papers" / "claims.toml").touch()
    (tmp_path / "papers" / "__init__.py").write_text(SCRIPTS)
    (tmp_path / "deep" / "er").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "deep" / "er")
    monkeypatch.delitem(sys.modules, "papers", raising=False)
    yield tmp_path
    sys.modules.pop("papers", None)


def test_claims_are_run_with_data_and_output(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = list(sys.path)
    assert main(["reproduce", "D12", "D6", "--data", str(checkout), "-o", str(checkout / "out")]) == 0
    assert (checkout / "out" / "REPORT.md").read_text() == f"['D12', 'D6'] {checkout}"
    assert sys.path == path
    assert capsys.readouterr().out.splitlines() == ["D12: met: 3 of 4", "D6: met: 3 of 4"]


def test_a_claim_that_surprises_is_1(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "BAD", "-o", str(checkout / "bad")]) == 1
    assert (checkout / "bad" / "REPORT.md").read_text() == "['BAD'] None"
    assert "does not expect" in capsys.readouterr().out
    assert main(["reproduce", "BAD", "-o", str(checkout / "json"), "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == {"id": "BAD", "met": True, "as_expected": False, "ours": "3 of 4"}


def test_without_a_checkout_it_says_to_clone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from motionmend.cli import reproduce

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reproduce, "__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    assert main(["reproduce", "--data", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert "clone" in said


def test_a_real_claim_of_this_project(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(Path(__file__).parent)
    assert main(["reproduce", "D4", "--data", str(data), "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("D4: met")
    assert (tmp_path / "REPORT.md").is_file()
