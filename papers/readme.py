"""The two pictures of the README: `python -m papers.readme --data DIR`."""

import argparse
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.report.figures import Panel, curves_figure

from .common import SPLITS, model_of, motion, spoiled
from .fig_2_5_knee import KNEE, SHOWN
from .fig_2_6_arms import JOINTS, cases, draw
from .harness import recordings_in
from .pictures import parents_within, shrink

NOISE, OUTLIERS = 3.0, 0.1  # degrees, share of the samples
MOMENTS = 6


def main() -> None:
    """Draw both into docs/pictures."""
    parser = argparse.ArgumentParser(prog="python -m papers.readme")
    parser.add_argument("--data", type=Path, help="folder of real recordings; default: MOTIONMEND_DATA")
    mocap = recordings_in(parser.parse_args().data)
    folder = Path(__file__).resolve().parents[1] / "docs" / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    knee(mocap, folder / "knee.png")
    arms(mocap, folder / "arms.png")


def knee(mocap: Path, path: Path) -> None:
    """One joint angle of a walk with noise and outliers in every channel."""
    truth = motion(mocap, SHOWN)
    noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS)
    repaired = model_of(mocap, SPLITS["walking"].learn).repair(noisy, "paper").recording
    column = truth.channels.index(KNEE)
    named = {"noisy": noisy, "truth": truth, "repaired": repaired}
    curves = {name: np.degrees(one.q[:, column]) for name, one in named.items()}
    panel = Panel("Right knee of a walk, 3° of noise and 10 % outliers", "degrees", curves)
    curves_figure(path, np.arange(truth.frames) / truth.fps, [panel])
    shrink(path)


def arms(mocap: Path, path: Path) -> None:
    """The joints of a walk without the arms, and with the arms filled in."""
    case = cases(mocap)["walker"]
    truth = case.test[-1]
    cut = mm.corrupt(truth, drop=case.arms).recording
    filled = mm.Denoiser().fit(case.learn).repair(cut, "paper").recording
    draw(path, truth, cut, filled, parents_within(motion(mocap, SHOWN).skeleton, JOINTS), MOMENTS)
    shrink(path)


if __name__ == "__main__":
    main()
