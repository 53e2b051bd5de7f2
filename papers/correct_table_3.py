"""Table 3 in kind: people the corrector has not learned from, every method

One corrector, of all ten movements, serves all (table 2). The paper's columns are raw, exemplars (Shen et al. 2012), one
Gaussian process for everything (Zhou et al. 2014), theirs offline and incremental.
"""

from collections import defaultdict
from pathlib import Path

import numpy as np

from motionmend.report.figures import lines_figure

from .common import Findings, Table
from .correct_common import ABOUT, MOVEMENTS, away, kinect_in, left_out, means

FILTERS = ("one-euro", "savgol", "kalman")
LEARNERS = ("constant", "ridge", "gp", "exemplar")
PAPER = ("paper", "exact")
WIDTHS = (1.0, 1.96)  # standard deviations that hold 68 and 95 %
EVERY = 4  # of the episodes: the paper's own variants, which are slow
SHOWN = ("raw", "constant", "ridge", "exemplar", "gp", "default", "online")


def run(mocap: Path, pictures: Path) -> Findings:
    """Mean joint error of every method by movement and over all."""
    errors: dict[str, list[float]] = defaultdict(list)
    published: dict[str, list[float]] = defaultdict(list)
    doubted: dict[str, list[float]] = defaultdict(list)
    movement, person = [], []
    inside: dict[float, list[float]] = defaultdict(list)
    for k, (model, one) in enumerate(left_out(kinect_in(mocap))):
        sensor, truth = one.pair.sensor, one.pair.truth
        if one.doubted:
            for name, positions in (("raw", sensor.positions), ("default", model.correct(sensor).positions)):
                doubted[name].append(away(truth, positions))
            continue
        errors["raw"].append(away(truth, sensor.positions))
        for method in (*FILTERS, *LEARNERS):
            errors[method].append(away(truth, model.correct(sensor, method=method).positions))
        found = model.correct(sensor)
        errors["default"].append(away(truth, found.positions))
        score = np.abs(found.positions - truth.positions)[truth.present] / found.std[truth.present][:, None]
        for width in WIDTHS:
            inside[width].append(float((score < width).mean()))
        errors["online"].append(away(truth, model.correct(sensor, online=True).positions))
        movement.append(one.movement)
        person.append(one.person)
        if k % EVERY == 0:
            published["raw"].append(errors["raw"][-1])
            published["default"].append(errors["default"][-1])
            for method in PAPER:
                published[method].append(away(truth, model.correct(sensor, method=method).positions))
            published["exact online"].append(away(truth, model.correct(sensor, online=True, method="exact").positions))
    alone: dict[str, list[float]] = defaultdict(list)
    for model, one in left_out(kinect_in(mocap), 1):
        if one.doubted:
            continue
        for method in ("ridge", "default"):
            alone[method].append(away(one.pair.truth, model.correct(one.pair.sensor, method=method).positions))
    fewer = means(alone)
    theirs = means(published)
    overall = means(errors)
    every = {name: float(np.mean(errors[name] + doubted[name])) for name in ("raw", "default")}
    rivals = {name: overall[name] for name in (*FILTERS, *LEARNERS)}
    best = min(rivals, key=lambda name: rivals[name])
    raw, default = np.array(errors["raw"]), np.array(errors["default"])
    kinds = np.array(movement)
    rows = [
        (
            MOVEMENTS[kind],
            str(int((kinds == kind).sum())),
            *(f"{np.mean(np.array(errors[name])[kinds == kind]):.2f}" for name in SHOWN),
        )
        for kind in sorted(set(movement))
    ]
    rows.append(("all", str(len(raw)), *(f"{overall[name]:.2f}" for name in SHOWN)))
    by_person = tuple(
        (name, *(f"{np.mean(np.array(errors[m])[np.array(person) == name]):.2f}" for m in SHOWN))
        for name in sorted(set(person))
    )
    steps = np.linspace(0, 100, 101)
    lines_figure(
        pictures / "correct_table_3.png",
        steps,
        {name: np.percentile(errors[name], steps) for name in ("raw", "ridge", "gp", "default")},
        xlabel="share of the episodes, %",
        ylabel="error, cm",
        leading=("default",),
    )
    values = {
        "raw": overall["raw"],
        "offline": overall["default"],
        "online": overall["online"],
        "paper": theirs["paper"],
        "exact": theirs["exact"],
        "exact_online": theirs["exact online"],
        "raw_there": theirs["raw"],
        "default_there": theirs["default"],
        "gp": overall["gp"],
        "exemplar": overall["exemplar"],
        "constant": overall["constant"],
        "ridge": overall["ridge"],
        "best": rivals[best],
        "of_raw": overall["default"] / overall["raw"],
        "of_best": overall["default"] / rivals[best],
        "online_of_best": overall["online"] / rivals[best],
        "online_of_offline": overall["online"] / overall["default"],
        "exact_of_raw": theirs["exact"] / theirs["raw"],
        "alone": fewer["default"],
        "alone_of_raw": fewer["default"] / overall["raw"],
        "alone_of_ridge": fewer["default"] / fewer["ridge"],
        "within_68": float(np.mean(inside[WIDTHS[0]])),
        "within_95": float(np.mean(inside[WIDTHS[1]])),
        "doubted": float(len(doubted["raw"])),
        "all_raw": every["raw"],
        "all_offline": every["default"],
        "all_of_raw": every["default"] / every["raw"],
        "worse": float(np.mean(default > raw)),
        "episodes": float(len(raw) + len(doubted["raw"])),
    }
    return Findings(
        values,
        (ABOUT, f"The best of all rivals is `{best}`. The paper's own variants are tried on every fourth episode."),
        (
            Table(
                "The paper's variants on every fourth episode, cm",
                ("method", "error"),
                tuple((name, f"{value:.2f}") for name, value in theirs.items()),
            ),
            Table("Mean joint error, cm, by movement", ("movement", "episodes", *SHOWN), tuple(rows)),
            Table("The same by person", ("person", *SHOWN), by_person),
            Table(
                "Every method, cm",
                ("method", "error"),
                tuple((n, f"{v:.2f}") for n, v in sorted(overall.items(), key=by)),
            ),
        ),
        (("correct_table_3.png", "Error by share of the episodes: half of them are better than the line at 50 %."),),
    )


def by(item: tuple[str, float]) -> float:
    """The number of a named number."""
    return item[1]
