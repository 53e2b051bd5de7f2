"""B9: feet that stand keep standing"""

from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm

from .beyond_common import PROBLEMS, in_parallel
from .common import Findings, Table, model_of, motion, spoiled

WALKS = ("walk, same person", "walk, unseen people")
NOISE, OUTLIERS = 3.0, 0.05  # degrees, share
LONGEST = 600  # frames at 120 Hz
KINDS = ("truth", "spoilt", "adaptive", "adaptive, cleaned", "paper", "butterworth")


def run(mocap: Path, pictures: Path) -> Findings:
    """Speed of the feet while the true ones stand, and joint errors, of noisy walks."""
    clips = [(name, seed) for name in WALKS for seed in range(len(PROBLEMS[name].test))]
    measured = in_parallel(partial(skates, mocap), clips)
    mean = {kind: np.mean([m[kind] for m in measured], axis=0) for kind in KINDS}
    rows = tuple(
        (name, PROBLEMS[name].test[seed], *(f"{found[kind][0]:.1f}" for kind in KINDS))
        for (name, seed), found in zip(clips, measured, strict=True)
    )
    return Findings(
        values={
            "skate_truth": float(mean["truth"][0]),
            "skate_adaptive": float(mean["adaptive"][0]),
            "skate_cleaned": float(mean["adaptive, cleaned"][0]),
            "skate_paper": float(mean["paper"][0]),
            "skate_spoilt": float(mean["spoilt"][0]),
            "adaptive_over_paper": float(mean["adaptive"][0] / mean["paper"][0]),
            "skate_over_truth": float(mean["adaptive"][0] / mean["truth"][0]),
            "cleaned_over_truth": float(mean["adaptive, cleaned"][0] / mean["truth"][0]),
            "joint_error": float(mean["adaptive"][1]),
            "joint_error_added": float(mean["adaptive, cleaned"][1] - mean["adaptive"][1]),
        },
        notes=(
            f"Walks at 120 Hz, the middle five seconds of longer ones, {NOISE:g} degrees of noise and {100 * OUTLIERS:g} % "
            "outliers in every channel, the root's too. Speed of the feet, cm/s, in the truth's own contacts.",
            f"Mean joint error: adaptive {mean['adaptive'][1]:.2f} cm, cleaned {mean['adaptive, cleaned'][1]:.2f} cm, "
            f"paper {mean['paper'][1]:.2f} cm.",
        ),
        tables=(Table("Speed of standing feet, cm/s", ("library", "clip", *KINDS), rows),),
    )


def skates(mocap: Path, which: tuple[str, int]) -> dict[str, tuple[float, float]]:
    """Speed of standing feet in cm/s and mean joint error in cm, by what was done."""
    problem, seed = which
    split = PROBLEMS[problem]
    model = model_of(mocap, split.learn)
    whole = motion(mocap, split.test[seed])
    first = max(0, (whole.frames - LONGEST) // 2)
    truth = whole.with_q(whole.q[first : first + LONGEST])
    noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS, seed=seed)
    done = {
        "truth": truth,
        "spoilt": noisy,
        "adaptive, cleaned": model.repair(noisy, "adaptive", footskate=True).recording,
    }
    done |= {name: model.repair(noisy, name).recording for name in ("adaptive", "paper", "butterworth")}
    found = {}
    for kind, recording in done.items():
        compared = mm.compare(truth, recording)
        found[kind] = (_known(compared.foot_skate_cm_s["other"]), _known(compared.mean_cm))
    return found


def _known(value: float | None) -> float:
    return float("nan") if value is None else value
