"""What README and docs say runs, exists and is there: examples, commands, files, links."""

import re
import shlex
from collections import Counter
from inspect import ismodule
from pathlib import Path
from pkgutil import resolve_name

import pytest

import motionmend
from motionmend.cli import COMMANDS, _app

README = Path(__file__).parents[1] / "README.md"
PAGES = [README, *sorted((README.parent / "docs").glob("*.md"))]


@pytest.mark.slow
def test_the_example_runs(tmp_path, monkeypatch, capsys):
    code = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.S)
    assert code
    monkeypatch.chdir(tmp_path)
    exec(compile(code.group(1), "README.md", "exec"), {})
    before, after = (float(v) for v in capsys.readouterr().out.splitlines()[-1].split("->"))
    assert after < 0.3 * before
    assert (tmp_path / "repaired.bvh").stat().st_size > 10_000


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)]+)\)", README.read_text(encoding="utf-8")))
def test_every_link_leads_to_a_file(link):
    assert (README.parent / link).exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_of_the_docs_leads_to_a_file(page):
    for link in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert "://" in link or (page.parent / link).exists(), link


def commands(page):
    """The command lines of each block of a page, without their comments."""
    for block in re.findall(r"```\n(.*?)```", page.read_text(encoding="utf-8"), re.S):
        yield [shlex.split(line, comments=True) for line in block.splitlines() if line.startswith("motionmend ")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_are_good_usage_as_they_stand(page):
    for words in (words for block in commands(page) for words in block):
        assert tuple(words[1:2]) in COMMANDS or tuple(words[1:3]) in COMMANDS, words
        _app(words[1:]).parse_args(words[1:], exit_on_error=False, print_error=False)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_command_of_a_page_writes_where_another_has_written(page):
    words = [words for block in commands(page) for words in block]
    written = Counter(one[one.index("-o") + 1] for one in words if "-o" in one)
    assert [out for out, count in written.items() if count > 1] == []


def test_every_file_that_is_named_in_the_docs_is_there():
    there = {
        f"/{path.relative_to(README.parent).as_posix()}"
        for folder in ("src", "tests", "papers", "benchmarks", "docs", "examples")
        for path in (README.parent / folder).rglob("*.py")
    }
    for page in PAGES:
        named = set(re.findall(r"(?<![\w*/.])([a-z][\w/]*\.py)\b", page.read_text(encoding="utf-8")))
        assert [name for name in sorted(named) if not any(path.endswith(f"/{name}") for path in there)] == [], page.name


@pytest.mark.parametrize("room", ["denoise", "track", "correct"])
def test_every_file_of_a_room_is_told_of(room):
    told = (README.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    folder = README.parent / "src" / "motionmend" / room
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*.py") if path.name != "__init__.py"}
    assert [name for name in sorted(files) if f"`{name}`" not in told] == []


def test_the_page_of_the_library_tells_of_all_that_is_public():
    page = (README.parent / "docs" / "api.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^ {3}(\w[\w.]*)$", page, re.M))
    homes = {name: getattr(motionmend, name) for name in motionmend.__all__}
    public = {value: name for name, value in homes.items() if callable(value)}
    for room in (value for name, value in homes.items() if ismodule(value) and name != "io"):
        for value, name in ((getattr(room, name), name) for name in room.__all__):
            if callable(value):
                public.setdefault(value, f"{room.__name__.partition('.')[2]}.{name}")
    assert sorted(set(public.values()) - told) == []
    for home, _, name in (f"motionmend.{name}".rpartition(".") for name in told):
        assert callable(resolve_name(f"{home}:{name}")), name
