"""What the scripts beyond the paper share: problems, cells, and the adaptive method on all of them."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

import motionmend as mm
from motionmend.arrays import Bools, Floats

from .common import SPLITS, Split, body, body_error, model_of, motion, reduced

Item = TypeVar("Item")
Result = TypeVar("Result")
Cell = tuple[float, float]  # degrees of noise, share of outliers

NOISES, SHARES = (1.0, 3.0, 5.0), (0.0, 0.05, 0.1, 0.2)
CELLS: tuple[Cell, ...] = tuple(product(NOISES, SHARES))
LONGEST = 150  # frames: of longer clips the middle five seconds are tried
LEVELS = {"68": 1.0, "95": 1.96}  # deviations to either side that hold so many per cent of a normal distribution

OTHER_WALKS = tuple(f"07_{n:02}" for n in range(1, 12))
OTHER_RUNS = tuple(f"16_{n}" for n in (35, 36, 37, 38, 39, 41, 43, 45, 46, 48, 49, 55, 56))
MIXED = (
    *SPLITS["walking"].learn,
    *OTHER_WALKS[:4],
    *OTHER_RUNS[:5],
    *SPLITS["jumping"].learn,
    *SPLITS["dance"].learn[:4],
    *("02_06", "86_01", "14_29", "135_07"),
)
PROBLEMS = {
    "walk, same person": SPLITS["walking"],
    "walk, unseen people": Split(OTHER_WALKS, ("16_32", "02_01", "05_01")),
    "walk, other unseen people": Split(SPLITS["walking"].learn, ("07_01", "02_02", "29_01")),
    "run, same person": SPLITS["running"],
    "run, unseen people": Split(OTHER_RUNS, ("09_09", "02_03", "09_01")),
    "jump, same person": SPLITS["jumping"],
    "dance, same person": SPLITS["dance"],
    "mixed library": Split(MIXED, ("16_32", "09_09", "16_04", "05_13")),
    "mixed library, free motion": Split(MIXED, ("02_05", "135_04", "131_04", "14_33")),
}
ABOUT_PROBLEMS = (
    "Nine problems, each a library and clips held out of it, reduced to 30 fps; of longer clips the middle five "
    "seconds. Free motion: "
    + ", ".join(PROBLEMS["mixed library, free motion"].test)
    + ", of which no take is in the library. Unseen people: nobody tried has a clip in the library."
)


@dataclass(frozen=True)
class Tried:
    """The adaptive repair of one clip in one cell, over body angles.

    Attributes
    ----------
    problem, clip, cell : what was tried.
    error : RMS, degrees.
    found : F1 of the rejected samples against the outliers; NaN without outliers.
    within : share of the errors within the stated 68 and 95 % intervals.
    noise : median over body angles of the noise it found, degrees.
    """

    problem: str
    clip: str
    cell: Cell
    error: float
    found: float
    within: dict[str, float]
    noise: float


def truth_of(mocap: Path, clip: str) -> mm.Motion:
    """A clip held out, as it is tried: at 30 fps, at most five seconds."""
    whole = reduced(motion(mocap, clip))
    first = max(0, (whole.frames - LONGEST) // 2)
    return whole.with_q(whole.q[first : first + LONGEST])


def spoilt(truth: mm.Motion, cell: Cell, seed: int) -> mm.evaluate.Corrupted[mm.Motion]:
    """The clip with the cell's noise and outliers in every channel, and where they are."""
    return mm.corrupt(truth, noise=np.radians(cell[0]), outliers=cell[1], seed=seed)


@cache
def adaptive_tries(mocap: Path) -> tuple[Tried, ...]:
    """The adaptive method on every clip of every problem in every cell; each clip has a draw of its own."""
    found = in_parallel(partial(_tries, mocap), tuple(PROBLEMS))
    return tuple(one for tries in found for one in tries)


def _tries(mocap: Path, problem: str) -> list[Tried]:
    split = PROBLEMS[problem]
    model = model_of(mocap, split.learn)
    found = []
    for seed, clip in enumerate(split.test):
        truth = truth_of(mocap, clip)
        counted = body(truth)
        for cell in CELLS:
            bad = spoilt(truth, cell, seed)
            repaired = model.repair(bad.recording, "adaptive")
            away = angles_off(truth, repaired.recording)
            found.append(
                Tried(
                    problem,
                    clip,
                    cell,
                    body_error(truth, repaired.recording),
                    f1(repaired.origin[:, counted] == mm.Origin.REPAIRED, bad.outlier[:, counted]),
                    within(away[:, counted], np.degrees(repaired.std)[:, counted]),
                    noise_found(repaired, counted),
                )
            )
    return found


def noise_found(repaired: mm.Repaired[mm.Motion], counted: Bools) -> float:
    """Median of the noise that the recording told over the channels that count, degrees; NaN where nothing is told."""
    return float("nan") if repaired.noise is None else float(np.degrees(np.median(repaired.noise[counted])))


def angles_off(truth: mm.Motion, other: mm.Motion) -> Floats:
    """(T, D) how far each angle is off, degrees, modulo a full turn; of translations nothing of meaning."""
    return np.degrees(np.abs((other.q - truth.q + np.pi) % (2 * np.pi) - np.pi))


def f1(found: Bools, real: Bools) -> float:
    """Harmonic mean of precision and recall; NaN when there is nothing to find."""
    return float(2 * (found & real).sum() / (found.sum() + real.sum())) if real.any() else float("nan")


def within(away: Floats, std: Floats) -> dict[str, float]:
    """Share of the errors within the intervals of `LEVELS`, over samples that were not left open."""
    told = np.isfinite(std) & np.isfinite(away)
    return {level: float((away[told] <= times * std[told]).mean()) for level, times in LEVELS.items()}


def in_parallel(task: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """The task of every item, in order, each on one thread of the linear algebra; a process for each core."""
    workers = min(len(items), os.cpu_count() or 1, 8)
    if workers == 1:
        return [_alone(task, item) for item in items]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        return list(pool.map(partial(_alone, task), items))


def _alone(task: Callable[[Item], Result], item: Item) -> Result:
    with threadpool_limits(1, user_api="blas"):
        return task(item)


def geometric_mean(ratios: Sequence[float]) -> float:
    """Of numbers above 0."""
    return float(np.exp(np.log(np.asarray(ratios)).mean()))


def cell_name(cell: Cell) -> str:
    """A cell as tables head it."""
    return f"{cell[0]:g}°, {100 * cell[1]:g} %"
