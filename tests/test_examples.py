"""Every example runs as a user runs it, by the public library alone, and what it claims holds."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
FIGURE = re.compile(r"\d+(?:\.\d+)?")


def imported(source: str) -> set[str]:
    """Dotted names of the modules that a script imports."""
    nodes = list(ast.walk(ast.parse(source)))
    plain = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    return plain | {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}


def test_there_are_examples():
    assert len(EXAMPLES) >= 4


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_what_an_example_claims_holds(path, tmp_path):
    # From a folder of its own: an example needs no file, and leaves none.
    done = subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", str(path)],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr  # among others what it asserts at its end
    assert list(tmp_path.iterdir()) == []
    printed = path.read_text(encoding="utf-8").count("print(f")
    assert sum(bool(FIGURE.search(line)) for line in done.stdout.splitlines()) >= printed >= 2, done.stdout
    assert "nan" not in done.stdout


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_one_for_the_gallery(path):
    source = path.read_text(encoding="utf-8")
    title, rule, *_ = (ast.get_docstring(ast.parse(source)) or "\n").splitlines()
    assert rule == "=" * len(title)
    assert "\n# %%\n" in source
    assert source.count("plt.show()") == 1
    assert isinstance(ast.parse(source).body[-1], ast.Assert)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_uses_what_users_have(path):
    for name in imported(path.read_text(encoding="utf-8")):
        assert name.split(".")[0] in ("motionmend", "numpy", "matplotlib"), name
        assert not any(part.startswith("_") for part in name.split(".")), name
