"""The README's example runs as it stands there."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


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
