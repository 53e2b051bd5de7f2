"""Repair by the method of the paper: the alternation alone, with its deviations, and file channel to file channel."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.motion import Motion
from motionmend.denoise import Denoiser, DenoiserModel
from motionmend.denoise.bases.optimise import PRIOR_WEIGHT, SCALE, Fit, fit_windows, window_starts
from motionmend.denoise.bases.repair import repair_channels
from motionmend.denoise.bases.support import interpolated
from motionmend.kernels.lagged import BLOCK_BYTES, overlap_add, project
from motionmend.numerics.robust import ESTIMATORS
from motionmend.numerics.ssa import Eigenbases

from . import data, memory, twins
from .metric import Metric
from .timing import Plan, Times, race, ratio

TARGET_RATE, TARGET_RATIO = 3000.0, 10.0
NAIVE_FRAMES = 60  # of the reading twin: pure Python loops over windows and bases
MOST_ALTERNATIONS = 200


@dataclass(frozen=True, eq=False)
class Case:
    """A spoiled recording as channels, and what the fit starts from."""

    measured: Floats
    start: Floats
    bases: Eigenbases

    def fit(self) -> Fit:
        """Ours."""
        return fit_windows(self.measured, self.start, self.bases)


def case(frames: int, gaps: float = data.GAPS) -> Case:
    """The performer with noise, outliers and gaps; the performer of the clips that taught, moving differently."""
    bases = data.learned()[1]
    measured = data.channels(data.spoiled(data.motion(frames, seed=data.SEED + 1), gaps=gaps))
    return Case(measured, interpolated(measured, bases.mean.mean(axis=0)), bases)


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite."""
    model = Denoiser(data.WINDOW, data.FPS, data.ENERGY).fit([data.motion(10_000)])
    middle = plan.frames[len(plan.frames) // 2]
    found: list[Metric] = []
    alone, whole = [], []
    for frames in plan.frames:
        spoiled = case(frames)
        fit = spoiled.fit()
        times = _times(model, spoiled, fit, plan.rounds_at(frames))
        found += _at_length(frames, fit, times)
        alone.append(median(times["ours"].cpu) / (fit.iterations + 1))
        whole.append(median(times["whole"].cpu))
    found += [
        Metric("repair.alternation.exponent", exponent(plan.frames, alone), "", "lower", 0.2),
        Metric("repair.whole.exponent", exponent(plan.frames, whole), "", "lower", 0.2),
    ]
    for frames in plan.frames[:-1]:  # the long one would take minutes, and its ratio per iteration is measured
        found += _same_cost(case(frames), 2)
    found += _against_loops()
    found += _parts(model, middle, plan.rounds)
    found += _limit(case(middle), plan.rounds)
    found += _memory(plan.frames[-1])
    return found + _real()


def _times(model: DenoiserModel, spoiled: Case, fit: Fit, rounds: int) -> dict[str, Times]:
    """Our alternation, plain NumPy with as many iterations, and all of `DenoiserModel.repair`, in turn."""
    measured, start, bases, iterations = spoiled.measured, spoiled.start, spoiled.bases, fit.iterations
    if fit.cost[-1] > twins.cost(twins.alternate(measured, start, bases, iterations), measured, bases) * (1 + 1e-9):
        raise AssertionError("repair.alternation: the plain one ends below our cost, it does not do the same work")
    recording = data.spoiled(data.motion(len(measured), seed=data.SEED + 1))
    runners: dict[str, Callable[[], object]] = {
        "ours": spoiled.fit,
        "plain": lambda: twins.alternate(measured, start, bases, iterations),
        "whole": lambda: model.repair(recording, "paper"),
    }
    return race(runners, rounds)


def _at_length(frames: int, fit: Fit, times: Mapping[str, Times]) -> list[Metric]:
    """Channels, alternation, deviations and back is the whole; the alternation is most of it."""
    key, whole = f"repair.alternation.{frames}", f"repair.whole.{frames}"
    return [
        ratio(f"{key}.plain_over_ours", times["plain"], times["ours"], target=TARGET_RATIO),
        times["ours"].seconds(f"{key}.ours"),
        times["plain"].seconds(f"{key}.plain"),
        times["ours"].rate(f"{key}.rate", frames, "frames/s"),
        Metric(f"{key}.iterations", fit.iterations, "iterations", "info"),
        times["whole"].rate(f"{whole}.rate", frames, "frames/s", TARGET_RATE),
        times["whole"].cpu_rate(f"{whole}.cpu_rate", frames, "frames/CPU s", TARGET_RATE),
        times["whole"].seconds(f"{whole}.ours"),
        ratio(f"{whole}.over_alternation", times["whole"], times["ours"], "lower"),
    ]


def _same_cost(spoiled: Case, rounds: int) -> list[Metric]:
    """Against plain alternation that goes on until its cost is ours."""
    key = f"repair.same_cost.{len(spoiled.measured)}"
    fit = spoiled.fit()
    needed = twins.iterations_to(float(fit.cost[-1]), spoiled.measured, spoiled.start, spoiled.bases, MOST_ALTERNATIONS)
    times = race(
        {
            "ours": spoiled.fit,
            "plain": lambda: twins.alternate(spoiled.measured, spoiled.start, spoiled.bases, needed),
        },
        rounds,
    )
    return [
        ratio(f"{key}.plain_over_ours", times["plain"], times["ours"], target=TARGET_RATIO),
        Metric(f"{key}.iterations_ours", fit.iterations, "iterations", "info"),
        Metric(f"{key}.iterations_plain", needed, "iterations", "info"),
    ]


def _against_loops() -> list[Metric]:
    """Against the twin that the tests read: Python loops over windows and bases."""
    spoiled = case(NAIVE_FRAMES)
    bases, loops = spoiled.bases, twins.of_tests()
    fit = spoiled.fit()
    starts = window_starts(NAIVE_FRAMES, bases.window, 1)
    weight = ESTIMATORS["welsch"].weight

    def by_loops() -> Floats:
        z = loops.alternate(
            spoiled.measured,
            spoiled.start,
            bases.mean,
            bases.vectors,
            starts,
            weight,
            SCALE,
            PRIOR_WEIGHT,
            fit.iterations,
        )
        return np.asarray(z)

    plain = twins.alternate(spoiled.measured, spoiled.start, bases, fit.iterations)
    if not np.allclose(by_loops(), plain, rtol=0.0, atol=1e-8):
        raise AssertionError("repair.loops: the two plain alternations disagree")
    times = race({"ours": spoiled.fit, "loops": by_loops}, 3)
    key = f"repair.loops.{NAIVE_FRAMES}.loops_over_ours"
    return [ratio(key, times["loops"], times["ours"], target=TARGET_RATIO)]


def _parts(model: DenoiserModel, frames: int, rounds: int) -> list[Metric]:
    """Where the time of a whole repair goes, and what gaps and a higher rate cost."""
    gappy, gapless = case(frames), case(frames, gaps=0.0)
    fast = data.spoiled(data.motion(frames, fps=120.0, seed=data.SEED + 1))
    fps = data.FPS
    times = race(
        {
            "alternation": gappy.fit,
            "gappy": lambda: repair_channels(gappy.measured, gappy.bases, fps, fps, "welsch"),
            "gapless": lambda: repair_channels(gapless.measured, gapless.bases, fps, fps, "welsch"),
            "fast": lambda: model.repair(fast, "paper"),
        },
        rounds,
    )
    return [
        ratio(f"repair.deviations.{frames}.over_alternation", times["gappy"], times["alternation"], "lower"),
        times["gappy"].rate(f"repair.channels.{frames}.rate", frames, "frames/s"),
        times["gapless"].rate(f"repair.channels_without_gaps.{frames}.rate", frames, "frames/s"),
        times["fast"].rate(f"repair.whole_at_120_hz.{frames}.rate", frames, "frames/s"),
    ]


def _limit(spoiled: Case, rounds: int) -> list[Metric]:
    """How near the products come to what the machine's matrix product does, and what share of the time they take."""
    frames, channels = spoiled.measured.shape
    bases = spoiled.bases
    count, size = bases.count, bases.window * channels
    vectors, series = np.ascontiguousarray(bases.vectors), spoiled.start
    starts = window_starts(frames, bases.window, 1)
    coefficients = project(series, vectors, starts)
    rows = max(1, BLOCK_BYTES // (8 * size))
    rng = np.random.default_rng(data.SEED)
    block, flat = rng.standard_normal((rows, size)), rng.standard_normal((size, count))
    short = rng.standard_normal((rows, count))
    large = rng.standard_normal((1500, 1500))
    times = race(
        {
            "fit": spoiled.fit,
            "project": lambda: project(series, vectors, starts),
            "overlap_add": lambda: overlap_add(coefficients, vectors, starts, frames),
            "gemm_project": lambda: block @ flat,
            "gemm_overlap_add": lambda: short @ flat.T,
            "gemm_large": lambda: large @ large,
        },
        rounds,
    )
    products = 2.0 * len(starts) * size * count  # of one call of either kernel; a multiply and an add
    at_block = 2.0 * rows * size * count
    both = _sum(times["project"], times["overlap_add"])
    gemms = _sum(times["gemm_project"], times["gemm_overlap_add"])
    calls = spoiled.fit().iterations + 1  # of each kernel; the sum of the mean windows is not counted
    inside = _scaled(both, calls)
    return [
        ratio("repair.limit.kernels_over_block_products", gemms, both, scale=products / at_block),
        ratio("repair.limit.products_in_fit", inside, times["fit"], "info"),
        _gflops("repair.limit.project", times["project"], products),
        _gflops("repair.limit.overlap_add", times["overlap_add"], products),
        _gflops("repair.limit.fit", times["fit"], 2 * products * calls),
        _gflops("repair.limit.dgemm_as_project", times["gemm_project"], at_block),
        _gflops("repair.limit.dgemm_as_overlap_add", times["gemm_overlap_add"], at_block),
        _gflops("repair.limit.dgemm_large", times["gemm_large"], 2.0 * 1500**3),
        Metric("repair.limit.flops_per_frame", 2 * products * calls / frames / 1e6, "Mflop", "info"),
    ]


def _gflops(key: str, times: Times, flops: float) -> Metric:
    return times.cpu_rate(key, flops / 1e9, "GFLOP/s")


def _sum(one: Times, other: Times) -> Times:
    wall = tuple(a + b for a, b in zip(one.wall, other.wall, strict=True))
    return Times(wall, tuple(a + b for a, b in zip(one.cpu, other.cpu, strict=True)))


def _scaled(times: Times, factor: float) -> Times:
    return Times(tuple(factor * t for t in times.wall), tuple(factor * t for t in times.cpu))


def exponent(frames: tuple[int, ...], seconds: list[float]) -> float:
    """Slope of log time over log frames: 1 when cost is linear."""
    return float(np.polyfit(np.log(frames), np.log(seconds), 1)[0])


def _memory(frames: int) -> list[Metric]:
    spoiled = case(frames)
    plain = memory.measure("repair-plain", spoiled.measured, spoiled.bases)
    return [
        *memory.measure("repair", spoiled.measured, spoiled.bases).metrics(f"repair.memory.channels.{frames}"),
        Metric(f"repair.memory.plain.{frames}.peak", plain.after / memory.MB, "MB", "info"),
    ]


def _real() -> list[Metric]:
    """A real walk, spoiled, by a model of the same person's other walks; as information."""
    folder = data.real_folder()
    clips: list[Motion] = data.real_clips(folder) if folder else []
    if len(clips) < 2:
        return []
    model = Denoiser(data.WINDOW, data.FPS, data.ENERGY).fit(clips[:-1])
    walk = data.spoiled(clips[-1])
    times = race({"ours": lambda: model.repair(walk, "paper")}, 5)["ours"]
    return [times.rate(f"repair.real.{walk.frames}.rate", walk.frames, "frames/s", TARGET_RATE)]
