"""The face of io: by ending, whole files only, one line for what goes wrong, nothing heavy loaded before its time."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Motion, Origin, Repaired
from motionmend.errors import FileError, UsageError
from motionmend.io import READABLE, WRITABLE, read, write
from motionmend.io.atomic import atomic
from motionmend.io.vertical import up_of


def some_markers(rng: np.random.Generator) -> Markers:
    positions = rng.normal(size=(9, 3, 3)) * 0.1
    positions[:, 1, 2] += 1.7
    positions[4, 0] = np.nan
    return Markers(("LHEE", "LFHD", "CLAV"), positions, 120.0)


# ---- by ending


@pytest.mark.parametrize("ending", [".c3d", ".trc", ".csv", ".C3D", ".TRC", ".Csv"])
def test_markers_in_every_format(tmp_path: Path, rng, ending: str) -> None:
    made = some_markers(rng)
    write(tmp_path / f"a{ending}", made)
    back = read(str(tmp_path / f"a{ending}"))
    assert isinstance(back, Markers)
    assert (back.names, back.fps) == (made.names, made.fps)
    np.testing.assert_array_equal(back.present, made.present)
    np.testing.assert_allclose(back.positions, made.positions, atol=1e-7)
    np.testing.assert_array_equal(back.up, [0, 0, 1])


@pytest.mark.parametrize("source", [".c3d", ".trc", ".csv"])
@pytest.mark.parametrize("target", [".c3d", ".trc", ".csv"])
def test_from_any_marker_format_to_any(tmp_path: Path, rng, source: str, target: str) -> None:
    made = some_markers(rng)
    write(tmp_path / f"a{source}", made)
    write(tmp_path / f"b{target}", read(tmp_path / f"a{source}"))
    back = read(tmp_path / f"b{target}")
    np.testing.assert_array_equal(back.present, made.present)
    np.testing.assert_allclose(back.positions, made.positions, atol=1e-6)


def test_a_repair_is_listed_in_c3d_and_accepted_elsewhere(tmp_path: Path, rng) -> None:
    made = some_markers(rng)
    whole = made.with_positions(np.nan_to_num(made.positions))
    origin = np.where(made.present, Origin.MEASURED, Origin.FILLED)
    outcome = Repaired(whole, origin, np.zeros((9, 3)), np.ones((9, 3)), "paper")
    for ending in (".c3d", ".trc", ".csv"):
        write(tmp_path / f"a{ending}", whole, repaired=outcome)
    assert any("1 samples were filled" in guess for guess in read(tmp_path / "a.c3d").guesses)


@pytest.mark.parametrize("name", ["02/02_01.amc", "16/16_35.amc"])
def test_joint_angles_in_both_formats(data: Path, tmp_path: Path, name: str) -> None:
    source = data / "mocap" / "amc" / name
    if not source.exists():
        source = sorted(source.parent.glob("*.amc"))[0]
    motion = read(source)
    assert isinstance(motion, Motion)
    assert motion.fps == 120.0
    for ending in (".amc", ".bvh"):
        write(tmp_path / f"a{ending}", motion)
        back = read(tmp_path / f"a{ending}")
        assert back.frames == motion.frames
        assert back.fps == pytest.approx(120.0)


def test_skeleton_may_be_named(data: Path, tmp_path: Path) -> None:
    folder = data / "mocap" / "amc" / "02"
    (tmp_path / "walk.amc").write_bytes((folder / "02_01.amc").read_bytes())
    with pytest.raises(FileError):
        read(tmp_path / "walk.amc")
    assert read(tmp_path / "walk.amc", skeleton=folder / "02.asf").frames == 343
    assert read(tmp_path / "walk.amc", skeleton=folder / "02.asf", fps=60.0).fps == 60.0


@pytest.mark.parametrize("name", ["c3d/cmu_02_01.c3d", "bvh/12_01.bvh", "accad_txt/run1TXT.ZIP"])
def test_files_keep_their_own_rate(data: Path, name: str) -> None:
    own = read(data / "mocap" / name)
    other = read(data / "mocap" / name, fps=31.0)
    assert other.fps == own.fps
    assert any("31 Hz given were not used" in guess for guess in other.guesses)
    assert read(data / "mocap" / name, fps=own.fps).guesses == own.guesses


def test_what_cannot_be_written_where(tmp_path: Path, rng, data: Path) -> None:
    motion = read(data / "mocap" / "bvh" / "12_01.bvh")
    for ending in (".c3d", ".trc", ".csv", ".tsv", ".txt", ".zip", ".xyz", ""):
        with pytest.raises(UsageError, match=r"joint angles are written to \.amc or \.bvh"):
            write(tmp_path / f"a{ending}", motion)
    for ending in (".amc", ".bvh", ".txt", ".zip", ".xyz", ""):
        with pytest.raises(UsageError, match=r"markers are written to \.c3d or \.trc or \.csv"):
            write(tmp_path / f"a{ending}", some_markers(rng))
    assert list(tmp_path.iterdir()) == []
    assert set(WRITABLE) < set(READABLE)


# ---- what goes wrong is one line


@pytest.mark.parametrize("ending", [*READABLE, ".asf", ".xyz", ""])
def test_missing_folder_and_empty_file(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    with pytest.raises(FileError, match="no such file") as caught:
        read(path)
    assert "\n" not in str(caught.value)
    path.mkdir()
    with pytest.raises(FileError, match="folder"):
        read(path)
    path.rmdir()
    path.touch()
    with pytest.raises(FileError, match=r"empty|wanted a recording|no recording"):
        read(path)


CONTENTS = {
    "text": b"The quick brown fox\njumps over the lazy dog\n",
    "zeros": bytes(3000),
    "noise": bytes(np.random.default_rng(3).integers(0, 256, 5000, dtype=np.uint8)),
    "ones": b"\xff" * 700,
    "digits": b"1 2 3 4 5 6\n" * 50,
    "one line": b"x" * 100_000,
    "spaces": b" \n\t\n  ",
    "bvh": b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n",
    "c3d": b"\x02\x50" + bytes(1022),
    "zip": b"PK\x03\x04" + bytes(300),
    "quotes": b'time,"a_x\n"" ,\n' * 9,
}


@pytest.mark.parametrize("ending", READABLE)
@pytest.mark.parametrize("content", CONTENTS)
def test_wrong_endings_and_rubbish(tmp_path: Path, ending: str, content: str) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(CONTENTS[content])
    with pytest.raises(FileError) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none(tmp_path: Path, fps: float) -> None:
    with pytest.raises(UsageError, match="frame rate above 0"):
        read(tmp_path / "a.amc", fps=fps)


@pytest.mark.parametrize("fps", [1e-3, 1e7])
def test_a_rate_nobody_records_at(tmp_path: Path, rng, fps: float) -> None:
    markers = some_markers(rng)
    write(tmp_path / "a.trc", Markers(markers.names, markers.positions, fps))
    with pytest.raises(FileError, match=r"a\.trc: wanted a rate of 0\.1 to 100000 Hz, came"):
        read(tmp_path / "a.trc")


# ---- whole or not there


def spoil(path: Path, failure: BaseException) -> None:
    """Fail in the midst of writing."""
    with atomic(path) as temporary:
        temporary.write_text("half")
        raise failure


def test_atomic_success_and_failure(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with atomic(path) as temporary:
        assert temporary.parent == path.parent
        assert temporary.suffix == ".csv"
        assert temporary.name.startswith(".")
        temporary.write_text("old")
        assert not path.exists()
    for failure, seen in (
        (ZeroDivisionError(), ZeroDivisionError),
        (KeyboardInterrupt(), KeyboardInterrupt),
        (OSError(28, "No space left on device"), FileError),
    ):
        with pytest.raises(seen):
            spoil(path, failure)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_atomic_says_why_it_cannot(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no folder"), atomic(tmp_path / "none" / "a.csv"):
        pass
    with pytest.raises(FileError, match="it is a folder"), atomic(tmp_path):
        pass
    with pytest.raises(FileError, match="cannot be written"), atomic(tmp_path / "a.csv"):
        pass  # the block wrote nothing
    assert list(tmp_path.iterdir()) == []


def test_atomic_says_the_first_failure_where_nothing_can_be_removed_either(tmp_path: Path, monkeypatch) -> None:
    def refused(self: Path, missing_ok: bool = False) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(Path, "unlink", refused)
    with pytest.raises(FileError, match=r"a\.csv: cannot be written: Read-only file system"):
        spoil(tmp_path / "a.csv", OSError(30, "Read-only file system"))


def test_a_writer_within_another_speaks_of_the_file_that_was_wanted(tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught, atomic(tmp_path / "a.csv") as temporary:
        spoil(temporary, OSError(28, "No space left on device"))
    assert str(caught.value) == f"{tmp_path / 'a.csv'}: cannot be written: No space left on device"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".c3d", ".trc", ".csv"])
def test_a_writer_that_fails_keeps_the_old_file(tmp_path: Path, rng, monkeypatch, ending: str) -> None:
    made = some_markers(rng)
    path = tmp_path / f"a{ending}"
    write(path, made)
    before = path.read_bytes()

    def full(self: Path, content: bytes) -> int:
        with self.open("wb") as handle:
            handle.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(FileError, match="No space left"):
        write(path, made.with_positions(made.positions + 1))
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", [".c3d", ".trc", ".csv"])
def test_same_recording_same_bytes(tmp_path: Path, rng, ending: str) -> None:
    made = some_markers(rng)
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder / f"a{ending}", made)
    assert (tmp_path / "one" / f"a{ending}").read_bytes() == (tmp_path / "two" / f"a{ending}").read_bytes()


# ---- what is loaded


def test_nothing_heavy_is_loaded(tmp_path: Path, rng) -> None:
    write(tmp_path / "a.c3d", some_markers(rng))
    code = (
        "import sys, motionmend.io\n"
        f"motionmend.io.read({str(tmp_path / 'a.c3d')!r})\n"
        "print([n for n in ('ezc3d', 'numba', 'matplotlib', 'scipy', 'safetensors') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# ---- which way is up


def standing(up: int, sign: float, rng: np.random.Generator) -> np.ndarray:
    """A body of 1.7 m that walks about and crouches, its lowest marker on the floor."""
    heights = np.array([0.05, 0.06, 0.9, 1.0, 1.4, 1.6, 1.7])
    frames = 200
    positions = rng.normal(size=(frames, 7, 3)) * 0.02 + np.cumsum(rng.normal(size=(frames, 1, 3)) * 0.02, axis=0)
    crouch = 0.8 + 0.2 * np.cos(np.linspace(0, 9, frames))[:, None]
    positions[:, :, up] = sign * (heights * crouch + rng.normal(size=(frames, 7)) * 0.002)
    return positions


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(
    "names",
    [
        ("S:LTOE", "S:RANK", "b", "c", "d", "S:LFHD", "S:RBHD"),
        ("L.Toe", "R.Heel", "b", "c", "d", "R.Head", "TopFrontHead"),
        ("LHEL", "LMT5", "b", "c", "d", "ARIEL", "LFHD"),
        ("a", "b", "c", "d", "e", "f", "g"),
    ],
)
def test_up_by_names_or_by_the_floor(rng, names: tuple[str, ...], axis: int, sign: float) -> None:
    up, said = up_of(names, standing(axis, sign, rng))
    assert up.tolist() == (sign * np.eye(3)[axis]).tolist()
    assert said is not None
    letter = ("+" if sign > 0 else "-") + "xyz"[axis]
    assert f"up is taken as {letter}" in said


def test_up_by_the_screen(rng) -> None:
    nameless = tuple("abcdefg")
    up, said = up_of(nameless, standing(2, 1.0, rng), "-Y")
    assert up.tolist() == [0, -1, 0]
    assert "screen" in str(said)
    named = ("LTOE", "RANK", "b", "c", "d", "LFHD", "RBHD")
    assert up_of(named, standing(2, 1.0, rng), "+Z")[1] is None
    up, said = up_of(named, standing(2, 1.0, rng), "+Y")
    assert up.tolist() == [0, 0, 1]
    assert "+Y was not followed" in str(said)


def test_up_without_any_position() -> None:
    up, said = up_of(("a",), np.full((3, 1, 3), np.nan))
    assert up.tolist() == [0, 0, 1]
    assert said is not None
