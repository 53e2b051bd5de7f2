"""Whether the tracker's memory stays flat over an hour of images.

A clip's frames are tracked over and over, to and fro so that nobody leaps, and looked back at as `motionmend track`
does; what the process holds is noted every hundred frames. The slope over the last two thirds is given in MB an hour of
30 images a second.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from motionmend import samples
from motionmend.bodies.camera import KINECT
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.evaluate.scenes import performed, view
from motionmend.track.hindsight.backwards import Moment, moment, revised
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step

from .metric import Metric
from .timing import Plan

FRAMES, EVERY, FPS = 108_000, 100, 30.0
CLIP = 60  # frames, tracked forwards and backwards


def held() -> float:
    """MB of memory that this process holds now; Linux only."""
    status = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in status if line.startswith("VmRSS")).split()[1]) / 1024


def run(plan: Plan) -> list[Metric]:
    """An hour of images; whatever the plan, for an hour is what is asked."""
    notes, seconds = tracked(FRAMES)
    number, memory = np.array(notes).T
    late = number > FRAMES / 3
    slope = float(np.polyfit(number[late], memory[late], 1)[0])
    return [
        Metric(f"endurance.{FRAMES}.rate", FRAMES / seconds, "images/s", "info"),
        Metric(f"endurance.{FRAMES}.held_after_a_third", float(memory[late][0]), "MB", "info"),
        Metric(f"endurance.{FRAMES}.held_at_the_end", float(memory[-1]), "MB", "info"),
        Metric(f"endurance.{FRAMES}.growth", slope * 3600.0 * FPS, "MB/h", "info"),
    ]


def tracked(frames: int) -> tuple[list[tuple[int, float]], float]:
    """MB held after each hundred frames, and the seconds that all took."""
    clip = samples.clip("reach", seconds=4.0, seed=4)
    model = TrackerModel.fit([clip], images=150)
    performer = performer_of(clip.skeleton)
    every = round(clip.fps / FPS)
    found = poses_of(clip, performer).poses
    up = np.asarray(clip.skeleton.up, dtype=np.float64)
    facing = view(np.zeros(3), up).turn @ found.root[0][:, 2]
    camera = view(found.translation[0], up, 3.0, np.degrees(np.arctan2(facing[0], -facing[2])))
    seen = found.moved(camera.turn, camera.shift).some(slice(0, CLIP * every, every))
    shown = list(performed(seen, performer, KINECT, fps=FPS, seed=0))
    order = [*range(len(shown)), *range(len(shown) - 2, 0, -1)]
    settings = settings_of()

    def moments() -> Iterator[Moment]:
        state = start(model, settings, shown[0], performer, seen[0])
        for k in range(frames):
            frame = shown[order[k % len(order)]]
            state, estimate = step(model, settings, state, replace(frame, time=k / FPS))
            yield moment(state, estimate)

    notes = []
    begin = perf_counter()
    for k, _ in enumerate(revised(model, settings, moments())):
        if k % EVERY == 0:
            notes.append((k, held()))
    return notes, perf_counter() - begin
