"""Bursts of outliers that are so long that what lies under them is a gap."""

import numpy as np

from ..arrays import Bools

LONG_BURST = 0.1  # s; across what is rejected for longer, a smoother that knows only how a channel bends strays


def long_runs(lost: Bools, fps: float) -> Bools:
    """(T, C) True where a channel is lost, missing or rejected, for longer than `LONG_BURST` on end."""
    frames = np.arange(len(lost))[:, None]
    last = np.maximum.accumulate(np.where(lost, -1, frames), axis=0)
    following = np.minimum.accumulate(np.where(lost, len(lost), frames)[::-1], axis=0)[::-1]
    return np.asarray(lost & (following - last - 1 > round(LONG_BURST * fps)))
