"""`motionmend pipeline`: from what was recorded to what can be used, in one go."""

from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, time
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from .. import __version__
from ..errors import FileError, MismatchError, UsageError, counted
from .denoise import LOST
from .folders import housed, new_folders
from .inputs import Refusal
from .options import WORKING, WRITING, AsJson, Out, Working, Writing
from .output import Done, work
from .speech import say
from .takes import Kind, Take, gather_takes, plan_takes
from .transform import write_json

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion, Repaired
    from ..bodies.postures import Postures
    from .correct import Correction
    from .denoise import Repair
    from .pipeline_config import PipelineConfig
    from .track import Follow


def pipeline(
    *takes: Annotated[
        Path,
        Parameter(
            help="Depth folders, recordings of sensors' skeletons, of markers or of joint angles; or folders of them.",
            negative="",
        ),
    ],
    out: Out,
    config: Annotated[
        Path | None, Parameter(help="Models and options of the steps, TOML with sections track, correct, denoise.")
    ] = None,
    models: Annotated[
        tuple[Path, ...],
        Parameter(name=["-m", "--model"], help="A tracker, corrector or denoiser (.mend); may be given once for each."),
    ] = (),
    as_json: AsJson = False,
    working: Working = WORKING,
    writing: Writing = WRITING,
) -> int:
    """Take every recording all the way: depth is tracked and denoised, sensors' skeletons are corrected and denoised,
    markers and joint angles are denoised.

    What a take is, is seen from its content. Depth and sensors give tables of joints (.csv) or joint angles (.bvh, and
    .amc for depth), by the ending of OUT or `format` in the configuration. Beside each output stands NAME.mend.json.
    """
    from .pipeline_config import PipelineConfig, put_aside, read_config, with_models

    given = [working.reachable(take) for take in takes]
    configured = PipelineConfig() if config is None else read_config(config)
    options = with_models(configured, models)
    for line in put_aside(configured, options):
        say(line)
    out = working.reachable(out)
    found, refused = gather_takes(given, out)
    if options.track.start is not None and sum(kind == "depth" for _, kind in found) > 1:
        raise UsageError(f"{config}: track.start is the first pose of one depth recording: leave it out for several")
    planned, barred = plan_takes(found, given, out, options.format, writing)
    try:
        chain, lacking = _chain(options, {take.kind for take in planned})
    except UsageError as error:
        raise UsageError(f"{config}: {error}" if config is not None else str(error)) from None
    with new_folders() as make:
        jobs = []
        for take in planned:
            lacks = lacking.get(take.kind)
            job = housed(take.job, make) if lacks is None else Refusal(take.job.source, lacks)
            if isinstance(job, Refusal):
                barred.append(job)
            else:
                jobs.append(take)
        refused = [*refused, *barred]
        if chain.follow is not None:
            chain = replace(chain, follow=replace(chain.follow, idle=working.idle(len(jobs))))
        return work(chain, jobs, name=_source, working=working, as_json=as_json, refused=refused, given=given)


def _chain(options: "PipelineConfig", kinds: set[Kind]) -> "tuple[Chain, dict[Kind, str]]":
    """The steps with their models read, and why takes of a kind cannot be worked on."""
    from .correct import Correction
    from .denoise import Repair, _check
    from .pipeline_config import NO_DENOISE
    from .track import Follow, _settings

    lacking: dict[Kind, str] = {}
    chain = Chain(options.fps)
    clean, seen, depth = options.denoise, options.correct, options.track
    if clean.method != NO_DENOISE:
        _check(clean.method, clean.robust, clean.max_std, clean.lag, clean.footskate, clean.model)
        repair = Repair(
            method=clean.method,
            robust=clean.robust,
            max_std=clean.max_std,
            lag=clean.lag,
            footskate=clean.footskate,
            fps=options.fps,
        )
        chain = replace(chain, repair=repair.knowing(clean.model))
    if "sensor" in kinds and seen.model is None:
        lacking["sensor"] = "a corrector was wanted for a sensor's skeleton: give one with -m or in --config"
    elif "sensor" in kinds and seen.model is not None:
        correction = Correction(method=seen.method, online=seen.online, fps=options.fps)
        chain = replace(chain, correction=correction.knowing(seen.model))
    if "depth" in kinds and depth.model is None:
        lacking["depth"] = "a tracker was wanted for depth: give one with -m or in --config"
    elif "depth" in kinds and depth.model is not None:
        if depth.body is not None and not depth.body.exists():
            raise FileError(f"{depth.body}: no such body: `motionmend track --body` makes one")
        terms = _settings(depth.preset, None if depth.terms is None else ",".join(depth.terms)).terms
        follow = Follow(depth.preset, terms, time())
        chain = replace(chain, follow=follow.knowing(depth.model, depth.skeleton, depth.body, depth.start))
    return chain, lacking


@dataclass(frozen=True)
class Step:
    """What a step of a chain leaves behind: its name, model, seconds, and what it had to say."""

    name: str
    model: dict[str, str] | None
    seconds: float
    warnings: tuple[str, ...] = ()

    def facts(self) -> dict[str, Any]:
        """For the file beside the output; seconds stand elsewhere, so that the rest is the same from run to run."""
        return {"step": self.name, "model": self.model, "warnings": self.warnings}


@dataclass(frozen=True)
class Chain:
    """The steps of one command line with their models; called with each take."""

    fps: float | None = None
    follow: "Follow | None" = None
    correction: "Correction | None" = None
    repair: "Repair | None" = None

    def __call__(self, take: Take, /) -> Done:
        if take.job.finished:
            facts = {"input": take.job.source, "output": take.job.target, "skipped": True}
            return Done(facts, line=f"{take.job.source}: {take.job.target} is there already, skipped")
        start = perf_counter()
        if take.kind == "recording":
            from ..io import read

            given = read(take.job.source, fps=self.fps)
            return self._cleaned(take, given, (), {"read": perf_counter() - start})
        angles = take.job.target.suffix.lower() != ".csv"
        found = self._tracked(take, angles) if take.kind == "depth" else self._corrected(take, angles)
        recording, step, guesses, read_seconds = found
        from ..bodies.postures import Postures

        if isinstance(recording, Postures):
            return self._table(take, recording, step, guesses, {"read": read_seconds, step.name: step.seconds})
        recording = replace(recording, guesses=tuple(dict.fromkeys((*guesses, *recording.guesses))))  # each once
        return self._cleaned(take, recording, (step,), {"read": read_seconds, step.name: step.seconds})

    def _tracked(self, take: Take, angles: bool) -> "tuple[Postures | Motion, Step, tuple[str, ...], float]":
        """Depth as joints or joint angles."""
        from ..io.depth import read_depth
        from .tracked_files import followed_motion

        assert self.follow is not None
        start = perf_counter()
        recording = read_depth(take.job.source)
        followed = self.follow.followed(take.job.source, recording)
        step = Step(
            "track",
            self.follow.model_facts,
            perf_counter() - start - followed.read,
            tuple(self.follow.warnings(recording, followed)),
        )
        found = followed_motion(followed, self.follow.skeleton, recording.fps) if angles else followed.postures
        return found, step, self.follow.guesses(recording), followed.read

    def _corrected(self, take: Take, angles: bool) -> "tuple[Postures | Motion, Step, tuple[str, ...], float]":
        """A sensor's skeleton corrected, as joints or joint angles."""
        from ..bodies.motion import Motion
        from ..bodies.posed_skeleton import motion_of
        from ..io.conversion import not_in
        from ..io.sensor import read_postures
        from .correct import empty_where_empty, rate_of, refuse_nobody, refuse_other_units, told_of

        assert self.correction is not None
        assert self.correction.model is not None
        start = perf_counter()
        sensor = read_postures(take.job.source, fps=self.fps)
        refuse_other_units(take.job.source, sensor)
        was_read = perf_counter()
        corrected = self.correction.model.correct(sensor, online=self.correction.online, method=self.correction.method)
        corrected = empty_where_empty(sensor, corrected)
        refuse_nobody(take.job.source, corrected)
        result = motion_of(corrected, rate_of(sensor, self.fps)) if angles else corrected
        lost = not_in(take.job.target.suffix.lower(), corrected)
        if isinstance(result, Motion):  # what the skeleton cannot do is no guess, as `correct` has it
            lost = (*lost, *(one for one in result.guesses if one not in corrected.guesses))
            result = replace(result, guesses=corrected.guesses)
        warnings = tuple(dict.fromkeys((*told_of(sensor, corrected), *lost)))
        step = Step("correct", self.correction.model_facts, perf_counter() - was_read, warnings)
        return result, step, sensor.guesses, was_read - start

    def _cleaned(
        self, take: Take, recording: "Motion | Markers", steps: tuple[Step, ...], seconds: dict[str, float]
    ) -> Done:
        """Joint angles or markers, denoised and written."""
        from ..io import write
        from ..io.conversion import not_in

        repaired, doubts = None, () if steps else recording.warnings  # a step before has told them
        lost = not_in(take.job.target.suffix.lower(), recording)
        if self.repair is not None:
            repaired, step = _repaired(self.repair, recording, made=bool(steps))
            step = replace(step, warnings=(*step.warnings, *lost))
            steps, seconds = (*steps, step), {**seconds, step.name: step.seconds}
        result = recording if repaired is None else repaired.recording
        said = (*doubts, *_warnings(steps)), recording.guesses
        start = perf_counter()
        with ExitStack() as whole:
            self._sidecar(whole, take, steps, result.frames, result.fps, repaired, *said, seconds, recording)
            write(take.job.target, result, repaired=repaired)
        return _said(take, steps, result.frames, repaired, *said, {**seconds, "write": perf_counter() - start})

    def _table(
        self, take: Take, postures: "Postures", step: Step, guesses: tuple[str, ...], seconds: dict[str, float]
    ) -> Done:
        """Joints, denoised as a cloud of markers and written as a table."""
        from ..io.atomic import atomic
        from ..io.joint_table import write_joint_table
        from ..io.table import uneven_times

        steps: tuple[Step, ...] = (step,)
        repaired = None
        if self.repair is not None and postures.frames > 1:
            repaired, last = _repaired(self.repair, as_markers(postures), made=True)
            postures, before = denoised(postures, repaired), repaired
            repaired = as_in_table(repaired, postures)
            said = (*uneven_times(postures.times), *_kept(before, repaired, step.name))
            last = replace(last, warnings=(*last.warnings, *said))
            steps, seconds = (*steps, last), {**seconds, last.name: last.seconds}
        told = _warnings(steps), guesses
        start = perf_counter()
        with ExitStack() as whole:
            self._sidecar(whole, take, steps, postures.frames, postures.fps, repaired, *told, seconds)
            write_joint_table(whole.enter_context(atomic(take.job.target)), postures)
        return _said(take, steps, postures.frames, repaired, *told, {**seconds, "write": perf_counter() - start})

    def _sidecar(
        self,
        whole: ExitStack,
        take: Take,
        steps: tuple[Step, ...],
        frames: int,
        fps: float,
        repaired: "Repaired[Any] | None",
        warnings: tuple[str, ...],
        guesses: tuple[str, ...],
        seconds: dict[str, float],
        recording: "Motion | Markers | None" = None,
    ) -> None:
        """The file beside the output; appears with it."""
        from ..io.atomic import atomic
        from .provenance import numbering, provenance

        facts = {
            "version": __version__,
            "input": take.job.source.name,
            "output": take.job.target.name,
            "kind": take.kind,
            "steps": [step.facts() for step in steps],
            "method": None if repaired is None else repaired.method,
            "frames": frames,
            "fps": fps,
            **({} if recording is None else numbering(recording)),
            **({} if repaired is None else provenance(repaired)),
            "warnings": warnings,
            "guesses": guesses,
            "seconds": {name: round(value, 4) for name, value in seconds.items()},
        }
        write_json(whole.enter_context(atomic(take.job.beside(".mend.json"))), facts)


def _repaired(repair: "Repair", recording: "Motion | Markers", made: bool) -> "tuple[Repaired[Any], Step]":
    """What the denoiser makes of a recording, as a step.

    A denoiser knows takes of one kind. Joints that another step has made (`made`) and that it does not know are
    repaired by what they show themselves, and that is said; a take that only needs denoising fails, as with `denoise`.

    Raises
    ------
    MismatchError : the model does not know the recording, which cannot be repaired without.
    """
    from ..denoise import MODEL_FREE_METHODS

    try:
        repaired, spent = repair.timed(recording)
    except MismatchError as error:
        needed = repair.method not in MODEL_FREE_METHODS or repair.lag is not None or repair.footskate
        if repair.model is None or needed or not made:
            raise
        repaired, spent = replace(repair, model=None, model_facts=None).timed(recording)
        said = f"repaired without the model: {error}"
        return repaired, Step("denoise", None, spent["repair"], (said, *repaired.warnings))
    return repaired, Step("denoise", repair.model_facts, spent["repair"], repaired.warnings)


def as_markers(postures: "Postures") -> "Markers":
    """Joints as a cloud of markers at the postures' usual rate; those that were held rather than seen are missing."""
    from ..bodies.joint_sets import known_set
    from ..bodies.motion import Markers
    from ..live.axes import page_from_sensor

    known = known_set(postures.names)
    positions = np.array(postures.positions)
    if postures.std is not None:
        positions[postures.std >= LOST] = np.nan
    up = page_from_sensor("" if known is None else known.key)[2]
    return Markers(postures.names, positions, postures.fps, up=up)


def denoised(postures: "Postures", repaired: "Repaired[Markers]") -> "Postures":
    """The postures after their repair as markers.

    What the repair left open stays as the step before had it, and so does a frame without the person. A deviation is
    the larger one of both steps: smoothing does not take away what is wrong all the time.
    """
    there = postures.present.any(axis=1)
    mended = np.asarray(np.isfinite(repaired.recording.positions).all(axis=2)) & np.asarray(there)[:, None]
    positions = np.where(mended[:, :, None], repaired.recording.positions, postures.positions)
    std = postures.std
    if std is not None:
        filled = mended & (std >= LOST)
        std = np.where(filled, repaired.std, np.where(mended, np.fmax(std, repaired.std), std))
    return replace(postures, positions=positions, std=std)


def as_in_table(repaired: "Repaired[Markers]", written: "Postures") -> "Repaired[Markers]":
    """What is said of a repair as its table has it: with the table's deviations, and positions that the repair left
    open and the step before had made are filled."""
    from ..bodies.motion import Origin

    there = written.present
    made = np.where(repaired.origin == Origin.LEFT_OPEN, np.uint8(Origin.FILLED), repaired.origin)
    std = repaired.std if written.std is None else written.std.astype(repaired.std.dtype)
    return replace(
        repaired,
        origin=np.where(there, made, np.uint8(Origin.LEFT_OPEN)),
        std=np.where(there, std, np.float32(np.nan)),
    )


def _kept(repaired: "Repaired[Markers]", written: "Repaired[Markers]", step: str) -> tuple[str, ...]:
    """A sentence about positions that a repair left open and that stay as the step before had them."""
    from ..bodies.motion import Origin

    kept = int(((repaired.origin == Origin.LEFT_OPEN) & (written.origin == Origin.FILLED)).sum())
    return (f"{counted(kept, 'position')} that it left open stand as {step} made them, as unsure",) if kept else ()


def _warnings(steps: tuple[Step, ...]) -> tuple[str, ...]:
    return tuple(f"{step.name}: {warning}" for step in steps for warning in step.warnings)


def _said(
    take: Take,
    steps: tuple[Step, ...],
    frames: int,
    repaired: "Repaired[Any] | None",
    warnings: tuple[str, ...],
    guesses: tuple[str, ...],
    seconds: dict[str, float],
) -> Done:
    seconds = {**seconds, "total": sum(seconds.values())}
    names = [step.name for step in steps]
    facts = {
        "input": take.job.source,
        "output": take.job.target,
        "kind": take.kind,
        "steps": names,
        "frames": frames,
        "seconds": seconds,
        "counts": {} if repaired is None else repaired.counts(),
        "warnings": warnings,
        "guesses": guesses,
    }
    line = f"{take.job.source}: {counted(frames, 'frame')}, {' and '.join(names) or 'nothing'} done: {take.job.target}"
    return Done(facts, line=line, warnings=warnings, guesses=guesses)


def _source(take: Take) -> Path:
    return take.job.source
