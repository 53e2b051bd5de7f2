"""`motionmend fit tracker`: poses and a detector for following people in depth images."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..batch import Failure, Outcome, one_blas_thread, run
from ..errors import FileError, UsageError, counted
from .archive import Reading
from .inputs import Input, gather
from .model_file import ModelFile, check_place, write_model
from .options import WORKING, AsJson, Files, Force, Rate, SkeletonFile, Whole, Working
from .output import exit_code, reasons, tell_failure, tell_guesses
from .speech import json_line, progress, say

if TYPE_CHECKING:
    from ..bodies.motion import Motion

_ENDINGS = (".amc", ".bvh")


def tracker(
    *clips: Files,
    out: ModelFile,
    images: Annotated[
        Whole,
        Parameter(
            help="Synthetic depth images the detector learns from, and half as many of people who are cut off; 0 "
            "learns none, then --start is needed."
        ),
    ] = 2000,
    seed: Annotated[Whole, Parameter(help="Of those images.")] = 0,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    force: Force = False,
    working: Working = WORKING,
) -> int:
    """Learn a tracker from clean clips of joint angles (.asf/.amc, .bvh) of any body with arms and legs.

    The clips' poses become the prior; a detector that finds people anew learns from depth images drawn of them. A
    clip that cannot be read, or on whose skeleton the joints are not found, is reported and left out.
    """
    from ..track.model import TrackerModel

    check_place(out, force)
    if images < 0:
        raise UsageError(f"--images: 0 or more were wanted, came {images}")
    start = perf_counter()
    inputs, refused = gather([working.reachable(clip) for clip in clips], _ENDINGS, "clip")
    reading = Reading(fps, skeleton and working.reachable(skeleton))
    for refusal in refused:
        tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=False, debug=False)
    with progress(len(inputs)) as advance:

        def heard(outcome: "Outcome[Input, Motion]") -> None:
            advance()

        outcomes = run(
            partial(thinned, reading=reading), inputs, jobs=working.width, cluster=working.cluster, on_done=heard
        )
    failures, motions = [], []
    guesses: dict[str, list[Path]] = {}
    for outcome in outcomes:
        if outcome.value is None:
            assert outcome.failure is not None
            failures.append((outcome.item.path, outcome.failure))
            tell_failure(outcome.item.path, outcome.failure, as_json=False, debug=working.debug)
            continue
        motions.append(outcome.value)
        for guess in (*outcome.value.warnings, *outcome.value.guesses):
            guesses.setdefault(guess, []).append(outcome.item.path)
    tell_guesses(guesses)
    if not motions:
        raise FileError(f"{out} not written: a tracker learns from clips of joint angles, none given can be used")
    was_read = perf_counter()
    with one_blas_thread():
        model = TrackerModel.fit(motions, seed=seed, detector=images > 0, images=images)
    was_fitted = perf_counter()
    sha256 = write_model(out, model)
    facts = {
        "output": out,
        "kind": "tracker",
        "sha256": sha256,
        "clips": len(motions),
        "frames": sum(motion.frames for motion in motions),
        "poses": len(model.database),
        "settings": {"images": images, "seed": seed},
        "failed": len(failures) + len(refused),
        "failures": reasons(failures, refused),
        "warnings": [],
        "guesses": list(guesses),
        "seconds": {"read": was_read - start, "fit": was_fitted - was_read, "total": perf_counter() - start},
    }
    if as_json:
        print(json_line(facts))
    drawn = f"{counted(images, 'image')} and half as many of people who are cut off" if images else "no images"
    say(f"{counted(len(motions), 'clip')}, {counted(len(model.database), 'pose')}, {drawn}: {out}")
    return exit_code([failure for _, failure in failures], refused)


def thinned(item: Input, /, *, reading: Reading) -> "Motion":
    """A clip at the pace of a depth camera, on a skeleton that a performer can be made of; a task for `batch.run`.

    Raises
    ------
    FileError, MismatchError : it cannot be read, or its joints are not found.
    """
    from ..bodies.motion import Motion
    from ..bodies.templates import performer_of
    from ..track.database import FPS, whole_poses

    clip = reading(item)
    if not isinstance(clip, Motion):
        raise FileError(f"{item.path}: joint angles were wanted, came markers")
    performer_of(clip.skeleton)
    step = max(1, round(clip.fps / FPS))
    q = clip.q[::step]
    lacking = int((~whole_poses(q)).sum())
    said = (f"{lacking} of {counted(len(q), 'pose')} lack channels and are left out",) if lacking else ()
    return replace(clip, q=q, fps=clip.fps / step, source=None, warnings=(*clip.warnings, *said))
