"""`motionmend correct`: put right what a depth sensor says of a person."""

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from .. import __version__
from ..errors import FileError, UsageError, counted
from .clock import since_start
from .inputs import Input, Job
from .options import WORKING, WRITING, AsJson, Files, Out, Working, Writing, check_rate
from .output import Done
from .transform import Forms, transform, write_json

if TYPE_CHECKING:
    from ..bodies.motion import Motion
    from ..bodies.postures import Postures
    from ..correct.corrector import CorrectorModel

WRITTEN = (".csv", ".bvh", ".amc")
TIMED = 200  # frames corrected one by one to tell how long each takes
WARM = 2  # of them, before which things are loaded
_DESCENDING = ("paper",)  # methods that descend frame by frame, and do not count their steps; all others solve directly
DIGITS = 3  # significant digits of what .mend.json says of each joint


def correct(
    *files: Files,
    model: Annotated[Path, Parameter(name=["-m", "--model"], help="Model (.mend) from `motionmend fit corrector`.")],
    out: Out,
    online: Annotated[
        bool,
        Parameter(show_default=False, help="Go on learning, from frames that are reliable and certain, as if live."),
    ] = False,
    method: Annotated[
        str,
        Parameter(
            help="How to correct: default, or what it is compared with: paper, exact, adaptive (local Gaussian "
            "processes), gp, "
            "exemplar, ridge, constant (learn from the same pairs), one-euro, savgol, kalman (only smooth)."
        ),
    ] = ("default"),
    look_ahead: Annotated[
        float | None,
        Parameter(
            help="Correct as if live: each frame from those before it and from so many seconds after it, 0 to 1. The "
            "latency is stated. Not given: each frame from the whole recording."
        ),
    ] = None,
    fps: Annotated[
        float | None, Parameter(help="Rate in Hz of files without times; 30 when not given.", validator=check_rate)
    ] = None,
    format: Annotated[
        str | None, Parameter(help="csv, bvh or amc: what to write for a folder or several files; csv when not given.")
    ] = None,
    as_json: AsJson = False,
    working: Working = WORKING,
    writing: Writing = WRITING,
) -> int:
    """Correct what depth sensors report: positions of joints, frame by frame.

    Reads Kinect tables (.skl, .csv), KIMORE and LabanotationSuite .csv, NTU .skeleton, UI-PRMD text, UTD-MHAD .mat,
    Keraal text, Azure Kinect bodies (.json), TRC of Pose2Sim, and tables of joints. The output keeps the sensor's axes,
    place, times, joints and their names, with a standard deviation (m) and a reliability (0 to 1) of each joint. Beside
    it stands NAME.mend.json.
    """
    from ..correct.corrector import METHODS
    from ..io.sensor import SENSOR_ENDINGS, looks_like_sensor

    if method not in METHODS:
        raise UsageError(f"--method: one of {', '.join(METHODS)} was wanted, came {method!r}")
    if format is not None and f".{format}" not in WRITTEN:
        raise UsageError(f"--format: one of {', '.join(e[1:] for e in WRITTEN)} was wanted, came {format!r}")
    if format is not None and out.suffix.lower() in WRITTEN and out.suffix.lower() != f".{format}" and not out.is_dir():
        raise UsageError(f"-o {out}: its ending and --format {format} differ: leave one of them out")
    if look_ahead is not None and method != "default":
        raise UsageError(f"--look-ahead goes with the default method alone, came --method {method}")
    if look_ahead is not None:
        frames_ahead(look_ahead)
    task = Correction(method=method, online=online, look_ahead=look_ahead, fps=fps, timed=as_json).knowing(model)
    task = replace(task, startup=since_start())
    ending = f".{format or 'csv'}"
    forms = Forms(
        SENSOR_ENDINGS,
        WRITTEN,
        ending,
        "sensor's recording of joints",
        looks_like_sensor,
        partial(placed, ending=ending),
    )
    return transform(
        task, files, out, sidecars=[".mend.json"], as_json=as_json, working=working, writing=writing, forms=forms
    )


def frames_ahead(seconds: float, fps: float = 30.0) -> int:
    """Frames of a --look-ahead of so many seconds at a rate in Hz.

    Raises
    ------
    UsageError : shorter than 0 s, or longer than what helps.
    """
    from ..correct.look_ahead import frames_in

    try:
        return frames_in(seconds, fps)
    except UsageError as error:
        raise UsageError(f"--look-ahead: {error}") from None


def placed(inputs: list[Input], *, ending: str) -> list[Input]:
    """Each input with the place of its output: its own without its endings; with them where two would be the same."""
    short = [replace(one, place=one.place.with_name(_stem(one.place.name) + ending)) for one in inputs]
    shared = Counter(str(one.place).lower() for one in short)
    return [
        new if shared[str(new.place).lower()] == 1 else replace(old, place=old.place.with_name(old.place.name + ending))
        for old, new in zip(inputs, short, strict=True)
    ]


def _stem(name: str) -> str:
    """A file's name without its endings: `x_positions.txt.gz` is `x_positions`."""
    whole = Path(name)
    return Path(whole.stem).stem if whole.suffix.lower() == ".gz" and Path(whole.stem).suffix else whole.stem


@dataclass(frozen=True)
class Correction:
    """The options of one command line, and the model they name; called with each file."""

    method: str = "default"
    online: bool = False
    look_ahead: float | None = None
    fps: float | None = None
    timed: bool = False  # also how long single frames take, live
    model: "CorrectorModel | None" = None
    model_facts: dict[str, str] | None = None
    startup: float = 0.0  # s, from the start of the process until work began

    def knowing(self, path: Path) -> "Correction":
        """The same options with the model read from its file."""
        from ..io.model import load_model
        from ..models import restore

        stored = load_model(path)
        facts = {"file": path.name, "sha256": stored.sha256}
        return replace(self, model=restore(stored, path, "corrector"), model_facts=facts)

    def __call__(self, job: Job, /) -> Done:
        from ..io.sensor import read_postures

        assert self.model is not None
        start = perf_counter()
        sensor = read_postures(job.source, fps=self.fps)
        refuse_other_units(job.source, sensor)
        was_read = perf_counter()
        corrected = self.model.correct(sensor, self.online, self.method, self._ahead(sensor))
        corrected = empty_where_empty(sensor, corrected)
        refuse_nobody(job.source, corrected)
        seconds = {"startup": self.startup, "read": was_read - start, "correct": perf_counter() - was_read}
        return self._save(job, sensor, corrected, told_of(sensor, corrected), seconds)

    def _ahead(self, sensor: "Postures") -> int | None:
        """Frames after each that it is corrected from; None for all."""
        return None if self.look_ahead is None else frames_ahead(self.look_ahead, rate_of(sensor))

    def _save(
        self,
        job: Job,
        sensor: "Postures",
        corrected: "Postures",
        warnings: tuple[str, ...],
        seconds: dict[str, float],
    ) -> Done:
        """Write the output and what is said of it."""
        from ..bodies.posed_skeleton import motion_of
        from ..io.conversion import not_in

        start = perf_counter()
        made = corrected if job.target.suffix.lower() == ".csv" else motion_of(corrected, rate_of(sensor, self.fps))
        seconds = {**seconds, "write": perf_counter() - start}
        warnings += tuple(one for one in made.guesses if one not in corrected.guesses)
        warnings += not_in(job.target.suffix.lower(), corrected)
        counts = tallied(sensor, corrected)
        reliability = _spread(corrected.reliability, sensor.names, corrected.present)
        ahead = self._ahead(sensor)
        latency = None if ahead is None else round(1000.0 * ahead / rate_of(sensor), 3)
        facts = {
            "version": __version__,
            "input": job.source.name,
            "output": job.target.name,
            "model": self.model_facts,
            "options": {
                "method": self.method,
                "online": self.online,
                "look_ahead": self.look_ahead,
                "fps": self.fps,
            },
            "method": self.method,
            "frames": sensor.frames,
            "fps": sensor.fps,
            "latency_ms": latency,
            "counts": counts,
            "channels": channels(sensor, corrected),
            "refused_frames": refused(corrected),
            "swapped_frames": flagged(corrected).get("swapped", []),
            "reliability": reliability,
            "std": _spread(corrected.std, sensor.names, corrected.present),
            "iterations": None if self.method in _DESCENDING else 0,
            "cost": [],
            "warnings": warnings,
            "guesses": sensor.guesses,
        }
        each = getattr(corrected.source, "seconds", None)
        if each is None and self.timed and self.model is not None and self.method == "default":
            again = perf_counter()
            each = live_seconds(self.model, sensor, ahead or 0)
            seconds = {**seconds, "timing": perf_counter() - again}
        frame_ms = _frame_ms(sensor.frames, seconds["correct"], each)
        start = perf_counter()
        with job.together(".mend.json"):
            _write(job.target, made)
            seconds["write"] += perf_counter() - start
            seconds["total"] = sum(seconds.values())
            rounded = {name: round(value, 4) for name, value in seconds.items()}
            write_json(job.beside(".mend.json"), {**facts, "seconds": {**rounded, "frame_ms": frame_ms}})
        said = {
            "input": job.source,
            "output": job.target,
            "frames": sensor.frames,
            "joints": len(sensor.names),
            "seconds": seconds,
            "frame_ms": frame_ms,
            "latency_ms": latency,
            "counts": counts,
            "reliability": reliability["all"],
            "refused_frames": refused(corrected),
            "warnings": warnings,
            "guesses": sensor.guesses,
        }
        empty = f", {counts['empty_frames']} without the person" if counts["empty_frames"] else ""
        late = f", given out {latency:.0f} ms late" if latency else ""
        mean = reliability["all"]["mean"]
        line = (
            f"{job.source}: {counted(sensor.frames, 'frame')}{empty}{late}, moved by {counts['moved_cm']} cm, "
            f"reliability {mean if mean is not None else 'unknown'}: {job.target}"
        )
        return Done(said, line=line, warnings=warnings, guesses=sensor.guesses)


def refuse_other_units(source: Path, sensor: "Postures") -> None:
    """Whether a recording may be in metres is asked of the size of the body.

    Raises
    ------
    FileError : nobody is so large, or so small.
    """
    from ..io.kinect_table import LARGEST_BODY, SMALLEST_BODY, size_of_body, unit_of_body

    size = size_of_body(sensor.positions)
    if size > LARGEST_BODY:
        raise FileError(
            f"{source}: metres were wanted, came a body that is {size:.4g} large: is it {unit_of_body(size)[1]}? "
            "Convert it"
        )
    if 0 < size < SMALLEST_BODY:
        raise FileError(
            f"{source}: came a body that is {size:.4g} m large: are its lengths in another unit? Convert it"
        )


def refuse_nobody(source: Path, corrected: "Postures") -> None:
    """A recording of which nothing could be corrected is a failed input.

    Raises
    ------
    FileError : no joint of it has a position.
    """
    if not corrected.present.any():
        raise FileError(
            f"{source}: nobody is where a sensor can see anybody, in any of {counted(corrected.frames, 'frame')}: "
            "check the unit (metres) and the axes"
        )


def empty_where_empty(sensor: "Postures", corrected: "Postures") -> "Postures":
    """A frame without the person stays one, and a joint without a position has no deviation."""
    empty = np.asarray(~sensor.present.any(axis=1))[:, None]
    gone = empty | ~corrected.present
    if not gone.any():
        return corrected
    positions = np.where(gone[:, :, None], np.nan, corrected.positions)
    std = None if corrected.std is None else np.where(gone, np.nan, corrected.std)
    sure = None if corrected.reliability is None else np.where(empty, 0.0, corrected.reliability)
    return replace(corrected, positions=positions, std=std, reliability=sure)


def tallied(sensor: "Postures", corrected: "Postures") -> dict[str, Any]:
    """How many samples (frames x joints) are what `channels` says, how many the sensor tracked and inferred, and how
    far they were moved (cm)."""
    there, now = sensor.present, corrected.present
    moved = np.linalg.norm(corrected.positions - sensor.positions, axis=2)[there & now]
    of_joints = channels(sensor, corrected).values()
    counts: dict[str, Any] = {
        "samples": int(there.size),
        **{kind: sum(one[kind] for one in of_joints) for kind in ("measured", "repaired", "filled", "left_open")},
        "empty_frames": int((~now.any(axis=1)).sum()),
    }
    if sensor.state is not None:
        counts |= {"tracked": int((sensor.state == 2).sum()), "inferred": int((sensor.state == 1).sum())}
        counts["not_tracked"] = int((sensor.state == 0).sum())
    counts["refused_frames"] = len(refused(corrected))
    counts["moved_cm"] = round(100 * float(np.median(moved)), 2) if moved.size else None
    for name, frames in flagged(corrected).items():
        counts.setdefault(f"{name}_frames", len(frames))
    return counts


def channels(sensor: "Postures", corrected: "Postures") -> dict[str, dict[str, int]]:
    """Of each joint how many frames stand as the sensor gave them (measured), were moved (repaired), filled and left
    open."""
    there, now = sensor.present, corrected.present
    moved = np.linalg.norm(
        np.where(there & now, 1.0, 0.0)[:, :, None] * np.nan_to_num(corrected.positions - sensor.positions), axis=2
    )
    repaired = there & now & (moved > 0)
    return {
        name: {
            "measured": int((there[:, k] & now[:, k] & ~repaired[:, k]).sum()),
            "repaired": int(repaired[:, k].sum()),
            "filled": int((now[:, k] & ~there[:, k]).sum()),
            "left_open": int((~now[:, k]).sum()),
        }
        for k, name in enumerate(sensor.names)
    }


def flagged(corrected: "Postures") -> dict[str, list[int]]:
    """Frames by what the corrector noted about them: swapped sides, turned around, refused."""
    flags, names = getattr(corrected.source, "flags", None), getattr(corrected.source, "flag_names", ())
    if flags is None:
        return {}
    whole = np.asarray(flags).reshape(corrected.frames, -1)
    return {name: np.flatnonzero(((whole >> bit) & 1).any(axis=1)).tolist() for bit, name in enumerate(names) if name}


def refused(corrected: "Postures") -> list[int]:
    """Frames that the corrector was not sure enough of to change."""
    return flagged(corrected).get("refused", [])


def _spread(values: Any, names: tuple[str, ...], present: Any) -> dict[str, dict[str, float | None]]:
    """Mean and 5th percentile of a quantity of all joints and of each, where the joint has a position."""

    def of(some: Any) -> dict[str, float | None]:
        if not some.size:
            return {"mean": None, "p05": None, "p95": None}
        return {
            "mean": _short(float(some.mean())),
            "p05": _short(float(np.percentile(some, 5))),
            "p95": _short(float(np.percentile(some, 95))),
        }

    if values is None:
        return {"all": of(np.empty(0))}
    known = present & np.isfinite(values)
    each = {name: of(values[known[:, k], k]) for k, name in enumerate(names)}
    return {"all": of(values[known]), **each}


def told_of(sensor: "Postures", corrected: "Postures") -> tuple[str, ...]:
    """What may be wrong with a sensor's file, and what was noted while it was corrected, each once."""
    return tuple(dict.fromkeys((*sensor.warnings, *getattr(corrected.source, "warnings", ()))))


def rate_of(sensor: "Postures", given: float | None = None) -> float:
    """The recording's rate in Hz; that given, or else a sensor's usual one, where a single frame tells none."""
    from ..io.sensor_source import USUAL_FPS

    return sensor.fps if np.isfinite(sensor.fps) and sensor.fps > 0 else given or USUAL_FPS


def live_seconds(model: "CorrectorModel", sensor: "Postures", look_ahead: int = 0) -> list[float]:
    """How long each of the recording's first frames takes when they come one by one, s."""
    state = model.start(sensor.names, look_ahead=look_ahead)
    found = []
    for t in range(min(sensor.frames, TIMED)):
        start = perf_counter()
        states = None if sensor.state is None else sensor.state[t]
        state, _ = model.feed(state, sensor.positions[t], states, float(sensor.times[t]))
        found.append(perf_counter() - start)
    return found


def _frame_ms(frames: int, whole: float, each: Any) -> dict[str, float | None]:
    """Milliseconds of a frame: the mean of the whole recording, and of single frames where their times are known."""
    mean = 1000 * whole / frames if frames else None
    if each is None or len(each) <= WARM:
        return dict.fromkeys(("mean", "median", "p50", "p95", "max"), mean)
    times = 1000 * np.asarray(each, dtype=np.float64)[WARM:]  # the first load and compile
    median, p95 = (float(value) for value in np.percentile(times, [50, 95]))
    return {"mean": mean, "median": median, "p50": median, "p95": p95, "max": float(times.max())}


def _write(path: Path, made: "Postures | Motion") -> None:
    from ..bodies.motion import Motion
    from ..io import write
    from ..io.joint_table import write_joint_table

    if isinstance(made, Motion):
        write(path, made)
    else:
        write_joint_table(path, made)


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
