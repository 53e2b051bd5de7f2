"""Bursts of outliers that are so long that what lies under them is a gap."""

import numpy as np
from scipy.ndimage import binary_opening

from ..arrays import Bools

LONG_BURST = 0.1  # s; across what is rejected for longer, a smoother that knows only how a channel bends strays


def long_runs(lost: Bools, fps: float) -> Bools:
    """(T, C) True where a channel is lost, missing or rejected, for longer than `LONG_BURST` on end."""
    return np.asarray(binary_opening(lost, np.ones((round(LONG_BURST * fps) + 1, 1), dtype=np.bool_)))
