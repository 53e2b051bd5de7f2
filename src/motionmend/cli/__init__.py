"""The command line: `main` reads the arguments, runs one command and turns every failure into one line."""

import _thread
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from importlib import import_module
from inspect import cleandoc
from io import TextIOWrapper
from typing import TYPE_CHECKING, Any

from ..errors import MotionMendError, UsageError, interrupt_in, one_line

if TYPE_CHECKING:
    from cyclopts import App

FAILED, BAD_USAGE, INTERRUPTED = 1, 2, 130
ENDED = 128  # and a signal's number: what a process returns that the signal ended
AGAIN = 0.01  # s after which an interrupt that was lost comes again

GROUPS = {"fit": "Learn a model from clean recordings.", "data": "Public recordings by name."}

COMMANDS = {  # the words of a command, in the order of the help: the module it lives in, its function there
    ("demo",): ("demo", "demo"),
    ("inspect",): ("inspect", "inspect"),
    ("fit", "denoiser"): ("fit", "denoiser"),
    ("fit", "tracker"): ("fit_tracker", "tracker"),
    ("fit", "corrector"): ("fit_corrector", "corrector"),
    ("data", "list"): ("data", "listed"),
    ("data", "get"): ("data", "get"),
    ("denoise",): ("denoise", "denoise"),
    ("track",): ("track", "track"),
    ("correct",): ("correct", "correct"),
    ("corrupt",): ("corrupt", "corrupt"),
    ("compare",): ("compare", "compare"),
    ("report",): ("report", "report"),
    ("view",): ("view", "view"),
    ("pipeline",): ("pipeline", "pipeline"),
    ("stream",): ("stream", "stream"),
    ("serve",): ("serve", "serve"),
    ("reproduce",): ("reproduce", "reproduce"),
}


RESUMABLE = ("denoise", "track", "correct", "corrupt", "pipeline")
INPUTS = ("files", "folders", "takes")  # what commands call that of which --json tells one by one


class Terminated(KeyboardInterrupt):
    """The process was asked to end, as `kill` does (SIGTERM) and a terminal that is closed (SIGHUP); what was begun is
    cleared away as after Ctrl-C. Its argument is the signal's number."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code.

    Parameters
    ----------
    argv : the arguments behind the program's name; None takes them from the process.

    Returns
    -------
    0 when all went well, 1 when an input failed, 2 for bad usage, 130 when interrupted, 143 when asked to end, 129 by a
    terminal that closed.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if argv is None:
        signal.signal(signal.SIGTERM, _terminate)
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as under nohup
            signal.signal(signal.SIGHUP, _terminate)
        sys.unraisablehook = _lost
        _open_closed_streams()
        for stream in (sys.stdout, sys.stderr):  # a name that a pipe's encoding lacks is spelt, not a failure
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
    try:
        return _interruptible(arguments)
    except KeyboardInterrupt as interrupt:
        if argv is None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is ending already
        resume = ", --resume goes on from there" if arguments and arguments[0] in RESUMABLE else ""
        code = ENDED + interrupt.args[0] if isinstance(interrupt, Terminated) else INTERRUPTED
        return _say(f"interrupted: what was finished stays{resume}", code)
    except BrokenPipeError:  # the reader of a pipe left, as `head` does: nobody is there to be told
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
        return FAILED
    except (MotionMendError, OSError) as error:
        if "--debug" in arguments:
            traceback.print_exc()
        return _say(_line(error), BAD_USAGE if isinstance(error, UsageError) else FAILED)
    except Exception as error:
        if "--debug" in arguments:
            traceback.print_exc()
        return _say(_line(error), FAILED)


def _interruptible(arguments: list[str]) -> int:
    """Run it; Ctrl-C stays one where compiled code, or its import, hands it on as an error of its own."""
    try:
        return _run(arguments)
    except Exception as error:
        if (interrupt := interrupt_in(error)) is None:
            raise
        raise interrupt from None


def _run(arguments: list[str]) -> int:
    from cyclopts import CycloptsError

    if (empty := _empty(arguments)) is not None:
        return _say(empty, BAD_USAGE)
    app = _app(arguments)
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
    try:
        code: Any = command(*bound.args, **bound.kwargs)
    except Exception as error:
        told = isinstance(error, UsageError | BrokenPipeError) or interrupt_in(error) is not None
        if bound.arguments.get("as_json") and not told:
            _tell_as_json(bound.arguments, _line(error))
        raise
    return int(code or 0)


def _empty(arguments: Sequence[str]) -> str | None:
    """What is wrong with arguments one of which is empty: as a path it would mean the folder one stands in."""
    for before, argument in zip(("", *arguments), arguments, strict=False):
        option, equals, value = argument.partition("=") if argument.startswith("-") else (before, "", argument)
        if value or not (equals or argument == ""):
            continue
        where = f"{option}: something" if option.startswith("-") else "a name"
        return f"{where} was wanted, came an empty argument: is it a variable of the shell that is not set?"
    return None


def _tell_as_json(given: Mapping[str, Any], line: str) -> None:
    """With --json a command that fails as a whole, as by its model, fails each of its inputs, or else its output."""
    from .speech import json_line

    inputs = next((given[name] for name in INPUTS if name in given), ())
    failed = [{"input": path} for path in inputs] or [{"output": given["out"]} if "out" in given else {}]
    for one in failed:
        print(json_line({**one, "error": one_line(line)}), flush=True)


def _app(arguments: Sequence[str]) -> "App":
    """The program's commands: all of them, or the one that the arguments begin with, so that only its module loads."""
    from cyclopts import App, Parameter

    from .. import __version__

    app = App(
        name="motionmend",
        version=__version__,
        help="Recover clean, complete full-body motion from noisy, gappy and ambiguous capture.",
        help_format="plaintext",
        default_parameter=Parameter(negative=""),
    )
    groups = {group: App(name=group, help=help, help_format="plaintext") for group, help in GROUPS.items()}
    asked = arguments[0] if arguments and arguments[0] in {words[0] for words in COMMANDS} else None
    for words, (module, function) in COMMANDS.items():
        if asked not in (None, words[0]):
            continue
        owner = groups[words[0]] if len(words) > 1 else app
        if owner is not app and words[0] not in app:
            app.command(owner)
        _add(owner, getattr(import_module(f".{module}", __name__), function), words[-1])
    return app


def _add(app: "App", command: Callable[..., int], name: str) -> None:
    """The command under this name, its docstring as help with each paragraph on a line of its own."""
    paragraphs = cleandoc(command.__doc__ or "").split("\n\n")
    app.command(command, name=name, help="\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs))


def _open_closed_streams() -> None:
    """Let a standard stream that the caller closed lead nowhere: what is opened next would take its number, and what
    is meant for people, or for another process that inherits the stream, would go there."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def _terminate(number: int, _frame: object) -> None:
    raise Terminated(number)


def _lost(unraisable: "sys.UnraisableHookArgs") -> None:
    """Let an interrupt come again that came upon what cannot fail, as callbacks of the compiler and clearing away do:
    Python tells of it with a traceback and goes on as if there had been none. All else is told as before."""
    interrupt = unraisable.exc_value
    if not isinstance(interrupt, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    number = interrupt.args[0] if isinstance(interrupt, Terminated) else signal.SIGINT
    # from elsewhere and later, for raised here it would be lost again; sent to the thread, it ends a wait as well
    if hasattr(signal, "pthread_kill"):
        again = threading.Timer(AGAIN, signal.pthread_kill, (threading.main_thread().ident, number))
    else:  # Windows
        again = threading.Timer(AGAIN, _thread.interrupt_main, (number,))
    again.daemon = True
    again.start()


def _line(error: Exception) -> str:
    """What an error says, without an operating system's number in front; that nobody expected it, if so."""
    if not isinstance(error, MotionMendError | OSError):
        return f"unexpected {type(error).__name__}: {error}: a defect of motionmend; --debug shows where"
    if not isinstance(error, OSError) or error.strerror is None:
        return str(error)
    return f"{error.filename}: {error.strerror}" if error.filename else error.strerror


def _say(line: str, code: int) -> int:
    print(f"motionmend: {one_line(line)}", file=sys.stderr)
    return code
