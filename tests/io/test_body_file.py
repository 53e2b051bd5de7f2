"""Bodies stored and used again."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.anatomy import average
from motionmend.errors import FileError
from motionmend.io.body_file import read_body, write_body


@settings(max_examples=10)
@given(st.floats(1.2, 2.2), st.integers(0, 2**32 - 1))
def test_a_body_comes_back(tmp_path_factory: pytest.TempPathFactory, stature: float, seed: int) -> None:
    body = average(stature).stretched(np.random.default_rng(seed).uniform(0.8, 1.3, (15, 3)))
    path = tmp_path_factory.mktemp("body") / "body.json"
    write_body(path, body)
    again = read_body(path)
    for name in ("offsets", "landmark_place", "tip_place", "lengths"):
        np.testing.assert_allclose(getattr(again, name), getattr(body, name), rtol=1e-8, atol=1e-12)
    for name in ("bone", "kind", "center", "turn", "size", "taper"):
        np.testing.assert_allclose(getattr(again.solids, name), getattr(body.solids, name), rtol=1e-8, atol=1e-12)
    write_body(path.with_name("again.json"), again)
    facts, later = (json.loads(one.read_text()) for one in (path, path.with_name("again.json")))
    assert facts.pop("lengths_m")["l_thigh"] == pytest.approx(body.lengths[9])
    later.pop("lengths_m")  # follow from the rest
    assert facts == later


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "JSON"),
        ("[1, 2]", "other JSON"),
        ('{"kind": "motionmend body", "version": 9}', "version 1"),
        ('{"kind": "motionmend body", "version": 1, "solids": {}}', "damaged"),
    ],
)
def test_what_is_no_body_is_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "body.json"
    path.write_text(text)
    with pytest.raises(FileError, match=said) as failure:
        read_body(path)
    assert "body.json" in str(failure.value)


def test_a_body_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot open"):
        read_body(tmp_path / "body.json")


def test_an_editor_may_have_put_a_mark_before_it(tmp_path: Path) -> None:
    path = tmp_path / "body.json"
    write_body(path, average(1.7))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    np.testing.assert_allclose(read_body(path).lengths, average(1.7).lengths, rtol=1e-8)


def test_lengths_that_were_changed_alone_are_not_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "body.json"
    write_body(path, average(1.7))
    facts = json.loads(path.read_text())
    facts["lengths_m"]["l_thigh"] *= 1.1
    path.write_text(json.dumps(facts))
    with pytest.raises(FileError, match=r"l_thigh is .* in lengths_m") as failure:
        read_body(path)
    assert "\n" not in str(failure.value)


def test_a_solid_on_no_bone(tmp_path: Path) -> None:
    path = tmp_path / "body.json"
    write_body(path, average(1.7))
    facts = json.loads(path.read_text())
    facts["solids"]["bone"][3] = 99
    path.write_text(json.dumps(facts))
    with pytest.raises(FileError, match="solids on bones that it lacks"):
        read_body(path)
