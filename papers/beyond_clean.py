"""B8: clean recordings are left alone"""

from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm

from .beyond_common import LONGEST, PROBLEMS, in_parallel
from .common import FPS, Findings, Table, body, body_error, model_of, motion, reduced

RATES = (30.0, 120.0)
METHODS = ("adaptive", "paper", "butterworth")


def run(mocap: Path, pictures: Path) -> Findings:
    """What each method changes in a clip without noise, outliers and gaps, and what it takes for outliers."""
    clips = [(name, clip, rate) for name, split in PROBLEMS.items() for clip in split.test for rate in RATES]
    measured = in_parallel(partial(changed, mocap), clips)
    values, rows = {}, []
    for rate in RATES:
        for name in PROBLEMS:
            here = [m for (n, _, r), m in zip(clips, measured, strict=True) if (n, r) == (name, rate)]
            mean = {key: float(np.mean([m[key] for m in here])) for key in here[0]}
            shown = (f"{mean[method]:.2f}" for method in METHODS)
            rows.append((name, f"{rate:g}", *shown, f"{100 * mean['rejected']:.2f} %"))
        of_rate = [m for (_, _, r), m in zip(clips, measured, strict=True) if r == rate]
        values[f"changed_{rate:g}"] = float(np.mean([m["adaptive"] for m in of_rate]))
        values[f"changed_{rate:g}_worst"] = max(m["adaptive"] for m in of_rate)
        values[f"rejected_{rate:g}"] = 100 * float(np.mean([m["rejected"] for m in of_rate]))
    values["changed_paper"] = float(np.mean([m["paper"] for m in measured]))
    head = ("problem", "fps", *METHODS, "adaptive takes for outliers")
    return Findings(
        values=values,
        notes=(
            f"RMS change over the body angles of clips held out, degrees; the middle {LONGEST / FPS:g} s of longer clips. "
            "The recordings have some noise of their own, which a repair may take out.",
        ),
        tables=(Table("RMS change of clean clips, degrees", head, tuple(rows)),),
    )


def changed(mocap: Path, which: tuple[str, str, float]) -> dict[str, float]:
    """RMS change by each method, and the share of body samples that adaptive rejects."""
    problem, clip, rate = which
    model = model_of(mocap, PROBLEMS[problem].learn)
    whole = reduced(motion(mocap, clip), rate)
    length = round(LONGEST * rate / FPS)
    first = max(0, (whole.frames - length) // 2)
    clean = whole.with_q(whole.q[first : first + length])
    found = {method: model.repair(clean, method) for method in METHODS}
    rejected = (found["adaptive"].origin == mm.Origin.REPAIRED)[:, body(clean)]
    return {method: body_error(clean, one.recording) for method, one in found.items()} | {
        "rejected": float(rejected.mean())
    }
