"""Reading recordings of a depth camera, whichever of the known forms a path holds."""

import os
from pathlib import Path

from ..errors import FileError
from .depth_recording import DepthRecording


def read_depth(path: str | os.PathLike[str]) -> DepthRecording:
    """A recording of a depth camera: a folder with camera.json, or a UTD-MHAD `*_depth.mat`.

    Raises
    ------
    FileError : not there, or not what it should be.
    """
    where = Path(path)
    if where.is_dir():
        from .depth_folder import read_depth_folder

        return read_depth_folder(where)
    if not where.exists():
        raise FileError(f"{where}: no such file or folder; check the path")
    if where.suffix.lower() != ".mat":
        raise FileError(
            f"{where}: wanted a folder with camera.json and depth/, or a *_depth.mat of UTD-MHAD, "
            f"came '{where.suffix or where.name}'"
        )
    from .utd_mhad import read_utd_depth

    return read_utd_depth(where)


def looks_like_depth_folder(path: Path) -> bool:
    """Whether a folder is meant as one recording: it has camera.json or a folder depth/; False for what may not be
    looked at."""
    try:
        return path.is_dir() and ((path / "camera.json").exists() or (path / "depth").is_dir())
    except OSError:
        return False
