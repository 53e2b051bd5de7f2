"""Figure 2.5: knee and thorax of training, spoiled and filtered motion

As in the paper two clips teach and a third of the same person is cleaned; the knee is spoiled by outliers from the
first frame to the last, the thorax is not.
"""

from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.evaluate import rms_angle
from motionmend.report.figures import Panel, curves_figure

from .common import SPLITS, Findings, Table, model_of, motion, reduced, spoiled

LEARN = ("16_15", "16_16")
SHOWN = "16_58"
KNEE, THORAX = "rtibia.rx", "thorax.rx"
OUTLIERS = 0.3


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of the spoiled knee before and after, and how far the untouched thorax moved, in three clips."""
    two = model_of(mocap, LEARN)
    five = model_of(mocap, SPLITS["walking"].learn)
    errors: dict[str, list[float]] = {}
    rows = []
    for clip in SPLITS["walking"].test:
        truth = reduced(motion(mocap, clip))
        noisy = knee_spoiled(truth)
        clean = two.repair(noisy, "paper").recording
        better = five.repair(noisy, "paper").recording
        found = {
            "knee_before": away(truth, noisy, KNEE),
            "knee_after": away(truth, clean, KNEE),
            "knee_five": away(truth, better, KNEE),
            "thorax_after": away(truth, clean, THORAX),
            "thorax_five": away(truth, better, THORAX),
        }
        for name, error in found.items():
            errors.setdefault(name, []).append(error)
        rows.append((clip, *(f"{error:.2f}" for error in found.values())))
        if clip == SHOWN:
            draw(pictures / "fig_2_5.png", reduced(motion(mocap, LEARN[0])), noisy, truth, clean)
    head = ("clip", "knee spoiled", "knee filtered", "knee, five clips", "thorax filtered", "thorax, five clips")
    return Findings(
        values={name: float(np.mean(found)) for name, found in errors.items()}
        | {"knee_ratio": float(np.mean(errors["knee_after"]) / np.mean(errors["knee_before"]))},
        notes=(
            f"Learned from {' and '.join(LEARN)} as the paper learns from two, and from five; all subject 16, 30 fps. "
            "The paper's clips 83-04, 83-55 and 83-68 are not in the data.",
            f"{100 * OUTLIERS:g} % of the knee's samples are off by 15 to 55 degrees; nothing else is spoiled.",
        ),
        tables=(Table("RMS error of one joint angle, degrees", head, tuple(rows)),),
        figures=(("fig_2_5.png", f"One training clip, and {SHOWN} as it was spoiled, repaired and true."),),
    )


def away(truth: mm.Motion, other: mm.Motion, channel: str) -> float:
    """RMS difference of one joint angle, degrees."""
    column = truth.channels.index(channel)
    return float(np.degrees(rms_angle(truth.q[:, column], other.q[:, column])))


def draw(path: Path, training: mm.Motion, noisy: mm.Motion, truth: mm.Motion, clean: mm.Motion) -> None:
    """Both joint angles of all four over the length of the shortest."""
    frames = min(training.frames, truth.frames)
    panels = []
    for title, channel in (("knee", KNEE), ("thorax", THORAX)):
        column = truth.channels.index(channel)
        named = {"training": training, "noisy": noisy, "truth": truth, "repaired": clean}
        curves = {name: np.degrees(one.q[:frames, column]) for name, one in named.items()}
        panels.append(Panel(f"{title} ({channel})", "degrees", curves))
    curves_figure(path, np.arange(frames) / truth.fps, panels)


def knee_spoiled(truth: mm.Motion) -> mm.Motion:
    """The clip with outliers in the knee alone."""
    column = truth.channels.index(KNEE)
    q = truth.q.copy()
    q[:, column] = spoiled(truth, outliers=OUTLIERS).q[:, column]
    return truth.with_q(q)
