"""Table 5 in kind: what each term of the energy is worth

Recordings in which the sensor fails on purpose: limbs guessed, drawn to the trunk and shaking, sides confused. Without
failures the sensor's own habits are what there is to correct, and neither time nor reliability can know of them.
"""

from collections import defaultdict
from pathlib import Path

from motionmend.correct.energy import Weights
from motionmend.correct.recordings import PAPER, by_paper
from motionmend.evaluate.sensor_failures import fail

from .common import Findings, Table
from .correct_common import ABOUT, away, kinect_in, left_out, means

TERMS = {
    "spatial": Weights(1.0, 0.0, 0.0),
    "spatial + temporal": Weights(0.6, 0.2, 0.0),
    "spatial + reliability": Weights(0.6, 0.0, 0.2),
    "all": Weights(0.6, 0.2, 0.2),
}
EVERY = 2  # of the episodes


def run(mocap: Path, pictures: Path) -> Findings:
    """Mean error with each choice of terms, on all joints and on those that fail."""
    del pictures
    errors: dict[str, list[float]] = defaultdict(list)
    failing: dict[str, list[float]] = defaultdict(list)
    honest: dict[str, list[float]] = defaultdict(list)
    for seed, (model, one) in enumerate(left_out(kinect_in(mocap))[::EVERY]):
        failed = fail(one.pair.sensor, seed=seed)
        given, truth = failed.postures, one.pair.truth
        found = {"raw": given.positions}
        for name, weights in TERMS.items():
            for method in PAPER:
                by_them = by_paper(model.knowledge, model.mixture, given, method, False, weights)
                found[f"{name}, {method}"] = by_them.positions
        found["default"] = model.correct(given).positions
        for name, positions in found.items():
            errors[name].append(away(truth, positions))
            failing[name].append(away(truth, positions, failed.affected))
            honest[name].append(away(truth, positions, ~failed.affected))
    overall, affected, seen = means(errors), means(failing), means(honest)
    rows = tuple((name, f"{overall[name]:.2f}", f"{affected[name]:.2f}", f"{seen[name]:.2f}") for name in overall)
    values = {name: overall[name] for name in ("raw", "default")}
    for method in PAPER:
        s, st, sr, whole = (overall[f"{name}, {method}"] for name in TERMS)
        values |= {f"{method}_s": s, f"{method}_st": st, f"{method}_sr": sr, f"{method}_all": whole}
        values |= {f"{method}_temporal": st / s, f"{method}_reliability": sr / st, f"{method}_both": whole / sr}
    values["adaptive_helps"] = overall["all, adaptive"] / overall["all, exact"]
    values["adaptive_others"] = seen["all, adaptive"] / seen["all, exact"]
    table = Table("Mean joint error, cm", ("terms", "all joints", "joints that fail", "the others"), rows)
    return Findings(
        values,
        (
            ABOUT,
            "`paper` descends frame by frame and takes the two postures before for true; `exact` solves all frames of a "
            "recording together, and so does `adaptive`, whose weights start from the same.",
        ),
        (table,),
    )
