"""Recordings of sensor skeletons: one reader for each format, chosen by what is in the file."""

import gzip
import json
import os
import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..bodies.postures import Postures
from ..errors import FileError, UsageError, counted
from .kinect_titles import are_numbered, columns_of, columns_without_titles
from .number_rows import numbers_of, split_cells
from .sensor_source import SensorSource, even_times, with_absent

SENSOR_ENDINGS = (".skl", ".skeleton", ".csv", ".txt", ".gz", ".mat", ".json", ".trc")
_TURNED = 1e-3  # off 1 that the norm of a quaternion in a text may be
_HEAD = 1 << 16  # bytes that hold the first row of every format

# What a file is whose content is known but no sensor's skeleton, and what to do with it.
_OTHERS = {
    "uiprmd angles": "UI-PRMD's angles: give the Positions file of the same name, its angles are read with it",
    "uiprmd markers": "UI-PRMD's optical markers: they are the truth in a list of pairs, nothing to correct",
    "keraal bodies": "Keraal's optical rigid bodies: they are the truth in a list of pairs, nothing to correct",
    "turns": "how joints are turned (quaternions), not where they are: give the positions recorded with them",
    "depth": "depth pictures: `motionmend track` takes them",
    "markers": "joint angles or markers: `motionmend denoise` takes them",
    "json": "JSON of another kind",
    "": "none of the layouts known",
}


def read_postures(path: str | os.PathLike[str], *, fps: float | None = None) -> Postures:
    """Read what a depth sensor, or a pose estimator, says of a person over time.

    Parameters
    ----------
    path : a Kinect table (.skl, .csv), a KIMORE .csv, an NTU .skeleton, UI-PRMD Kinect positions (.txt, .txt.gz),
        a UTD-MHAD skeleton (.mat), a Keraal Kinect text, Azure Kinect bodies (.json), a TRC of Pose2Sim, or our own
        table of joints (.csv).
    fps : Hz, of a file without times; 30 (what the sensors have) when not given.

    Returns
    -------
    postures : metres and seconds, in the sensor's axes, order and names; NaN where there is no position. What had to be
        supposed is in `guesses`, what is wrong with the file in `warnings`.

    Raises
    ------
    FileError : not there, empty, none of these, damaged or cut off.
    UsageError : a rate that is none.
    """
    file = Path(path)
    if fps is not None and not 0 < fps < float("inf"):
        raise UsageError(f"a frame rate above 0 Hz is wanted, came {fps}")
    if file.is_dir():
        raise FileError(f"{file}: wanted a sensor's recording, this is a folder; name a file in it")
    if not file.exists():
        raise FileError(f"{file}: no such file; check the path")
    if not file.stat().st_size:
        raise FileError(f"{file}: wanted a sensor's recording, this file is empty; get a complete copy")
    kind = kind_of(file)
    if kind in _OTHERS:
        raise FileError(f"{file}: wanted joints as a sensor gives them, came {_OTHERS[kind]}")
    postures = _read(file, kind, fps)
    if not (postures.present & postures.positions.any(axis=2)).any():  # zeros are what recorders write for nobody
        raise FileError(
            f"{file}: nobody is in it: no joint has a position in any of {counted(postures.frames, 'frame')}"
        )
    if fps is None or np.allclose(np.diff(postures.times), 1.0 / fps, rtol=1e-4):
        return postures
    return replace(
        postures, guesses=(*postures.guesses, f"the file has its own times: the {fps:g} Hz given were not used")
    )


def kind_of(path: str | os.PathLike[str]) -> str:
    """What a file is by its content: a key of the readers, of what they refuse, or "" for what is not known.

    Parameters
    ----------
    path : a file.

    Raises
    ------
    FileError : it cannot be opened.
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending in (".skl", ".skeleton", ".trc"):
        return {".skl": "table", ".skeleton": "ntu", ".trc": "trc"}[ending]
    if ending in (".amc", ".bvh", ".c3d", ".zip"):
        return "markers"
    if ending == ".mat":
        from .utdmhad import variables_of

        found = variables_of(file)
        return (
            "depth"
            if {"d_depth", "depth_array"} & set(found)
            else "utdmhad"
            if found == () or "d_skel" in found
            else ""
        )
    head = _head(file)
    start = head.lstrip()[:1]
    if start in ("{", "[") or ending == ".json":
        return "azure" if _azure(file, head) else "json"
    return _of_text(file, head)


def looks_like_sensor(path: str | os.PathLike[str]) -> bool:
    """Whether a file found in a folder is a sensor's skeleton; also True for what cannot be opened, so that reading it
    says why."""
    try:
        return not Path(path).stat().st_size or kind_of(path) not in _OTHERS
    except (FileError, OSError):
        return True


def _read(file: Path, kind: str, fps: float | None) -> Postures:
    if kind == "table":
        from .kinect_table import read_kinect_table

        return read_kinect_table(file, fps)
    if kind == "ntu":
        from .ntu import read_ntu

        return read_ntu(file, fps)
    if kind == "uiprmd":
        from .uiprmd import read_uiprmd

        return read_uiprmd(file, fps)
    if kind == "utdmhad":
        from .utdmhad import read_utdmhad

        return read_utdmhad(file, fps)
    if kind == "keraal":
        from .keraal import read_keraal

        return read_keraal(file, fps)
    if kind == "azure":
        from .azure import read_azure

        return read_azure(file, fps)
    if kind == "joints":
        from .joint_table import read_joint_table

        return _with_kind(_of_table(read_joint_table(file)), "table of joints", fps)
    return _with_kind(_of_trc(file, fps), "joints in a TRC file", fps)


def _of_table(postures: Postures) -> Postures:
    """A table of joints without those that are at the sensor itself, as recorders write what they do not see."""
    positions, _ = with_absent(postures.positions, postures.state)  # a table that has infinite ones is refused
    zeros = int((postures.present & ~np.isfinite(positions).all(axis=2)).sum())
    said = (f"{counted(zeros, 'position')} at exactly (0, 0, 0), or of nobody, taken as missing",) if zeros else ()
    return replace(postures, positions=positions, guesses=(*postures.guesses, *said))


def _of_trc(file: Path, fps: float | None) -> Postures:
    """The joints of a TRC file at its own times; where it lacks them, at those of its rate."""
    from .trc import STATED, TrcSource, read_trc

    markers = read_trc(file, fps)
    assert isinstance(markers.source, TrcSource)
    even, own = markers.source.start + np.arange(markers.frames) / markers.fps, markers.source.times
    known = bool(np.isfinite(own).all())
    rest = tuple(one for one in markers.guesses if not one.startswith(STATED))  # it is not what counts
    return Postures(
        markers.names,
        markers.positions,
        own if known else even,
        guesses=rest if known else markers.guesses,
        warnings=markers.warnings,
    )


def _with_kind(postures: Postures, kind: str, fps: float | None) -> Postures:
    """With a source, and warnings of times that do not rise."""
    warnings = postures.warnings
    steps = np.diff(postures.times)
    if len(steps) and not (steps > 0).any():
        times, said = even_times(postures.frames, fps, why="the times do not rise")
        return replace(postures, times=times, source=SensorSource(kind), warnings=(*warnings, *said))
    same, back = int((steps == 0).sum()), int((steps < 0).sum())
    if back and not any("goes back" in one for one in warnings):
        warnings += (f"the time goes back {back} times: rows are kept in the order of the file",)
    if same:
        warnings += (f"{same} of {postures.frames} times are those of the row before",)
    return replace(postures, source=SensorSource(kind), warnings=warnings)


def _head(file: Path) -> str:
    """The start of a file as text, unzipped when it is gzip."""
    try:
        with file.open("rb") as raw:
            packed = raw.read(2) == b"\x1f\x8b"
        with gzip.open(file) if packed else file.open("rb") as content:
            start = content.read(_HEAD)
    except (OSError, EOFError, zlib.error) as failure:
        raise FileError(
            f"{file}: wanted a sensor's recording, cannot read it: {failure}; get a complete copy"
        ) from None
    wide = start[:2] in (b"\xff\xfe", b"\xfe\xff")
    return start.decode("utf-16" if wide else "utf-8-sig", errors="replace")


def _azure(file: Path, head: str) -> bool:
    """Whether a JSON text is the offline processor's; also True for one that is broken, so that reading it says so."""
    if '"joint_names"' in head or '"joint_positions"' in head or '"bodies"' in head:
        return True
    try:
        from .azure import starts_as_azure
        from .number_rows import unpacked

        return starts_as_azure(json.loads(unpacked(file, "JSON")))
    except ValueError:
        return True


def _of_text(file: Path, head: str) -> str:
    from .joint_table import starts_as_joint_table
    from .uiprmd import MARKERS, is_angles

    lines = [line for line in head.splitlines() if line.strip()]
    if not lines:
        return ""
    cells = split_cells(lines[0])
    if numbers_of(cells) is None:
        if starts_as_joint_table(file):
            return "table" if are_numbered(cells) else "joints"
        if any(line.lower().startswith("frame#") for line in lines[:20]):
            return "trc"
        return "table" if columns_of(cells) else "markers" if cells[0].lower() in ("field", "time") else ""
    if len(cells) == 66:
        return "uiprmd angles" if is_angles(file) else "uiprmd"
    if len(cells) == 1 and len(lines) > 2 and len(split_cells(lines[2])) == 10:
        return "ntu"
    known = {3 * len(MARKERS): "uiprmd markers", 175: "keraal", 119: "keraal bodies"}
    if len(cells) not in known and columns_without_titles(len(cells)) is None:
        return ""
    return known.get(len(cells), "turns" if _are_turns(lines) else "table")


def _are_turns(lines: Sequence[str]) -> bool:
    """Whether rows hold quaternions for each joint, as KIMORE's JointOrientation: four numbers of norm 1, or zeros."""
    numbers = numbers_of(split_cells(lines[len(lines) // 2])) or [0.0]
    norms = np.linalg.norm(np.clip(numbers[len(numbers) % 4 :], -2.0, 2.0).reshape(-1, 4), axis=1)
    return bool(norms.any()) and bool((np.abs(norms[norms != 0.0] - 1.0) < _TURNED).all())
