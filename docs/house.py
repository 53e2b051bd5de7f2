"""What Sphinx has to be told about this house: how docstrings are written, where links lead, how figures look."""

import re
from collections.abc import Iterator
from inspect import getdoc
from itertools import pairwise
from os.path import relpath
from pathlib import Path
from typing import Any

import numpy as np

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
# Pages that stand elsewhere in the repository, by the names they get here; `docs/more` is made, and git-ignored.
ELSEWHERE = {
    "more/readme": ROOT / "README.md",
    "more/report": ROOT / "papers" / "REPORT.md",
    "more/speed": ROOT / "benchmarks" / "RESULTS.md",
    "more/benchmarks": ROOT / "benchmarks" / "README.md",
    "more/contributing": ROOT / "CONTRIBUTING.md",
    "more/changes": ROOT / "CHANGELOG.md",
}
_PAGES = {path: f"/{name}.md" for name, path in ELSEWHERE.items()}
_PAGES[ROOT / "examples"] = "/gallery/index.rst"
_LISTED = ("Parameters", "Attributes", "Raises", "Returns")
_ITEM = re.compile(r"([\w*.]+(?:, [\w*.]+)*) : (.*)")
_LONE = re.compile(r"^(?=\w\.(?: |$))")  # a unit such as "s.", which would begin a numbered list
_NEXT = re.compile(r"(?<=\.) ([A-Za-z]\w*(?:, \w+)*) : ")  # after a sentence, on the same line


def linked(text: str, folder: Path, page_folder: Path) -> str:
    """Markdown of a file in `folder`, with links to files of the repository as a page in `page_folder` has them."""

    def turned(link: re.Match[str]) -> str:
        to, hash_sign, anchor = link[1].partition("#")
        path = (folder / to).resolve()
        if not to or "://" in to or not path.exists():
            return link[0]
        return f"]({_PAGES.get(path, relpath(path, page_folder))}{hash_sign}{anchor})"

    return re.sub(r"\]\(([^)\s]+)\)", turned, text)


def under_one_title(text: str) -> str:
    """Markdown in which all headings but the first are one step lower, if there are several of the highest."""
    parts = text.split("```")  # every other one is code, where # begins a comment
    if sum(len(re.findall("^# ", part, re.M)) for part in parts[::2]) < 2:
        return text
    parts[::2] = [re.sub("^#", "##", part, flags=re.M) for part in parts[::2]]
    return "```".join(parts).replace("## ", "# ", 1)


def pages_from_elsewhere(app: Any) -> None:
    """Write `docs/more`; what has not changed is left as it is, so that Sphinx need not read it again."""
    for name, path in ELSEWHERE.items():
        page = DOCS / f"{name}.md"
        page.parent.mkdir(exist_ok=True)
        text = linked(under_one_title(path.read_text("utf-8")), path.parent, page.parent)
        if not page.exists() or page.read_text("utf-8") != text:
            page.write_text(text, "utf-8")


def links_of_a_page(app: Any, name: str, source: list[str]) -> None:
    """The links of a page that stands in docs itself."""
    if (DOCS / name).parent == DOCS:
        source[0] = linked(source[0], DOCS, DOCS)


def sections(lines: list[str]) -> Iterator[tuple[str, list[str]]]:
    """The sections of a docstring by their titles; what stands before the first has none."""
    starts = [k for k in range(len(lines) - 1) if lines[k].strip() and set(lines[k + 1].strip()) == {"-"}]
    ends = [*starts, len(lines)]
    yield "", lines[: ends[0]]
    for start, end in pairwise(ends):
        yield lines[start], lines[start + 2 : end]


def restated(lines: list[str]) -> Iterator[str]:
    """A docstring as numpydoc has it: here a sentence follows `name :`, not a type, and Returns may be prose."""
    for title, body in sections(lines):
        if title not in _LISTED:
            yield from ((title, "-" * len(title), *body) if title else body)
            continue
        body = [part for line in body for part in _NEXT.sub(r"\n\1 : ", line).split("\n")]
        if title == "Returns" and not any(line.startswith(" ") or _ITEM.fullmatch(line) for line in body):
            yield from ("", "", f":returns: {body[0]}", *(f"    {line}" for line in body[1:]), "")
            continue
        yield from (".. rubric:: Attributes", "") if title == "Attributes" else (title, "-" * len(title))
        for line in body:
            item = _ITEM.fullmatch(line)
            told = item and _LONE.sub(r"\\", item[2], count=1)
            if title == "Attributes":
                yield f"- **{item[1]}** – {told}" if item else f"  {line.strip()}"
            else:
                yield from (item[1], f"    {told}") if item else (line,)


def for_napoleon(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Before napoleon reads a docstring."""
    lines[:] = restated(lines)


def after_napoleon(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """What a property says before a colon is no type either."""
    if what == "property":
        lines[:] = (getdoc(value) or "").splitlines()


def is_an_array(app: Any, what: str, name: str, value: Any, skip: bool, options: Any) -> bool | None:
    """Tables that all objects of a class share are not written out."""
    return True if isinstance(value, np.ndarray) else None


class InOrder:
    """Which example comes first."""

    def __init__(self, folder: str) -> None:
        self.names = ("repair_a_recording.py", "fill_a_missing_arm.py", "fill_gaps_of_markers.py")

    def __call__(self, name: str) -> tuple[int, str]:
        return self.names.index(name) if name in self.names else len(self.names), name


def figures_as_in_reports(gallery: Any, name: str) -> None:
    """Colours and lines of the library's own figures, for the examples'."""
    import matplotlib.pyplot as plt
    from cycler import cycler

    from motionmend.report.style import COLOURS, STYLE

    plt.rcParams.update({**STYLE, "savefig.dpi": 120, "axes.prop_cycle": cycler(color=COLOURS)})


def arrays_by_name() -> None:
    """Array types are called by their names in signatures, not by what they stand for; before modules are loaded."""
    from numpy import typing

    from motionmend import arrays

    for home, names in ((arrays, ("Floats", "Ints", "Singles", "Bytes", "Bools")), (typing, ("ArrayLike",))):
        for name in names:
            setattr(home, name, type(name, (), {"__module__": home.__name__}))


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    arrays_by_name()
    app.connect("builder-inited", pages_from_elsewhere)
    app.connect("source-read", links_of_a_page)
    app.connect("autodoc-process-docstring", for_napoleon, priority=400)  # napoleon's is 500
    app.connect("autodoc-process-docstring", after_napoleon, priority=600)
    app.connect("autodoc-skip-member", is_an_array)
    return {"parallel_read_safe": True}
