"""Bursts of outliers that are so long that what lies under them is a gap, and gaps so short that they are none."""

import numpy as np
from scipy.ndimage import binary_opening

from ...arrays import Bools

LONG_BURST = 0.1  # s; across what is rejected for longer, a smoother that knows only how a channel bends strays

SHORT_GAP = 1 / 30  # s; within it how a marker moves tells more of it than the markers about it


def long_runs(lost: Bools, fps: float) -> Bools:
    """(T, C) True where a channel is lost, missing or rejected, for longer than `LONG_BURST` on end."""
    return np.asarray(binary_opening(lost, np.ones((round(LONG_BURST * fps) + 1, 1), dtype=np.bool_)))


def short_runs(lost: Bools, fps: float) -> Bools:
    """(T, C) True where a channel is lost for no longer than `SHORT_GAP` on end, or for a single frame."""
    most = max(1, round(SHORT_GAP * fps))
    return np.asarray(lost & ~binary_opening(lost, np.ones((most + 1, 1), dtype=np.bool_)))
