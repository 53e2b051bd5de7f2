"""B12: libraries of clips that are noisy and full of outliers themselves

Section 2.4 asks for bases of noisy recordings. Here a whole library is: learned from as it is, and each clip repaired by
what it shows itself first.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.denoise import unspoiled

from .beyond_common import PROBLEMS, Cell, cell_name, geometric_mean, in_parallel, spoilt, truth_of
from .common import FPS, Findings, Table, body_error, motions

TRIED = ("walk, same person", "walk, unseen people", "run, same person", "run, unseen people", "dance, same person")
SPOILT: tuple[Cell, ...] = ((1.0, 0.0), (3.0, 0.05), (3.0, 0.1))  # of the library
CELLS: tuple[Cell, ...] = ((1.0, 0.0), (3.0, 0.1))  # of the recordings
FIRST_SEED = 100  # of the library's draws, which are none of the recordings'


def run(mocap: Path, pictures: Path) -> Findings:
    """Errors of the adaptive method by library: clean, spoiled as it is, spoiled and repaired first, and none."""
    jobs = [(problem, cell) for problem in TRIED for cell in SPOILT]
    measured = dict(zip(jobs, in_parallel(partial(tried, mocap), jobs), strict=True))
    rows, over_clean, over_best, raw_over_clean = [], [], [], []
    for (problem, library), errors in measured.items():
        for cell in CELLS:
            clean, raw, first, none = (errors[name, cell] for name in ("clean", "as it is", "repaired", "none"))
            rows.append(
                (problem, cell_name(library), cell_name(cell), *(f"{e:.2f}" for e in (clean, raw, first, none)))
            )
            over_clean.append(first / clean)
            raw_over_clean.append(raw / clean)
            over_best.append(first / none)
    head = ("problem", "library", "recording", "clean library", "as it is", "repaired first", "no library")
    return Findings(
        values={
            "spoiled_over_clean": geometric_mean(over_clean),
            "spoiled_worst": max(over_clean),
            "spoiled_over_none": max(over_best),
            "spoiled_raw": geometric_mean(raw_over_clean),
            "spoiled_raw_worst": max(raw_over_clean),
            "spoiled_found": float(np.mean([errors["found", (0.0, 0.0)] for errors in measured.values()])),
        },
        notes=(
            "Clips held out at 30 fps, at most their middle five seconds; libraries as recorded, a draw for each clip.",
        ),
        tables=(Table("Errors by what the library's clips were, degrees", head, tuple(rows)),),
    )


def tried(mocap: Path, job: tuple[str, Cell]) -> dict[tuple[str, Cell], float]:
    """Mean errors by library and cell, and the share of the library's clips that were found to be spoiled."""
    problem, library = job
    split = PROBLEMS[problem]
    clean = motions(mocap, split.learn)
    raw = [spoilt(clip, library, FIRST_SEED + k).recording for k, clip in enumerate(clean)]
    made = [unspoiled(clip) for clip in raw]
    models = {"clean": _learned(clean), "as it is": _learned(raw), "repaired": _learned([clip for clip, _ in made])}
    errors: dict[tuple[str, Cell], list[float]] = {}
    for seed, name in enumerate(split.test):
        truth = truth_of(mocap, name)
        for cell in CELLS:
            bad = spoilt(truth, cell, seed).recording
            for which, model in models.items():
                errors.setdefault((which, cell), []).append(body_error(truth, model.repair(bad).recording))
            alone = mm.repair_without_model(bad)
            errors.setdefault(("none", cell), []).append(body_error(truth, alone.recording))
    found = float(np.mean([spoiled is not None for _, spoiled in made]))
    return {key: float(np.mean(each)) for key, each in errors.items()} | {("found", (0.0, 0.0)): found}


def _learned(clips: Sequence[mm.Motion | mm.Markers]) -> mm.DenoiserModel:
    return mm.Denoiser(fps=FPS).fit(clips)
