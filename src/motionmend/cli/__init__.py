"""The command line: `main` reads the arguments, runs one command and turns every failure into one line."""

import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from inspect import cleandoc
from typing import TYPE_CHECKING, Any

from ..errors import MotionMendError, UsageError

if TYPE_CHECKING:
    from cyclopts import App

FAILED, BAD_USAGE, INTERRUPTED = 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code.

    Parameters
    ----------
    argv : the arguments behind the program's name; None takes them from the process.

    Returns
    -------
    0 when all went well, 1 when an input failed, 2 for bad usage, 130 when interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        return _run(arguments)
    except KeyboardInterrupt:
        return _say("interrupted: what was finished stays, --resume goes on from there", INTERRUPTED)
    except BrokenPipeError:  # the reader of a pipe left, as `head` does: nobody is there to be told
        sys.stdout = open("/dev/null" if sys.platform != "win32" else "NUL", "w", encoding="utf-8")  # noqa: SIM115
        return FAILED
    except (MotionMendError, OSError) as error:
        if "--debug" in arguments:
            traceback.print_exc()
        return _say(str(error), BAD_USAGE if isinstance(error, UsageError) else FAILED)
    except Exception as error:
        if "--debug" in arguments:
            traceback.print_exc()
        line = f"unexpected {type(error).__name__}: {error}: a defect of motionmend; --debug shows where"
        return _say(line, FAILED)


def _run(arguments: list[str]) -> int:
    from cyclopts import CycloptsError

    app = _app()
    try:
        command, bound, *_ = app.parse_args(arguments, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        known = " ".join(["motionmend", *(error.command_chain or ()), "--help"])
        return _say(f"{error} See {known}", BAD_USAGE)
    asked = {"--help", "-h", "--version"}.intersection(arguments)
    if command == app.help_print and not asked:  # no command at all
        with redirect_stdout(sys.stderr):
            command(*bound.args, **bound.kwargs)
        return BAD_USAGE
    code: Any = command(*bound.args, **bound.kwargs)
    return int(code or 0)


def _app() -> "App":
    from cyclopts import App, Parameter

    from .. import __version__
    from . import (
        compare,
        correct,
        corrupt,
        data,
        demo,
        denoise,
        fit,
        fit_corrector,
        fit_tracker,
        inspect,
        pipeline,
        report,
        reproduce,
        serve,
        stream,
        track,
    )

    app = App(
        name="motionmend",
        version=__version__,
        help="Recover clean, complete full-body motion from noisy, gappy and ambiguous capture.",
        help_format="plaintext",
        default_parameter=Parameter(negative=""),
    )
    learning = App(name="fit", help="Learn a model from clean recordings.", help_format="plaintext")
    _add(app, demo.demo)
    _add(app, inspect.inspect)
    app.command(learning)
    _add(learning, fit.denoiser)
    _add(learning, fit_tracker.tracker)
    _add(learning, fit_corrector.corrector)
    keeping = App(name="data", help="Public recordings by name.", help_format="plaintext")
    app.command(keeping)
    _add(keeping, data.listed, "list")
    _add(keeping, data.get)
    _add(app, denoise.denoise)
    _add(app, track.track)
    _add(app, correct.correct)
    _add(app, corrupt.corrupt)
    _add(app, compare.compare)
    _add(app, report.report)
    _add(app, pipeline.pipeline)
    _add(app, stream.stream)
    _add(app, serve.serve)
    _add(app, reproduce.reproduce)
    return app


def _add(app: "App", command: Callable[..., int], name: str | None = None) -> None:
    """The command under its own name or another, its docstring as help with each paragraph on a line of its own."""
    paragraphs = cleandoc(command.__doc__ or "").split("\n\n")
    app.command(command, name=name, help="\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs))


def _say(line: str, code: int) -> int:
    print(f"motionmend: {' '.join(line.split())}", file=sys.stderr)
    return code
