"""Section 2.3: joint angles and markers, 120 and 30 frames a second

The paper reduces everything to 30 fps first. Here a recording keeps its own rate: the bases are brought to it.
"""

from pathlib import Path

import numpy as np

import motionmend as mm

from .common import (
    SEEDS,
    SPLITS,
    Findings,
    Table,
    body_error,
    distances,
    markers,
    model_of,
    motion,
    reduced,
    spoiled,
    stretch,
)
from .sec_2_3_1_gaps import TAKES

NOISE, OUTLIERS = 3.0, 0.1  # degrees
MARKER_NOISE = 0.01  # m


def run(mocap: Path, pictures: Path) -> Findings:
    """Errors before and after at both rates, for .amc and .c3d."""
    values: dict[str, float] = {}
    rows = []
    for rate in (120.0, 30.0):
        before, after, kept = angles_at(mocap, rate)
        values |= {f"amc_{rate:.0f}_before": before, f"amc_{rate:.0f}_after": after, f"amc_{rate:.0f}_kept": kept}
        rows.append((".amc", f"{rate:g}", f"{before:.2f} degrees", f"{after:.2f} degrees"))
        before, after, kept = markers_at(mocap, rate)
        values |= {f"c3d_{rate:.0f}_before": before, f"c3d_{rate:.0f}_after": after, f"c3d_{rate:.0f}_kept": kept}
        rows.append((".c3d", f"{rate:g}", f"{before:.2f} cm", f"{after:.2f} cm"))
    values["kept"] = min(value for name, value in values.items() if name.endswith("kept"))
    values["worst_ratio"] = max(
        values[f"{kind}_{rate}_after"] / values[f"{kind}_{rate}_before"]
        for kind in ("amc", "c3d")
        for rate in (120, 30)
    )
    return Findings(
        values=values,
        notes=(
            f"Joint angles: walking of one subject, {NOISE:g} degrees of noise, {100 * OUTLIERS:g} % outliers, RMS "
            "over body angles. Markers: the last third of a take of squats, learned from its first two, "
            f"{100 * MARKER_NOISE:g} cm of noise and {100 * OUTLIERS:g} % outliers of 5 to 50 cm, RMS distance.",
        ),
        tables=(Table("Error before and after", ("file", "fps", "spoiled", "filtered"), tuple(rows)),),
    )


def angles_at(mocap: Path, rate: float) -> tuple[float, float, float]:
    """Mean error before and after, and 1 when frames, rate and channels are those of the input."""
    split = SPLITS["walking"]
    model = model_of(mocap, split.learn)
    before, after, kept = [], [], True
    for clip in split.test:
        truth = reduced(motion(mocap, clip), rate)
        noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS)
        repaired = model.repair(noisy, "paper").recording
        before.append(body_error(truth, noisy))
        after.append(body_error(truth, repaired))
        same = (repaired.frames, repaired.fps, repaired.channels) == (truth.frames, truth.fps, truth.channels)
        kept = kept and same
    return float(np.mean(before)), float(np.mean(after)), float(kept)


def markers_at(mocap: Path, rate: float) -> tuple[float, float, float]:
    """The same for markers."""
    take, first, last = TAKES["squat"]
    squats = markers(mocap, take)
    squats = mm.Markers(squats.names, squats.positions[first:last], squats.fps, up=squats.up)
    model = mm.Denoiser().fit([stretch(squats, 0.0, 2 / 3)])
    truth = reduced(stretch(squats, 2 / 3, 1.0), rate)
    before, after, kept = [], [], True
    for seed in SEEDS:
        noisy = mm.corrupt(truth, noise=MARKER_NOISE, outliers=OUTLIERS, seed=seed).recording
        repaired = model.repair(noisy, "paper").recording
        for found, one in ((before, noisy), (after, repaired)):
            away = distances(truth.positions, one.positions, truth.present)
            found.append(float(np.sqrt(np.square(away).mean())))
        same = (repaired.frames, repaired.fps, repaired.names) == (truth.frames, truth.fps, truth.names)
        kept = kept and same
    return float(np.mean(before)), float(np.mean(after)), float(kept)
