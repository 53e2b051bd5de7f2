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
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for left_out, takes in (("edge", EDGES), ("prior", PRIOR)):
        scenes = [stage(mocap, take) for take in takes]
        images = [[shown(scene, seed) for seed in SEEDS] for scene in scenes]
        for preset in ("paper", "default"):
            used = tuple(term for term in settings_of(preset).terms if term != "color")
            errors: dict[str, list[float]] = {"with": [], "without": []}
            for take, scene, seeds in zip(takes, scenes, images, strict=True):
                for key in errors:
                    wish = settings_of(preset, tuple(t for t in used if key == "with" or t != left_out))
                    tracks = [follow(model, wish, frames, scene.performer, scene.poses[0]) for frames in seeds]
                    away_by = np.concatenate([away(scene.joints, track.joints) for track in tracks])
                    errors[key].append(float(away_by.mean()))
                    rows.append((take.name, preset, f"{key} {left_out}", *numbers(away_by)))
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
