"""Figure 8 in kind: where a hand goes, by the sensor, corrected offline, learning on the way, and in truth

The paper shows a golf swing; the widest movement of a hand in the data is an arm raised sideways or ahead.
"""

from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.correct.corrector import CorrectorModel
from motionmend.report.figures import Panel, curves_figure

from .common import Findings, Table
from .correct_common import ABOUT, MOVEMENTS, Episode, kinect_in, left_out

ARMS = ("m07", "m08", "m09", "m10")
AXES = ("sideways", "upward", "along the camera's view")
WAYS = ("sensor", "their terms", "their terms, incremental", "default", "default, incremental")
KEYS = ("exact", "exact_online", "default", "online")
PICTURED = ("sensor", "default", "default, incremental")


def run(mocap: Path, pictures: Path) -> Findings:
    """The hand that moves most, in every episode that moves an arm; the picture is of the one the sensor sees as usual."""
    tried = [
        (one, *_paths(model, one))
        for model, one in left_out(kinect_in(mocap))
        if one.movement in ARMS and not one.doubted
    ]
    errors = np.array([[_missed(one, joint, paths[way]) for way in WAYS] for one, joint, paths in tried])
    kinds = np.array([one.movement for one, _, _ in tried])
    rows = [
        (MOVEMENTS[kind], str((kinds == kind).sum()), *(f"{e:.1f}" for e in errors[kinds == kind].mean(axis=0)))
        for kind in ARMS
    ]
    mean = errors.mean(axis=0)
    one, joint, paths = tried[int(np.argsort(errors[:, 0])[len(errors) // 2])]
    shown = {**{way: paths[way] for way in PICTURED}, "truth": one.pair.truth.positions[:, joint]}
    curves_figure(
        pictures / "correct_fig_8.png",
        one.pair.sensor.times - one.pair.sensor.times[0],
        [Panel(axis, "cm", {n: 100.0 * path[:, k] for n, path in shown.items()}) for k, axis in enumerate(AXES)],
    )
    return Findings(
        {
            **{f"hand_{way}": float(value) for way, value in zip(("raw", *KEYS), mean, strict=True)},
            "hand_of_raw": float(mean[3] / mean[0]),
            "hand_online_of_offline": float(mean[4] / mean[3]),
        },
        (
            ABOUT,
            "The hand that moves most, in every episode of an arm's movement that the data's notes do not doubt. Hands are what "
            "this sensor sees best.",
        ),
        (
            Table(
                "Mean distance of the hand from the truth, cm",
                ("movement", "episodes", *WAYS),
                (*rows, ("all", str(len(errors)), *(f"{value:.1f}" for value in mean))),
            ),
        ),
        (
            (
                "correct_fig_8.png",
                f"{MOVEMENTS[one.movement].capitalize()} by {one.person}, the middle one by the sensor's error: the hand over time.",
            ),
        ),
    )


def _missed(one: Episode, joint: int, path: Floats) -> float:
    """Mean distance from the truth, cm."""
    return float(100.0 * np.nanmean(np.linalg.norm(path - one.pair.truth.positions[:, joint], axis=1)))


def _paths(model: CorrectorModel, one: Episode) -> tuple[int, dict[str, Floats]]:
    """The joint of the hand that moves most, and its places (T, 3) m each way."""
    sensor, truth = one.pair.sensor, one.pair.truth
    hands = [j for j, name in enumerate(truth.names) if "wrist" in name.lower() or "hand" in name.lower()]
    spread = [np.nanstd(truth.positions[:, j], axis=0).sum() if truth.present[:, j].any() else 0.0 for j in hands]
    joint = hands[int(np.argmax(spread))]
    found = {
        "sensor": sensor.positions,
        "their terms": model.correct(sensor, method="exact").positions,
        "their terms, incremental": model.correct(sensor, online=True, method="exact").positions,
        "default": model.correct(sensor).positions,
        "default, incremental": model.correct(sensor, online=True).positions,
    }
    return joint, {way: positions[:, joint] for way, positions in found.items()}
