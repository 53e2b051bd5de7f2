"""Section 5.3: what learning costs by the number of frames

UI-PRMD has 12,000 frames that belong together. For more, they are taken again as other people: turned, larger or smaller by up
to 7 %, with 3 mm of fresh noise on the sensor's side. That says what learning costs, and nothing of what it gains.
"""

import tracemalloc
from dataclasses import replace
from pathlib import Path
from time import thread_time

import numpy as np

from motionmend.correct.corrector import Corrector, Pair
from motionmend.report.figures import lines_figure

from .common import Findings, Table
from .correct_common import ABOUT, episodes, kinect_in

FRAMES = (2_500, 10_000, 30_000, 100_000)


def run(mocap: Path, pictures: Path) -> Findings:
    """Seconds of one core and peak memory."""
    pairs = [one.pair for one in episodes(kinect_in(mocap))]
    seconds, memory = [], []
    for frames in FRAMES:
        some = _many(pairs, frames)
        tracemalloc.start()
        begin = thread_time()
        Corrector().fit(some)
        seconds.append(thread_time() - begin)
        memory.append(tracemalloc.get_traced_memory()[1] / 2**20)
        tracemalloc.stop()
    lines_figure(
        pictures / "correct_learning.png",
        np.array(FRAMES, float) / 1000.0,
        {"seconds": np.array(seconds), "memory, 10 MiB": np.array(memory) / 10.0},
        xlabel="thousand frames",
        ylabel="cost of learning",
        leading=("seconds",),
    )
    rows = tuple((f"{n:,}", f"{s:.1f}", f"{m:.0f}") for n, s, m in zip(FRAMES, seconds, memory, strict=True))
    return Findings(
        {
            "few": seconds[0],
            "many": seconds[-1],
            "memory": memory[-1],
            "by_linear": (seconds[-1] / seconds[-2]) / (FRAMES[-1] / FRAMES[-2]),
            "memory_by_linear": (memory[-1] / memory[-2]) / (FRAMES[-1] / FRAMES[-2]),
        },
        (ABOUT, "Frames beyond 12,000 are the same ones turned, resized and with fresh noise."),
        (Table("What learning costs", ("frames", "seconds of one core", "MiB at its peak"), rows),),
        (("correct_learning.png", "Cost of learning by the number of frames: seconds of one core, and memory."),),
    )


def _many(pairs: list[Pair], frames: int) -> list[Pair]:
    rng = np.random.default_rng(0)
    found: list[Pair] = []
    count = 0
    while count < frames:
        one, again = pairs[len(found) % len(pairs)], len(found) >= len(pairs)
        angle, size = (rng.uniform(-np.pi, np.pi), rng.uniform(0.93, 1.07)) if again else (0.0, 1.0)
        turn = size * np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        some = slice(0, min(one.sensor.frames, frames - count))
        noise = 0.003 * again * rng.standard_normal(one.sensor.positions[some].shape)
        sensor = replace(
            one.sensor, positions=(one.sensor.positions[some] + noise) @ turn.T, times=one.sensor.times[some]
        )
        truth = replace(one.truth, positions=one.truth.positions[some] @ turn.T, times=one.truth.times[some])
        found.append(Pair(sensor, truth))
        count += sensor.frames
    return found
