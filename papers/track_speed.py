"""Time a frame on one thread"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import cycle, islice
from pathlib import Path
from time import perf_counter

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.camera import DepthFrame
from motionmend.cli.looking_back import made_ready, revised_beside, second_process
from motionmend.track.hindsight.backwards import Moment, moment
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step

from .common import Findings, Table
from .track_common import ABOUT, BEND, DANCE, FPS, TURN, Stage, foreign, recorded, shown, stage, tracker

LONG = 900  # frames of a recording that is followed and looked back at by two processes
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
    alone = [1e3 / (one["default"].mean() + back) for one, back in zip(readings, looking, strict=True)]
    rates = _on_two(model, [(scene, frames) for preset, _, scene, _, frames in shows if preset == "default"])

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
            "fps_alone": float(np.median(alone)),
            "fps": float(np.median(rates)),
            "fps_least": float(min(rates)),
            "fps_most": float(max(rates)),
        },
        (
            ABOUT,
            "The thread's own time, so that a busy computer does not count; the first five frames left out. Looking back "
            "is done for three seconds at a time, and timed by the clock; it is not in a frame's milliseconds. Frames a "
            f"second: each take there and back until it has {LONG} frames, followed by one process and looked back at by "
            "another, as `motionmend track` has it, by the clock, the second one's start (about 1 s) left out; by one "
            f"process alone {np.median(alone):.0f}. Of {READINGS} readings in a row the middle one: they gave "
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


def _on_two(model: TrackerModel, shows: Sequence[tuple[Stage, list[DepthFrame]]]) -> list[float]:
    """Frames a second of long recordings, followed here while another process looks back, in each reading."""
    settings, rates = settings_of("default"), []
    with second_process(LONG, idle=True) as other:
        assert other is not None
        other.submit(made_ready).result()
        for _ in range(READINGS):
            begin, told = perf_counter(), 0
            for scene, frames in shows:
                told += sum(1 for _ in revised_beside(other, model, settings, _moments(model, scene, frames)))
            rates.append(told / (perf_counter() - begin))
    return rates


def _moments(model: TrackerModel, scene: Stage, frames: Sequence[DepthFrame]) -> Iterator[Moment]:
    """A take followed there and back until there are `LONG` frames."""
    settings, state = settings_of("default"), None
    there_and_back = cycle([*frames, *frames[-2:0:-1]])
    for t, frame in enumerate(islice(there_and_back, LONG)):
        here = replace(frame, time=t / FPS)
        if state is None:
            state = start(model, settings, here, scene.performer, scene.poses[0])
        state, estimate = step(model, settings, state, here)
        yield moment(state, estimate)
