"""Learning: the lag covariance, its eigenvectors, and all of `Denoiser.fit`."""

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.motion import Motion
from motionmend.denoise import Denoiser
from motionmend.kernels import lagged
from motionmend.numerics.ssa import eigenbases, lag_covariance

from . import data, memory, twins
from .metric import Metric
from .timing import Plan, race, ratio

PAPER_FRAMES = 2_000  # the dissertation learns from so many in two minutes (section 2.2.1)


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite."""
    found: list[Metric] = []
    for frames in plan.frames:
        clean = data.motion(frames)
        series = data.channels(clean)
        found += _lag(series, plan.rounds_at(frames), target=5.0 if frames == plan.frames[-1] else None)
        found += _eigenvectors(series, plan.rounds_at(frames))
        found += _whole(f"fit.whole.{frames}", clean, 3)
    found += _whole("fit.whole.2000", data.motion(PAPER_FRAMES), 3, target=120.0)
    found += _memory(plan.frames[-1])
    return found + _real()


def _lag(series: Floats, rounds: int, target: float | None) -> list[Metric]:
    key = f"fit.lag_products.{len(series)}"
    ours = lagged.lag_products([series[:500]], data.WINDOW)
    if not np.allclose(ours, twins.lag_products(series[:500], data.WINDOW), rtol=1e-9, atol=1e-6):
        raise AssertionError(f"{key}: ours and the plain product disagree, their times cannot be compared")
    times = race(
        {
            "ours": lambda: lagged.lag_products([series], data.WINDOW),
            "covariance": lambda: lag_covariance(series, data.WINDOW),
            "plain": lambda: twins.lag_products(series, data.WINDOW),
        },
        rounds,
    )
    return [
        ratio(f"{key}.plain_over_ours", times["plain"], times["ours"], target=target),
        ratio(f"fit.lag_covariance.{len(series)}.over_products", times["covariance"], times["ours"], "lower"),
        times["ours"].seconds(f"{key}.ours"),
        times["plain"].seconds(f"{key}.plain"),
        times["covariance"].seconds(f"fit.lag_covariance.{len(series)}.ours"),
    ]


def _eigenvectors(series: Floats, rounds: int) -> list[Metric]:
    from scipy.sparse.linalg import eigsh

    covariance = lag_covariance(series, data.WINDOW)
    matrix = covariance.matrix()
    bases = eigenbases(covariance, data.ENERGY)
    times = race(
        {
            "ours": lambda: eigenbases(covariance, data.ENERGY),
            "plain": lambda: twins.leading(covariance.matrix(), data.ENERGY),
            "lanczos": lambda: eigsh(covariance.matrix(), k=bases.count, which="LA", v0=np.ones(len(matrix))),
        },
        rounds,
    )
    key = f"fit.eigenbases.{len(series)}"
    return [
        ratio(f"{key}.plain_over_ours", times["plain"], times["ours"]),
        ratio(f"{key}.lanczos_over_ours", times["lanczos"], times["ours"], "info"),
        times["ours"].seconds(f"{key}.ours"),
        times["plain"].seconds(f"{key}.plain"),
        Metric(f"{key}.count", bases.count, "bases", "info"),
    ]


def _whole(key: str, clean: Motion, rounds: int, target: float | None = None) -> list[Metric]:
    denoiser = Denoiser(data.WINDOW, data.FPS, data.ENERGY)
    times = race({"ours": lambda: denoiser.fit([clean])}, rounds)["ours"]
    return [times.seconds(f"{key}.ours", target), times.rate(f"{key}.rate", clean.frames, "frames/s")]


def _memory(frames: int) -> list[Metric]:
    clean = data.motion(frames)
    series = data.channels(clean)
    return [
        *memory.measure("learn", clean.q).metrics(f"fit.memory.whole.{frames}", target=1000.0),
        *memory.measure("lag", series).metrics(f"fit.memory.lag_covariance.{frames}"),
        Metric(f"fit.memory.plain.{frames}.peak", memory.measure("lag-plain", series).after / memory.MB, "MB", "info"),
    ]


def _real() -> list[Metric]:
    """The same on real joint angles, as information: not every machine has them."""
    folder = data.real_folder()
    clips = data.real_clips(folder) if folder else []
    if not clips:
        return []
    denoiser = Denoiser(data.WINDOW, data.FPS, data.ENERGY)
    times = race({"ours": lambda: denoiser.fit(clips)}, 3)["ours"]
    frames = sum(clip.frames for clip in clips)
    return [
        times.seconds(f"fit.real.{frames}.ours"),
        times.rate(f"fit.real.{frames}.rate", frames, "frames/s"),
        Metric(f"fit.real.{frames}.count", denoiser.fit(clips).bases.count, "bases", "info"),
    ]
