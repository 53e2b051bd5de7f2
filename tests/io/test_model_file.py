"""Model files: what goes in comes out, damage is noticed, nothing is executed."""

import hashlib
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from safetensors.numpy import save_file

from motionmend.errors import FileError, UsageError
from motionmend.io.model import load_model, save_model

dtypes = st.sampled_from(["f8", "f4", "f2", "i8", "i4", "u1", "u2", "?", ">f8", ">i4"])
arrays = st.dictionaries(
    st.text(st.characters(codec="utf-8", exclude_categories=("C",)), min_size=1, max_size=6),
    dtypes.flatmap(lambda d: hnp.arrays(d, hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))),
    max_size=4,
)
values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**60), 2**60)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=60)
@given(st.text(max_size=8), arrays, st.dictionaries(st.text(), values, max_size=4))
def test_comes_back_as_saved(tmp_path_factory, kind: str, stored: dict, header: dict) -> None:
    path = tmp_path_factory.mktemp("model") / "a.mend"
    digest = save_model(path, kind, stored, header)
    model = load_model(path)
    assert (model.kind, model.header, model.sha256) == (kind, header, digest)
    assert digest == hashlib.sha256(path.read_bytes()).hexdigest()
    assert set(model.arrays) == set(stored)
    for name, array in stored.items():
        np.testing.assert_array_equal(model.arrays[name], array)
        assert model.arrays[name].shape == array.shape
        assert model.arrays[name].dtype == array.dtype.newbyteorder("=")
        assert not model.arrays[name].flags.writeable
    first = path.read_bytes()
    save_model(path, kind, dict(reversed(stored.items())), dict(reversed(header.items())))
    assert path.read_bytes() == first, "same content, same bytes"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "a.mend"
    save_model(
        path,
        "denoiser",
        {"mean": np.arange(12.0).reshape(3, 4).T, "flag": np.array(True)},
        {"fps": 30.0, "names": ["a"]},
    )
    return path


@pytest.mark.slow
def test_every_flipped_bit_is_noticed(model: Path) -> None:
    whole = model.read_bytes()
    for at in range(len(whole)):
        for bit in range(8):
            damaged = bytearray(whole)
            damaged[at] ^= 1 << bit
            model.write_bytes(damaged)
            with pytest.raises(FileError) as caught:
                load_model(model)
            assert "\n" not in str(caught.value)


def test_every_cut_is_noticed(model: Path) -> None:
    whole = model.read_bytes()
    for size in range(len(whole)):
        model.write_bytes(whole[:size])
        with pytest.raises(FileError):
            load_model(model)


class Evil:
    """What a pickle would run on loading."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))


def test_pickles_and_strangers_are_refused(tmp_path: Path) -> None:
    path, trace = tmp_path / "a.mend", tmp_path / "ran"
    path.write_bytes(pickle.dumps(Evil(trace)))
    with pytest.raises(FileError, match="this is none"):
        load_model(path)
    assert not trace.exists()
    save_file({"a": np.ones(3)}, str(path))
    with pytest.raises(FileError, match="this is none"):
        load_model(path)
    path.write_bytes(b"")
    with pytest.raises(FileError, match="this is none"):
        load_model(path)
    with pytest.raises(FileError, match="cannot open"):
        load_model(tmp_path / "nowhere.mend")
    with pytest.raises(FileError, match="cannot open"):
        load_model(tmp_path)


def test_what_cannot_be_saved(tmp_path: Path) -> None:
    path = tmp_path / "a.mend"
    with pytest.raises(UsageError, match="type object"):
        save_model(path, "x", {"a": np.array([{}], dtype=object)}, {})
    with pytest.raises(UsageError, match="'a' is of type <U1"):
        save_model(path, "x", {"a": np.array(["b"])}, {})
    with pytest.raises(UsageError, match="JSON"):
        save_model(path, "x", {}, {"a": np.nan})
    with pytest.raises(UsageError, match="JSON"):
        save_model(path, "x", {}, {"a": np.ones(2)})
    with pytest.raises(UsageError, match=r"\.mend"):
        save_model(tmp_path / "a.safetensors", "x", {}, {})
    with pytest.raises(FileError, match="no folder"):
        save_model(tmp_path / "none" / "a.mend", "x", {}, {})
    assert list(tmp_path.iterdir()) == []
