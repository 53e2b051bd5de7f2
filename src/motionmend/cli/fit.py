"""`motionmend fit`: learn models from clean recordings."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..batch import Failure, one_blas_thread, run
from ..errors import FileError, UsageError
from .inputs import Input, gather
from .options import WORKING, AsJson, Files, Force, Rate, SkeletonFile, Working
from .output import exit_code, json_line, progress, say, tell_failure, tell_guesses

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion


def denoiser(
    *clips: Files,
    out: Annotated[Path, Parameter(name=["-o", "--out"], help="The model to write; ends in .mend.")],
    fps: Rate = None,
    model_fps: Annotated[float, Parameter(help="Rate in Hz the model works at.")] = 30.0,
    window: Annotated[int, Parameter(help="Length of the lag window in frames at --model-fps.")] = 20,
    energy: Annotated[float, Parameter(help="Share of the variance the bases keep, above 0 and at most 1.")] = 0.99,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    force: Force = False,
    working: Working = WORKING,
) -> int:
    """Learn a denoiser from clean clips of one kind: joint angles of one channel set, or one marker set.

    A clip that cannot be read is reported and left out.
    """
    from ..denoise import Denoiser
    from ..io import READABLE
    from ..models import save_model

    if out.suffix.lower() != ".mend":
        raise UsageError(f"-o: a model's name ends in .mend, came {out}")
    if out.exists() and not force:
        raise FileError(f"{out} is there already: --force overwrites it")
    settings = Denoiser(window=window, fps=model_fps, energy=energy)
    start = perf_counter()
    inputs, refused = gather([working.reachable(clip) for clip in clips], READABLE, "clip")
    recordings, failures = _read_all(inputs, fps, skeleton, working)
    for refusal in refused:
        tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=False, debug=False)
    if not recordings:
        raise FileError(f"{out} not written: a denoiser learns from clean clips, none of those given can be used")
    was_read = perf_counter()
    with one_blas_thread():
        model = settings.fit(recordings)
    was_fitted = perf_counter()
    out.parent.mkdir(parents=True, exist_ok=True)
    sha256 = save_model(out, model)
    for note in model.notes:
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
        "warnings": model.notes,
        "guesses": list(dict.fromkeys(guess for clip in recordings for guess in clip.guesses)),
        "seconds": {
            "read": was_read - start,
            "fit": was_fitted - was_read,
            "total": perf_counter() - start,
        },
    }
    if as_json:
        print(json_line(facts))
    say(f"{model.clips} clips, {model.frames} frames, {model.bases.count} bases: {out}")
    return exit_code(failures, refused)


def _read_all(
    inputs: Sequence[Input], fps: float | None, skeleton: Path | None, working: Working
) -> tuple[list["Motion | Markers"], list[Failure]]:
    """The clips that can be read, in order, and why the others cannot; says so as it goes."""
    recordings: list[Motion | Markers] = []
    failures: list[Failure] = []
    guesses: dict[str, list[Path]] = {}
    task = partial(read_clip, fps=fps, skeleton=skeleton and working.reachable(skeleton))
    with progress(len(inputs)) as advance:
        outcomes = run(task, inputs, jobs=working.width, cluster=working.cluster, on_done=lambda _: advance())
    for outcome in outcomes:
        path = outcome.item.path
        if outcome.failure is not None:
            tell_failure(path, outcome.failure, as_json=False, debug=working.debug)
            failures.append(outcome.failure)
        elif outcome.value is not None:
            recordings.append(outcome.value)
            for guess in outcome.value.guesses:
                guesses.setdefault(guess, []).append(path)
    tell_guesses(guesses)
    return recordings, failures


def read_clip(item: Input, /, *, fps: float | None, skeleton: Path | None) -> "Motion | Markers":
    """One clip; a task for `batch.run`."""
    from ..io import read

    return read(item.path, fps=fps, skeleton=skeleton)
