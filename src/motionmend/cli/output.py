"""How a command goes through its inputs and tells what came of each."""

import re
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..batch import Failure, Outcome, Task, run
from ..errors import one_line
from .inputs import Refusal, place_among
from .options import Working
from .speech import json_line, progress, say

Item = TypeVar("Item")


@dataclass(frozen=True)
class Done:
    """What a command has to say about one input.

    Attributes
    ----------
    facts : the input's JSON object.
    text : its result for people, for stdout; empty when the result is a file.
    line : one line for stderr; empty when there is nothing to say.
    warnings, guesses : one sentence each, for stderr; the facts hold them too.
    """

    facts: Mapping[str, Any]
    text: str = ""
    line: str = ""
    warnings: tuple[str, ...] = ()
    guesses: tuple[str, ...] = ()


def work(
    task: Task[Item, Done],
    items: Sequence[Item],
    *,
    name: Callable[[Item], Path],
    working: Working,
    as_json: bool,
    refused: Sequence[Refusal] = (),
    given: Sequence[Path] = (),
    against: Callable[[Item], Path] | None = None,
) -> int:
    """Run a task on every item and say what came of each, in the order of the items, as soon as it is its turn.

    Parameters
    ----------
    task : see `batch.run`.
    items : what to work on.
    name : the input file of an item.
    working : processes and cluster.
    as_json : JSON on stdout instead of text.
    refused : what could not even be tried.
    given : files and folders as on the command line: what was refused is told where it stands among them. What is not
        among them is told first.
    against : the file that an item's is held against, as a truth, which may be at fault itself.

    Returns
    -------
    The exit code.
    """
    barred = deque(sorted(refused, key=lambda refusal: place_among(refusal.path, given)))  # a stable order

    def tell_refused(before: tuple[int, Path] | None) -> None:
        while barred and (before is None or place_among(barred[0].path, given) < before):
            refusal = barred.popleft()
            tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=as_json, debug=False)

    waiting: dict[int, Outcome[Item, Done]] = {}
    guesses: dict[str, list[Path]] = {}
    turn = 0
    with progress(len(items)) as advance:

        def heard(outcome: Outcome[Item, Done]) -> None:
            nonlocal turn
            advance()
            waiting[outcome.index] = outcome
            while turn in waiting:
                told = waiting.pop(turn)
                turn += 1
                path = name(told.item)
                tell_refused(place_among(path, given))
                if told.failure is not None:
                    held = None if against is None else against(told.item)
                    tell_failure(path, told.failure, as_json=as_json, debug=working.debug, also=held)
                elif told.value is not None:
                    _tell(path, told.value, as_json=as_json, first=turn == 1)
                    for guess in told.value.guesses:
                        guesses.setdefault(guess, []).append(path)

        outcomes = run(task, items, jobs=working.width, cluster=working.cluster, on_done=heard)
    tell_refused(None)
    tell_guesses(guesses)
    failures = [o.failure for o in outcomes if o.failure is not None]
    return exit_code(failures, refused, done=len(outcomes) - len(failures))


def exit_code(failures: Sequence[Failure], refused: Sequence[Refusal] = (), done: int = 0) -> int:
    """0 when all went well, 2 when the usage was bad, else 1; usage by which anything could be `done` was not."""
    if not done and any(failure.kind == "UsageError" for failure in failures):
        return 2
    return 1 if failures or refused else 0


def tell_failure(path: Path, failure: Failure, *, as_json: bool, debug: bool, also: Path | None = None) -> None:
    """One line on stderr that holds the file's name; with --json also an object with `error` on stdout.

    Where a message begins with the file that it was held against (`also`), that one is at fault.
    """
    if debug and failure.traceback:
        print(failure.traceback.rstrip(), file=sys.stderr, flush=True)
    # A bare word, as of a folder, may stand in any message.
    plain = not path.suffix and len(path.parts) == 1
    begins = r"\A" if plain else r"(?<![\w./-])"
    message, name = one_line(failure.message), one_line(str(path))
    named = re.search(rf"{begins}{re.escape(name)}(?![\w-])", message) is not None
    named = named or (also is not None and message.startswith(one_line(f"{also}: ")))
    say(f"motionmend: {message if named else f'{name}: {message}'}")
    if as_json:
        print(json_line({"input": str(path), "error": message.removeprefix(f"{name}: ")}), flush=True)


def reasons(failures: Sequence[tuple[Path, Failure]], refused: Sequence[Refusal] = ()) -> list[dict[str, str]]:
    """Inputs that failed or were refused, and why, for --json of a command that makes one thing of many files."""
    told = [(path, failure.message) for path, failure in failures]
    told += [(one.path, one.reason) for one in refused]
    return [{"input": str(path), "error": one_line(why).removeprefix(f"{one_line(str(path))}: ")} for path, why in told]


def tell_guesses(guesses: Mapping[str, Sequence[Path]]) -> None:
    """Each thing supposed, once, with the file or the number of files it was supposed for."""
    for guess, paths in guesses.items():
        where = str(paths[0]) if len(paths) == 1 else f"{len(paths)} files, {paths[0]} first"
        say(f"guess ({where}): {guess}")


def _tell(path: Path, done: Done, *, as_json: bool, first: bool) -> None:
    for warning in done.warnings:
        say(f"warning ({path}): {warning}")
    if done.line:
        say(done.line)
    if as_json:
        print(json_line(done.facts), flush=True)
    elif done.text:
        print(done.text if first else f"\n{done.text}", flush=True)
