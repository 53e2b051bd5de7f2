"""MATLAB files: what scipy wrote comes back, and what is damaged is an error and never the end of the process."""

import io
import random
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat, whosmat

from motionmend.io.mat5 import MatError, variables

RNG = np.random.default_rng(0)
HELD = {
    "d": RNG.normal(size=(20, 3, 4)),
    "u": RNG.integers(0, 4000, (5, 6, 2)).astype(np.uint16),
    "s": RNG.normal(size=(2, 3)).astype(np.float32),
    "i": np.arange(-4, 4, dtype=np.int8).reshape(2, 4),
    "text": "words",
    "z": np.array([[1 + 2j]]),
    "none": np.zeros((0, 3)),
    "struct": {"a": 1.0},
}


def saved(compressed: bool) -> bytes:
    whole = io.BytesIO()
    savemat(whole, HELD, do_compression=compressed)
    return whole.getvalue()


@pytest.mark.parametrize("compressed", [False, True])
def test_what_is_in_a_file(tmp_path: Path, compressed: bool) -> None:
    path = tmp_path / "a.mat"
    path.write_bytes(saved(compressed))
    found = {one.name: one for one in variables(path)}
    told = {name: (shape, kind) for name, shape, kind in whosmat(path) if name not in ("z", "text")}
    assert {name: (one.shape, one.kind) for name, one in found.items() if name in told} == told
    assert set(found) == set(HELD)
    for name in ("d", "u", "s", "i", "none"):
        values = found[name].numbers()
        np.testing.assert_array_equal(values, loadmat(path)[name])
        assert values.dtype == HELD[name].dtype  # type: ignore[attr-defined]
    for name in ("text", "z", "struct"):
        with pytest.raises(MatError, match=f"{name} holds no plain numbers"):
            found[name].numbers()


def test_bytes_may_be_the_other_way_round(tmp_path: Path) -> None:
    def element(kind: int, body: bytes) -> bytes:
        return struct.pack(">II", kind, len(body)) + body + bytes(-len(body) % 8)

    numbers = np.arange(6, dtype=">f8")
    inside = element(6, struct.pack(">II", 6, 0)) + element(5, struct.pack(">2i", 2, 3)) + element(1, b"big")
    array = element(14, inside + element(9, numbers.tobytes()))
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI" + array)
    (only,) = variables(tmp_path / "a.mat")
    np.testing.assert_array_equal(only.numbers(), numbers.reshape(2, 3, order="F"))
    np.testing.assert_array_equal(loadmat(tmp_path / "a.mat")["big"], only.numbers())


def test_whole_numbers_stay_as_short_as_they_are_stored(tmp_path: Path) -> None:
    """MATLAB writes doubles that are whole as such; depth would take four times the memory."""
    raw = bytearray(saved(False))
    at = raw.index(struct.pack("<I", 11), 128)  # the class of `u`
    raw[at] = 6
    (tmp_path / "a.mat").write_bytes(raw)
    found = {one.name: one for one in variables(tmp_path / "a.mat")}["u"]
    assert found.kind == "double"
    assert found.numbers().dtype == np.uint16


@pytest.mark.slow
@pytest.mark.parametrize("compressed", [False, True])
def test_whatever_is_damaged_ends_in_one_line(tmp_path: Path, compressed: bool) -> None:
    """Of such files scipy's reader ended the process in one of a hundred."""
    rng, path = random.Random(1), tmp_path / "a.mat"
    whole = io.BytesIO()
    savemat(whole, {"d_skel": HELD["d"]})
    raw = whole.getvalue()
    said = []
    for _ in range(600):
        spoilt = bytearray(raw)
        for _ in range(rng.choice([1, 1, 2, 4])):
            spoilt[rng.randrange(128 if compressed else 0, 200)] = rng.randrange(256)
        if rng.random() < 0.2:
            del spoilt[rng.randrange(len(spoilt)) :]
        if compressed:
            packed = zlib.compress(bytes(spoilt[128:]), 1)
            spoilt[128:] = struct.pack("<II", 15, len(packed)) + packed
        path.write_bytes(spoilt)
        try:
            for one in variables(path):
                if one.numeric:
                    one.numbers()
        except MatError as error:
            said.append(str(error))
    assert 100 < len(said) < 600
    assert all(len(line.splitlines()) == 1 for line in said)


def test_other_versions_say_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "a.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400))
    with pytest.raises(MatError, match=r"MATLAB 7\.3 file; save it with -v7 to have it read$"):
        variables(tmp_path / "a.mat")
    (tmp_path / "a.mat").write_bytes(struct.pack("<5i", 0, 1, 1, 0, 2).ljust(200, b"\0"))
    with pytest.raises(MatError, match="MATLAB 4 file, none of version 5 to 7; save it with -v7"):
        variables(tmp_path / "a.mat")
    (tmp_path / "a.mat").write_bytes(bytes(200))
    with pytest.raises(MatError, match="version 5 to 7, or its header is damaged; get a complete copy"):
        variables(tmp_path / "a.mat")


def test_what_unpacks_to_more_than_its_shape_promises_is_not_unpacked(tmp_path: Path) -> None:
    """Ten megabytes of zeros for six numbers, in ten kilobytes."""

    def element(kind: int, body: bytes) -> bytes:
        return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)

    inside = element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<2i", 2, 3)) + element(1, b"d")
    packed = zlib.compress(element(14, inside + element(9, bytes(10_000_000))))
    whole = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed
    (tmp_path / "a.mat").write_bytes(whole)
    (only,) = variables(tmp_path / "a.mat")
    with pytest.raises(MatError, match="more than its shape promises"):
        only.numbers()
