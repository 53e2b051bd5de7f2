"""`motionmend track`: follow a person in depth images."""

from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, time
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from .. import __version__
from ..arrays import runs
from ..errors import FileError, MismatchError, UsageError, counted
from .clock import began
from .depth_inputs import FORMATS, gather_depth, plan_depth
from .folders import new_folders, ready_and_housed
from .inputs import Job, ending
from .options import WORKING, WRITING, AsJson, Out, Working, Writing
from .output import Done, work
from .transform import write_json

if TYPE_CHECKING:
    from ..arrays import Bools, Floats
    from ..bodies.performer import Performer
    from ..bodies.skeleton import Skeleton
    from ..io.depth_recording import DepthRecording
    from ..track.model import TrackerModel
    from .following import Followed

FARTHEST = 4.0  # m that joints of one body are apart, at most
ELSEWHERE = 0.3  # m between the joints given and those found, from which on the start was not what is followed


def track(
    *folders: Annotated[
        Path,
        Parameter(
            help="Depth folders (camera.json, depth/000000.png ...), UTD-MHAD *_depth.mat files, or folders of them.",
            negative="",
        ),
    ],
    model: Annotated[Path, Parameter(name=["-m", "--model"], help="Model (.mend) from `motionmend fit tracker`.")],
    out: Out,
    skeleton: Annotated[
        Path | None, Parameter(help="The person's .asf (or a .bvh of theirs): lengths are taken from it.")
    ] = None,
    start: Annotated[
        Path | None,
        Parameter(
            help="A table of joints (.csv), one row: the pose of frame 0 in camera axes; joints may be left out."
        ),
    ] = None,
    body: Annotated[
        Path | None,
        Parameter(help="The person's body (.json): used when it is there, else found in the images and stored there."),
    ] = None,
    terms: Annotated[
        str | None,
        Parameter(help="What counts, separated by commas: surface (needed), color, edge, prior, limits, freespace."),
    ] = None,
    preset: Annotated[
        str, Parameter(help="default, or paper: the dissertation's terms, weights and windows.")
    ] = "default",
    format: Annotated[
        str | None,
        Parameter(help="csv (joints in camera axes), bvh or amc (joint angles, y up); the ending of OUT says it too."),
    ] = None,
    as_json: AsJson = False,
    working: Working = WORKING,
    writing: Writing = WRITING,
) -> int:
    """Follow a person through recordings of one depth camera.

    Writes one row for each image: 16 joints in metres (x right, y down, z forward) with their standard deviations. A
    row without the person has empty cells; deviations of 0.10 or more say that the body was lost. Beside each output
    stands NAME.mend.json: which frames were held, lost, recovered or revised, options, cost and seconds.
    """
    settings = _settings(preset, terms)
    if format is not None and format not in FORMATS:
        raise UsageError(f"--format: one of {', '.join(FORMATS)} was wanted, came {format!r}")
    folders, out = tuple(working.reachable(folder) for folder in folders), working.reachable(out)
    inputs, refused = gather_depth(folders)
    if start is not None and len(inputs) > 1:
        raise UsageError("--start is the first pose of one recording: leave it out for several")
    with new_folders() as make:
        planned = plan_depth(inputs, folders, out, format)
        jobs, barred = ready_and_housed(planned, inputs, [".mend.json"], writing, make)
        refused = [*refused, *barred]
        if body is not None:
            try:
                make(body.parent)
            except OSError as error:
                raise FileError(f"{body}: its folder cannot be made: {error.strerror or error}") from None
        task = Follow(preset, settings.terms, began()).knowing(model, skeleton, body, start)
        codes = []
        while body is not None and task.performer is None and len(jobs) > 1:
            # The first recording with somebody in it finds the body, whatever --jobs is, and all others use it.
            alone = replace(working, jobs=1, cluster=None)
            task = replace(task, idle=working.idle(1))
            codes.append(work(task, jobs[:1], name=_source, working=alone, as_json=as_json))
            jobs = jobs[1:]
            task = task.knowing(model, skeleton, body, start)
        task = replace(task, idle=working.idle(len(jobs)))
        codes.append(work(task, jobs, name=_source, working=working, as_json=as_json, refused=refused, given=folders))
        return max(codes)


def _settings(preset: str, terms: str | None) -> Any:
    from ..track.settings import settings_of

    try:
        return settings_of(preset, None if terms is None else [term.strip() for term in terms.split(",")])
    except UsageError as error:
        raise UsageError(f"{'--preset' if 'preset' in str(error) else '--terms'}: {error}") from None


@dataclass(frozen=True)
class Follow:
    """The options of one command line with all that they name; called with each recording."""

    preset: str
    terms: tuple[str, ...]
    began: float  # s since the epoch, when the command was started
    model: "TrackerModel | None" = None
    model_facts: dict[str, str] | None = None
    performer: "Performer | None" = None
    skeleton: "Skeleton | None" = None
    landmarks: "Floats | None" = None
    start: Path | None = None
    body: Path | None = None
    skeleton_file: Path | None = None
    supposed: tuple[str, ...] = ()  # of the skeleton's file
    idle: bool = False  # whether there is a processor that works on nothing else

    def knowing(self, model: Path, skeleton: Path | None, body: Path | None, start: Path | None) -> "Follow":
        """The same options with the files read.

        Raises
        ------
        FileError, MismatchError : one of them is not what it should be.
        """
        from ..bodies.templates import performer_of
        from ..io.body_file import read_body
        from ..io.model import load_model
        from ..models import restore

        stored = load_model(model)
        known, supposed = (None, ()) if skeleton is None else _skeleton(skeleton)
        try:
            performer = None if known is None else performer_of(known)
        except MismatchError as error:
            raise FileError(f"{skeleton}: {error}{_of_lengths(supposed)}") from None
        if body is not None and body.exists():
            performer = read_body(body)  # what is known of widths too
        return replace(
            self,
            model=restore(stored, model, "tracker"),
            model_facts={"file": model.name, "sha256": stored.sha256},
            skeleton=known,
            performer=performer,
            landmarks=None if start is None else _landmarks(start),
            start=start,
            body=body,
            skeleton_file=skeleton,
            supposed=supposed,
        )

    def __call__(self, job: Job, /) -> Done:
        from ..io.depth import read_depth

        if job.finished:
            facts = {"input": job.source, "output": job.target, "skipped": True}
            return Done(facts, line=f"{job.source}: {job.target} is there already, skipped")
        startup = time() - self.began
        begin = perf_counter()
        recording = read_depth(job.source)
        opened = perf_counter() - begin
        followed = self.followed(job.source, recording)
        return self.save(job, recording, followed, startup, opened)

    def followed(self, source: Path, recording: "DepthRecording") -> "Followed":
        """The person through the whole recording, read from `source`.

        Raises
        ------
        FileError : nobody is in it.
        """
        from ..io.depth_recording import without_color
        from ..track.settings import settings_of
        from .following import follow
        from .looking_back import second_process

        assert self.model is not None
        settings = settings_of(self.preset, self.terms)
        recording = recording if "color" in self.terms else without_color(recording)
        with second_process(recording.frames, idle=self.idle) as other:
            followed = follow(self.model, settings, recording, self.performer, self.landmarks, other)
        if not followed.seen.any():
            said = _nobody(followed, given=self.performer is not None)
            raise FileError(f"{source}: {said}{_of_lengths(self.supposed)}")
        return followed

    def save(self, job: Job, recording: "DepthRecording", followed: "Followed", startup: float, opened: float) -> Done:
        """Write the output and the file beside it."""
        from ..io.body_file import write_body
        from .tracked_files import write_followed

        begin = perf_counter()
        warnings = self.warnings(recording, followed)
        with job.together(".mend.json"):
            write_followed(job.target, followed, self.skeleton, recording.fps)
            if self.body is not None and self.performer is None:
                write_body(self.body, followed.performer)
            seconds = {
                "startup": startup,
                "read": opened + followed.read,
                "track": followed.track + followed.calibrate,
                "write": perf_counter() - begin,
                "total": time() - self.began,
                "calibrate": followed.calibrate,
                "stages": {name: round(value, 4) for name, value in followed.stages.items()},
            }
            facts = self._facts(job, recording, followed, warnings)
            write_json(job.beside(".mend.json"), {**facts, "seconds": _rounded(seconds)})
        said = {
            "input": job.source,
            "output": job.target,
            "frames": recording.frames,
            "lost": followed.lost,
            "seconds": seconds,
            "frame_ms": _frame_ms(followed),
            "restarts": followed.restarts,
            "preset": self.preset,
            "terms": self.terms,
            "counts": _summed(followed.counts()),
            "warnings": warnings,
            "guesses": self.guesses(recording),
        }
        lost = f", {followed.lost} of them without the person" if followed.lost else ""
        line = f"{job.source}: {counted(recording.frames, 'frame')}{lost}: {job.target}"
        return Done(said, line=line, warnings=tuple(warnings), guesses=self.guesses(recording))

    def guesses(self, recording: "DepthRecording") -> tuple[str, ...]:
        """What was supposed of the images, and of the skeleton that was given."""
        return (*recording.guesses, *self.supposed)

    def warnings(self, recording: "DepthRecording", followed: "Followed") -> list[str]:
        """What a user should know before they trust the joints."""
        warnings = [*recording.warnings]
        if "color" in self.terms and not recording.has_color:
            warnings.append("there is no colour: the term color does nothing")
        if self.performer is None and not followed.calibrated:
            taken = "the person could not be measured, proportions of an average adult were taken: give their skeleton"
            warnings.append(f"{taken} or body" if self.body is None else f"{taken}; {self.body.name} has them too")
        warnings += followed.doubts
        if self.landmarks is not None:
            warnings += _elsewhere(self.landmarks, followed)
        if followed.furnished:
            warnings.append(
                "something as large as a body keeps its place in all frames while somebody moves: it was taken for "
                "furniture and not followed (--start says who is)"
            )
        if followed.company.any():
            whom = "that --start points at" if self.start else "most like a body in the first frame (--start says who)"
            said = f"somebody else is in frames {_stretches(followed.company)}, too"
            warnings.append(f"{said}: one person is followed, the one {whom}")
        if followed.moved.any():
            warnings.append(
                f"the camera moves in frames {_stretches(followed.moved)}: floor and walls are followed, joints are "
                "where it sees them in each frame"
            )
        if followed.mistaken.any():
            warnings.append(
                f"frames {_stretches(followed.mistaken)} are left empty: what was followed in them stands there still "
                "at the end, as furniture does"
            )
        if followed.damaged.any():
            least, usual = 100 * followed.returns[followed.damaged].min(), 100 * np.median(followed.returns)
            warnings.append(
                f"frames {_stretches(followed.damaged)} are blank or damaged: depth in {least:.0f} % of the image or "
                f"more, where most have {usual:.0f} %; the room is told from whole ones"
            )
        if followed.lost > 0.1 * recording.frames:
            warnings.append(f"{followed.lost} of {counted(recording.frames, 'frame')} without the person")
        return warnings

    def _facts(
        self, job: Job, recording: "DepthRecording", followed: "Followed", warnings: list[str]
    ) -> dict[str, Any]:
        counts = followed.counts()
        return {
            "version": __version__,
            "input": job.source.name,
            "output": job.target.name,
            "model": self.model_facts,
            "options": {
                "preset": self.preset,
                "terms": self.terms,
                "skeleton": self.skeleton_file.name if self.skeleton_file else None,
                "start": self.start.name if self.start else None,
                "body": self.body.name if self.body else None,
            },
            "method": "track",
            "frames": recording.frames,
            "fps": recording.fps,
            "lost": followed.lost,
            "restarts": followed.restarts,
            "bone_lengths_m": dict(zip(followed.performer.bones, _short(followed.performer.lengths), strict=True)),
            "counts": _summed(counts),
            "channels": counts,
            "std": _std(followed),
            "runs": followed.runs(),
            "joint_runs": followed.joint_runs(),
            "iterations": followed.iterations,
            "cost": {name: float(f"{value:.6g}") for name, value in sorted(followed.cost.items())},
            "converged": followed.converged,
            "warnings": warnings,
            "guesses": self.guesses(recording),
        }


def _skeleton(path: Path) -> "tuple[Skeleton, tuple[str, ...]]":
    """The skeleton of an .asf, or of a recording of joint angles, and what was supposed of its file."""
    from ..io.amc import AmcSource, read_amc
    from ..io.asf import read_asf, skeleton_of
    from ..io.bvh import read_bvh
    from ..io.hierarchy import BvhSource

    if ending(path) == ".asf":
        acclaim = read_asf(path)
        return skeleton_of(acclaim), acclaim.guesses
    if ending(path) not in (".amc", ".bvh"):
        raise FileError(f"{path}: wanted a skeleton (.asf or .bvh), came {path.suffix or 'a file without ending'!r}")
    recording = read_amc(path) if ending(path) == ".amc" else read_bvh(path)
    if isinstance(recording.source, AmcSource):
        return recording.skeleton, recording.source.asf.guesses
    assert isinstance(recording.source, BvhSource)
    of_rate = recording.source.rate_guesses  # which nobody asked for
    return recording.skeleton, tuple(f"{path.name}: {one}" for one in recording.guesses if one not in of_rate)


def _of_lengths(supposed: tuple[str, ...]) -> str:
    """What of all that was supposed makes a body larger or smaller, as the end of a sentence."""
    return "".join(f"; {one}" for one in supposed if "unit of length" in one)


def _landmarks(path: Path) -> "Floats":
    """(16, 3) m, the joints of a start pose; NaN where the table has none."""
    from ..bodies.performer import LANDMARKS
    from ..io.joint_table import read_joint_table

    table = read_joint_table(path)
    strange = [name for name in table.names if name not in LANDMARKS]
    if strange:
        raise FileError(f"{path}: wanted joints of {', '.join(LANDMARKS)}, came {', '.join(strange[:5])}")
    if table.frames != 1:
        raise FileError(f"{path}: one row was wanted, the pose of frame 0, came {table.frames}: keep that one alone")
    found = np.full((len(LANDMARKS), 3), np.nan)
    for name, place in zip(table.names, table.positions[0], strict=True):
        found[LANDMARKS.index(name)] = place
    if np.isfinite(found).all(axis=1).sum() < 3:
        raise FileError(f"{path}: wanted three joints or more to start from, came fewer")
    apart = float(np.ptp(found[np.isfinite(found).all(axis=1)], axis=0).max())
    if apart > FARTHEST:
        raise FileError(f"{path}: joints in m were wanted, came some that are {apart:.3g} m apart: in mm or cm?")
    nearest = int(np.nanargmin(found[:, 2]))
    if found[nearest, 2] <= 0.0:
        raise FileError(
            f"{path}: joints before the camera were wanted (x right, y down, z forward), came {LANDMARKS[nearest]} at "
            f"z {found[nearest, 2]:.3g} m: in other axes?"
        )
    return found


def _elsewhere(given: "Floats", followed: "Followed") -> list[str]:
    """What is said of a start pose (16, 3) m that is not where the person is in frame 0."""
    if not followed.seen[0]:
        return ["nobody was found in frame 0, where --start has somebody: it did nothing"]
    apart = np.linalg.norm(followed.postures.positions[0] - given, axis=1)
    off = float(np.median(apart[np.isfinite(apart)]))
    if off < ELSEWHERE:
        return []
    return [
        f"in frame 0 the joints of --start are {off:.2g} m from those found, and were not believed: x right, y down, z "
        "forward, m?"
    ]


def _stretches(frames: "Bools", most: int = 5) -> str:
    """Stretches of frames (T,) as a message names them: 3 to 7, 9 to 9, and how many more there are."""
    found = runs(frames)
    said = ", ".join(f"{first} to {last - 1}" for first, last in found[:most])
    return said if len(found) <= most else f"{said} and in {len(found) - most} other places"


def _nobody(followed: "Followed", *, given: bool) -> str:
    """Why nobody was followed, with a body that was given or not."""
    frames = len(followed.returns)
    if not followed.returns.any():
        return f"nobody is in it: {counted(frames, 'depth image')}, all empty; check the sensor or depth_scale"
    said = f"nobody was found in {counted(frames, 'frame')}"
    if followed.mistaken.any():
        said += ": what looks most like somebody never moves, as furniture does"
    body = ", whether the body given is this person's" if given else ""
    return f"{said}; check camera.json (depth_scale, fx, fy){body}, or give `motionmend track` a --start"


def _frame_ms(followed: "Followed") -> dict[str, float | None]:
    spent = followed.frame_ms
    if not len(spent):
        return {"median": None, "p95": None, "max": None}
    return {
        "median": float(np.median(spent)),
        "p95": float(np.quantile(spent, 0.95)),
        "max": float(spent.max()),
    }


def _std(followed: "Followed") -> dict[str, dict[str, Any]]:
    """Mean and largest deviation of each joint, in the frames with the person."""
    std = followed.postures.std
    assert std is not None
    seen = std[followed.seen]
    return {
        name: {"unit": "m", "mean": _three(seen[:, j].mean()), "max": _three(seen[:, j].max())}
        for j, name in enumerate(followed.postures.names)
    }


def _three(value: float) -> float:
    return float(f"{value:.3g}")


def _short(values: "Floats") -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def _summed(counts: dict[str, dict[str, int]]) -> dict[str, int]:
    kinds = ("measured", "repaired", "filled", "left_open")
    return {kind: sum(one[kind] for one in counts.values()) for kind in kinds}


def _rounded(seconds: dict[str, Any]) -> dict[str, Any]:
    return {name: round(value, 4) if isinstance(value, float) else value for name, value in seconds.items()}


def _source(job: Job) -> Path:
    return job.source
