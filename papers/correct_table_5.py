"""Table 5 in kind: what each term of the energy is worth

Recordings in which the sensor fails on purpose: limbs guessed, drawn to the trunk and shaking, sides confused. Without
failures the sensor's own habits are what there is to correct, and neither time nor reliability can know of them.
"""

from collections import defaultdict
from pathlib import Path

from motionmend.correct.energy import Weights
from motionmend.correct.recordings import by_paper
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
        found |= {
            name: by_paper(model.knowledge, model.mixture, given, "exact", False, weights).positions
            for name, weights in TERMS.items()
        }
        found |= {
            f"{name}, adaptive": by_paper(model.knowledge, model.mixture, given, "adaptive", False, weights).positions
            for name, weights in TERMS.items()
            if name != "spatial"  # alone there is nothing to weigh it against
        }
        found["default"] = model.correct(given).positions
        for name, positions in found.items():
            errors[name].append(away(truth, positions))
            failing[name].append(away(truth, positions, failed.affected))
            honest[name].append(away(truth, positions, ~failed.affected))
    overall, affected, seen = means(errors), means(failing), means(honest)
    rows = tuple((name, f"{overall[name]:.2f}", f"{affected[name]:.2f}", f"{seen[name]:.2f}") for name in overall)
    key = {"raw": "raw", "spatial": "s", "spatial + temporal": "st", "spatial + reliability": "sr", "all": "all"}
    values = {short: overall[name] for name, short in key.items()}
    values |= {
        "default": overall["default"],
        "adaptive": overall["all, adaptive"],
        "adaptive_st": overall["spatial + temporal, adaptive"],
        "adaptive_sr": overall["spatial + reliability, adaptive"],
        "adaptive_helps": overall["all, adaptive"] / overall["all"],
        "adaptive_others": seen["all, adaptive"] / seen["all"],
        "temporal_helps": overall["spatial + temporal"] / overall["spatial"],
        "reliability_helps": overall["spatial + reliability"] / overall["spatial"],
        "all_helps": overall["all"] / min(overall["spatial + temporal"], overall["spatial + reliability"]),
    }
    table = Table("Mean joint error, cm", ("terms", "all joints", "joints that fail", "the others"), rows)
    return Findings(
        values,
        (ABOUT, "Each choice of weights is solved exactly; `adaptive` starts from the same."),
        (table,),
    )
