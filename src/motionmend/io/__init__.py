"""Recordings in and out: one reader and one writer for each ending, values in metres, radians and seconds.

`read` and `write` choose by the ending, whatever its case. Nothing heavy is loaded until a file of its kind is met.
"""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..bodies.motion import Markers, Motion, Repaired
from ..errors import FileError, UsageError

READABLE = (".amc", ".bvh", ".c3d", ".trc", ".csv", ".tsv", ".txt", ".zip")
WRITABLE = (".amc", ".bvh", ".c3d", ".trc", ".csv", ".tsv")
_OF_MARKERS = (".c3d", ".trc", ".csv", ".tsv")
_SLOWEST, _FASTEST = 0.1, 1e5  # Hz; nobody is recorded slower or faster, and work at a usual rate would never end

__all__ = ["READABLE", "WRITABLE", "looks_meant", "read", "write"]


def read(
    path: str | os.PathLike[str], *, fps: float | None = None, skeleton: str | os.PathLike[str] | None = None
) -> Motion | Markers:
    """Read a recording.

    Parameters
    ----------
    path : .amc or .bvh (joint angles); .c3d, .trc, .csv, Qualisys' .tsv, or ACCAD's .txt or .zip (markers).
    fps : Hz, of a file that carries no rate. One that carries a rate keeps it.
    skeleton : the .asf of an .amc; looked for beside the file when not given.

    Returns
    -------
    recording : with a sentence in `guesses` for all that the file did not say.

    Raises
    ------
    FileError : not there, empty, not what its ending promises, damaged or cut off, at a rate nobody records at.
    UsageError : a rate that is none.
    """
    file = Path(path)
    ending = file.suffix.lower()
    if fps is not None and not 0 < fps < float("inf"):
        raise UsageError(f"a frame rate above 0 Hz is wanted, came {fps}")
    if file.is_dir():
        raise FileError(f"{file}: wanted a recording, this is a folder; name a file in it")
    if not file.exists():
        raise FileError(f"{file}: no such file; check the path")
    if ending == ".asf":
        raise FileError(f"{file}: a skeleton, no recording; read the .amc that goes with it")
    if ending not in READABLE:
        raise FileError(f"{file}: wanted a recording ({', '.join(READABLE)}), came '{ending or file.name}'")
    if not file.stat().st_size:
        raise FileError(f"{file}: wanted a recording, this file is empty; get a complete copy")
    recording = _read(file, ending, fps, skeleton)
    if not _SLOWEST <= recording.fps <= _FASTEST:
        raise FileError(
            f"{file}: wanted a rate of {_SLOWEST:g} to {_FASTEST:g} Hz, came {recording.fps:g} Hz; correct it in the"
            " file or, where the file states none, --fps"
        )
    if fps is not None and abs(recording.fps - fps) > 1e-6 * fps:
        note = f"the file states its own rate, {recording.fps:g} Hz: the {fps:g} Hz given were not used"
        return replace(recording, guesses=(*recording.guesses, note))
    return recording


def looks_meant(path: str | os.PathLike[str]) -> bool:
    """Whether a file that nobody named, but that lies in a folder somebody named, is meant as a recording.

    Endings .txt, .zip, .csv and .tsv are those of many other things: such a file has to start as a recording does. What
    cannot be opened or is a damaged archive is taken for one, so that reading it says what is wrong.

    Parameters
    ----------
    path : a file with an ending in READABLE.
    """
    ending = Path(path).suffix.lower()
    if ending in (".txt", ".zip"):
        from .accad import starts_as_accad

        return starts_as_accad(path)
    if ending == ".csv":
        from .table import starts_as_table

        return starts_as_table(path)
    if ending == ".tsv":
        from .qualisys import starts_as_qualisys

        return starts_as_qualisys(path)
    return True


def write(path: str | os.PathLike[str], recording: Motion | Markers, *, repaired: Repaired[Any] | None = None) -> None:
    """Write a recording; the file is whole or not there.

    Parameters
    ----------
    path : .amc or .bvh for a Motion; .c3d, .trc, .tsv or .csv for Markers.
    recording : a file of the same kind that it came from gives back everything that is not motion.
    repaired : the repair that made it; a C3D file lists what was filled and replaced, a table has its deviations where
        that had them from which the recording came.

    Raises
    ------
    UsageError : an ending that cannot hold this recording.
    FileError : the file cannot be written, or its format cannot hold the recording.
    """
    file = Path(path)
    ending = file.suffix.lower()
    fitting = _OF_MARKERS if isinstance(recording, Markers) else tuple(e for e in WRITABLE if e not in _OF_MARKERS)
    if ending not in fitting:
        kind = "markers" if isinstance(recording, Markers) else "joint angles"
        raise UsageError(f"{file}: {kind} are written to {' or '.join(fitting)}, came '{ending or file.name}'")
    if isinstance(recording, Markers):
        _write_markers(file, ending, recording, repaired)
    elif ending == ".amc":
        from .amc import write_amc

        write_amc(file, recording)
    else:
        from .bvh import write_bvh

        write_bvh(file, recording)


def _read(file: Path, ending: str, fps: float | None, skeleton: str | os.PathLike[str] | None) -> Motion | Markers:
    if ending == ".amc":
        from .amc import read_amc

        return read_amc(file, None if skeleton is None else Path(skeleton), fps)
    if ending == ".bvh":
        from .bvh import read_bvh

        return read_bvh(file)
    if ending == ".c3d":
        from .c3d import read_c3d

        return read_c3d(file, fps)
    if ending == ".trc":
        from .trc import read_trc

        return read_trc(file, fps)
    if ending == ".tsv":
        from .qualisys import read_qualisys

        return read_qualisys(file, fps)
    if ending == ".csv":
        from .table import read_table

        return read_table(file, fps)
    from .accad import read_accad, starts_as_accad
    from .sensor import kind_of

    if ending == ".txt" and not starts_as_accad(file) and kind_of(file) in ("table", "keraal", "uiprmd"):
        raise FileError(
            f"{file}: wanted markers, this is a sensor's skeleton; `motionmend correct` makes a table (.csv) of it"
        )
    return read_accad(file, fps)


def _write_markers(file: Path, ending: str, markers: Markers, repaired: Repaired[Markers] | None) -> None:
    if ending == ".c3d":
        from .c3d import write_c3d

        write_c3d(file, markers, repaired)
    elif ending == ".trc":
        from .trc import write_trc

        write_trc(file, markers)
    elif ending == ".tsv":
        from .qualisys import write_qualisys

        write_qualisys(file, markers)
    else:
        from .table import write_table

        write_table(file, markers, repaired)
