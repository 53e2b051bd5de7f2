"""Figure 7 in kind: how many local models answer, and how large they are"""

from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import meanings
from motionmend.correct.classic import Samples
from motionmend.correct.corrector import CorrectorModel
from motionmend.correct.paper import neighbour_inputs
from motionmend.numerics.local_gp import fit_mixture, predict
from motionmend.report.figures import lines_figure

from .common import Findings
from .correct_common import ABOUT, episodes, folds, kinect_in, learned, samples_of

MODELS = 30  # Q
SIZES = (5, 15, 30, 50, 70)  # S
NEAREST = (1, 3, 5, 9, 15, 25)  # L
JOINTS = ("elbow", "wrist", "knee", "ankle")
S, L = 50, 9  # the paper's choice


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of the spatial term alone by S at L = 9, and by L at S = 50."""
    kinect = kinect_in(mocap)
    people = folds(episodes(kinect))[0]
    taught = learned(kinect, people)
    tried = samples_of(taught, [one.pair for one in episodes(kinect) if one.person in people])
    found = {size: error(taught, tried, size, NEAREST) for size in SIZES}
    by_size = np.array([found[size][NEAREST.index(L)] for size in SIZES])
    by_nearest = np.array(found[S])
    lines_figure(
        pictures / "correct_fig_7_size.png",
        np.array(SIZES, float),
        {"spatial term": by_size},
        xlabel="samples of a local model, S",
        ylabel="error, cm",
    )
    lines_figure(
        pictures / "correct_fig_7_nearest.png",
        np.array(NEAREST, float),
        {"spatial term": by_nearest},
        xlabel="local models that answer, L",
        ylabel="error, cm",
    )
    at = SIZES.index(S)
    return Findings(
        {
            "at_paper": float(by_size[at]),
            "small": float(by_size[0]),
            "beyond_size": float(by_size[-1] / by_size[at]),
            "one": float(by_nearest[0]),
            "nine_of_one": float(by_nearest[NEAREST.index(L)] / by_nearest[0]),
            "beyond_nearest": float(by_nearest[-1] / by_nearest[NEAREST.index(L)]),
        },
        (
            ABOUT,
            f"One fold, {MODELS} models; elbows, wrists, knees and ankles; the spatial term alone, in standard form.",
        ),
        (),
        (
            ("correct_fig_7_size.png", "Error by the size of local models."),
            ("correct_fig_7_nearest.png", "Error by the number of models that answer."),
        ),
    )


def error(model: CorrectorModel, tried: Samples, size: int, nearest: tuple[int, ...]) -> list[float]:
    """Mean distance in cm from the true offsets, for each number of models that answer."""
    body = model.watcher.body
    inputs = neighbour_inputs(model.samples.postures, body)
    known = np.asarray(np.isfinite(model.samples.offsets).all(axis=2))
    joints = [j for j, meaning in enumerate(meanings(body.names)) if (meaning or "").endswith(JOINTS)]
    mixture = fit_mixture(
        [inputs[known[:, j], j] for j in joints], [model.samples.offsets[known[:, j], j] for j in joints], MODELS, size
    )
    queries = neighbour_inputs(tried.postures, body)[:, joints]
    return [_distance(tried.offsets[:, joints], predict(mixture, queries, count)[0]) for count in nearest]


def _distance(truth: Floats, found: Floats) -> float:
    distance = np.linalg.norm(truth - found, axis=2)
    return float(100.0 * distance[np.isfinite(distance)].mean())
