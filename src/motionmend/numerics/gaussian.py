"""Smoothing by a Gaussian that may be wide: by Fourier transforms, whose cost does not grow with its width."""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ..arrays import Floats

REACH = 4.0  # widths on either side


def gaussian_smooth(values: Floats, width: float) -> Floats:
    """Values (T, C) averaged over the frames about each by a Gaussian; before the first and after the last frame stand
    the first and the last.

    As `scipy.ndimage.gaussian_filter1d` with mode nearest, to rounding relative to a channel's largest value.

    Parameters
    ----------
    values : (T, C), finite; of single precision they stay so.
    width : standard deviation, frames, above 0.
    """
    reach = int(REACH * width + 0.5)
    bell = np.exp(-0.5 * np.square(np.arange(-reach, reach + 1) / width))
    bell = (bell / bell.sum()).astype(values.dtype)
    frames, channels = values.shape
    size = next_fast_len(frames + 2 * reach, real=True)
    longer = np.zeros((channels, size), dtype=values.dtype)
    longer[:, :reach] = values[0][:, None]
    longer[:, reach : reach + frames] = values.T
    longer[:, reach + frames : frames + 2 * reach] = values[-1][:, None]
    spectrum = rfft(longer, size, axis=1)
    spectrum *= rfft(bell, size)
    return np.ascontiguousarray(irfft(spectrum, size, axis=1)[:, 2 * reach : 2 * reach + frames].T)
