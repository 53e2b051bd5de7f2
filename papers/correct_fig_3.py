"""Figure 3 in kind: how many samples are needed"""

from pathlib import Path

import numpy as np

from motionmend.arrays import Floats, Ints
from motionmend.bodies.joint_sets import meanings
from motionmend.correct.paper import neighbour_inputs
from motionmend.numerics.local_gp import Hyper, budget, covariance, factor, fit_hyper
from motionmend.report.figures import lines_figure

from .common import Findings
from .correct_common import ABOUT, episodes, folds, kinect_in, learned, samples_of

SAMPLES = 1120  # the paper's
SHARES = (1.0, 0.85, 0.65, 0.5, 0.35, 0.2)
JOINTS = ("elbow", "wrist", "knee", "ankle")
TRIED = 600  # frames of the people left out


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of one Gaussian process per joint by the share of samples that budgeting, or chance, has left."""
    kinect = kinect_in(mocap)
    people = folds(episodes(kinect))[0]
    model = learned(kinect, people)
    tried = samples_of(model, [one.pair for one in episodes(kinect) if one.person in people])
    body = model.watcher.body
    rng = np.random.default_rng(0)
    chosen = np.sort(rng.permutation(len(model.samples.postures))[:SAMPLES])
    some = np.linspace(0, len(tried.postures) - 1, TRIED).astype(int)
    inputs = neighbour_inputs(model.samples.postures[chosen], body)
    queries = neighbour_inputs(tried.postures[some], body)
    curves: dict[str, list[Floats]] = {"budget": [], "chance": []}
    for j, meaning in enumerate(meanings(body.names)):
        if not (meaning or "").endswith(JOINTS):
            continue
        known = np.asarray(np.isfinite(model.samples.offsets[chosen, j]).all(axis=1))
        x, y = inputs[known, j], model.samples.offsets[chosen][known, j]
        hyper = fit_hyper(x[::4], y[::4])
        truth = tried.offsets[some, j]
        order = rng.permutation(len(x))
        counts = [max(round(share * len(x)), 2) for share in SHARES]
        best = np.arange(len(x))
        kept = []
        for n in counts:
            best = best[budget(x[best], y[best], hyper, n)]
            kept.append(best)
        curves["budget"].append(np.array([_error(x, y, picked, hyper, queries[:, j], truth) for picked in kept]))
        by_chance = [np.sort(order[:n]) for n in counts]
        curves["chance"].append(np.array([_error(x, y, picked, hyper, queries[:, j], truth) for picked in by_chance]))
    mean = {name: np.mean(rows, axis=0) for name, rows in curves.items()}
    lines_figure(
        pictures / "correct_fig_3.png",
        100 * np.array(SHARES),
        mean,
        xlabel="samples kept, %",
        ylabel="error, cm",
        leading=("budget",),
    )
    at, low = SHARES.index(0.65), SHARES.index(0.35)
    return Findings(
        {
            "samples": float(SAMPLES),
            "all": float(mean["budget"][0]),
            "kept_65": float(mean["budget"][at]),
            "ratio": float(mean["budget"][at] / mean["budget"][0]),
            "chance_ratio": float(mean["chance"][at] / mean["chance"][0]),
            "ratio_35": float(mean["budget"][low] / mean["budget"][0]),
            "chance_ratio_35": float(mean["chance"][low] / mean["chance"][0]),
        },
        (ABOUT, "Elbows, wrists, knees and ankles; one process per joint on its bone neighbours; people left out."),
        (),
        (("correct_fig_3.png", "Error by the share of samples kept: by Kullback-Leibler divergence, and by chance."),),
    )


def _error(x: Floats, y: Floats, kept: Ints, hyper: Hyper, queries: Floats, truth: Floats) -> float:
    lower = factor(x[kept], hyper)
    weights = np.linalg.solve(lower.T, np.linalg.solve(lower, y[kept]))
    distance = np.linalg.norm(covariance(queries, x[kept], hyper) @ weights - truth, axis=1)
    return float(100.0 * distance[np.isfinite(distance)].mean())
