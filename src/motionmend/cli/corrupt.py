"""`motionmend corrupt`: spoil clean recordings in a known way."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from .. import __version__
from ..errors import UsageError, counted
from .inputs import Job
from .options import WORKING, WRITING, AsJson, Files, Out, Rate, SkeletonFile, Whole, Working, Writing
from .output import Done
from .speech import say
from .transform import transform, write_json

if TYPE_CHECKING:
    from ..arrays import Bools


MOST_NOISE = 0.5  # m; who says more for markers means millimetres


def corrupt(
    *files: Files,
    out: Out,
    noise: Annotated[
        float,
        Parameter(
            help="Standard deviation of Gaussian noise: degrees for joint angles (root translation then gets "
            "1 cm per degree), metres for markers."
        ),
    ] = 0.0,
    outliers: Annotated[
        float,
        Parameter(
            help="Share of the samples that become outliers: a fraction below 1, a percentage from 1 on. "
            "Angles move by 15 to 55 degrees, markers by 0.05 to 0.5 m."
        ),
    ] = 0.0,
    gaps: Annotated[
        float,
        Parameter(
            help="Share of the samples that go missing in bursts of 0.1 to 2 s: a fraction below 1, a percentage "
            "from 1 on."
        ),
    ] = 0.0,
    drop: Annotated[
        tuple[str, ...],
        Parameter(
            consume_multiple=True,
            show_default=False,
            help="Joints, channels or markers that are missing throughout, by name.",
        ),
    ] = (),
    seed: Annotated[Whole, Parameter(help="Of the random numbers; the same seed spoils the same samples.")] = 0,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    working: Working = WORKING,
    writing: Writing = WRITING,
) -> int:
    """Spoil clean recordings with noise, outliers and gaps, to see how well a repair finds back.

    Beside each output stands NAME.corrupt.json: the options, and which samples became outliers or went missing.
    """
    if not 0 <= noise < float("inf"):
        raise UsageError(f"--noise: a standard deviation of 0 or above was wanted, came {noise:g}")
    spoil = Spoil(
        noise,
        _share("--outliers", outliers),
        _share("--gaps", gaps),
        drop,
        seed,
        fps,
        skeleton and working.reachable(skeleton),
    )
    return transform(spoil, files, out, sidecars=[".corrupt.json"], as_json=as_json, working=working, writing=writing)


def _share(option: str, given: float) -> float:
    """A share in [0, 1) from a fraction below 1 or a percentage; says which it took."""
    if not 0 <= given <= 100:
        raise UsageError(f"{option}: a fraction below 1 or a percentage up to 100 was wanted, came {given:g}")
    if given == 0:
        return 0.0
    percent = given >= 1
    kind, value = ("a percentage", given) if percent else ("a fraction", 100 * given)
    say(f"{option} {given:g}: taken as {kind}, {value:g} % of the samples")
    return given / 100 if percent else given


@dataclass(frozen=True)
class Spoil:
    """The options of one command line; called with each file."""

    noise: float
    outliers: float
    gaps: float
    drop: tuple[str, ...]
    seed: int
    fps: float | None
    skeleton: Path | None

    def __call__(self, job: Job, /) -> Done:
        import numpy as np

        from ..bodies.motion import Motion
        from ..evaluate import corrupt
        from ..io import read, write
        from ..io.conversion import not_in
        from .findings import labels
        from .provenance import numbering

        clean: Any = read(job.source, fps=self.fps, skeleton=self.skeleton)
        moving = isinstance(clean, Motion)
        warnings: tuple[str, ...] = clean.warnings
        warnings += () if moving or self.noise <= MOST_NOISE else (_in_metres(self.noise),)
        warnings += not_in(job.target.suffix.lower(), clean)
        spoilt = corrupt(
            clean,
            noise=float(np.radians(self.noise)) if moving else self.noise,
            outliers=self.outliers,
            gaps=self.gaps,
            drop=self.drop,
            seed=self.seed,
        )
        names = labels(clean.channels)
        counts = {
            "samples": int(clean.present.size),
            "outliers": int(spoilt.outlier.sum()),
            "missing": int(spoilt.missing.sum()),
            "missing_before": int((~clean.present).sum()),
        }
        with job.together(".corrupt.json"):
            write(job.target, spoilt.recording)
            write_json(
                job.beside(".corrupt.json"),
                {
                    "version": __version__,
                    "input": job.source.name,
                    "output": job.target.name,
                    "options": {
                        "noise": self.noise,
                        "noise_unit": "deg" if moving else "m",
                        "outliers": self.outliers,
                        "gaps": self.gaps,
                        "drop": self.drop,
                        "seed": self.seed,
                    },
                    "frames": clean.frames,
                    "fps": clean.fps,
                    **numbering(clean),
                    "counts": counts,
                    "outlier_runs": _runs_by_name(names, spoilt.outlier),
                    "missing_runs": _runs_by_name(names, spoilt.missing),
                    "guesses": clean.guesses,
                },
            )
        facts: dict[str, Any] = {
            "input": job.source,
            "output": job.target,
            "frames": clean.frames,
            "counts": counts,
            "warnings": warnings,
            "guesses": clean.guesses,
        }
        samples = counted(counts["samples"], "sample")
        share = f"{counted(counts['outliers'], 'outlier')}, {counts['missing']} missing of {samples}"
        return Done(facts, line=f"{job.source}: {share}: {job.target}", warnings=warnings, guesses=clean.guesses)


def _in_metres(noise: float) -> str:
    return (
        f"--noise of markers is in metres: took {noise:g} m, more than a limb; {noise / 1000:g} would be {noise:g} mm"
    )


def _runs_by_name(names: list[str], mask: "Bools") -> dict[str, list[tuple[int, int]]]:
    """Stretches [first frame from 0, number of frames] of each channel or marker that has any."""
    from .provenance import mask_runs

    return {name: runs for c, name in enumerate(names) if (runs := mask_runs(mask[:, c]))}
