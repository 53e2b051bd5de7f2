"""Who may import whom, read off the source: nothing points upward, and what is heavy is loaded late."""

import ast
import shutil
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

import motionmend

PACKAGE = Path(motionmend.__file__).parent

# Each layer and what lies below it. The kernels lie under everything; a room never opens onto another room.
BELOW = {
    "errors": set[str](),
    "arrays": {"errors"},
    "rooms": set[str](),
    "kernels": set[str](),
    "numerics": {"kernels"},
    "bodies": {"kernels"},
    "denoise": {"bodies", "numerics", "kernels"},
    "track": {"bodies", "numerics", "kernels"},
    "correct": {"bodies", "numerics", "kernels"},
    "io": {"bodies", "kernels"},
    "evaluate": {"bodies", "kernels"},
    "samples": {"bodies", "kernels"},
}
ROOF = {"__init__", "__main__", "report", "view", "live", "batch", "processes", "datasets", "models", "cli"}
FREE = {"errors", "arrays", "rooms"}
# The folders of the denoising room: each knows those before it, and the two files in which a repair's outcome is told.
DENOISE = (
    "channels",
    "library",
    "bases",
    "outliers",
    "noise",
    "rivals",
    "footskate",
    "dynamics",
    "labels",
    "gaps",
    "outcome",
    "too_short",
    "faults",
    "adaptive",
)
HEAVY = {"numba", "sklearn", "matplotlib", "ezc3d", "cv2"}


class Import(NamedTuple):
    """One import: its line, the dotted name asked for, and whether loading the file runs it."""

    line: int
    name: str
    at_load: bool


def imports(root: Path, file: Path) -> tuple[Import, ...]:
    """All imports of a file under the package folder `root`; relative ones spelt out from `motionmend`."""
    return imports_of(("motionmend", *file.relative_to(root).parent.parts), file.read_text("utf-8"))


@cache
def imports_of(package: tuple[str, ...], source: str) -> tuple[Import, ...]:
    """All imports of a module's source in a package."""

    def walk(node: ast.AST, at_load: bool) -> Iterator[Import]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                for alias in child.names:
                    yield Import(child.lineno, alias.name, at_load)
            elif isinstance(child, ast.ImportFrom):
                base = package[: len(package) - child.level + 1] if child.level else []
                stem = ".".join([*base, *([child.module] if child.module else [])])
                for alias in child.names:
                    yield Import(child.lineno, f"{stem}.{alias.name}", at_load)
            elif isinstance(child, ast.Call) and _is_import_call(child):
                for argument in child.args[:1]:
                    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                        yield Import(child.lineno, argument.value, at_load)
                yield from walk(child, at_load)
            elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
                yield from walk(child, False)
            else:
                inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
                yield from walk(child, at_load and not inside)

    return tuple(walk(ast.parse(source), True))


def _is_import_call(call: ast.Call) -> bool:
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    return name in ("import_module", "__import__")


def layer(root: Path, file: Path) -> str:
    """The first name below the package: a folder, or a module at the package's root."""
    return file.relative_to(root).with_suffix("").parts[0]


def upward(root: Path) -> list[str]:
    """One line for each import of the package that the rule forbids."""
    found = []
    for file in sorted(root.rglob("*.py")):
        here = layer(root, file)
        if here in ROOF:
            continue
        if here not in BELOW:
            found.append(f"{file.relative_to(root)}: {here} is in no layer")
            continue
        allowed = {here} | BELOW[here] | FREE
        for one in imports(root, file):
            parts = one.name.split(".")
            if parts[0] != "motionmend":
                continue
            target = parts[1] if len(parts) > 1 else "__init__"
            if target not in allowed:
                found.append(f"{file.relative_to(root)}:{one.line}: {here} imports {one.name}")
    return found


def inward(root: Path) -> list[str]:
    """One line for each import of a folder of the denoising room that it may not know."""
    found = []
    for file in sorted((root / "denoise").glob("*/*.py")):
        known = DENOISE[: DENOISE.index(file.parent.name) + 1]
        for one in imports(root, file):
            parts = one.name.split(".")
            if parts[:2] == ["motionmend", "denoise"] and parts[2] not in known:
                found.append(f"{file.relative_to(root)}:{one.line}: {file.parent.name} imports {one.name}")
    return found


def early(root: Path) -> list[str]:
    """One line for each heavy import that runs when a module is loaded, the kernels' numba aside."""
    found = []
    for file in sorted(root.rglob("*.py")):
        here = layer(root, file)
        for one in imports(root, file):
            top = one.name.split(".")[0]
            if one.at_load and top in HEAVY and not (here == "kernels" and top == "numba"):
                found.append(f"{file.relative_to(root)}:{one.line}: loads {one.name}")
    return found


def circles(root: Path) -> list[str]:
    """One line for each set of files that import each other in a circle, late imports and those for types included."""
    files = {
        ".".join(("motionmend", *file.relative_to(root).with_suffix("").parts)): file for file in root.rglob("*.py")
    }
    names = {name.removesuffix(".__init__"): file for name, file in files.items()}

    def known(file: Path) -> set[str]:
        asked = (one.name for one in imports(root, file))
        return {name if name in names else name.rpartition(".")[0] for name in asked} & (names.keys() - package(file))

    def package(file: Path) -> set[str]:  # a folder's own door may be asked for what lies beside it
        return {".".join(("motionmend", *file.relative_to(root).parent.parts))}

    left = {name: known(file) for name, file in names.items()}
    while True:  # who asks nobody, or is asked by nobody, is in no circle
        asked = {name for others in left.values() for name in others}
        ends = {name for name, others in left.items() if name not in asked or not others & left.keys()}
        if not ends:
            return [f"{name} <-> {', '.join(sorted(others & left.keys()))}" for name, others in sorted(left.items())]
        left = {name: others for name, others in left.items() if name not in ends}


def foreign(root: Path) -> list[str]:
    """One line for each import of a kernel but numpy, numba, the standard library and its own layer."""
    allowed = {"numpy", "numba", "motionmend", *sys.stdlib_module_names}
    return [
        f"{file.relative_to(root)}:{one.line}: imports {one.name}"
        for file in sorted((root / "kernels").rglob("*.py"))
        for one in imports(root, file)
        if one.name.split(".")[0] not in allowed
    ]


@pytest.mark.slow
def test_nothing_imports_upward() -> None:
    assert upward(PACKAGE) == []


def test_no_files_import_each_other_in_a_circle() -> None:
    assert circles(PACKAGE) == []


def test_a_planted_circle_is_found(copy: Path) -> None:
    (copy / "io" / "one.py").write_text("def f():\n    from .two import g\n", "utf-8")
    (copy / "io" / "two.py").write_text("from .three import h\n", "utf-8")
    (copy / "io" / "three.py").write_text("from ..io import one\n", "utf-8")
    found = circles(copy)
    assert [line.split()[0] for line in found] == ["motionmend.io.one", "motionmend.io.three", "motionmend.io.two"]


def test_folders_of_the_denoising_room_know_those_before_them() -> None:
    assert {path.parent.name for path in (PACKAGE / "denoise").glob("*/*.py")} <= set(DENOISE)
    assert inward(PACKAGE) == []


def test_a_folder_that_knows_a_later_one_is_told(copy: Path) -> None:
    (copy / "denoise" / "noise" / "planted.py").write_text("from ..adaptive.rounds import rounds\n", encoding="utf-8")
    assert inward(copy) == ["denoise/noise/planted.py:1: noise imports motionmend.denoise.adaptive.rounds.rounds"]


def test_heavy_libraries_are_imported_where_they_are_used() -> None:
    assert early(PACKAGE) == []


def test_kernels_know_only_arrays() -> None:
    assert foreign(PACKAGE) == []


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the package in which a test may break the rule."""
    root = tmp_path / "motionmend"
    shutil.copytree(PACKAGE, root, ignore=shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc"))
    return root


@pytest.mark.parametrize(
    ("file", "source", "wanted"),
    [
        ("bodies/planted.py", "from ..io import read", "bodies imports motionmend.io.read"),
        ("bodies/planted.py", "from .. import numerics", "bodies imports motionmend.numerics"),
        ("numerics/planted.py", "import motionmend.bodies.skeleton", "imports motionmend.bodies.skeleton"),
        (
            "kernels/planted.py",
            "def f():\n    from ..bodies import motion\n",
            "kernels imports motionmend.bodies",
        ),
        ("denoise/deep/planted.py", "from ...io.bvh import read_bvh", "denoise imports motionmend.io.bvh"),
        (
            "denoise/planted.py",
            "class A:\n    async def f(self):\n        from ..track import x\n",
            "track.x",
        ),
        ("io/planted.py", "if True:\n    from .. import denoise as d\n", "io imports motionmend.denoise"),
        ("samples/planted.py", "import motionmend", "samples imports motionmend"),
        ("samples/planted.py", "from motionmend import read", "samples imports motionmend.read"),
        (
            "evaluate/planted.py",
            "from importlib import import_module\nimport_module('motionmend.cli')",
            "cli",
        ),
        (
            "errors.py",
            "from .arrays import Floats\nfrom .bodies import motion",
            "errors imports motionmend.bodies",
        ),
        ("novel.py", "x = 1", "novel is in no layer"),
    ],
)
def test_a_planted_upward_import_is_found(copy: Path, file: str, source: str, wanted: str) -> None:
    planted = copy / file
    planted.parent.mkdir(exist_ok=True)
    planted.write_text(source, "utf-8")
    found = upward(copy)
    assert len(found) == 1, found
    assert wanted in found[0]
    assert found[0].startswith(file)


def test_a_planted_heavy_import_is_found_only_at_load(copy: Path) -> None:
    (copy / "io" / "planted.py").write_text("def f():\n    import ezc3d\n", "utf-8")
    assert early(copy) == []
    (copy / "io" / "planted.py").write_text("try:\n    import ezc3d\nexcept ImportError:\n    pass\n", "utf-8")
    assert early(copy) == ["io/planted.py:2: loads ezc3d"]


def test_a_planted_foreign_import_is_found(copy: Path) -> None:
    (copy / "kernels" / "planted.py").write_text("from scipy import linalg\n", "utf-8")
    assert foreign(copy) == ["kernels/planted.py:1: imports scipy.linalg"]
