"""Figure 2.8: the thorax, ours and three rivals against the truth"""

from pathlib import Path

import numpy as np

from motionmend.report.figures import Panel, curves_figure

from .common import SPLITS, Findings, Table, model_of, motion, reduced, spoiled
from .fig_2_7_rivals import METHODS

CHANNEL = "thorax.rz"  # the thorax's angle that moves most in this walk
NOISE, OUTLIERS = 3.0, 0.1


def run(mocap: Path, pictures: Path) -> Findings:
    """Curves of one joint angle by all four methods."""
    split = SPLITS["walking"]
    truth = reduced(motion(mocap, split.test[0]))
    noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS)
    column = truth.channels.index(CHANNEL)
    model = model_of(mocap, split.learn)
    curve = {m: np.degrees(model.repair(noisy, m).recording.q[:, column]) for m in METHODS}
    true, given = (np.degrees(m.q[:, column]) for m in (truth, noisy))
    error = {m: float(np.sqrt(np.square(c - true).mean())) for m, c in {"input": given, **curve}.items()}
    curves_figure(
        pictures / "fig_2_8.png",
        np.arange(truth.frames) / truth.fps,
        [
            Panel("spoiled", "degrees", {"noisy": given, "truth": true}),
            Panel("ours", "degrees", {"truth": true, "repaired": curve["paper"]}),
            Panel("rivals", "degrees", {"truth": true, **{m: curve[m] for m in METHODS if m != "paper"}}),
        ],
    )
    return Findings(
        values={
            "thorax_paper": error["paper"],
            "thorax_next": min(error[m] for m in METHODS if m != "paper"),
            "thorax_input": error["input"],
        },
        notes=(f"Walking clip {split.test[0]} with {NOISE:g} degrees of noise and {100 * OUTLIERS:g} % outliers.",),
        tables=(
            Table(
                f"RMS error of {CHANNEL}, degrees",
                ("input", *METHODS),
                (tuple(f"{error[m]:.2f}" for m in ("input", *METHODS)),),
            ),
        ),
        figures=(("fig_2_8.png", f"The angle {CHANNEL} by all four methods."),),
    )
