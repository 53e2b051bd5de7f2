"""Whittaker's smoother: the smooth curve nearest to weighted samples."""

import numpy as np
from scipy.linalg import solveh_banded

from ..arrays import Floats

LEAST_WEIGHT = 1e-12  # of the largest; keeps stretches without any sample determined (straight lines)


def whittaker(values: Floats, weights: Floats, smoothness: float) -> Floats:
    """Minimise  sum_t w_t |y_t - z_t|² + smoothness · sum_t |z_{t+1} - 2 z_t + z_{t-1}|².

    Parameters
    ----------
    values : (T, C) y; read only where the weight is above 0.
    weights : (T,) at least 0, the same for all channels; at least two above 0.
    smoothness : above 0; half of a sine of f cycles a frame passes when it is (2 sin(pi f))^-4 / w.

    Returns
    -------
    (T, C) z; straight lines between and beyond samples where there are none.

    Source
    ------
    Whittaker 1923, "On a new method of graduation"; Eilers 2003, "A perfect smoother".
    """
    frames = len(values)
    known = np.where((weights > 0)[:, None], values, 0.0)
    diagonal = np.zeros(frames)
    beside, beyond = np.zeros(frames), np.zeros(frames)
    if frames > 2:
        diagonal[:-2] += 1.0
        diagonal[1:-1] += 4.0
        diagonal[2:] += 1.0
        beside[1:-1] -= 2.0
        beside[2:] -= 2.0
        beyond[2:] = 1.0
    # without its straight line a long stretch without samples comes back as exact zeros, not as rounding errors
    time = np.stack([np.ones(frames), np.arange(frames) - frames / 2.0], axis=1)
    share = np.sqrt(weights)[:, None]
    line = time @ np.linalg.lstsq(share * time, share * known, rcond=None)[0]
    ridge = LEAST_WEIGHT * float(weights.max(initial=1.0))
    bands = np.stack([smoothness * beyond, smoothness * beside, smoothness * diagonal + weights + ridge])
    bent = solveh_banded(bands, weights[:, None] * (known - line), check_finite=False)
    return np.asarray(line + bent)


def response(smoothness: float) -> Floats:
    """(512,) share of a sine that passes `whittaker` of weights 1, by its frequency from 0 to 1/2 cycle a frame.

    Their mean is the share of a sample that comes of itself, the mean of their squares that of white noise's variance.

    Parameters
    ----------
    smoothness : as of `whittaker`.
    """
    # in the middle of each interval: slow sines count no more than others
    return passed(smoothness, (np.arange(512) + 0.5) * np.pi / 512)


def passed(smoothness: float, angles: Floats) -> Floats:
    """Share of a sine that passes `whittaker` of weights 1, away from the ends.

    Parameters
    ----------
    smoothness : as of `whittaker`.
    angles : of any shape, radians a frame that the sine goes on by.

    Returns
    -------
    Of the angles' shape.
    """
    return np.asarray(1.0 / (1.0 + smoothness * (2.0 - 2.0 * np.cos(angles)) ** 2))
