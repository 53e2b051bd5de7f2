"""Recordings that can be drawn, for `report` and `view`: each read, what fails told."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..batch import Failure
from ..errors import MotionMendError
from .inputs import Refusal, gather
from .output import tell_failure, tell_guesses
from .speech import say

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion
    from ..bodies.postures import Postures


@dataclass(frozen=True, eq=False)
class Drawable:
    """A recording as it can be drawn.

    Attributes
    ----------
    path : of its file.
    name : by which it is shown.
    recording : of a sensor its joints as markers at an even rate.
    joints : of a sensor, as they are; None of other recordings.
    """

    path: Path
    name: str
    recording: "Motion | Markers"
    joints: "Postures | None"


def read_drawable(
    files: Sequence[Path], fps: float | None, skeleton: Path | None, *, debug: bool, as_json: bool = False
) -> tuple[list[Drawable], list[Failure], list[Refusal]]:
    """What can be drawn of files and folders; what cannot be read, and what was guessed, is told.

    Parameters
    ----------
    files : files and folders.
    fps : Hz, of files that carry no rate.
    skeleton : an .asf for .amc files that have none beside them.
    debug : tell failures with their tracebacks.
    as_json : tell failures on stdout too, as JSON.

    Returns
    -------
    The recordings, the failures that were told, and what was refused unread.
    """
    from ..io import READABLE
    from ..io.sensor import SENSOR_ENDINGS

    inputs, refused = gather(files, {*READABLE, *SENSOR_ENDINGS}, meant=_meant)
    for refusal in refused:
        tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=as_json, debug=debug)
    found: list[Drawable] = []
    failures: list[Failure] = []
    guesses: dict[str, list[Path]] = {}
    for one in inputs:
        try:
            found.append(Drawable(one.path, str(one.place), *_read(one.path, fps, skeleton)))
        except MotionMendError as error:
            failures.append(failed(one.path, error, debug=debug, as_json=as_json))
            continue
        for warning in found[-1].recording.warnings:
            say(f"warning ({one.path}): {warning}")
        for guess in found[-1].recording.guesses:
            guesses.setdefault(guess, []).append(one.path)
    tell_guesses(guesses)
    return found, failures, refused


def failed(path: Path, error: MotionMendError, *, debug: bool, as_json: bool = False) -> Failure:
    """The failure of an input, told."""
    failure = Failure(type(error).__name__, str(error), "")
    tell_failure(path, failure, as_json=as_json, debug=debug)
    return failure


def _read(path: Path, fps: float | None, skeleton: Path | None) -> "tuple[Motion | Markers, Postures | None]":
    from ..bodies.motion import Markers
    from ..io import read
    from ..io.sensor import read_postures
    from ..io.sensor_source import USUAL_FPS
    from ..io.table import uneven_times
    from ..io.vertical import up_of
    from .compare_joints import holds_joints

    if not holds_joints(path):
        return read(path, fps=fps, skeleton=skeleton), None
    postures = read_postures(path, fps=fps)
    rate = postures.fps if postures.frames > 1 and postures.fps > 0 else USUAL_FPS
    up, _ = up_of(postures.names, postures.positions)
    said = (*postures.warnings, *uneven_times(postures.times))
    drawn = Markers(postures.names, postures.positions, rate, up=up, guesses=postures.guesses, warnings=said)
    return drawn, postures


def _meant(path: Path) -> bool:
    """Whether a file found in a folder can be drawn."""
    from ..io import READABLE, looks_meant
    from ..io.sensor import looks_like_sensor

    return (path.suffix.lower() in READABLE and looks_meant(path)) or looks_like_sensor(path)
