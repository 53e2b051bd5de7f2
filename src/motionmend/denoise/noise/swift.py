"""Noise that goes with speed: motion blur, soft tissue, samples that are late or early by chance.

How loud each moment is says little for itself, and fast moments are short. But where noise is the larger the faster a
joint or marker moves, it is so throughout a recording: one number says it, and all moments of all channels together
tell that number.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from ...arrays import Bools, Floats, Ints
from ...numerics.gaussian import gaussian_smooth
from ..bases.support import interpolated

SMOOTHED, LEAST_SMOOTHED = 0.03, 2.0  # s and frames, of the Gaussian whose slope is the speed
LONE = 5  # frames, of which outliers of one or two are seen to be none of the motion
MEDIAN = 1.5  # times the variance that a running median leaves of slow changes of noise than a mean would
STRAYS = 2.5  # deviations of it that are not taken for speed
STEEPER = np.r_[0.0, np.geomspace(0.05, 50.0, 24)]  # deviations that a channel's usual speed adds to that at rest
SLOPES = np.geomspace(1e-4, 1.0, 60)  # s, noise to speed
ALIKE = 0.5  # deviation of the logarithm of the slope between channels
NEEDED = 5.0  # of log-likelihood that the slope has to win, for anything of it to be believed
ONE_MOMENT = 0.67  # deviation of the logarithm of a variance that is told by a moment of one channel
MOTION = 0.7  # mean of the logarithm of that growth, from which fast moments of a channel tell nothing
FEWEST = 4.0  # widths' worth of frames that tell of a channel
_NOTHING, _EVERYTHING = 1e-9, 1e15


def goes_with_speed(
    noise: Floats,
    tells: Bools,
    grown: Floats,
    moving: list[Floats],
    width: float,
    faint: float,
) -> Floats:
    """By how much each sample is noisier for its channel's speed; 0 where the recording does not show any such thing.

    The variance of noise is a² + (b v)² at speed v. The slope b is a time, by which samples are off or over which they
    are blurred, and so much the same for all channels. Of several speeds the one counts that says most.

    Parameters
    ----------
    noise : (T, C) logarithm of the variance of noise about each moment.
    tells : (T, C) True where it is that of noise.
    grown : (T, C) logarithm of how much larger squared differences are over two frames than over one: 0 of noise.
    moving : speeds that noise may go with, each (T, C) in channel units a second (`speeds`).
    width : frames, of the Gaussian that `noise` was smoothed with.
    faint : logarithm of a variance below which noise is not followed.

    Returns
    -------
    (T, C) added to the logarithm of the variance, at that frame.
    """
    found, best = np.zeros(noise.shape), NEEDED
    for speed in moving:
        added, gain = _added(noise, tells, grown, speed, width, faint)
        if gain > best:
            found, best = added, gain
    return np.asarray((1.0 - NEEDED / best) * found)


def speeds(measured: Floats, noise: Floats, fps: float, together: int, joints: Ints | None) -> list[Floats]:
    """Speeds that noise may go with: each (T, C), channel units a second.

    Of an angle its own, and that of all angles of its joint; of a marker over the ground, and about the others.

    Parameters
    ----------
    measured : (T, C) the channels, NaN = missing; outliers and all.
    noise : (T, C) their variance of noise about each moment: what may be its doing is no speed.
    fps : Hz.
    together : neighbouring columns that move together: 1 for angles, 3 for markers.
    joints : (C,) alike where angles are of one joint; None = none are.
    """
    if together == 1:
        own = _speed(measured, noise, fps, 1)
        if joints is None:
            return [own]
        return [own, np.sqrt(np.square(own) @ (joints[:, None] == joints))]
    points = measured.reshape(len(measured), -1, together)
    known = np.isfinite(points)
    middle = np.where(known, points, 0.0).sum(axis=1, keepdims=True) / np.maximum(known.sum(axis=1, keepdims=True), 1)
    return [_speed(one.reshape(measured.shape), noise, fps, together) for one in (points, points - middle)]


def _speed(moving: Floats, noise: Floats, fps: float, together: int) -> Floats:
    """(T, C) of the columns that move together, of what is left without lone outliers."""
    calm = median_filter(interpolated(moving), (LONE, 1), mode="nearest")
    width = max(SMOOTHED * fps, LEAST_SMOOTHED)
    slope = fps * gaussian_filter1d(calm, width, axis=0, order=1, mode="nearest")
    # of white noise the slope of a Gaussian has this variance, and that of the sum of some squares is twice as many
    chance = MEDIAN * fps**2 / (4.0 * np.sqrt(np.pi) * width**3) * noise
    square, by_chance = (one.reshape(len(moving), -1, together) for one in (np.square(slope), chance))
    likely = (together + STRAYS * np.sqrt(2.0 * together)) * by_chance.mean(axis=2)
    speed = np.sqrt(np.maximum(square.sum(axis=2) - likely, 0.0))
    return np.asarray(speed.repeat(together, axis=1))


def _added(
    noise: Floats,
    tells: Bools,
    grown: Floats,
    speed: Floats,
    width: float,
    faint: float,
) -> tuple[Floats, float]:
    """(T, C) what a slope adds to the logarithm of the variance, and the log-likelihood that it wins."""
    channels = np.flatnonzero(tells.sum(axis=0) > FEWEST * width)
    if not len(channels):
        return np.zeros(noise.shape), 0.0
    speed, told = speed[:, channels], tells[:, channels]
    level, count = np.where(told, noise[:, channels], 0.0), told.sum(axis=0)
    usual = np.sqrt(np.where(told, np.square(speed), 0.0).sum(axis=0) / count) + _NOTHING
    # for each steepness, the level at rest of every channel, and how much is left unexplained
    rest, left = np.empty((2, len(STEEPER), len(channels)))
    # a slope needs no more digits
    relative, known = np.minimum(speed / usual, _EVERYTHING).astype(np.float32), level.astype(np.float32)
    for i, steeper in enumerate(STEEPER.tolist()):
        apart = np.where(told, known - gaussian_smooth(np.log(np.square(steeper * relative) + 1.0), width), 0.0)
        rest[i] = apart.sum(axis=0, dtype=np.float64) / count
        left[i] = np.square(np.where(told, apart - rest[i], 0.0)).sum(axis=0)
    # where fast moments are mostly motion, those that look like noise do so by chance
    fast = (speed > usual) & np.isfinite(grown[:, channels])
    motion = np.where(fast, grown[:, channels], 0.0).sum(axis=0) > MOTION * fast.sum(axis=0)
    left[:, motion] = 0.0
    span = 2.0 * np.sqrt(np.pi) * width  # frames that a Gaussian of this width averages
    left /= 2.0 * ONE_MOMENT**2 * span
    slope = STEEPER[:, None] / usual * np.exp(0.5 * rest)
    cost = np.stack([np.interp(SLOPES, slope[:, c], left[:, c]) for c in range(len(channels))], axis=1)
    total = cost.sum(axis=1)
    common = int(total.argmin())
    unlike = np.square(np.log(SLOPES / SLOPES[common])) / (2.0 * ALIKE**2)
    own = SLOPES[(cost + unlike[:, None]).argmin(axis=0)]
    still = np.array([np.interp(own[c], slope[:, c], rest[:, c]) for c in range(len(channels))])
    added = np.zeros(noise.shape)
    added[:, channels] = np.log1p(np.square(own * speed) / np.exp(np.maximum(still, faint)))
    without, with_it = (
        _unexplained(one, told & ~motion) for one in (level, level - gaussian_smooth(added[:, channels], width))
    )
    moment = max(ONE_MOMENT**2, with_it / max(1, (told & ~motion).sum()))
    return added, (without - with_it) / (2.0 * moment * span)


def _unexplained(level: Floats, told: Bools) -> float:
    """Sum of squares of what (T, C) tells, but for what channels share at a moment, and what each has throughout."""
    weight = told.astype(np.float64)
    left = np.where(told, level, 0.0)
    for axis in (0, 1, 0, 1, 0):
        left = left - weight * left.sum(axis=axis, keepdims=True) / np.maximum(
            weight.sum(axis=axis, keepdims=True), 1.0
        )
    return float(np.square(left).sum())
