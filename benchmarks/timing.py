"""Fair timing on a machine that others use too: runners take turns, and what is compared is compared round by round."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil
from statistics import median

from threadpoolctl import threadpool_limits

from .metric import TOLERANCE, Direction, Metric

LEAST_SECONDS = 0.05  # a runner faster than this is called several times in a row for one timing


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    frames : lengths of the recordings; the last one is the long one.
    rounds : timings of each runner.
    long_rounds : the same for the last length.
    """

    frames: tuple[int, ...] = (1_000, 10_000, 60_452)
    rounds: int = 7
    long_rounds: int = 3

    def rounds_at(self, frames: int) -> int:
        """Timings at this length."""
        return self.long_rounds if frames == self.frames[-1] else self.rounds


@dataclass(frozen=True)
class Times:
    """Seconds of one call, one entry for each round: wall clock and processor."""

    wall: tuple[float, ...]
    cpu: tuple[float, ...]

    def seconds(self, key: str, target: float | None = None) -> Metric:
        """The median wall time as information."""
        return Metric(key, median(self.wall), "s", "info", low=min(self.wall), high=max(self.wall), target=target)

    def rate(self, key: str, amount: float, unit: str, target: float | None = None) -> Metric:
        """`amount` per second of wall clock as information."""
        rates = [amount / seconds for seconds in self.wall]
        return Metric(key, median(rates), unit, "info", low=min(rates), high=max(rates), target=target)

    def cpu_rate(self, key: str, amount: float, unit: str, target: float | None = None) -> Metric:
        """`amount` per second of the processor as information: the rate with the machine to oneself."""
        rates = [amount / seconds for seconds in self.cpu]
        return Metric(key, median(rates), unit, "info", low=min(rates), high=max(rates), target=target)


def race(runners: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, Times]:
    """Time the runners in turn, A B A B, each on one thread of the linear algebra; a first call is thrown away.

    Parameters
    ----------
    runners : by name; each call does the whole work.
    rounds : timings of each.
    """
    wall: dict[str, list[float]] = {name: [] for name in runners}
    cpu: dict[str, list[float]] = {name: [] for name in runners}
    calls: dict[str, int] = {}
    with threadpool_limits(1):
        for run in runners.values():
            run()  # thrown away: kernels are compiled and pages come in
        for _ in range(rounds):
            for name, run in runners.items():
                seconds, worked = _timed(run, calls.get(name, 1))
                if name not in calls:
                    calls[name] = ceil(LEAST_SECONDS / seconds)
                    if calls[name] > 1:
                        seconds, worked = _timed(run, calls[name])
                wall[name].append(seconds)
                cpu[name].append(worked)
    return {name: Times(tuple(wall[name]), tuple(cpu[name])) for name in runners}


def _timed(run: Callable[[], object], calls: int) -> tuple[float, float]:
    """Wall and processor seconds of one call."""
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(calls):
        run()
    return max((time.perf_counter() - wall) / calls, 1e-9), max((time.process_time() - cpu) / calls, 1e-9)


def ratio(
    key: str,
    slow: Times,
    fast: Times,
    direction: Direction = "higher",
    *,
    scale: float = 1.0,
    tolerance: float = TOLERANCE,
    target: float | None = None,
) -> Metric:
    """Processor seconds of `slow` over those of `fast`, times `scale`: the median over the rounds and their range.

    Processor time leaves out the time that other people's work took; dividing within a round leaves out what the
    clock rate and the shared caches did in the meantime.
    """
    found = [scale * a / b for a, b in zip(slow.cpu, fast.cpu, strict=True)]
    return Metric(key, median(found), "x", direction, tolerance, min(found), max(found), target)
