"""`motionmend demo`: the whole way once, on a synthetic performer, from clean clips to a repaired recording."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import FileError
from .options import AsJson, Debug, Force
from .speech import json_line, say

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion, Repaired
    from ..evaluate import Comparison

FORMATS = ("amc", "bvh", "c3d")
SHOWN = {"amc": "joint angles, .amc", "bvh": "joint angles, .bvh", "c3d": "markers, .c3d"}
LEARNED = (("walk", 0), ("walk", 1), ("walk", 2), ("turn", 0), ("turn", 1), ("run", 0))  # action, seed
HELD_OUT = ("walk", 7)
DRAWN = tuple(f"{side}{bone}.rx" for bone in ("femur", "tibia", "humerus", "radius") for side in "lr")
SECONDS = 6.0
NOISE_DEGREES, NOISE_METRES, OUTLIERS, GAPS, SEED = 3.0, 0.01, 0.1, 0.1, 1


def demo(
    *,
    out: Annotated[Path, Parameter(name=["-o", "--out"], help="Folder to write to.")] = Path("motionmend-demo"),
    as_json: AsJson = False,
    force: Force = False,
    debug: Debug = False,
) -> int:
    """Make a synthetic recording, spoil it, repair it, and write everything: files, report.html, figures.

    A denoiser learns from six synthetic clips and repairs a seventh that was spoiled with 3 degrees (markers: 1 cm)
    of noise, 10 % outliers and 10 % gaps: as .amc, as .bvh and as markers in .c3d. Takes under a minute.
    """
    start = perf_counter()
    if out.exists() and not out.is_dir():
        raise FileError(f"{out}: a folder was wanted, this is a file: name another with --out")
    if out.is_dir() and any(out.iterdir()) and not force:
        raise FileError(f"{out} is not empty: --force writes into it, or name another folder with --out")
    takes = [_take(out / kind, kind) for kind in FORMATS]
    _show(out, takes[0])
    for take in takes if as_json else ():
        print(json_line(_facts(out / take.kind, take)))
    if not as_json:
        print(_table(takes))
        print(_next_steps(out))
    say(f"{perf_counter() - start:.0f} s: {out}")
    return 0


@dataclass(frozen=True)
class _Take:
    """One recording of one format: as it was, as it was spoiled, as it was repaired, and how far off each is."""

    kind: str
    clean: "Motion | Markers"
    spoiled: "Motion | Markers"
    repaired: "Repaired[Any]"
    before: "Comparison"
    after: "Comparison"


def _take(folder: Path, kind: str) -> _Take:
    """Write clips, learn from the files, spoil and repair another file; everything goes through files."""
    from ..batch import one_blas_thread
    from ..denoise import Denoiser
    from ..evaluate import compare
    from ..io import read
    from ..models import save_model
    from .corrupt import Spoil
    from .denoise import Repair
    from .inputs import Job

    say(f"{SHOWN[kind]}: learning, spoiling, repairing")
    clips = folder / "clips"
    clips.mkdir(parents=True, exist_ok=True)
    learned = [_written(clips / f"{action}_{seed}.{kind}", action, seed) for action, seed in LEARNED]
    clean, spoiled, repaired = (folder / f"{name}.{kind}" for name in ("clean", "spoiled", "repaired"))
    _written(clean, *HELD_OUT)
    with one_blas_thread():
        save_model(folder / "model.mend", Denoiser().fit([read(path) for path in learned]))
        noise = NOISE_METRES if kind == "c3d" else NOISE_DEGREES
        Spoil(noise, OUTLIERS, GAPS, (), SEED, None, None)(Job(clean, spoiled, spoiled.with_suffix("")))
        repair = Repair().knowing(folder / "model.mend")
        bad = read(spoiled)
        mended, seconds = repair.timed(bad)
        repair.save(Job(spoiled, repaired, repaired.with_suffix("")), bad, mended, seconds)
        truth = read(clean)
        return _Take(kind, truth, bad, mended, compare(truth, bad), compare(truth, read(repaired)))


def _written(path: Path, action: str, seed: int) -> Path:
    """A synthetic clip as a file of the kind its ending says."""
    from .. import samples
    from ..io import write

    clip = samples.clip(action, seconds=SECONDS, seed=seed)
    write(path, samples.markers(clip) if path.suffix == ".c3d" else clip)
    return path


def _show(out: Path, take: _Take) -> None:
    """The page that plays the recording and two figures."""
    import numpy as np

    from ..bodies.motion import Motion
    from ..bodies.skeleton import positions
    from ..report import html_report
    from ..report.figures import Panel, curves_figure, skeleton_figure

    rows = {"clean": take.clean, "spoiled": take.spoiled, "repaired": take.repaired.recording}
    html_report(out / "report.html", list(rows.items()), repaired=take.repaired)
    if not isinstance(take.clean, Motion):
        return
    motions = {name: motion for name, motion in rows.items() if isinstance(motion, Motion)}
    gaps = dict(zip(take.clean.channels, (~take.spoiled.present).sum(axis=0), strict=True))
    names = sorted(DRAWN, key=lambda name: -gaps[name])[:3]
    panels = [
        Panel(
            take.clean.channels[c],
            "°",
            {name: np.degrees(motions[name].q[:, c]) for name in ("spoiled", "clean", "repaired")},
            {"repaired": np.degrees(take.repaired.std[:, c])},
            ~take.spoiled.present[:, c],
        )
        for c in map(take.clean.channels.index, names)
    ]
    times = np.arange(take.clean.frames) / take.clean.fps
    curves_figure(out / "curves.png", times, panels, title="Three joint angles of a walk")
    skeleton = take.clean.skeleton
    at = {name: positions(skeleton, motion.q) for name, motion in motions.items()}
    skeleton_figure(
        out / "skeletons.png",
        {name: at[name] for name in ("spoiled", "repaired")},
        skeleton.parents,
        frames=np.linspace(0, take.clean.frames - 1, 7).astype(int).tolist(),
        fps=take.clean.fps,
        up=skeleton.up,
        ghost=at["clean"],
    )


def _facts(folder: Path, take: _Take) -> dict[str, Any]:
    """A recording's files and its errors before and after, in degrees and centimetres."""
    return {
        "input": folder / f"spoiled.{take.kind}",
        "output": folder / f"repaired.{take.kind}",
        **{
            when: {"rms_deg": found.rms_deg, "mean_cm": found.mean_cm, "share_missing": found.missing["share"]}
            for when, found in (("before", take.before), ("after", take.after))
        },
    }


def _table(takes: list[_Take]) -> str:
    """Errors before and after, in degrees and centimetres."""
    lines = [f"{'':<20}{'rms_deg':>18}{'mean_cm':>18}{'missing':>18}"]
    for take in takes:
        cells = (
            _change(take.before.rms_deg, take.after.rms_deg),
            _change(take.before.mean_cm, take.after.mean_cm),
            f"{100 * take.before.missing['share']:.1f} -> {100 * take.after.missing['share']:.1f} %",
        )
        lines.append(f"{SHOWN[take.kind]:<20}" + "".join(f"{cell:>18}" for cell in cells))
    return "\n".join(lines)


def _change(before: float | None, after: float | None) -> str:
    return "" if before is None or after is None else f"{before:.2f} -> {after:.2f}"


def _next_steps(out: Path) -> str:
    amc = out / "amc"
    return "\n".join(
        [
            "",
            f"See {out / 'report.html'} in a browser; what was done to each sample: {amc / 'repaired.mend.json'}.",
            "The same with recordings of your own:",
            "  motionmend inspect YOUR.amc",
            "  motionmend fit denoiser CLEAN_CLIPS -o my.mend",
            "  motionmend denoise YOUR.amc -m my.mend -o repaired.amc --report",
            f"Or again with these: motionmend fit denoiser {amc / 'clips'} -o again.mend",
        ]
    )
