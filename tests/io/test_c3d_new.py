"""C3D files written anew: they give back what was written, to us and to ezc3d and py-c3d."""

from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from c3d_files import markers, py_c3d, some_markers
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers
from motionmend.io.c3d import read_c3d, write_c3d

numbers = st.floats(-20, 20, allow_nan=False, width=32)
names = st.text(
    st.characters(codec="utf-8", exclude_categories=("C", "Z"), exclude_characters="*:"), min_size=1, max_size=8
)


@settings(max_examples=40)
@given(st.data(), st.integers(1, 6), st.integers(1, 4), st.sampled_from([119.88, 100.0, 29.97, 1 / 3, 1000.0]))
def test_new_files_give_back_what_was_written(tmp_path_factory, draw, frames: int, count: int, fps: float) -> None:
    labels = draw.draw(st.lists(names, min_size=count, max_size=count, unique=True))
    positions = np.array(draw.draw(st.lists(numbers, min_size=frames * count * 3, max_size=frames * count * 3)))
    positions = positions.reshape(frames, count, 3)
    positions[np.array(draw.draw(st.lists(st.booleans(), min_size=frames, max_size=frames)))] = np.nan
    # "_m" at the end: a label that ends in "Moment" or "Force" is that of a computed point, and is read as one.
    made = Markers(tuple(f"k{label}_m" for label in labels), positions, fps, up=np.array([0.0, 1.0, 0.0]))
    folder = tmp_path_factory.mktemp("new")
    write_c3d(folder / "a.c3d", made)
    read = read_c3d(folder / "a.c3d")
    assert read.names == made.names
    assert read.fps == pytest.approx(fps, rel=1e-7)
    np.testing.assert_array_equal(read.present, made.present)
    np.testing.assert_allclose(read.positions, made.positions, rtol=1e-6, atol=2e-9)
    write_c3d(folder / "b.c3d", made)
    assert (folder / "a.c3d").read_bytes() == (folder / "b.c3d").read_bytes()


def test_new_files_are_read_by_others(tmp_path: Path, rng) -> None:
    made = replace(some_markers(rng, count=300), up=np.array([0.0, 1.0, 0.0]))
    write_c3d(tmp_path / "a.c3d", made)
    theirs = ezc3d.c3d(str(tmp_path / "a.c3d"))
    np.testing.assert_allclose(theirs["data"]["points"][:3].T, made.positions * 1000, rtol=1e-6)
    assert theirs["parameters"]["POINT"]["UNITS"]["value"] == ["mm"]
    assert theirs["parameters"]["POINT"]["Y_SCREEN"]["value"] == ["+Y"]
    assert theirs["parameters"]["POINT"]["USED"]["value"] == [300]
    second = py_c3d(tmp_path / "a.c3d")
    np.testing.assert_array_equal(second[:, :, 3] < 0, ~made.present)
    np.testing.assert_allclose(second[made.present][:, :3], made.positions[made.present] * 1000, rtol=1e-6)


def test_residuals_are_written(tmp_path: Path, rng) -> None:
    made = markers(rng.normal(size=(5, 2, 3)), residuals=np.full((5, 2), 0.0012))
    write_c3d(tmp_path / "a.c3d", made)
    np.testing.assert_allclose(read_c3d(tmp_path / "a.c3d").residuals, 0.0012, atol=1e-8)
    np.testing.assert_allclose(py_c3d(tmp_path / "a.c3d")[:, :, 3], 1.2, atol=1e-6)
