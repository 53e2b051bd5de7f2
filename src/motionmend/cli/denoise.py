"""`motionmend denoise`: repair recordings and say what was done to every sample."""

from contextlib import ExitStack
from dataclasses import dataclass, replace
from math import inf, radians
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from .. import __version__
from ..errors import UsageError, counted
from .clock import since_start
from .inputs import Job
from .options import WORKING, WRITING, AsJson, Files, Out, Rate, SkeletonFile, Working, Writing
from .output import Done
from .transform import transform, write_json

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion, Repaired
    from ..denoise import DenoiserModel

DEFAULT_METHOD = "adaptive"
LOST = 0.10  # m; a deviation that says that a joint was not seen but held


def denoise(
    *files: Files,
    out: Out,
    model: Annotated[
        Path | None,
        Parameter(name=["-m", "--model"], help="Model (.mend) from `motionmend fit denoiser`."),
    ] = None,
    method: Annotated[
        str,
        Parameter(
            help="How to repair: adaptive finds noise and outliers in the recording itself, fills gaps, and does so "
            "better with a model; paper and kalman-data need one. gaussian, savgol, butterworth and kalman filter; "
            "linear, spline and pca (markers only) fill gaps and leave the rest."
        ),
    ] = DEFAULT_METHOD,
    robust: Annotated[
        str,
        Parameter(help="Estimator of method paper: welsch, tukey, huber, student, or square (not robust)."),
    ] = "welsch",
    max_std: Annotated[
        float | None,
        Parameter(
            help="Leave missing samples open that would be less sure than this: standard deviation in degrees for "
            "joint angles (root translations stay), metres for markers. Not given: fill what can be filled."
        ),
    ] = None,
    lag: Annotated[
        float | None,
        Parameter(
            help="Repair as if live: each frame from those before it and at most this many seconds after it, a "
            "quarter of a second of frames at a time. The latency of both together is stated. Not given: the whole "
            "recording at once."
        ),
    ] = None,
    footskate: Annotated[
        bool,
        Parameter(show_default=False, help="Keep feet still on the ground afterwards (joint angles, with a model)."),
    ] = False,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    report: Annotated[
        bool, Parameter(show_default=False, help="Write NAME.report.html beside each output: before and after.")
    ] = False,
    as_json: AsJson = False,
    working: Working = WORKING,
    writing: Writing = WRITING,
) -> int:
    """Repair recordings: remove noise and outliers, fill what is missing.

    Each output keeps its input's rate, frames and channels; a table of joints (.csv) also what it says of them: states
    and reliabilities as they are, deviations as they become, and what deviates by 0.10 m or more counts as not seen.
    Frames in which nobody is seen are filled while that is surer than 0.10 m. Beside each output stands NAME.mend.json:
    what each sample is (measured, repaired, filled, left open), standard deviations in degrees and metres, model,
    options and cost. Of all that is written only its last entry, "seconds", differs from run to run.
    """
    _check(method, robust, max_std, lag, footskate, model)
    skeleton = skeleton and working.reachable(skeleton)
    repair = Repair(
        method=method,
        robust=robust,
        max_std=max_std,
        lag=lag,
        footskate=footskate,
        fps=fps,
        skeleton=skeleton,
        report=report,
    ).knowing(model)
    repair = replace(repair, startup=since_start())
    sidecars = [".mend.json", *([".report.html"] if report else [])]
    return transform(repair, files, out, sidecars=sidecars, as_json=as_json, working=working, writing=writing)


def _check(
    method: str, robust: str, max_std: float | None, lag: float | None, footskate: bool, model: Path | None
) -> None:
    """Refuse options that make no sense, alone or together."""
    from ..denoise import METHODS, MODEL_FREE_METHODS
    from ..numerics.robust import ESTIMATORS

    if method not in METHODS:
        raise UsageError(f"--method: one of {', '.join(METHODS)} was wanted, came {method!r}")
    if robust not in ESTIMATORS:
        raise UsageError(f"--robust: one of {', '.join(ESTIMATORS)} was wanted, came {robust!r}")
    if max_std is not None and not max_std >= 0:
        raise UsageError(f"--max-std: a standard deviation of 0 or more was wanted, came {max_std}")
    if lag is not None and not 0 <= lag < inf:
        raise UsageError(f"--lag: seconds, 0 or more, were wanted, came {lag}")
    if lag is not None and method != DEFAULT_METHOD:
        raise UsageError(f"--lag goes with --method {DEFAULT_METHOD}, came {method}: leave one of them out")
    if lag is not None and footskate:
        raise UsageError("--footskate needs the whole recording: leave out --lag, or clean feet in a second run")
    if model is None and method not in MODEL_FREE_METHODS:
        raise UsageError(
            f"--method {method} learns from clips: give a model with -m, or choose one of "
            f"{', '.join(MODEL_FREE_METHODS)}"
        )
    if model is None and lag is not None:
        raise UsageError("--lag needs to know clean motion beforehand: give a model with -m")
    if model is None and footskate:
        raise UsageError("--footskate needs a model: give one with -m")


@dataclass(frozen=True)
class Repair:
    """The options of one command line, and the model they name; called with each file."""

    method: str = DEFAULT_METHOD
    robust: str = "welsch"
    max_std: float | None = None  # degrees or m
    lag: float | None = None  # s; None = the whole recording at once
    footskate: bool = False
    fps: float | None = None
    skeleton: Path | None = None
    report: bool = False
    model: "DenoiserModel | None" = None
    model_facts: dict[str, str] | None = None
    startup: float = 0.0  # s, from the start of the process until work began

    def knowing(self, model: Path | None) -> "Repair":
        """The same options with the model read from its file."""
        from ..io.model import load_model
        from ..models import restore

        if model is None:
            return self
        stored = load_model(model)
        facts = {"file": model.name, "sha256": stored.sha256}
        return replace(self, model=restore(stored, model, "denoiser"), model_facts=facts)

    def __call__(self, job: Job, /) -> Done:
        from ..io import read

        start = perf_counter()
        recording = read(job.source, fps=self.fps, skeleton=self.skeleton)
        was_read = perf_counter() - start
        joints = joints_seen(recording)
        repaired, seconds = self.timed(recording if joints is None else joints)
        if joints is not None:
            repaired = empty_where_nobody(joints, repaired)
        return self.save(job, recording, repaired, {"startup": self.startup, "read": was_read, **seconds})

    def timed(self, recording: "Motion | Markers") -> "tuple[Repaired[Any], dict[str, float]]":
        """What the method makes of a recording, and the seconds it took under `repair`."""
        from ..bodies.motion import Motion
        from ..denoise import FixedLag, repair_with_lag, repair_without_model
        from ..denoise.outcome import opened_where_unsure

        known: Any = recording  # each call takes motions and markers, none takes the union of both
        found: Repaired[Any]
        limit = radians(self.max_std) if self.max_std is not None and isinstance(known, Motion) else self.max_std
        start = perf_counter()
        if self.model is not None and self.lag is None:
            found = self.model.repair(known, self.method, robust=self.robust, footskate=self.footskate, max_std=limit)
        else:
            if self.model is None:
                found = repair_without_model(known, self.method)
            else:
                found = repair_with_lag(self.model, known, FixedLag(self.lag or 0.0))
            found = found if limit is None else opened_where_unsure(found, limit)
        return found, {"repair": perf_counter() - start}

    def save(
        self, job: Job, recording: "Motion | Markers", repaired: "Repaired[Any]", seconds: dict[str, float]
    ) -> Done:
        """Write the output and the files beside it; `seconds` is what was spent so far, `repair` among it."""
        from ..denoise.gaps.unsure import hardly_known
        from ..io import write
        from ..io.atomic import atomic
        from ..io.conversion import not_in
        from ..io.table import as_written

        start = perf_counter()
        told = as_written(repaired) if job.target.suffix.lower() == ".csv" else repaired
        lost = not_in(job.target.suffix.lower(), recording)
        of_repair = (*repaired.warnings, *hardly_known(repaired), *lost)
        warnings = (*recording.warnings, *of_repair)
        sidecars = (".mend.json", *((".report.html",) if self.report else ()))
        with job.together(*sidecars), ExitStack() as whole:
            if self.report:
                page = whole.enter_context(atomic(job.beside(".report.html")))
                self._write_report(page, recording, replace(told, warnings=of_repair))
            write(job.target, repaired.recording, repaired=repaired)
            seconds = {**seconds, "write": perf_counter() - start}
            seconds["total"] = sum(seconds.values())
            facts = self._facts(job, recording, told, warnings)
            write_json(job.beside(".mend.json"), {**facts, "seconds": _rounded(seconds)})
        counts = repaired.counts()
        latency = self._latency(recording.fps)
        share = 1000 * seconds["repair"] / recording.frames if recording.frames else None
        frame_ms = dict.fromkeys(("mean", "median", "p95", "max"), share)  # repaired together, all cost alike
        said = {
            "input": job.source,
            "output": job.target,
            "frames": recording.frames,
            "seconds": seconds,
            "frame_ms": frame_ms,
            "latency_s": latency,
            "counts": counts,
            "warnings": warnings,
            "guesses": recording.guesses,
        }
        late = "" if latency is None else f", given out {latency:.2f} s late"
        line = f"{job.source}: {counted(recording.frames, 'frame')}, {_summed(counts)}{late}: {job.target}"
        return Done(said, line=line, warnings=warnings, guesses=recording.guesses)

    def _latency(self, fps: float) -> float | None:
        """Seconds after which a frame was given out at the latest; None where all are at the end."""
        from ..denoise import FixedLag

        return None if self.lag is None else round(FixedLag(self.lag).latency(fps), 6)

    def _facts(
        self,
        job: Job,
        recording: "Motion | Markers",
        repaired: "Repaired[Any]",
        warnings: tuple[str, ...],
    ) -> dict[str, Any]:
        from .provenance import numbering, provenance

        return {
            "version": __version__,
            "input": job.source.name,
            "output": job.target.name,
            "model": self.model_facts,
            "options": {
                "method": self.method,
                "robust": self.robust,
                "max_std": self.max_std,
                "lag": self.lag,
                "footskate": self.footskate,
                "fps": self.fps,
                "skeleton": self.skeleton.name if self.skeleton else None,
            },
            "method": repaired.method,
            "frames": recording.frames,
            "fps": recording.fps,
            **numbering(recording),
            "latency_s": self._latency(recording.fps),
            **provenance(repaired),
            "warnings": warnings,
            "guesses": recording.guesses,
        }

    def _write_report(self, page: Path, recording: "Motion | Markers", repaired: "Repaired[Any]") -> None:
        from ..report import html_report

        facts: dict[str, str] = {}  # the page names the method itself
        if self.model_facts:
            facts["model"] = f"{self.model_facts['file']}, SHA-256 {self.model_facts['sha256']}"
        named = [("before", recording), ("after", repaired.recording)]
        html_report(page, named, repaired=repaired, facts=facts)


def joints_seen(recording: "Motion | Markers") -> "Markers | None":
    """Joints of a table that says how sure it is of them, those that were held rather than seen missing; else None."""
    from ..bodies.motion import Markers
    from ..io.table import TableSource

    source = recording.source
    if not isinstance(recording, Markers) or not isinstance(source, TableSource) or source.beside is None:
        return None
    std, positions = source.beside.std, np.array(recording.positions)
    if std is not None:
        positions[std >= LOST] = np.nan
    return replace(recording, positions=positions)


def empty_where_nobody(joints: "Markers", repaired: "Repaired[Markers]") -> "Repaired[Markers]":
    """The repair without what it filled into frames in which no joint is, unless that is as sure as a joint seen."""
    from ..denoise.outcome import opened_where_unsure

    nobody = ~joints.present.any(axis=1, keepdims=True)
    return opened_where_unsure(repaired, np.where(nobody, LOST, inf), f"{LOST} m in frames without anybody")


def _summed(counts: dict[str, int]) -> str:
    from .findings import percent

    whole = max(1, sum(counts.values()))
    shown = {"repaired": "repaired", "filled": "filled", "left_open": "left open"}
    parts = [f"{percent(counts[name] / whole)} {words}" for name, words in shown.items() if counts[name]]
    return ", ".join(parts) or "nothing replaced"


def _rounded(seconds: dict[str, float]) -> dict[str, float]:
    return {name: round(value, 4) for name, value in seconds.items()}
