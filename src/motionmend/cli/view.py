"""`motionmend view`: recordings in rerun's viewer."""

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..batch import Failure
from ..errors import FileError, MotionMendError, UsageError
from .inputs import gather
from .options import Debug, Files, Rate, SkeletonFile
from .output import exit_code, say, tell_failure, tell_guesses

if TYPE_CHECKING:
    from pathlib import Path

    from ..bodies.motion import Markers, Motion

HIGHEST = 65535


def view(
    *files: Files,
    port: Annotated[int, Parameter(help="Of the viewer's page on this machine; 0: any port that is free.")] = 9090,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    debug: Debug = False,
) -> int:
    """Show recordings over each other in rerun's viewer, in a browser on this machine, until Ctrl-C.

    Needs the extra: pip install 'motionmend[view]'. `motionmend report` makes a page that needs nothing more.
    """
    from ..io import READABLE
    from ..io.sensor import SENSOR_ENDINGS
    from ..view import need_viewer, served
    from .report import drawable, meant

    if not 0 <= port <= HIGHEST:
        raise UsageError(f"--port: a port from 0 to {HIGHEST} was wanted, came {port}")
    need_viewer()
    inputs, refused = gather(files, (*READABLE, *SENSOR_ENDINGS), meant=meant)
    shown: list[tuple[str, Motion | Markers]] = []
    guesses: dict[str, list[Path]] = {}
    failures = []
    for refusal in refused:
        tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=False, debug=debug)
    for one in inputs:
        try:
            recording, _ = drawable(one.path, fps, skeleton)
        except MotionMendError as error:
            failures.append(Failure(type(error).__name__, str(error), ""))
            tell_failure(one.path, failures[-1], as_json=False, debug=debug)
            continue
        shown.append((str(one.place), recording))
        for guess in recording.guesses:
            guesses.setdefault(guess, []).append(one.path)
    if not shown:
        raise FileError("none of the recordings given can be shown")
    tell_guesses(guesses)
    try:
        with served(shown, port) as (address, process):
            say(f"{len(shown)} recording{'s'[: len(shown) != 1]}: {address} (Ctrl-C ends it)")
            process.wait()
            raise FileError(f"rerun's viewer ended by itself with code {process.returncode}")
    except KeyboardInterrupt:
        return exit_code(failures, refused)
