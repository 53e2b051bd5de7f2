"""`motionmend fit`: learn models from clean recordings."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Annotated

from cyclopts import Parameter

from ..batch import Failure, one_blas_thread, workers
from ..errors import FileError, MismatchError, counted
from .archive import Lesson, Reading, learn, survey, total
from .inputs import gather
from .model_file import ModelFile, check_place, write_model
from .options import WORKING, AsJson, Files, Force, Rate, SkeletonFile, Whole, Working
from .output import exit_code, reasons, tell_failure, tell_guesses
from .speech import json_line, progress, say

_NO_CLIP = "a denoiser learns from clean clips, none of those given can be used"


def denoiser(
    *clips: Files,
    out: ModelFile,
    fps: Rate = None,
    model_fps: Annotated[float, Parameter(help="Rate in Hz the model works at.")] = 30.0,
    window: Annotated[Whole, Parameter(help="Length of the lag window in frames at --model-fps.")] = 20,
    energy: Annotated[float, Parameter(help="Share of the variance the bases keep, above 0 and at most 1.")] = 0.99,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    force: Force = False,
    working: Working = WORKING,
) -> int:
    """Learn a denoiser from clean clips of one kind: joint angles of one channel set, or one marker set.

    A clip that cannot be read is reported and left out. One that is noisy or full of outliers itself is repaired by
    what it shows itself first, which is said.
    """
    from ..denoise import Denoiser
    from ..io import READABLE

    check_place(out, force)
    settings = Denoiser(window=window, fps=model_fps, energy=energy)
    start = perf_counter()
    inputs, refused = gather([working.reachable(clip) for clip in clips], READABLE, "clip")
    reading = Reading(fps, skeleton and working.reachable(skeleton))
    # each clip is read twice, for its layout and for all else
    with progress(2 * len(inputs)) as advance, workers(working.width, working.cluster) as staff:
        found = total(partial(survey, reading=reading), inputs, working, staff, advance)
        failures = _told(found.failures, working)
        tell_guesses(found.value.guesses if found.value else {})
        for refusal in refused:
            tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=False, debug=False)
        if found.value is None:
            raise FileError(f"{out} not written: {_NO_CLIP}")
        alike, turned, strange = found.value.alike()
        failures += _told(strange, working)
        was_read = perf_counter()
        with one_blas_thread():
            layout = alike.sketch.layout()
        task = partial(learn, reading=reading, layout=layout, window=window, model_fps=model_fps)
        learned = total(task, alike.clips, working, staff, advance)
    failures += _told(learned.failures, working)
    if learned.value is None:
        raise FileError(f"{out} not written: {_NO_CLIP}")
    for path in learned.value.short:
        say(f"note: {path}: no {window / model_fps:.3g} s in which nothing is missing: no bases are learned from it")
    try:
        with one_blas_thread():
            model = settings.learned(layout, learned.value.statistics, _repaired_first(learned.value, layout.kind))
    except MismatchError as error:
        raise MismatchError(f"{out} not written: {error}") from None
    was_fitted = perf_counter()
    sha256 = write_model(out, model)
    notes = (*_of_another_order(turned), *model.notes)
    for note in notes:
        say(f"note: {note}")
    facts = {
        "output": out,
        "kind": "denoiser",
        "sha256": sha256,
        "clips": model.clips,
        "frames": model.frames,
        "channels": len(model.layout.names),
        "bases": model.bases.count,
        "settings": {"window": window, "model_fps": model_fps, "energy": energy},
        "failed": len(failures) + len(refused),
        "failures": reasons(failures, refused),
        "short": learned.value.short,
        "spoiled": [
            {"clip": path, "noise": round(one.noise, 3), "outliers": round(one.outliers, 4)}
            for path, one in learned.value.spoiled
        ],
        "warnings": notes,
        "guesses": list(found.value.guesses),
        "seconds": {
            "read": was_read - start,
            "fit": was_fitted - was_read,
            "total": perf_counter() - start,
        },
    }
    if as_json:
        print(json_line(facts))
    say(f"{counted(model.clips, 'clip')}, {counted(model.frames, 'frame')}, {model.bases.count} bases: {out}")
    return exit_code([failure for _, failure in failures], refused)


def _told(failures: Iterable[tuple[Path, Failure]], working: Working) -> list[tuple[Path, Failure]]:
    """The failures of clips, each said in one line."""
    told = []
    for path, failure in failures:
        tell_failure(path, failure, as_json=False, debug=working.debug)
        told.append((path, failure))
    return told


def _repaired_first(lesson: Lesson, kind: str) -> tuple[str, ...]:
    """What is said of clips that were spoiled themselves."""
    from ..denoise.spoiled_clips import told

    if not lesson.spoiled:
        return ()
    paths = [path for path, _ in lesson.spoiled]
    those = f"{paths[0]}:" if len(paths) == 1 else f"{len(paths)} clips, {paths[0]} first:"
    return (f"{those} {told([one for _, one in lesson.spoiled], 'cm' if kind == 'markers' else 'degrees')}",)


def _of_another_order(clips: Sequence[Path]) -> tuple[str, ...]:
    """What is said of clips whose joints turn in another order than the others'."""
    if not clips:
        return ()
    those = str(clips[0]) if len(clips) == 1 else f"{len(clips)} clips, {clips[0]} first"
    return (f"{those}: joints turn in another order than in the other clips; their angles were written in that",)
