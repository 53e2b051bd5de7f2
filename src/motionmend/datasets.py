"""Public recordings by name, fetched from where their authors keep them and believed only by their SHA-256.

Nothing is fetched unless somebody asks for it by name, and nothing is kept whose hash is another. Addresses hold the
version of the source that the hashes were taken from.
"""

import hashlib
import os
import urllib.error
import urllib.request
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path

from .errors import FileError, UsageError

_TIMEOUT = 30.0  # s without an answer
_PIECE = 1 << 16  # bytes
_SLACK = 1 << 20  # bytes more than promised that are still read, to tell a wrong file from an endless one

_LABAN = "https://raw.githubusercontent.com/microsoft/LabanotationSuite"
_GESTURES = "GestureAuthoringTools/LabanEditor/data_input"
_UIPRMD = (
    "https://raw.githubusercontent.com/niemasd/UI-PRMD-Analysis/26439c7c53318e27b77044f3d76d923c1e21a963/"
    "Segmented%20Movements"
)


@dataclass(frozen=True)
class Item:
    """A file of a data set: its place below the data set's folder, where it comes from, its hash and size in bytes."""

    path: str
    url: str
    sha256: str
    size: int


@dataclass(frozen=True)
class Dataset:
    """Recordings that belong together: what they are, whose, on which terms, and the files."""

    name: str
    what: str
    source: str
    terms: str
    items: tuple[Item, ...]

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(item.size for item in self.items)


DATASETS: tuple[Dataset, ...] = (
    Dataset(
        "laban-gestures",
        "three gestures of one person before a second Kinect: 25 joints with tracking states",
        "LabanotationSuite, github.com/microsoft/LabanotationSuite",
        "MIT",
        (
            Item(
                "Ges01_wavehand.csv",
                f"{_LABAN}/a1b332af8e99eb95da7e23368e58f837f207fbfe/{_GESTURES}/Ges01_wavehand.csv",
                "3f1677de9a0e7b1ce61d899300b96f1e162351b84f1a4d69f0ab9e0901a6e7cd",
                114790,
            ),
            Item(
                "Ges02_balancinghands.csv",
                f"{_LABAN}/fc370a36de707e4ab0de8345e564dfc940fc68d5/{_GESTURES}/Ges02_balancinghands.csv",
                "190bd8b24504a5e6dac3ff07898d4ceacadfe9e355113d57f955b541a6fe86ee",
                119623,
            ),
            Item(
                "Ges03_drawlines.csv",
                f"{_LABAN}/fc370a36de707e4ab0de8345e564dfc940fc68d5/{_GESTURES}/Ges03_drawlines.csv",
                "1741fdfc8965d71df67012008cce58b8aa3b44a0bee2fd3fff97edee82f62c30",
                159831,
            ),
        ),
    ),
    Dataset(
        "uiprmd-squats",
        "one deep squat of three people, by a second Kinect and by optical markers at once: pairs for `fit corrector`",
        "UI-PRMD, Vakanski et al. 2018, doi:10.3390/data3010002; copy of github.com/niemasd/UI-PRMD-Analysis",
        "research use, terms of the source",
        (
            Item(
                "Kinect/Positions/m01_s01_e01_positions.txt.gz",
                f"{_UIPRMD}/Kinect/Positions/m01_s01_e01_positions.txt.gz",
                "78a774da56bba70f9422bca48e3a6eaeb7491ad48f9409eeb5bfaa6e707dea3f",
                9342,
            ),
            Item(
                "Kinect/Angles/m01_s01_e01_angles.txt.gz",
                f"{_UIPRMD}/Kinect/Angles/m01_s01_e01_angles.txt.gz",
                "91ae7820c0937cf380a6c37cc5e67e37276d039e5d100584928dd3884ba50f46",
                16188,
            ),
            Item(
                "Vicon/Positions/m01_s01_e01_positions.txt.gz",
                f"{_UIPRMD}/Vicon/Positions/m01_s01_e01_positions.txt.gz",
                "77209a2a2d2992e324679a0d2a42ba0fed48ad83ad960f1812547fbb4c449b36",
                80869,
            ),
            Item(
                "Kinect/Positions/m01_s02_e01_positions.txt.gz",
                f"{_UIPRMD}/Kinect/Positions/m01_s02_e01_positions.txt.gz",
                "7976b0826a5c5446a00c055940f56cd86e4499d7a740167aa0c6a9c208a9a66c",
                9611,
            ),
            Item(
                "Kinect/Angles/m01_s02_e01_angles.txt.gz",
                f"{_UIPRMD}/Kinect/Angles/m01_s02_e01_angles.txt.gz",
                "5f06999ff28dc528fc1f9417a12ae1914ee2f0366afb8f80a8e54a79f640b708",
                16918,
            ),
            Item(
                "Vicon/Positions/m01_s02_e01_positions.txt.gz",
                f"{_UIPRMD}/Vicon/Positions/m01_s02_e01_positions.txt.gz",
                "c78c70ac9ebcb2d042cf4ccba6505065332c02f680579b86945881fadcc40eec",
                88129,
            ),
            Item(
                "Kinect/Positions/m01_s03_e01_positions.txt.gz",
                f"{_UIPRMD}/Kinect/Positions/m01_s03_e01_positions.txt.gz",
                "c93fc258beca10e33f4ef817b185c6666bc9b45bce352c1572f26cc06fc2f32e",
                9808,
            ),
            Item(
                "Kinect/Angles/m01_s03_e01_angles.txt.gz",
                f"{_UIPRMD}/Kinect/Angles/m01_s03_e01_angles.txt.gz",
                "ed5366ae64280ff2973ae67ab95d9d9b02e99e55c8dd2708d3de7263ec3208c7",
                17232,
            ),
            Item(
                "Vicon/Positions/m01_s03_e01_positions.txt.gz",
                f"{_UIPRMD}/Vicon/Positions/m01_s03_e01_positions.txt.gz",
                "8cf875adecf791bb831895812f6a0388380e0a2ef62d1b3b107e5f9a99bfef1a",
                97831,
            ),
        ),
    ),
)


def named(name: str, datasets: Sequence[Dataset] = DATASETS) -> Dataset:
    """The data set of that name.

    Raises
    ------
    UsageError : there is none.
    """
    for one in datasets:
        if one.name == name:
            return one
    raise UsageError(f"a data set named {', '.join(one.name for one in datasets)} was wanted, came {name!r}")


def fetch(dataset: Dataset, folder: str | os.PathLike[str], done: Callable[[Item], None] | None = None) -> list[Path]:
    """Fetch the files of a data set that are not there yet.

    Parameters
    ----------
    dataset : one of `DATASETS`.
    folder : the files lie below `folder/NAME`; made when it is not there.
    done : called with each file when it is there.

    Returns
    -------
    The files, in the order of the data set. One that is there with the right hash is not fetched again.

    Raises
    ------
    FileError : no connection, no such file at the source, another content than promised, or it cannot be written.
    """
    top = Path(folder) / dataset.name
    found = []
    for item in dataset.items:
        target = top / item.path
        if not (target.is_file() and sha256_of(target) == item.sha256):
            _fetch(item, target)
        found.append(target)
        if done is not None:
            done(item)
    return found


def sha256_of(path: str | os.PathLike[str]) -> str:
    """The SHA-256 of a file, in hexadecimal."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _fetch(item: Item, target: Path) -> None:
    from .io.atomic import atomic

    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        raise FileError(f"{target}: the folder cannot be made: {failure.strerror}; choose another with --dir") from None
    with atomic(target) as temporary:
        hashed, size = hashlib.sha256(), 0
        try:
            with urllib.request.urlopen(item.url, timeout=_TIMEOUT) as answer, temporary.open("wb") as file:
                while piece := answer.read(_PIECE):
                    hashed.update(piece)
                    size += len(piece)
                    file.write(piece)
                    if size > item.size + _SLACK:
                        break
        except (urllib.error.URLError, HTTPException, TimeoutError, ConnectionError, ValueError) as failure:
            why = getattr(failure, "reason", failure)
            raise FileError(
                f"{target}: {item.url} cannot be fetched ({why}); try again when it can be reached"
            ) from None
        if hashed.hexdigest() != item.sha256:
            raise FileError(
                f"{target}: {item.url} gave {size} bytes with SHA-256 {hashed.hexdigest()[:12]}..., wanted {item.size} "
                f"with {item.sha256[:12]}...: it was changed or cut off, and is not kept"
            )
