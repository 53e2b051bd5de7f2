"""`motionmend report`."""

from pathlib import Path

from commands import Command, files_below


def test_a_page_with_what_is_known_of_a_repair(cli: Command, library: Path, tmp_path: Path) -> None:
    cli("denoise", library / "take.amc", "-m", library / "amc.mend", "-o", tmp_path / "clean.amc")
    files = [library / "take.amc", tmp_path / "clean.amc"]
    ran = cli("report", *files, "-o", tmp_path / "sub" / "page.html")
    assert (ran.code, ran.out) == (0, "")
    page = (tmp_path / "sub" / "page.html").read_text("utf-8")
    assert page.startswith("<!DOCTYPE html>") or page.startswith("<!doctype html>")
    assert "amc.mend" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert cli("report", *files, "-o", tmp_path / "again.html").code == 0
    assert (tmp_path / "again.html").read_text("utf-8") == page


def test_a_bad_recording_is_told_and_the_page_shows_the_others(cli: Command, library: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.amc").touch()
    ran = cli("report", tmp_path / "bad.amc", library / "take.c3d", "-o", tmp_path / "page.html")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "bad.amc" in ran.failures[0]
    assert (tmp_path / "page.html").is_file()


def test_a_page_is_not_overwritten_and_never_empty(cli: Command, library: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text("mine")
    ran = cli("report", library / "take.c3d", "-o", page)
    assert (ran.code, len(ran.failures), page.read_text()) == (1, 1, "mine")
    (tmp_path / "bad.amc").touch()
    assert cli("report", tmp_path / "bad.amc", "-o", tmp_path / "none.html").code == 1
    assert files_below(tmp_path) == {"page.html", "bad.amc"}


def test_a_foreign_sidecar_is_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    cli("denoise", library / "take.c3d", "--method", "linear", "-o", tmp_path / "clean.c3d")
    (tmp_path / "clean.mend.json").write_text("{}")
    ran = cli("report", tmp_path / "clean.c3d", "-o", tmp_path / "page.html")
    assert ran.code == 1
    assert "clean.mend.json" in ran.err


def test_the_page_of_a_repair_names_its_method_once(cli: Command, library: Path, tmp_path: Path) -> None:
    command = ["denoise", library / "take.amc", "-m", library / "amc.mend", "-o", tmp_path / "clean.amc", "--report"]
    assert cli(*command).code == 0
    assert (tmp_path / "clean.report.html").read_text("utf-8").count('<th scope="row">method</th>') == 1
