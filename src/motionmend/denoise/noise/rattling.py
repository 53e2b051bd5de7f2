"""A single channel that rattles for a moment: noise many times as loud as its own, from one frame to the next."""

import numpy as np
from scipy.ndimage import binary_dilation, binary_propagation, find_objects, label, uniform_filter1d

from ...arrays import Floats

LEAST = {1: 4.0, 3: 3.0}  # degrees, and cm of markers, that count
TIMES = 10.0  # louder than the channel is else
SECONDS, FRAMES = 0.1, 12  # that it lasts for, at least
MOSTLY = 0.75  # of its second differences that are as large as noise of `LEAST` has seven in ten
LULL = 0.5  # about which it goes on
BESIDE = 3  # frames on either side that may be bad as well
_QUIET_NORMAL = 0.3853205  # quantile of |N(0, 1)| at 0.3
_MIDDLE_NORMAL = 0.6744898  # at 0.5
_SECOND, _FOURTH = 6.0, 70.0  # variance of differences of white noise of variance one
WHITE = 0.5  # of what second differences say fourth ones say of noise; of motion much less
RARE = 0.05  # of all second differences: where more are as large, outliers or noise are common and found otherwise


def rattles(measured: Floats, fps: float, together: int = 1) -> Floats:
    """(T, C) standard deviation of the noise where a channel rattles, 0 elsewhere.

    Parameters
    ----------
    measured : (T, C) in degrees or cm, NaN = missing.
    fps : Hz.
    together : neighbouring columns of one marker: 1 for angles, 3 for markers.

    Notes
    -----
    No joint shakes by degrees from frame to frame. A search that knows outliers to be rare takes each turn for a jump,
    and noise that comes and goes is asked whether it lasts; a tenth of a second of it is neither.
    """
    found = np.zeros(measured.shape)
    longest = max(FRAMES, round(SECONDS * fps))
    if len(measured) < 2 * longest:
        return found
    bend = np.abs(np.diff(measured, n=2, axis=0))
    known = np.isfinite(bend)
    usual = np.array(
        [np.median(one[seen]) if seen.any() else np.inf for one, seen in zip(bend.T, known.T, strict=True)]
    )
    least = np.maximum(TIMES * usual / (_MIDDLE_NORMAL * np.sqrt(_SECOND)), LEAST[together])
    large = known & (bend > _QUIET_NORMAL * np.sqrt(_SECOND) * least)
    if not large.any() or large.sum() > RARE * known.sum():
        return found
    share = uniform_filter1d(large.astype(np.float64), longest, axis=0, mode="constant")
    for c in np.flatnonzero((share >= MOSTLY).any(axis=0)):
        sure, maybe = share[:, c] >= MOSTLY, share[:, c] >= LULL
        near = binary_dilation(binary_propagation(sure, mask=maybe), iterations=longest // 2)
        for (run,) in find_objects(label(near)[0]):
            where = run.start + np.flatnonzero(large[run, c])
            first, end = max(int(where[0]) + 2 - BESIDE, 0), int(where[-1]) + 1 + BESIDE
            some = measured[first:end, c]
            second, fourth = _told(some, 2, _SECOND), _told(some, 4, _FOURTH)
            if fourth > max(WHITE * second, least[c]):
                found[first:end, c] = np.where(np.isfinite(some), fourth, 0.0)
    return np.asarray(found.reshape(len(found), -1, together).max(axis=2).repeat(together, axis=1))


def _told(some: Floats, order: int, scale: float) -> float:
    """Standard deviation of white noise by the median of differences of an order, 0 where there are none."""
    size = np.abs(np.diff(some, n=order))
    size = size[np.isfinite(size)]
    return float(np.median(size) / (_MIDDLE_NORMAL * np.sqrt(scale))) if size.size else 0.0
