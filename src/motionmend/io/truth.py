"""The other half of a pair: what an optical system recorded while the sensor looked on, as joints."""

import os
from pathlib import Path

from ..bodies.motion import Markers
from ..bodies.postures import Postures
from ..bodies.truth_joints import joints_of_markers, joints_of_motion
from ..errors import FileError


def read_truth(
    path: str | os.PathLike[str], *, fps: float | None = None, skeleton: str | os.PathLike[str] | None = None
) -> Postures:
    """Read joints from markers (.c3d, .trc, ACCAD's text, UI-PRMD's Vicon text), an animated skeleton (.bvh, .amc), a
    table of joints (.csv), Keraal's rigid bodies, or another sensor's recording.

    Parameters
    ----------
    path : the file.
    fps : Hz, of a file without a rate or times.
    skeleton : the .asf of an .amc; looked for beside the file when not given.

    Raises
    ------
    FileError : not there, empty, damaged, or none of these.
    UsageError : a rate that is none.
    """
    from . import read
    from .sensor import kind_of, read_postures

    file = Path(path)
    if not file.is_file():
        raise FileError(f"{file}: no such file; check the path")
    kind = kind_of(file)
    if kind == "uiprmd markers":
        from .uiprmd import read_uiprmd_markers

        return joints_of_markers(read_uiprmd_markers(file, fps))
    if kind == "keraal bodies":
        from .keraal import read_keraal_bodies

        return read_keraal_bodies(file, fps)
    if kind == "markers":
        recording = read(file, fps=fps, skeleton=skeleton)
        return joints_of_markers(recording) if isinstance(recording, Markers) else joints_of_motion(recording)
    if kind == "trc":
        from .trc import read_trc

        return joints_of_markers(read_trc(file, fps))
    return read_postures(file, fps=fps)
