"""A single channel that rattles for a moment: noise many times as loud as its own, from one frame to the next."""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import binary_dilation, binary_propagation, find_objects, label, maximum_filter1d, uniform_filter1d

from ...arrays import Bools, Floats
from ...numerics.walk import NORMAL_MEDIAN
from ..bases.support import bridged
from .quiet import QUIET_NORMAL

LEAST = {1: 4.0, 3: 3.0}  # degrees, and cm of markers, that count
TIMES = 10.0  # louder than the channel is else
SECONDS, FRAMES = 0.1, 12  # that it lasts for, at least
MOSTLY = 0.75  # of its second differences that are as large as noise of `LEAST` has seven in ten
LULL = 0.5  # about which it goes on
BESIDE = 3  # frames on either side that may be bad as well
ALSO_SHAKES = 2.0  # degrees, of a second difference
ENDS = 3  # frames that are put before and after a recording, to tell whether the body goes along at its ends
ALSO = 6  # frames before and after a pose in which no more is believed to rattle
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
    least = np.maximum(TIMES * usual / (NORMAL_MEDIAN * np.sqrt(_SECOND)), LEAST[together])
    large = known & (bend > QUIET_NORMAL * np.sqrt(_SECOND) * least)
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


def but_for_poses(
    rattle: Floats, measured: Floats, vouched: Bools, as_pose: Callable[[Floats, Bools, Floats], Bools] | None
) -> Floats:
    """(T, C) of `rattles`, but not where only angles rattle and the body does not.

    Parameters
    ----------
    rattle, measured : (T, C) what `rattles` gives, and of what, in degrees or cm.
    vouched : (T, C) True where a sample is no outlier.
    as_pose : of measured, rejected and values, what is no outlier for the pose: `as_pose.smoother_as_pose`; None =
        there is no body.
    """
    shaken = rattle > 0
    if as_pose is None or not shaken.any():
        return rattle
    bends = np.pad(np.diff(measured, n=2, axis=0), ((1, 1), (0, 0)))
    # a thigh that shakes about itself is undone by the foot: what shakes in the same frames is looked at with it
    shaking = maximum_filter1d(np.abs(np.nan_to_num(bends)), 5, axis=0) > ALSO_SHAKES
    still = np.zeros(shaken.shape, dtype=np.bool_)
    longer = np.pad(measured, ((ENDS, ENDS), (0, 0)), mode="edge")  # else nothing tells at an end
    for moved in (shaken, shaken | (shaking & shaken.any(axis=1, keepdims=True))):
        some = np.pad(moved, ((ENDS, ENDS), (0, 0)))
        still |= as_pose(longer, some, bridged(np.where(some, np.nan, longer)))[ENDS:-ENDS]
    of_body = shaken & binary_dilation(still | vouched, np.ones((2 * ALSO + 1, 1), dtype=np.bool_))
    # What rattles together is replaced together, or not at all: of a chain of which half is left the end goes astray.
    left, within = (np.asarray(one.any(axis=1)) for one in (of_body, shaken))
    whole = np.asarray(binary_propagation(left, mask=within))
    return np.where(whole[:, None], 0.0, rattle)


def _told(some: Floats, order: int, scale: float) -> float:
    """Standard deviation of white noise by the median of differences of an order, 0 where there are none."""
    size = np.abs(np.diff(some, n=order))
    size = size[np.isfinite(size)]
    return float(np.median(size) / (NORMAL_MEDIAN * np.sqrt(scale))) if size.size else 0.0
