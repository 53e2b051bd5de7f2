"""The adaptive repair: frames a second, what frames, channels, window and bases cost, its kernels, its memory."""

from dataclasses import replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from scipy.signal import butter, savgol_filter, sosfiltfilt

from motionmend.bodies.motion import Motion
from motionmend.denoise import Denoiser, DenoiserModel
from motionmend.denoise.rivals.classic import CUT_OFF
from motionmend.kernels.banded import walk_certainty
from motionmend.kernels.search import RECENT, likeliest_history

from . import data, memory, twins
from .metric import Metric
from .peers import filterpy_walks
from .repair import exponent
from .timing import Plan, Times, race, ratio

MOST_FRAMES = 10_000  # of the long recording: some twenty seconds of work
SWEPT_FRAMES = 400
TAUGHT, TAUGHT_SWEPT = 10_000, 3_000  # frames that teach a model
WINDOWS, ENERGIES, CHANNELS = (10, 20, 40), (0.9, 0.99, 0.999), (16, 32, 62)
ROUNDS = 3
RATE = 1_000.0  # frames/s of 62 channels, wanted of two cores
SEARCH_FRAMES, CERTAIN_FRAMES, WIDTH = 40, 60, 14


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite."""
    model = learned()
    lengths = sorted({min(frames, MOST_FRAMES) for frames in plan.frames})
    found: list[Metric] = []
    alone = []
    for frames in lengths:
        spoiled = data.spoiled(data.motion(frames, seed=data.SEED + 1))
        times = race(
            {"ours": partial(model.repair, spoiled, "adaptive"), "paper": partial(model.repair, spoiled, "paper")},
            ROUNDS if frames < MOST_FRAMES else 1,
        )
        key = f"adaptive.whole.{frames}"
        found += [
            ratio(f"{key}.over_paper", times["ours"], times["paper"], "lower"),
            times["ours"].seconds(f"{key}.ours"),
            times["ours"].rate(f"{key}.rate", frames, "frames/s", RATE),
            times["ours"].cpu_rate(f"{key}.cpu_rate", frames, "frames/CPU s"),
        ]
        alone.append(median(times["ours"].cpu))
    found.append(Metric("adaptive.whole.exponent", exponent(tuple(lengths), alone), "", "lower", 0.2))
    found += _fast(model, min(2_000, lengths[-1]))
    found += _swept(min(SWEPT_FRAMES, lengths[-1]))
    found += _against_peers(model, lengths[0])
    found += _kernels()
    found += memory.measure_adaptive(lengths[-1], model).metrics(f"adaptive.memory.{lengths[-1]}")
    return found


def learned(window: int = data.WINDOW, energy: float = data.ENERGY, channels: int | None = None) -> DenoiserModel:
    """A model of the performer; those of another window, energy or number of channels learn from less."""
    frames = TAUGHT if (window, energy, channels) == (data.WINDOW, data.ENERGY, None) else TAUGHT_SWEPT
    return Denoiser(window, data.FPS, energy).fit([_with_channels(data.motion(frames), channels)])


def _with_channels(motion: Motion, channels: int | None) -> Motion:
    """The performer with only the first degrees of freedom: the other joints are stiff."""
    if channels is None:
        return motion
    body = motion.skeleton
    stiff = replace(
        body,
        dof_names=body.dof_names[:channels],
        dof_joint=body.dof_joint[:channels],
        dof_axis=body.dof_axis[:channels],
        dof_kind=body.dof_kind[:channels],
        limits=body.limits[:channels],
    )
    return Motion(stiff, motion.q[:, :channels], motion.fps)


def _fast(model: DenoiserModel, frames: int) -> list[Metric]:
    """At 120 Hz, by frame dearer than at 30 Hz or not."""
    fast = data.spoiled(data.motion(frames, fps=120.0, seed=data.SEED + 1))
    slow = data.spoiled(data.motion(frames, seed=data.SEED + 1))
    times = race({"fast": partial(model.repair, fast, "adaptive"), "slow": partial(model.repair, slow, "adaptive")}, 2)
    return [
        times["fast"].rate(f"adaptive.at_120_hz.{frames}.rate", frames, "frames/s"),
        ratio(f"adaptive.at_120_hz.{frames}.over_30_hz", times["fast"], times["slow"], "lower"),
    ]


def _swept(frames: int) -> list[Metric]:
    """Seconds by window, number of bases and channels, and the dearest over the cheapest."""
    found: list[Metric] = []
    sweeps: dict[str, dict[str, DenoiserModel]] = {
        "window": {str(window): learned(window=window) for window in WINDOWS},
        "bases": {},
        "channels": {str(count): learned(channels=count) for count in CHANNELS},
    }
    for energy in ENERGIES:
        model = learned(energy=energy)
        sweeps["bases"][str(model.bases.count)] = model
    clean = data.motion(frames, seed=data.SEED + 1)
    for name, models in sweeps.items():
        spoilt = {
            size: data.spoiled(_with_channels(clean, int(size) if name == "channels" else None)) for size in models
        }
        runners = {size: partial(model.repair, spoilt[size], "adaptive") for size, model in models.items()}
        times = race(runners, 2)
        found += [times[size].seconds(f"adaptive.by_{name}.{size}.ours") for size in models]
        first, *_, last = times.values()
        found.append(ratio(f"adaptive.by_{name}.most_over_least", last, first, "lower"))
    return found


def _against_peers(model: DenoiserModel, frames: int) -> list[Metric]:
    """Filters and smoothers that look at a channel at a time, on the same recording; as information."""
    spoiled = data.spoiled(data.motion(frames, seed=data.SEED + 1), gaps=0.0)
    values = data.channels(spoiled)
    sections = butter(2, CUT_OFF, fs=data.FPS, output="sos")
    times = race(
        {
            "ours": partial(model.repair, spoiled, "adaptive"),
            "kalman_data": partial(model.repair, spoiled, "kalman-data"),
            "scipy_savgol": partial(savgol_filter, values, 11, 3, axis=0),
            "scipy_butterworth": partial(sosfiltfilt, sections, values, axis=0),
        },
        1,
    )
    key = f"adaptive.peers.{frames}"
    found = [times[name].rate(f"{key}.{name}.rate", frames, "frames/s") for name in times]
    return found + filterpy_walks(values, f"{key}.filterpy")


def _kernels() -> list[Metric]:
    """The search and the certainty of walks against the tests' reading twins, once both say the same."""
    loops = twins.of_tests()
    case = search_case(SEARCH_FRAMES)
    outlier, _ = likeliest_history(*case.values())
    if not np.array_equal(outlier.astype(bool), loops.beam_of_histories(case, WIDTH, RECENT)[2]):
        raise AssertionError("adaptive.search: the kernel and its twin reject different samples")
    rng = np.random.default_rng(data.SEED)
    weight, steps = rng.uniform(0.2, 2.0, (CERTAIN_FRAMES, 1)), rng.uniform(0.1, 1.0, (CERTAIN_FRAMES, 1))
    wide = np.full(1, 25.0)

    def by_loops() -> Any:
        return loops.walk_certainty(weight[:, 0], steps[:, 0], 25.0, 25.0)

    if not np.allclose(walk_certainty(weight, steps, wide, wide)[0][:, 0], by_loops()[0], rtol=0.0, atol=1e-4):
        raise AssertionError("adaptive.certainty: the kernel and its twin disagree")
    times: dict[str, Times] = race(
        {
            "search": lambda: likeliest_history(*case.values()),
            "search_loops": lambda: loops.beam_of_histories(case, WIDTH, RECENT),
            "certainty": lambda: walk_certainty(weight, steps, wide, wide),
            "certainty_loops": by_loops,
        },
        ROUNDS,
    )
    return [
        ratio(f"adaptive.search.{SEARCH_FRAMES}.loops_over_ours", times["search_loops"], times["search"]),
        times["search"].rate(f"adaptive.search.{SEARCH_FRAMES}.rate", SEARCH_FRAMES, "frames/s"),
        ratio(f"adaptive.certainty.{CERTAIN_FRAMES}.dense_over_ours", times["certainty_loops"], times["certainty"]),
    ]


def search_case(frames: int) -> dict[str, Any]:
    """One channel of a smooth walk with outliers, and everything the search asks, in the kernel's order."""
    rng = np.random.default_rng(data.SEED)
    shape = frames, 1
    truth = np.cumsum(np.cumsum(0.3 * rng.standard_normal(shape), axis=0), axis=0)
    observed = truth + rng.standard_normal(shape)
    observed += (rng.random(shape) < 0.15) * rng.choice([-1.0, 1.0], shape) * rng.uniform(15, 40, shape)
    modes = np.full((3, 3), 0.1) + 0.7 * np.eye(3)
    return {
        "observed": observed,
        "hint": truth,
        "hint_var": np.full(shape, 9.0),
        "pull": np.zeros(shape),
        "step_var": np.full(shape, 0.09),
        "noise_var": np.ones(shape),
        "outlier_rate": 0.15,
        "outlier_follow": 0.15,
        "outlier_density": 1 / 80.0,
        "outlier_held": 0.3,
        "factors": np.array([1.0, 25.0, 1000.0]),
        "log_modes": np.log(modes),
        "width": WIDTH,
        "start": observed[0].copy(),
        "start_var": np.full(1, 400.0),
        "speed_var": np.full(1, 4.0),
        "vouched": np.zeros(frames, dtype=bool),
        "at_pole": np.zeros(frames, dtype=bool),
    }
