"""Time a frame on one thread"""

from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.track.settings import settings_of

from .common import Findings, Table
from .track_common import ABOUT, BEND, DANCE, TURN, foreign, recorded, shown, stage, tracker

READINGS = 3  # of everything, the middle one counts: the machine is not always as quick, and the first loads kernels


def run(mocap: Path, pictures: Path) -> Findings:
    """Milliseconds of a frame of 320 x 240 with the Kinect's noise, everything but reading it."""
    del pictures
    model = tracker(mocap)
    shows = []
    for preset, takes in (("default", (BEND, TURN, DANCE)), ("paper", (BEND,))):
        for take in takes:
            scene = stage(mocap, take)
            ways = {"own body": list(shown(scene, 0, colored=preset == "paper"))}
            if preset == "default":
                ways["another body"] = list(foreign(scene, 1, 0, 80))
            shows += [(preset, take, scene, name, frames) for name, frames in ways.items()]
    spent: dict[tuple[str, str, str], list[Floats]] = {}  # ms of each frame, a reading after the other
    behind: dict[tuple[str, str, str], list[float]] = {}  # ms a frame
    iterations: dict[tuple[str, str, str], float] = {}
    for _ in range(READINGS):
        for preset, take, scene, name, frames in shows:
            track = recorded(model, settings_of(preset), frames, scene.performer, scene.poses[0])
            key = preset, take.name, name
            spent.setdefault(key, []).append(1e3 * track.seconds[5:])
            behind.setdefault(key, []).append(1e3 * track.behind / len(frames))
            iterations[key] = float(track.iterations.mean())
    readings = [
        {
            preset: np.concatenate([ms[r] for (one, *_), ms in spent.items() if one == preset])
            for preset in ("default", "paper")
        }
        for r in range(READINGS)
    ]
    looking = [np.mean([ms[r] for (one, *_), ms in behind.items() if one == "default"]) for r in range(READINGS)]
    rates = [1e3 / (one["default"].mean() + back) for one, back in zip(readings, looking, strict=True)]

    def middle(preset: str, percent: float) -> float:
        return float(np.median([np.percentile(one[preset], percent) for one in readings]))

    rows = tuple(
        (
            *key,
            f"{np.median([np.median(ms) for ms in spent[key]]):.1f}",
            f"{np.median([np.percentile(ms, 95) for ms in spent[key]]):.1f}",
            f"{np.median(behind[key]):.1f}",
            f"{iterations[key]:.1f}",
        )
        for key in spent
    )
    return Findings(
        {
            "ms_median": middle("default", 50),
            "ms_95": middle("default", 95),
            "paper_ms_median": middle("paper", 50),
            "paper_ms_95": middle("paper", 95),
            "behind_ms": float(np.median(looking)),
            "fps": float(np.median(rates)),
            "fps_least": float(min(rates)),
            "fps_most": float(max(rates)),
        },
        (
            ABOUT,
            "The thread's own time, so that a busy computer does not count; the first five frames left out. Looking back "
            "is done for three seconds at a time, partly on a second thread, and timed by the clock; it is in the frames a "
            f"second, not in a frame's milliseconds. Of {READINGS} readings in a row the middle one: they gave "
            f"{min(rates):.0f} to {max(rates):.0f} frames a second, by what else the machine does.",
        ),
        (
            Table(
                "Milliseconds a frame",
                ("preset", "motion", "who", "median", "95 %", "looking back", "iterations"),
                rows,
            ),
        ),
    )
