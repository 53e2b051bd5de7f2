"""`motionmend view`: recordings in rerun's viewer."""

from typing import Annotated

from cyclopts import Parameter

from ..errors import FileError, UsageError, counted
from .drawable import read_drawable
from .options import Debug, Files, Rate, SkeletonFile, Whole
from .output import exit_code
from .speech import say

HIGHEST = 65535


def view(
    *files: Files,
    port: Annotated[Whole, Parameter(help="Of the viewer's page on this machine; 0: any port that is free.")] = 9090,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    debug: Debug = False,
) -> int:
    """Show recordings over each other in rerun's viewer, in a browser on this machine, until Ctrl-C.

    Needs the extra: pip install 'motionmend[view]'. `motionmend report` makes a page that needs nothing more.
    """
    from ..view import need_viewer, served

    if not 0 <= port <= HIGHEST:
        raise UsageError(f"--port: a port from 0 to {HIGHEST} was wanted, came {port}")
    need_viewer()
    drawn, failures, refused = read_drawable(files, fps, skeleton, debug=debug)
    if not drawn:
        raise FileError("none of the recordings given can be shown")
    shown = [(one.name, one.recording) for one in drawn]
    try:
        with served(shown, port) as (address, process):
            say(f"{counted(len(shown), 'recording')}: {address} (Ctrl-C ends it)")
            process.wait()
            raise FileError(f"rerun's viewer ended by itself with code {process.returncode}")
    except KeyboardInterrupt:
        return exit_code(failures, refused)
