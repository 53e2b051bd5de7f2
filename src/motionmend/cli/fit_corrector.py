"""`motionmend fit corrector`: learn what a sensor gets wrong from pairs of its recordings and the truth."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..batch import Failure, one_blas_thread, run
from ..errors import FileError, counted
from .model_file import ModelFile, check_place, write_model
from .options import WORKING, AsJson, Force, Rate, SkeletonFile, Working
from .output import exit_code, reasons, tell_failure, tell_guesses
from .speech import json_line, progress, say

if TYPE_CHECKING:
    from ..correct.pairs import Matched
    from ..io.pairs_list import Listed


def corrector(
    pairs: Annotated[
        Path,
        Parameter(help="List of pairs (.csv) with the columns sensor, truth, offset_s; paths relative to the list."),
    ],
    /,
    *,
    out: ModelFile,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    keep_strange: Annotated[
        bool,
        Parameter(show_default=False, help="Learn also from pairs whose truth does not look like what was sensed."),
    ] = False,
    as_json: AsJson = False,
    force: Force = False,
    working: Working = WORKING,
) -> int:
    """Learn a corrector from pairs of a sensor's recording and the truth, recorded at the same time.

    offset_s: the sensor's time + offset = the truth's time, in seconds; where it is blank it is estimated. The truth
    may be markers, joints or joint angles, in axes of its own: each is brought to the sensor's frame by one rigid
    motion. A pair that cannot be read is reported and left out; so is one that does not belong together.
    """
    from ..correct.corrector import Corrector
    from ..io.pairs_list import read_pairs_list

    check_place(out, force)
    start = perf_counter()
    listed = read_pairs_list(working.reachable(pairs))
    found, failures, guesses = _read(listed, fps, skeleton and working.reachable(skeleton), working)
    tell_guesses(guesses)
    for one in found:
        for warning in one.matched.warnings:
            say(f"warning ({one.listed.sensor}): {warning}")
    left_out = [] if keep_strange else _left_out(found)
    apart = {one["line"] for one in left_out}
    used = [one for one in found if one.listed.line not in apart]
    twice = _twice(listed)
    for warning in twice:
        say(f"warning ({pairs}): {warning}")
    for entry in left_out:
        say(f"{entry['sensor']} is left out: {entry['why']}")
    if not used:
        raise FileError(f"{out} not written: no pair of {pairs} can be learned from")
    was_read = perf_counter()
    with one_blas_thread():
        model = Corrector().fit([one.matched.pair for one in used])
    was_fitted = perf_counter()
    sha256 = write_model(out, model)
    notes = tuple(getattr(model, "notes", ()))
    for note in notes:
        say(f"note: {note}")
    frames = sum(one.matched.sensor.frames for one in used)
    facts: dict[str, Any] = {
        "output": out,
        "kind": "corrector",
        "sha256": sha256,
        "pairs": len(used),
        "frames": frames,
        "joints": used[0].matched.sensor.names,
        "offsets_s": {str(one.listed.sensor): round(one.matched.offset, 4) for one in used},
        "error_cm": {str(one.listed.sensor): round(100 * one.matched.mean_error, 2) for one in used},
        "left_out": left_out,
        "failed": len(failures),
        "failures": reasons(failures),
        "warnings": [*notes, *twice, *(w for one in found for w in one.matched.warnings)],
        "guesses": list(guesses),
        "seconds": {"read": was_read - start, "fit": was_fitted - was_read, "total": perf_counter() - start},
    }
    if as_json:
        print(json_line(facts))
    aside = f", {len(left_out)} left out" if left_out else ""
    say(f"{counted(len(used), 'pair')}, {counted(frames, 'frame')}{aside}: {out}")
    return exit_code([failure for _, failure in failures])


@dataclass(frozen=True, eq=False)
class _Found:
    """A row of the list and its recordings, brought together."""

    listed: "Listed"
    matched: "Matched"


def together(listed: "Listed", /, *, fps: float | None, skeleton: Path | None) -> "Matched":
    """Read a pair and bring it together; a task for `batch.run`."""
    from ..correct.pairs import match
    from ..io.sensor import read_postures
    from ..io.truth import read_truth

    sensor = read_postures(listed.sensor, fps=fps)
    return match(sensor, read_truth(listed.truth, skeleton=skeleton), listed.offset)


def _read(
    listed: "tuple[Listed, ...]", fps: float | None, skeleton: Path | None, working: Working
) -> tuple[list[_Found], list[tuple[Path, Failure]], dict[str, list[Path]]]:
    """All pairs that can be read, why the others cannot, and what was guessed of which file."""
    task = partial(together, fps=fps, skeleton=skeleton)
    with progress(len(listed)) as advance:
        outcomes = run(task, listed, jobs=working.width, cluster=working.cluster, on_done=lambda outcome: advance())
    found, failures = [], []
    guesses: dict[str, list[Path]] = {}
    for outcome in outcomes:
        if outcome.failure is not None:
            tell_failure(outcome.item.sensor, outcome.failure, as_json=False, debug=working.debug)
            failures.append((outcome.item.sensor, outcome.failure))
        elif outcome.value is not None:
            found.append(_Found(outcome.item, outcome.value))
            for file, read in ((outcome.item.sensor, outcome.value.sensor), (outcome.item.truth, outcome.value.truth)):
                for guess in (*read.warnings, *read.guesses):
                    guesses.setdefault(guess, []).append(file)
    return found, failures, guesses


def _twice(listed: "tuple[Listed, ...]") -> list[str]:
    """What is said of rows that name the files of a row before them."""
    first: dict[tuple[Path, Path], int] = {}
    said = []
    for row in listed:
        pair = row.sensor.resolve(), row.truth.resolve()
        if first.setdefault(pair, row.line) != row.line:
            said.append(f"line {row.line} names the pair of line {first[pair]} again: it counts twice")
    return said


def _left_out(found: list[_Found]) -> list[dict[str, Any]]:
    """The pairs that do not belong together, and why."""
    from ..correct.pairs import strange

    reasons = strange([one.matched for one in found])
    return [
        {"line": one.listed.line, "sensor": str(one.listed.sensor), "truth": str(one.listed.truth), "why": why}
        for one, why in zip(found, reasons, strict=True)
        if why
    ]
