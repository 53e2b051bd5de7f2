"""Peak memory of one piece of work, in a process of its own: `python -m benchmarks.memory TASK FILE.npz`.

The process loads its input, notes its peak, does the work and notes the peak again.
"""

import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from motionmend.arrays import Floats
from motionmend.numerics.ssa import Eigenbases

from .metric import Metric

if TYPE_CHECKING:
    from motionmend.denoise import DenoiserModel

MB = 1e6
_BASES = ("mean", "vectors", "values", "total", "discarded")


@dataclass(frozen=True)
class Peak:
    """Bytes: the process before and after the work, and the input's own size; and the seconds that the work took."""

    before: int
    after: int
    data: int
    seconds: float

    def metrics(self, key: str, target: float | None = None) -> list[Metric]:
        """The whole process's peak in MB as information, and what the work added, in sizes of its input."""
        return [
            Metric(f"{key}.peak", self.after / MB, "MB", "info", target=target),
            Metric(f"{key}.peak_added", (self.after - self.before) / self.data, "inputs", "lower"),
        ]

    def info(self, key: str) -> list[Metric]:
        """The same, never gated."""
        return [replace(metric, direction="info") for metric in self.metrics(key)]


def measure(task: str, data: Floats, bases: Eigenbases | None = None) -> Peak:
    """Peak memory of a task.

    Parameters
    ----------
    task : one of `TASKS`.
    data : (T, 62) channels, or q for the task that takes a motion.
    bases : for the repairs; made here, so that learning them leaves no peak over there.
    """
    return _measured(task, data, {} if bases is None else {name: getattr(bases, name) for name in _BASES})


def measure_adaptive(frames: int, model: "DenoiserModel") -> Peak:
    """Peak memory of the adaptive repair of the performer; the model comes ready made."""
    from .data import SEED, motion, spoiled

    arrays, header = model.to_arrays()
    q = spoiled(motion(frames, seed=SEED + 1)).q
    return _measured("adaptive", q, {**arrays, "header": np.array(json.dumps(header))})


def _measured(task: str, data: Floats, parts: Mapping[str, Any]) -> Peak:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "input.npz"
        np.savez(file, data=data, **parts)
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.memory", task, str(file)],
            cwd=Path(__file__).parents[1],
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        raise RuntimeError(f"measuring the memory of {task} failed: {done.stderr.strip()[-2000:]}")
    found = json.loads(done.stdout)
    return Peak(found["before"], found["after"], data.nbytes, found["seconds"])


def peak() -> int:
    """The most memory this process has held so far, bytes.

    Linux hands the parent's peak down in `getrusage`, so there its own counter is asked.
    """
    status = Path("/proc/self/status")
    if status.exists():
        return 1024 * int(next(line for line in status.read_text().splitlines() if line.startswith("VmHWM")).split()[1])
    if sys.platform == "win32":
        import psutil

        return int(psutil.Process().memory_info().peak_wset)
    from resource import RUSAGE_SELF, getrusage

    return getrusage(RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _learn(given: Mapping[str, Floats]) -> Callable[[], object]:
    from motionmend.bodies.motion import Motion
    from motionmend.denoise import Denoiser

    from .data import ENERGY, FPS, WINDOW, skeleton

    motion = Motion(skeleton(), given["data"], FPS)
    return lambda: Denoiser(WINDOW, FPS, ENERGY).fit([motion])


def _lag(given: Mapping[str, Floats]) -> Callable[[], object]:
    from motionmend.numerics.ssa import lag_covariance

    from .data import WINDOW

    return lambda: lag_covariance(given["data"], WINDOW)


def _lag_plain(given: Mapping[str, Floats]) -> Callable[[], object]:
    from .data import WINDOW
    from .twins import lag_products

    return lambda: lag_products(given["data"], WINDOW)


def _repair(given: Mapping[str, Floats]) -> Callable[[], object]:
    from motionmend.denoise.bases.repair import repair_channels

    from .data import FPS

    bases = _given_bases(given)
    return lambda: repair_channels(given["data"], bases, FPS, FPS, "welsch")


def _repair_plain(given: Mapping[str, Floats]) -> Callable[[], object]:
    from motionmend.denoise.bases.support import interpolated

    from .twins import alternate

    bases = _given_bases(given)
    return lambda: alternate(given["data"], interpolated(given["data"], bases.mean.mean(axis=0)), bases, 2)


def _adaptive(given: Mapping[str, Floats]) -> Callable[[], object]:
    from motionmend.bodies.motion import Motion
    from motionmend.denoise import DenoiserModel

    from .data import FPS, skeleton

    model = DenoiserModel.from_arrays(given, json.loads(str(given["header"])))
    motion = Motion(skeleton(), given["data"], FPS)
    return lambda: model.repair(motion, "adaptive")


def _given_bases(given: Mapping[str, Floats]) -> Eigenbases:
    return Eigenbases(given["mean"], given["vectors"], given["values"], float(given["total"]), given["discarded"])


TASKS: Mapping[str, Callable[[Mapping[str, Floats]], Callable[[], object]]] = {
    "learn": _learn,
    "lag": _lag,
    "lag-plain": _lag_plain,
    "repair": _repair,
    "repair-plain": _repair_plain,
    "adaptive": _adaptive,
}

if __name__ == "__main__":
    with threadpool_limits(1):
        work = TASKS[sys.argv[1]](dict(np.load(sys.argv[2])))
        before, begin = peak(), perf_counter()
        work()
        print(json.dumps({"before": before, "after": peak(), "seconds": perf_counter() - begin}))
