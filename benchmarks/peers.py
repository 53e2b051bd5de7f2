"""Other people's filters beside ours, where they do comparable work: frames a second, as information only."""

from collections.abc import Callable
from functools import partial
from importlib import import_module

import numpy as np
from scipy.signal import butter, savgol_filter, sosfiltfilt

from motionmend.arrays import Floats
from motionmend.denoise.rivals.classic import CUT_OFF, FILTERS

from . import data
from .metric import Metric
from .timing import Plan, race

KALMAN_CHANNELS = 3  # filterpy works through a recording in Python: a few channels tell its rate


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite: no gaps, 62 channels at 120 Hz."""
    frames = plan.frames[len(plan.frames) // 2]
    fps = 120.0
    noisy = data.channels(data.spoiled(data.motion(frames, fps), gaps=0.0))
    sections = butter(2, CUT_OFF, fs=fps, output="sos")
    runners: dict[str, Callable[[], object]] = {
        f"ours_{name}": partial(way, noisy, fps) for name, way in FILTERS.items()
    }
    runners["scipy_savgol"] = partial(savgol_filter, noisy, 45, 3, axis=0)
    runners["scipy_butterworth"] = partial(sosfiltfilt, sections, noisy, axis=0)
    times = race(runners, plan.rounds)
    found = [times[name].rate(f"peers.{name}.{frames}.rate", frames, "frames/s") for name in runners]
    short = noisy[: min(frames, 1_000)]
    return found + filterpy_walks(short, f"peers.filterpy_kalman.{len(short)}")


def filterpy_walks(noisy: Floats, key: str) -> list[Metric]:
    """A random walk per channel, filtered and smoothed by filterpy where it is installed; its variances are given."""
    try:
        new_filter = import_module("filterpy.kalman").KalmanFilter
    except ImportError:
        return []

    def smooth() -> None:
        for channel in noisy[:, :KALMAN_CHANNELS].T:
            walk = new_filter(dim_x=1, dim_z=1)
            walk.x, walk.F, walk.H = np.array([[channel[0]]]), np.eye(1), np.eye(1)
            walk.P, walk.Q, walk.R = 10.0 * np.eye(1), np.eye(1), np.eye(1)
            means, covariances, _, _ = walk.batch_filter(channel[:, None])
            walk.rts_smoother(means, covariances)

    # frames of all 62 channels: the few that are timed stand for all
    worth = len(noisy) * KALMAN_CHANNELS / noisy.shape[1]
    times = race({"filterpy": smooth}, 3)["filterpy"]
    return [times.rate(f"{key}.rate", worth, "frames/s")]
