"""Tables of joints with deviations, reliabilities and states."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.postures import Postures
from motionmend.errors import FileError
from motionmend.io.joint_table import beside_of, read_joint_table, starts_as_joint_table, write_joint_table
from motionmend.io.table import read_table

PLAIN = "time,head_x,head_y,head_z,l_hand_x,l_hand_y,l_hand_z\n0,0.1,0.2,2.3,0,0.5,2\n0.033333,,,,0,0.5,2\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "a.csv"
    path.write_text(text, newline="")
    return path


def test_reads_names_metres_seconds_and_blanks(tmp_path: Path) -> None:
    read = read_joint_table(written(tmp_path, PLAIN))
    assert read.names == ("head", "l_hand")
    assert read.times.tolist() == [0.0, 0.033333]
    assert read.present.tolist() == [[True, True], [False, True]]
    assert read.positions[0, 0].tolist() == [0.1, 0.2, 2.3]
    assert read.std is None
    assert read.state is None
    assert read.reliability is None


def test_written_as_read(tmp_path: Path) -> None:
    write_joint_table(tmp_path / "b.csv", read_joint_table(written(tmp_path, PLAIN)))
    assert (tmp_path / "b.csv").read_text() == PLAIN


def test_columns_are_found_by_title_in_any_order(tmp_path: Path) -> None:
    read = read_joint_table(written(tmp_path, "time,a_state,a_z,a_y,a_x,b_x,b_y,b_z,b_std\n1,2,3,2,1,4,5,6,0.5\n"))
    assert read.names == ("a", "b")
    assert read.positions[0].tolist() == [[1, 2, 3], [4, 5, 6]]
    assert read.state is not None
    assert read.state.tolist() == [[2, 2]]  # nothing is told of b
    assert read.std is not None
    assert np.isnan(read.std[0, 0])
    assert read.std[0, 1] == 0.5
    assert beside_of(tmp_path / "a.csv") == {"std", "state"}


@settings(max_examples=40)
@given(st.data(), st.integers(1, 5), st.integers(1, 4))
def test_everything_comes_back(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject, frames: int, joints: int
) -> None:
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    xyz = rng.normal(size=(frames, joints, 3)) * 10.0 ** rng.integers(-4, 3, (frames, joints, 1))
    xyz[rng.random((frames, joints)) < 0.2] = np.nan
    whole = Postures(
        tuple(f"j_{k} w,x" for k in range(joints)),
        xyz,
        data.draw(st.sampled_from([0.0, 12.5, 6.3e7])) + np.arange(frames) / 30,
        state=rng.integers(0, 3, (frames, joints), dtype=np.uint8) if data.draw(st.booleans()) else None,
        std=rng.random((frames, joints)) if data.draw(st.booleans()) else None,
        reliability=rng.random((frames, joints)) if data.draw(st.booleans()) else None,
    )
    path = tmp_path_factory.mktemp("table") / "a.csv"
    write_joint_table(path, whole)
    again = read_joint_table(path)
    assert again.names == whole.names
    np.testing.assert_allclose(again.times, whole.times, rtol=0, atol=1.01e-6)
    np.testing.assert_allclose(again.positions, whole.positions, rtol=1e-8)
    for what in ("state", "std", "reliability"):
        one, other = getattr(whole, what), getattr(again, what)
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_allclose(other, one, rtol=1e-8)
    write_joint_table(path.with_name("b.csv"), again)
    assert path.read_bytes() == path.with_name("b.csv").read_bytes()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("frame,a_x,a_y,a_z\n", "first title"),
        ("time,a_x,a_y\n0,1,2\n", "x, y and z"),
        ("time,a_x,a_y,a_z,a_w\n0,1,2,3,4\n", "a_w"),
        ("time,a_x,a_y,a_z,a_x\n0,1,2,3,4\n", "two columns"),
        ("time,a_x,a_y,a_z\n", "cut off"),
        ("time,a_x,a_y,a_z\n0,1,2\n", "line 2"),
        ("time,a_x,a_y,a_z\n0,1,2,three\n", "no number"),
        ("time,a_x,a_y,a_z\n,1,2,3\n", "time in line 2"),
        ("time,a_x,a_y,a_z,a_std\n0,1,2,3,-1\n", "_std"),
        ("time,a_x,a_y,a_z,a_state\n0,1,2,3,7\n", "_state"),
        ("time,a_x,a_y,a_z,a_reliability\n0,1,2,3,1.5\n", "_reliability"),
    ],
)
def test_a_bad_table_is_one_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileError, match=said) as failure:
        read_joint_table(written(tmp_path, text))
    assert "a.csv" in str(failure.value)
    assert "\n" not in str(failure.value)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, None), (100.0, "centimetres"), (1000.0, "millimetres")])
def test_a_body_larger_than_anybody_is_said_to_be_in_other_units(
    tmp_path: Path, scale: float, unit: str | None
) -> None:
    body = np.array([[0.0, 1.7, 3.0], [0.0, 1.0, 3.0], [0.1, 0.1, 3.0]])
    for names in (("head", "pelvis", "l_ankle"), ("a1", "a2", "a3")):  # markers of a room may well lie apart
        table = Postures(names, np.tile(scale * body, (4, 1, 1)), np.arange(4) / 30)
        write_joint_table(tmp_path / "a.csv", table)
        for warnings in (read_joint_table(tmp_path / "a.csv").warnings, read_table(tmp_path / "a.csv").warnings):
            said = [one for one in warnings if "metres were wanted" in one]
            assert len(said) == (unit is not None and names[0] == "head")
            assert all(f"are the numbers {unit}?" in one for one in said)
        (tmp_path / "a.csv").unlink()


def test_what_starts_as_one(tmp_path: Path) -> None:
    assert starts_as_joint_table(written(tmp_path, PLAIN))
    assert not starts_as_joint_table(written(tmp_path, "time,a,b\n0,1,2\n"))


def test_nothing_to_write_and_names_that_stand_twice(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="joints and frames"):
        write_joint_table(tmp_path / "a.csv", Postures((), np.zeros((0, 0, 3)), np.zeros(0)))
    with pytest.raises(FileError, match="two joints"):
        write_joint_table(tmp_path / "a.csv", Postures(("a", "a"), np.zeros((1, 2, 3)), np.zeros(1)))
    assert not list(tmp_path.iterdir())
