"""TSV files of Qualisys Track Manager: read however they were exported, written as they came."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers
from motionmend.errors import FileError
from motionmend.io import looks_meant, read, write
from motionmend.io.qualisys import read_qualisys, write_qualisys

KEYS = (
    "NO_OF_FRAMES\t3\nNO_OF_CAMERAS\t9\nNO_OF_MARKERS\t2\nFREQUENCY\t300\nNO_OF_ANALOG\t0\nDESCRIPTION\t--\n"
    "TIME_STAMP\t2022-11-19, 17:00:37.668\t20040.25825930\nDATA_INCLUDED\t3D\nEVENT\ttick\t10\t12.0\n"
)
NAMES = "MARKER_NAMES\tLHEE\tLFHD\nTRAJECTORY_TYPES\tMixed\tMeasured\n"
TITLES = "Frame\tTime\tLHEE X\tLHEE Y\tLHEE Z\tLFHD X\tLFHD Y\tLFHD Z\n"
BARE = "1\t2\t3\t400\t500\t1700\n0.000\t0.000\t0.000\t401\t500\t1700\n3\t2\t3\t402\t500\t1700\n"
ROWS = "".join(f"{7 + k}\t{0.02 + k / 300:.5f}\t{row}\n" for k, row in enumerate(BARE.splitlines()))
FULL = KEYS + NAMES + TITLES + ROWS


def written(folder: Path, text: str, name: str = "a.tsv") -> Path:
    path = folder / name
    path.write_text(text, newline="")
    return path


VARIANTS = {
    "frames, times and titles": FULL,
    "without titles": KEYS + NAMES + ROWS,
    "without frames and times": KEYS + NAMES + BARE,
    "without trajectory types": KEYS + NAMES.splitlines()[0] + "\n" + BARE,
    "blank where missing": FULL.replace("0.000\t0.000\t0.000", "\t\t"),
    "NULL where missing": FULL.replace("0.000\t0.000\t0.000", "NULL\tNULL\tNULL"),
    "windows line ends": FULL.replace("\n", "\r\n"),
    "a byte order mark": "\ufeff" + FULL,
    "a tab behind every row": FULL.replace("1700\n", "1700\t\n"),
    "keys in small letters": FULL.replace("FREQUENCY", "Frequency"),
    "the first marker missing at first": KEYS
    + NAMES
    + BARE.replace("1\t2\t3", "\t\t").replace("0.000\t0.000\t0.000", "\t\t"),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_reads_what_exporters_write(tmp_path: Path, variant: str) -> None:
    file = read(written(tmp_path, VARIANTS[variant]))
    assert file.channels == ("LHEE", "LFHD")
    assert file.fps == 300.0
    assert file.present.tolist() == [["at first" not in variant, True], [False, True], [True, True]]
    np.testing.assert_allclose(file.positions[2], [[0.003, 0.002, 0.003], [0.402, 0.5, 1.7]])


@pytest.mark.parametrize("variant", VARIANTS)
def test_comes_back_as_it_was(tmp_path: Path, variant: str) -> None:
    text = VARIANTS[variant].replace("\r\n", "\n").replace("\ufeff", "").replace("\t\n", "\n")
    write(tmp_path / "b.tsv", read(written(tmp_path, VARIANTS[variant])))
    came = (tmp_path / "b.tsv").read_text()
    rows = len(BARE.splitlines())
    assert came.splitlines()[:-rows] == text.splitlines()[:-rows]
    for one, other in zip(came.splitlines()[-rows:], text.splitlines()[-rows:], strict=True):
        cells, wanted = one.split("\t"), other.split("\t")
        assert len(cells) == len(wanted)
        for a, b in zip(cells, wanted, strict=True):
            assert a == b or float(a) == pytest.approx(float(b), abs=1e-5)


@settings(max_examples=30)
@given(st.data(), st.integers(1, 5), st.integers(1, 4), st.sampled_from([119.88, 100.0, 300.0]))
def test_markers_from_elsewhere_survive(tmp_path_factory, draw, frames: int, count: int, fps: float) -> None:
    numbers = st.floats(-50, 50, allow_nan=False)
    positions = np.array(draw.draw(st.lists(numbers, min_size=frames * count * 3, max_size=frames * count * 3)))
    positions = positions.reshape(frames, count, 3)
    positions[np.array(draw.draw(st.lists(st.booleans(), min_size=frames, max_size=frames)))] = np.nan
    made = Markers(tuple(f"m {k}" for k in range(count)), positions, fps)
    path = tmp_path_factory.mktemp("tsv") / "a.tsv"
    write_qualisys(path, made)
    file = read_qualisys(path)
    assert (file.names, file.fps) == (made.names, fps)
    np.testing.assert_array_equal(file.present, made.present)
    np.testing.assert_allclose(file.positions, made.positions, rtol=1e-8, atol=2e-9)


BAD = {
    "empty": ("", "empty"),
    "no header": (BARE, "there is none; export it with its header"),
    "another table": ("a\tb\n1\t2\n", "export it with its header"),
    "binary": ("NO_OF_FRAMES\0", "binary"),
    "bodies": (FULL.replace("\t3D", "\t6D"), "wanted DATA_INCLUDED 3D, came 6D"),
    "no rate": (FULL.replace("FREQUENCY\t300", "FREQUENCY\t0"), "wanted a FREQUENCY above 0 Hz.*--fps"),
    "no rows": (KEYS + NAMES + TITLES, "ends before"),
    "fewer rows than promised": (FULL[: FULL.index("9\t0.02")], "promises 3 frames, the file holds 2"),
    "cut in a row": (FULL[:-12], "cut off or damaged"),
    "a word": (FULL.replace("402", "4o2"), "'4o2' in line 15 is no number"),
    "a name twice": (FULL.replace("\tLFHD\n", "\tLHEE\n", 1), "two columns"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_one_clear_line(tmp_path: Path, kind: str) -> None:
    text, why = BAD[kind]
    with pytest.raises(FileError, match=why) as caught:
        read(written(tmp_path, text))
    assert "\n" not in str(caught.value)
    assert "a.tsv" in str(caught.value)


def test_a_rate_that_the_file_lacks_is_given(tmp_path: Path) -> None:
    file = read(written(tmp_path, FULL.replace("FREQUENCY\t300\n", "")), fps=200.0)
    assert file.fps == 200.0
    assert any("200 Hz as given" in guess for guess in file.guesses)


def test_other_tables_in_a_folder_are_not_meant(tmp_path: Path) -> None:
    assert looks_meant(written(tmp_path, FULL))
    assert not looks_meant(written(tmp_path, "participant_id\tage\n1\t30\n", "participants.tsv"))
