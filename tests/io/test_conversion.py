"""What another format has no place for, and by which number a file counts its frames."""

import struct
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from c3d_files import markers, real, some_markers

from motionmend import samples
from motionmend.bodies.postures import Postures
from motionmend.io import read, write
from motionmend.io.conversion import first_frame, not_in
from motionmend.io.trc import TrcSource


def with_all(path: Path) -> Path:
    """A C3D with analog channels, two events, a computed point and a group of its own."""
    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    c3d["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = ["LFHD", "RFHD", "LKneeAngles"]
    c3d["parameters"]["ANALOG"]["RATE"]["value"] = [100.0]
    c3d["parameters"]["ANALOG"]["LABELS"]["value"] = ["Fz", "EMG"]
    c3d["data"]["points"] = np.concatenate([np.random.default_rng(0).normal(size=(3, 3, 9)), np.ones((1, 3, 9))])
    c3d["data"]["analogs"] = np.ones((1, 2, 9))
    c3d.add_parameter("EVENT", "USED", [2])
    c3d.add_parameter("SUBJECTS", "NAMES", ["Ada"])
    c3d.write(str(path))
    return path


def test_a_c3d_loses_in_text_what_it_has_and_nothing_else(tmp_path: Path) -> None:
    made = read(with_all(tmp_path / "a.c3d"))
    for ending in (".trc", ".csv", ".tsv"):
        (said,) = not_in(ending, made)
        for what in ("2 events", "2 analog channels", "1 point that", "SUBJECTS"):
            assert what in said
        assert "force plate" not in said
    assert not_in(".c3d", made) == ()
    assert not any("untouched" in guess for guess in made.guesses)


def test_what_has_nothing_more_loses_nothing(tmp_path: Path, rng: np.random.Generator) -> None:
    made = some_markers(rng)
    for ending in (".c3d", ".trc", ".csv", ".tsv"):
        write(tmp_path / f"a{ending}", made)
        again = read(tmp_path / f"a{ending}")
        for other in (".c3d", ".trc", ".csv", ".tsv"):
            assert not_in(other, again) == ()


def test_a_table_loses_what_stands_beside_positions_and_angles_their_limits(tmp_path: Path) -> None:
    table = Postures(("head", "pelvis"), np.ones((4, 2, 3)), np.arange(4) / 30, std=np.full((4, 2), 0.1))
    assert not_in(".csv", table) == ()
    assert "deviations" in not_in(".bvh", table)[0]
    clip = samples.clip("walk", seconds=0.2)
    write(tmp_path / "a.amc", clip)
    assert "limits" in not_in(".bvh", read(tmp_path / "a.amc"))[0]
    assert not_in(".amc", read(tmp_path / "a.amc")) == ()


def test_the_number_of_the_first_frame(tmp_path: Path, rng: np.random.Generator) -> None:
    made = some_markers(rng)
    write(tmp_path / "a.c3d", made)
    raw = bytearray((tmp_path / "a.c3d").read_bytes())
    assert first_frame(read(tmp_path / "a.c3d")) is None
    struct.pack_into("<2H", raw, 6, 501, 520)
    (tmp_path / "a.c3d").write_bytes(raw)
    assert first_frame(read(tmp_path / "a.c3d")) == 501
    source = TrcSource({"Units": "m"}, 1.0, 77, 0.5, np.zeros(0))
    write(tmp_path / "a.trc", replace(made, source=source))
    assert first_frame(read(tmp_path / "a.trc")) == 77
    write(tmp_path / "a.csv", made)
    assert first_frame(read(tmp_path / "a.csv")) is None


@pytest.mark.parametrize(("name", "what"), [("gt_squat", "SUBJECTS"), ("emory_SoccerHeader", "analog channel")])
def test_real_files(data: Path, name: str, what: str) -> None:
    recording = read(real(data, name))
    assert what in not_in(".trc", recording)[0]
    assert not_in(".c3d", recording) == ()


def test_markers_from_nowhere_lose_nothing() -> None:
    assert not_in(".trc", markers(np.ones((3, 2, 3)))) == ()
