"""The claims of the papers: every one has its entry and its script, and the quick ones really run."""

import sys
from importlib import import_module
from pathlib import Path

import pytest

from motionmend.errors import FileError, UsageError

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module", autouse=True)
def papers():
    """The package `papers` of the checkout; it is not installed with motionmend."""
    sys.path.insert(0, str(ROOT))
    sys.modules.pop("papers", None)
    try:
        yield import_module("papers")
    finally:
        sys.path.remove(str(ROOT))


@pytest.fixture(scope="module")
def claims(papers):
    return import_module("papers.claims").load()


@pytest.mark.parametrize(
    ("part", "letter", "wanted"),
    [("claims", "D", 17), ("tracking", "T", 21), ("correcting", "C", 9), ("beyond", "B", 12)],
)
def test_every_claim_is_there_once_in_its_file(claims, part, letter, wanted):
    own = [claim.id for claim in claims if claim.part == part]
    numbers = [int(one.removeprefix(letter)) for one in own]
    assert own == [f"{letter}{number}" for number in sorted(set(numbers))]
    assert len(own) >= wanted
    if part != "correcting":  # of the paper on correction some need people, or are judged together
        assert numbers == list(range(1, wanted + 1))


def test_every_claim_says_what_where_and_when_it_is_met(claims):
    for claim in claims:
        for text in (claim.title, claim.place, claim.theirs, claim.ours, claim.expected):
            assert text.strip(), claim.id
        assert claim.expected == "met" or claim.expected.startswith("not met: "), claim.id
        assert claim.criteria, claim.id


def test_every_script_is_there_and_runs(claims):
    for script in {script for claim in claims for script in claim.script}:
        assert (ROOT / "papers" / f"{script}.py").is_file(), script
        assert callable(import_module(f"papers.{script}").run), script


def test_no_script_is_left_without_a_claim(claims):
    named = {script for claim in claims for script in claim.script}
    kinds = ("fig_", "sec_", "beyond_", "track_", "correct_")
    scripts = [path for path in (ROOT / "papers").glob("*.py") if path.stem.startswith(kinds)]
    there = {path.stem for path in scripts if "\ndef run(" in path.read_text(encoding="utf-8")}
    assert there == named


@pytest.mark.parametrize(
    ("direction", "measured", "holds"),
    [
        ("above", 0.95, True),
        ("above", 0.85, False),
        ("below", 1.05, True),
        ("below", 1.15, False),
        ("equal", 1.1, True),
        ("equal", 1.2, False),
        ("above", float("nan"), False),
        ("below", float("nan"), False),
        ("equal", float("nan"), False),
    ],
)
def test_a_criterion_judges_by_direction_and_tolerance(papers, direction, measured, holds):
    criterion = import_module("papers.claims").Criterion("x", "1", direction, 1.0, 0.101, "a number")
    assert criterion.holds(measured) is holds


def test_every_claim_of_the_paper_on_correction_has_a_row_is_judged_in_one_or_is_out_of_reach(papers, claims):
    module = import_module("papers.claims")
    own = [claim for claim in claims if claim.part == "correcting"]
    rows, within = {claim.id for claim in own}, {one for claim in own for one in claim.also}
    beyond = {one.id for one in module.out_of_reach()}
    assert not rows & within
    assert not (rows | within) & beyond
    assert {f"C{number}" for number in range(1, 18)} <= rows | within | beyond
    assert [claim.id for claim in module.choose(claims, ["c9"])] == ["C11", "C14"]


def test_what_is_out_of_reach_says_so_and_runs_nothing(papers, tmp_path):
    told = []
    (result,) = papers.run(["C16"], None, tmp_path / "out", on_done=told.append)
    assert told == [result]
    assert (result["id"], result["met"], result["as_expected"]) == ("C16", False, True)
    assert "people" in result["ours"]
    assert not (tmp_path / "out").exists()


def test_an_unknown_claim_is_refused(papers, tmp_path):
    with pytest.raises(UsageError, match="D99"):
        papers.run(["D99"], tmp_path, tmp_path / "out")


def test_without_data_it_says_so(papers, tmp_path, monkeypatch):
    monkeypatch.delenv("MOTIONMEND_DATA", raising=False)
    with pytest.raises(UsageError, match="MOTIONMEND_DATA"):
        papers.run(["D4"], None, tmp_path / "out")
    with pytest.raises(FileError, match="mocap"):
        papers.run(["D4"], tmp_path, tmp_path / "out")


@pytest.mark.slow
def test_quick_claims_run_on_real_recordings(papers, data, tmp_path):
    results = papers.run(["d4", "D1", "T5"], data, tmp_path)
    assert [(result["id"], result["met"], result["as_expected"]) for result in results] == [
        ("D1", True, True),
        ("D4", True, True),
        ("T5", True, True),
    ]
    report = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    assert "figures/fig_2_3.png" in report
    assert str(data) not in report
    assert str(tmp_path) not in report
    assert 1_000 < (tmp_path / "figures" / "fig_2_3.png").stat().st_size < 150_000


@pytest.mark.slow
def test_the_same_claim_gives_the_same_picture(papers, data, tmp_path):
    pictures = []
    for name in ("one", "two"):
        papers.run(["D4"], data, tmp_path / name)
        pictures.append((tmp_path / name / "figures" / "fig_2_3.png").read_bytes())
    assert pictures[0] == pictures[1]


def test_the_committed_report_covers_every_claim(claims):
    report = (ROOT / "papers" / "REPORT.md").read_text(encoding="utf-8")
    for claim in claims:
        assert f"**{claim.id}** {claim.title}" in report
    for path in (ROOT / "papers" / "figures").glob("*.png"):
        assert path.stat().st_size < 150_000, path.name
        assert f"figures/{path.name}" in report
