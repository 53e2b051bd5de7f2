"""The likeliest history of every channel: which samples are outliers, and when the motion is calm, bursts or jumps."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...arrays import Bools, Bytes, Floats
from ...numerics.quantiles import quantile_of_known
from ..outliers.poles import bends_of
from .smoothing import VAGUE

HISTORIES = 14  # kept side by side for each channel
# Motion is calm, bursts or jumps: factors on the variance of its second differences, how common each is and how
# likely a burst or jump goes on. Wide on purpose: which factors exactly hardly matters, that there are three does.
FACTORS = np.array([1.0, 25.0, 1000.0])
COMMON = np.array([0.96, 0.035, 0.005])
GOES_ON = 0.7
OUTLIER_SPAN = 80.0  # degrees or cm over which an outlier may lie


def likeliest_histories(
    measured: Floats,
    expected: Floats,
    doubt: Floats,
    pull: Floats,
    step_var: Floats,
    noise_var: Floats,
    rate: Floats,
    follow: float,
    held: float,
    calm: Floats,
    together: int,
    vouched: Bools,
) -> tuple[Bools, Bytes]:
    """Outliers and modes of the likeliest history of every channel or group of channels.

    Parameters
    ----------
    measured : (T, C) in degrees and cm, NaN = missing.
    expected, doubt : (T, C) what the library says, and the variance of its errors.
    pull : (T, C) second difference that the other channels let expect.
    step_var, noise_var : (T, C) variance of second differences when calm, and of the noise.
    rate : (C,) share of outliers.
    follow, held : share of the samples after one that are some as well, and of these that are off by as much.
    calm : (C,) variance of second differences when calm, all others open.
    together : neighbouring columns that are outliers together.
    vouched : (T, C) True where a sample is no outlier.

    Returns
    -------
    (T, C) True where a sample is rejected, and (T, C) which of `FACTORS` the motion has.
    """
    from ...kernels.search import likeliest_history

    channels = measured.shape[1]
    goes_on = np.where(np.arange(len(COMMON)) > 0, GOES_ON, 0.0)[:, None]
    log_modes = np.log(goes_on * np.eye(len(COMMON)) + (1.0 - goes_on) * COMMON)
    known = np.isfinite(measured)
    begin = np.nan_to_num(quantile_of_known(measured, 0.5))
    strays = np.where(known, np.square(measured - begin), 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    density, at_pole = OUTLIER_SPAN**-together, bends_of(vouched)

    def history(first: int) -> tuple[Bytes, Bytes]:
        own = slice(first, first + together)
        return likeliest_history(
            np.ascontiguousarray(measured[:, own]),
            np.ascontiguousarray(expected[:, own]),
            np.ascontiguousarray(doubt[:, own]),
            np.ascontiguousarray(pull[:, own]),
            np.ascontiguousarray(step_var[:, own]),
            np.ascontiguousarray(noise_var[:, own]),
            float(rate[own].mean()),
            max(follow, float(rate[own].mean())),
            density,
            held,
            FACTORS,
            log_modes,
            HISTORIES,
            begin[own],
            VAGUE + strays[own],
            50.0 * calm[own] + 1.0,
            np.ascontiguousarray(vouched[:, own].any(axis=1)),
            np.ascontiguousarray(at_pole[:, own].any(axis=1)),
        )

    found = _in_threads(history, list(range(0, channels, together)))
    outlier = np.stack([o for o, _ in found], axis=1).repeat(together, axis=1).astype(bool)
    mode = np.stack([m for _, m in found], axis=1).repeat(together, axis=1)
    return outlier & known, mode


def _in_threads(task: Callable[[int], tuple[Bytes, Bytes]], items: list[int]) -> list[tuple[Bytes, Bytes]]:
    """The task of every item, in order; the kernels let threads run side by side."""
    first = [task(items[0])]  # compiles it once
    with ThreadPoolExecutor(max_workers=min(4, os.cpu_count() or 1)) as pool:
        return first + list(pool.map(task, items[1:]))


def pulled(values: Floats, calm: Floats, scale: Floats) -> Floats:
    """(T, C) second difference of each channel that those of the others let expect, of values (T, C) with covariance
    `calm` (C, C) times the square of `scale` (T, C)."""
    bend = (values[:-2] - 2.0 * values[1:-1] + values[2:]) / scale[2:]
    precision = np.linalg.inv(calm)
    pull = np.zeros(values.shape)
    pull[2:] = (bend - bend @ precision / np.diag(precision)) * scale[2:]
    return pull
