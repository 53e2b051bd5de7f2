"""Correction live: the server in processes of its own, a crowd of clients here, every frame timed there and back."""

import asyncio
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, thread_time

import numpy as np
import psutil
from threadpoolctl import threadpool_limits
from websockets.asyncio.client import connect

from motionmend import samples
from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT20, correspondence
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import positions
from motionmend.correct import Corrector, CorrectorModel, Pair
from motionmend.live.messages import Frame, Hello, encode_frame, encode_hello, read_answer
from motionmend.models import save_model

from .metric import Metric
from .timing import Plan

FPS = 30.0
SECONDS, WARM = 12.0, 2.0  # of each crowd; the first seconds are not counted
CROWDS = {1: None, 20: 0.015, 100: 0.040}  # clients, and the round trip in s that 99 of 100 frames should not exceed
STRANGERS = 8  # who stand before the corrector one after the other, when it is timed alone
PATIENCE = 3.0  # s for the last answers


@dataclass(frozen=True, eq=False)
class Crowd:
    """What a crowd of clients saw: round trips in s, frames without an answer, processor seconds of the server for a
    frame that is answered, and of the crowd itself, which shares the machine with it, for a frame that is sent."""

    round_trip: Floats
    lost: int
    processor: float
    own: float

    def metrics(self, clients: int) -> list[Metric]:
        """As information: absolute times are never gated."""
        key = f"live.{clients}"
        p50, p95, p99 = np.percentile(self.round_trip, (50, 95, 99)).tolist()
        return [
            Metric(f"{key}.round_trip.p50", p50, "s", "info"),
            Metric(f"{key}.round_trip.p95", p95, "s", "info"),
            Metric(f"{key}.round_trip.p99", p99, "s", "info", target=CROWDS.get(clients)),
            Metric(f"{key}.lost", self.lost, "frames", "info"),
            Metric(f"{key}.processor_per_frame", self.processor, "s", "info"),
            Metric(f"{key}.cores", self.processor * FPS * clients, "cores", "info"),
            Metric(f"{key}.clients_per_frame", self.own, "s", "info"),
        ]


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite: each crowd against a server of its own."""
    found: list[Metric] = []
    with TemporaryDirectory() as folder:
        model = Path(folder) / "sensor.mend"
        taken = _recordings()
        corrector = Corrector().fit(taken)
        found += steps_alone(corrector, taken[0].sensor)
        save_model(model, corrector)
        frames = [pair.sensor.positions for pair in taken]
        for clients in CROWDS:
            with serving(model) as (process, url):
                crowd = asyncio.run(crowded(url, frames, clients, process))
            found += crowd.metrics(clients)
    return found


def steps_alone(model: CorrectorModel, sensor: Postures) -> list[Metric]:
    """Processor seconds of the corrector's own step: the rest of a frame is the server's. And how much longer the frame
    takes in which somebody else stands there, who is met as a stranger: all clients of a crowd that plays a recording
    again and again leap at once."""
    state, rows = model.start(sensor.names), []
    with threadpool_limits(1):
        for k in range(STRANGERS * sensor.frames):
            person, at = divmod(k, sensor.frames)
            aside = np.array([3.0 * (person % 2), 0.0, 0.0])
            start = thread_time()
            state, _ = model.step(state, sensor.positions[at] + aside, None, k / FPS)
            rows.append(thread_time() - start)
    spent = np.array(rows).reshape(STRANGERS, -1)[1:]
    low, middle, high = np.percentile(spent[:, 1:], (5, 50, 95)).tolist()
    met = spent[:, 0] / middle
    stranger = Metric("live.stranger_by_step", float(np.median(met)), "x", "lower", low=met.min(), high=met.max())
    return [Metric("live.step", middle, "s", "info", low=low, high=high), stranger]


def _recordings() -> list[Pair]:
    """The synthetic performer as a sensor with a bias and noise sees it, and as it was; 30 Hz."""
    pairs = []
    for seed, action in enumerate(("walk", "reach", "jump", "turn")):
        clip = samples.clip(action, seconds=5.0, seed=seed)
        joints = correspondence(clip.skeleton.names, KINECT20.names)
        truth = positions(clip.skeleton, clip.q)[:: round(clip.fps / FPS), joints]
        noise = np.random.default_rng(seed).normal(0.0, 0.005, truth.shape)
        sensor = truth + 0.04 * np.sin(np.arange(60.0)).reshape(20, 3) + noise
        times, state = np.arange(len(truth)) / FPS, np.full(truth.shape[:2], 2, np.uint8)
        pairs.append(Pair(Postures(KINECT20.names, sensor, times, state=state), Postures(KINECT20.names, truth, times)))
    return pairs


@contextmanager
def serving(model: Path) -> Iterator[tuple[psutil.Process, str]]:
    """`motionmend serve` as its users start it, on a free port."""
    command = [sys.executable, "-m", "motionmend", "serve", "-m", str(model), "--listen", "ws://127.0.0.1:0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            for line in process.stderr:
                if found := re.search(r"ws://\S+", line):
                    yield psutil.Process(process.pid), found[0]
                    break
        finally:
            process.terminate()
            process.wait(30)


async def crowded(url: str, recordings: list[Floats], clients: int, server: psutil.Process) -> Crowd:
    """Clients at 30 Hz, each with a phase of its own, for some seconds."""
    count = round(SECONDS * FPS)
    at, back = np.full((clients, count), np.nan), np.full((clients, count), np.nan)
    before, own, start = _processor(server), process_time(), perf_counter() + 1.0
    await asyncio.gather(
        *(
            _client(url, recordings[k % len(recordings)], start + k / clients / FPS, at[k], back[k])
            for k in range(clients)
        )
    )
    processor, own = _processor(server) - before, process_time() - own
    took = (back - at)[:, round(WARM * FPS) :]
    answered = int(np.isfinite(back).sum())
    return Crowd(took[np.isfinite(took)], back.size - answered, processor / max(1, answered), own / back.size)


async def _client(url: str, recording: Floats, start: float, at: Floats, back: Floats) -> None:
    """One client: frames of a recording round and round, `at` when sent and `back` when answered."""
    state = np.full(len(KINECT20.names), 2, np.uint8)
    async with connect(url, compression=None, max_queue=None) as connection:
        await connection.send(encode_hello(Hello(KINECT20.key, KINECT20.names, FPS)))

        async def hear() -> None:
            for _ in range(len(at)):
                answer = read_answer(await connection.recv(), len(state))
                back[answer.seq] = perf_counter()

        hearing = asyncio.create_task(hear())
        for k in range(len(at)):
            message = encode_frame(Frame(k, k / FPS, recording[k % len(recording)], state, "msgpack"))
            await asyncio.sleep(max(0.0, start + k / FPS - perf_counter()))
            at[k] = perf_counter()
            await connection.send(message)
        await asyncio.wait({hearing}, timeout=PATIENCE)
        hearing.cancel()


def _processor(process: psutil.Process) -> float:
    """Processor seconds of a process and those it started."""
    every = [process, *process.children(recursive=True)]
    return sum(one.cpu_times().user + one.cpu_times().system for one in every)
