"""Figures 3.11 and 3.12: where edges matter, and where the prior does"""

from pathlib import Path

import numpy as np

from motionmend.track.settings import settings_of

from .common import Findings, Table
from .track_common import ABOUT, SIT, TURN, Take, away, follow, library, numbers, shown, stage

RAISED = Take("lift arm", "02_06", 1500, 1820)
EDGES = (SIT, RAISED)
PRIOR = (TURN, Take("walk and turn", "16_41", 0, 160))
SEEDS = (0, 1)


def run(mocap: Path, pictures: Path) -> Findings:
    """Tracking with and without one term, the rest as it is, in both presets."""
    del pictures
    model = library(mocap)
    rows, values = [], {}
    for left_out, takes in (("edge", EDGES), ("prior", PRIOR)):
        for preset in ("paper", "default"):
            whole = settings_of(preset)
            used = tuple(term for term in whole.terms if term != "color")
            errors: dict[str, list[float]] = {"with": [], "without": []}
            for take in takes:
                scene = stage(mocap, take)
                for key in errors:
                    wish = settings_of(preset, tuple(t for t in used if key == "with" or t != left_out))
                    tracks = [
                        away(
                            scene.joints,
                            follow(model, wish, shown(scene, seed), scene.performer, scene.poses[0]).joints,
                        )
                        for seed in SEEDS
                    ]
                    errors[key].append(float(np.mean([one.mean() for one in tracks])))
                    rows.append((take.name, preset, f"{key} {left_out}", *numbers(np.concatenate(tracks))))
            for key, found in errors.items():
                values[f"{preset}_{key}_{left_out}"] = float(np.mean(found))
            values[f"{preset}_{left_out}_ratio"] = float(np.mean(errors["with"]) / np.mean(errors["without"]))
    return Findings(
        values,
        (ABOUT, "Two seeds of the Kinect's noise, given lengths and first pose; without colour."),
        (
            Table(
                "With and without a term, cm",
                ("motion", "preset", "terms", "mean", "95 %", "largest", "> 15 cm, %"),
                tuple(rows),
            ),
        ),
    )
