"""A single channel that rattles for a moment: noise many times as loud as its own, from one frame to the next."""

from collections.abc import Callable
from functools import cache
from itertools import combinations

import numpy as np
from scipy.ndimage import binary_dilation, binary_propagation, find_objects, label, maximum_filter1d, uniform_filter1d

from ...arrays import Bools, Floats, Ints
from ...numerics.quantiles import quantile_of_known
from ...numerics.walk import NORMAL_MEDIAN
from ..bases.support import interpolated
from .quiet import QUIET_NORMAL

LEAST = {1: 4.0, 3: 3.0}  # degrees, and cm of markers, that count
TIMES = 10.0  # louder than the channel is else
SECONDS, FRAMES = 0.1, 12  # that it lasts for, at least
MOSTLY = 0.75  # of its second differences that are as large as noise of `LEAST` has seven in ten
LULL = 0.5  # about which it goes on
BESIDE = 3  # frames on either side that may be bad as well
ALSO_SHAKES = 2.0  # degrees, of a second difference
ENDS = 3  # frames that are put before and after a recording, to tell whether the body goes along at its ends
_SECOND, _FOURTH = 6.0, 70.0  # variance of differences of white noise of variance one
WHITE = 0.5  # of what second differences say fourth ones say of noise; of motion much less
RARE = 0.15  # of all other second differences of such channels: where more are as large, outliers are found otherwise
RARE_APART = 0.05  # of all, whatever rattles, where frames are far apart
BENT, OFF, SMOOTH = 12, 1.0, 0.65  # frames of a parabola, degrees or cm off it, and samples that lie on it at most
CLOSE = 0.2  # s
BEYOND = 3.0  # deviations of its calm noise
MANY = 0.5  # of all channels at once: noise that comes and goes
CALM = 0.2  # quantile of second differences that what rattles for half of a short clip has not reached
POSE = 0.25  # of a run's frames in which the body does not rattle with it; by chance it does not in a few


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
    calm = _calm(bend, known)
    least = np.maximum(TIMES * calm, LEAST[together])
    large = known & (bend > QUIET_NORMAL * np.sqrt(_SECOND) * least)
    # a body moves on parabolas for as long only where frames are close; else outliers near each other are not told
    if not large.any() or (fps * CLOSE < BENT and large.sum() > RARE_APART * known.sum()):
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
            if fourth > max(WHITE * second, least[c]) and _smooth_share(some, max(OFF, BEYOND * calm[c])) < SMOOTH:
                found[first:end, c] = np.where(np.isfinite(some), fourth, 0.0)
    rest = large & ~(found[1:-1] > 0)
    if rest.sum() > RARE * known[:, large.any(axis=0)].sum():
        return np.zeros(measured.shape)
    found[(found > 0).mean(axis=1) > MANY] = 0.0
    return np.asarray(found.reshape(len(found), -1, together).max(axis=2).repeat(together, axis=1))


def but_for_poses(
    rattle: Floats,
    measured: Floats,
    vouched: Bools,
    as_pose: Callable[[Floats, Bools, Floats], Bools] | None,
    joints: Ints | None = None,
    limb: Bools | None = None,
) -> Floats:
    """(T, C) of `rattles`, but not where only angles rattle and the body does not.

    Parameters
    ----------
    rattle, measured : (T, C) what `rattles` gives, and of what, in degrees or cm.
    vouched : (T, C) True where a sample is no outlier.
    as_pose : of measured, rejected and values, what is no outlier for the pose: `as_pose.smoother_as_pose`; None =
        there is no body.
    joints : (C,) a number for each joint, alike where columns are angles of one; None = each has one of its own.
    limb : (C, C) True for two channels of one joint, or of joints of which one carries the other; None = none does.
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
        still |= as_pose(longer, some, interpolated(np.where(some, np.nan, longer)))[ENDS:-ENDS]
    run: Ints = np.asarray(label(shaken, np.array([[0, 1, 0]] * 3))[0], dtype=np.int64)
    share = np.bincount(run.ravel(), (still | vouched).ravel()) / np.bincount(run.ravel())
    # near a pole all angles of a joint rattle, and the joint does not in some frames at least
    whole = np.zeros(shaken.shape, dtype=np.bool_)
    for joint in np.unique(joints) if joints is not None else ():
        own = np.flatnonzero(joints == joint)
        whole[:, own] = len(own) > 1 and shaken[:, own].all(axis=1, keepdims=True)
    as_joint = np.bincount(run.ravel(), whole.ravel()) / np.bincount(run.ravel()) >= MOSTLY
    of_body = shaken & ((share >= POSE) | (as_joint & (share > 0)))[run]
    if limb is not None:
        of_body |= _along_limbs(run, np.abs(np.nan_to_num(bends)), limb)
    # What rattles together along a limb is replaced together, or not at all: of half of it the end goes astray.
    left = of_body.copy()
    if limb is not None:
        for c in np.flatnonzero(of_body.any(axis=0)):
            left |= of_body[:, [c]] & limb[c]
    return np.where(np.asarray(binary_propagation(left & shaken, np.array([[0, 1, 0]] * 3), shaken)), 0.0, rattle)


def _along_limbs(run: Ints, bends: Floats, limb: Bools) -> Bools:
    """(T, C) True for the runs in which another channel of the limb, that does not rattle, bends as much then."""
    found = np.zeros(run.shape, dtype=np.bool_)
    for c in np.flatnonzero(run.any(axis=0)):
        others = np.flatnonzero(limb[c] & (np.arange(len(limb)) != c))
        for (here,) in find_objects(label(run[:, c])[0]):
            own, beside = bends[here, c], np.where(run[here][:, others] > 0, 0.0, bends[here][:, others])
            loud = own > np.median(own)
            if (np.mean(beside[loud] >= own[loud, None], axis=0) > WHITE).any():
                found[here, c] = True
    return found


def _calm(bend: Floats, known: Bools) -> Floats:
    """(C,) standard deviation of white noise that bends (T, C) as much as a channel is usually bent, where it is calm.

    By the median; where that is further from a smaller quantile than in most channels, by as far as in these.
    """
    some = np.where(known, bend, np.nan)
    low, middle = (np.where(known.any(axis=0), quantile_of_known(some, share), np.inf) for share in (CALM, 0.5))
    told = np.isfinite(low) & (low > 0)
    if told.any():
        middle[told] = np.minimum(middle[told], low[told] * np.median(middle[told] / low[told]))
    return np.asarray(middle / (NORMAL_MEDIAN * np.sqrt(_SECOND)))


def _told(some: Floats, order: int, scale: float) -> float:
    """Standard deviation of white noise by the median of differences of an order, 0 where there are none."""
    size = np.abs(np.diff(some, n=order))
    size = size[np.isfinite(size)]
    return float(np.median(size) / (NORMAL_MEDIAN * np.sqrt(scale))) if size.size else 0.0


def _smooth_share(some: Floats, off: float) -> float:
    """Share of samples (N,) that lie no more than `off` from a parabola through three of those about them.

    Of lone outliers near each other, whose second differences are all large, the samples between lie on it.
    """
    count = min(BENT, len(some))
    through, weights = _parabolas(count)
    starts = [*range(0, len(some) - count, BENT // 3), len(some) - count]
    on_it = []
    for start in starts:
        here = some[start : start + count]
        with np.errstate(invalid="ignore"):
            near = np.abs((weights @ here[through][:, :, None])[..., 0] - here) <= off
        on_it.append(near.sum(axis=1).max() / max(1, np.isfinite(here).sum()))
    return float(np.mean(on_it))


@cache
def _parabolas(count: int) -> tuple[Ints, Floats]:
    """(P, 3) all threes of so many frames, and (P, count, 3) what each of them counts in every frame of a parabola."""
    through = np.array(list(combinations(range(count), 3)))
    powers = np.arange(count, dtype=np.float64)[:, None] ** np.arange(3)
    return through, np.asarray(powers @ np.linalg.inv(powers[through]))
