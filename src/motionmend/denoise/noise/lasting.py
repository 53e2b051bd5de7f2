"""Noise that lasts: each frame's is much that of the frame before, and passes for motion unless it is told."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats, Ints
from .kept_distances import steadiest_distances
from .quiet import quiet_variance
from .trembling import trembling

ORDER = 4  # of the differences that are asked: motion hardly shows in them, over short lags
_OF_WHITE = 70.0  # variance of fourth differences of white noise of variance one
# Of the variance of fourth differences over a lag, as one of `Fourth`, by the noise's correlations over 0 to 4 lags.
OF_CORRELATIONS = np.array([70.0, -112.0, 56.0, -16.0, 2.0]) / _OF_WHITE
LONGEST = 0.15  # s, lag beyond which motion is sure to show
# Doublings of a lag add this much to the logarithm (base 2) of the differences' variance: noise that is new in every
# frame nothing, what lasts up to 1, smooth motion 3 and more, the more the longer the lag. Noise and motion together
# pass through 1 on their way up.
LEAST_GROWTH, MOST_GROWTH, RISES = 0.6, 1.6, 0.3
# Degrees or cm, squared, a second, by which clean recordings wander as if by such noise.
USUAL_OF_ANGLES, USUAL_OF_MARKERS = 10.0, 0.2
FEWEST_FRAMES, FEWEST_LAGS, MOST = 64, 3, 0.5
# Distances between markers: cm squared a second by which they wander in clean recordings; growth between which they
# show noise, for skin gives way but does not move on; and the most that is kept: how long noise lasts skin hides.
USUAL_OF_DISTANCES, BETWEEN, MOST_KEPT = 0.2, (0.4, 1.7), 0.9
MOMENT = 0.25  # s, of which means tell which distance is steady
FLAT = 1.5  # Hz; of what changes more slowly nothing tells noise from motion
BELOW = 0.7  # of the highest frequency: where a tremble is looked for
_EDGE = np.pi - 1e-6
_STAYS = np.concatenate([np.linspace(0.3, 0.9, 61), 1.0 - np.geomspace(0.09, 0.005, 40)])
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Lasting:
    """Noise of which each frame keeps a share of the one before (an autoregression of first order).

    Frequencies are in radians a frame.

    Attributes
    ----------
    variance : (C,) of the noise, channel units squared; 0 where it is not known to last.
    stays : share that is kept from one frame to the next.
    lowest : frequency down to which it was told from motion.
    flat : frequency below which it is taken to be as strong as there.
    """

    variance: Floats
    stays: float
    lowest: float
    flat: float

    @property
    def in_band(self) -> Floats:
        """(C,) variance of white noise that is as strong at `lowest`."""
        return np.asarray(self.variance * self._density(self.lowest))

    def of_bends(self, lag: int) -> Floats:
        """(C,) variance of its second differences over so many frames."""
        kept = self.stays**lag
        return np.asarray(self.variance * (6.0 - 8.0 * kept + 2.0 * kept**2))

    def left_by(self, variance: Floats) -> Floats:
        """(T, C) variance of errors where a smoother that takes the noise for white, as `in_band`, states (T, C).

        It lets through what lies below some frequency, and there noise that lasts is stronger.
        """
        white = self.in_band
        known = white > 0
        edge = np.pi * np.minimum(variance / np.where(known, white, 1.0), 1.0)
        beyond = np.maximum(self._below(edge) - self._below(np.asarray(self.flat)), 0.0)
        passed = self.variance * (beyond + self._density(self.flat) * np.minimum(self.flat, edge) / np.pi)
        return np.where(known, np.maximum(variance, passed), variance)

    def _density(self, frequency: float) -> float:
        """Spectral density of such noise of variance one; that of white noise is one."""
        return float((1.0 - self.stays**2) / (1.0 - 2.0 * self.stays * np.cos(frequency) + self.stays**2))

    def _below(self, frequency: Floats) -> Floats:
        """Share of its variance below a frequency."""
        rises = (1.0 + self.stays) / (1.0 - self.stays)
        return np.asarray(2.0 / np.pi * np.arctan(rises * np.tan(0.5 * np.minimum(frequency, _EDGE))))


@dataclass(frozen=True, eq=False)
class Fourth:
    """Fourth differences of channels over L lags, which noise and motion make grow each in its way.

    Attributes
    ----------
    lags : (L,) frames, each twice the one before.
    found : (L, C) variance of white noise that makes them as large, channel units squared; NaN where there are none.
    asked : (C,) channels that move and have some over every lag.
    growth : (L - 1,) of the logarithm (base 2) from lag to lag, the median of the channels that are asked.
    """

    lags: Ints
    found: Floats
    asked: Bools
    growth: Floats


def lasting_noise(measured: Floats, fps: float, usual: float) -> Lasting | None:
    """Tell noise that lasts from noise that does not, and from motion.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing.
    fps : Hz.
    usual : channel units squared a second, as `USUAL_OF_ANGLES`.

    Returns
    -------
    None where noise is new in every frame, motion hides it, or most channels show no more than clean recordings do.

    Notes
    -----
    Fourth differences over one, two, four frames and so on are asked, as long as they grow as noise lets them. How
    loud it is is told by those of neighbouring frames, which motion reaches last; what clean recordings show as well
    is taken off.
    """
    found = _lasting(measured, fps, usual, _STAYS, _before_motion)
    return None if found is None or trembling(measured, BELOW * np.pi, fps)[0] else found


def lasting_by_distances(measured: Floats, fps: float) -> Lasting | None:
    """The same of markers, by the distance of each to the one near it from which that changes least.

    However fast a body moves, skin keeps its markers apart; but it gives way slowly, which hides how long noise
    lasts: it is taken to keep no more than `MOST_KEPT`. Both markers of a distance have an equal part in its noise.

    Parameters
    ----------
    measured : (T, C) in cm, NaN = missing; three columns a marker.
    fps : Hz.

    Returns
    -------
    None where there are too few frames or markers, or distances do not change as noise that lasts makes them.
    """
    if len(measured) < FEWEST_FRAMES or measured.shape[1] < 6:
        return None
    apart = steadiest_distances(measured.reshape(len(measured), -1, 3), max(2, round(MOMENT * fps)))
    between = _lasting(apart, fps, USUAL_OF_DISTANCES, _STAYS[_STAYS <= MOST_KEPT], _before_skin)
    if between is None:
        return None
    # no motion hides what of them changes slowly
    return replace(between, variance=np.repeat(0.5 * between.variance, 3), flat=0.0)


def _before_motion(growth: Floats) -> Bools:
    """Where differences grow from lag to lag (L,) as noise lets them: more and more of motion shows in them."""
    return np.asarray(growth <= np.minimum(MOST_GROWTH, np.append(growth[0], growth[:-1]) + RISES))


def _before_skin(growth: Floats) -> Bools:
    """The same of distances (L,)."""
    return np.asarray((growth >= BETWEEN[0]) & (growth <= BETWEEN[1]))


def _lasting(
    measured: Floats, fps: float, usual: float, stays: Floats, as_noise: Callable[[Floats], Bools]
) -> Lasting | None:
    """Noise that lasts in (T, C), of the shares that may stay (S,), by differences that grow `as_noise` makes them."""
    if len(measured) < FEWEST_FRAMES:
        return None
    fourth = fourth_by_lag(measured, fps, LONGEST)
    if fourth is None:
        return None
    lags, found, asked, growth = fourth.lags, fourth.found, fourth.asked, fourth.growth
    told = 1 + int(np.argmin(np.append(as_noise(growth), [False])))
    if growth[0] < LEAST_GROWTH or told < FEWEST_LAGS:
        return None
    kept = stays[:, None] ** lags[:told]
    expected = np.polynomial.polynomial.polyval(kept, OF_CORRELATIONS)
    apart = np.log(np.median(found[:told, asked] / found[0, asked], axis=1)) - np.log(expected / expected[:, :1])
    best = int(np.square(apart).sum(axis=1).argmin())
    variance = np.zeros(measured.shape[1])
    variance[asked] = found[0, asked] / expected[best, 0]
    wanders = found[0] * _OF_WHITE / 20.0 * fps
    variance *= np.where(asked, np.clip(1.0 - usual / np.maximum(wanders, _NOTHING), 0.0, None), 0.0)
    # where most wander as clean recordings do, how much stays was told by these, and the others are lively
    if (variance > 0).sum() < MOST * asked.sum():
        return None
    lowest = np.pi / lags[told - 1]
    return Lasting(variance, float(stays[best]), lowest, min(lowest, 2.0 * np.pi * FLAT / fps))


def fourth_by_lag(measured: Floats, fps: float, longest: float) -> Fourth | None:
    """Fourth differences over one, two and four frames, and on by doublings; None where no channel has any.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing.
    fps : Hz.
    longest : s, lag beyond which none is asked, nor beyond a sixteenth of the frames.
    """
    lags = [1, 2, 4]
    while 2 * lags[-1] <= min(longest * fps, len(measured) / 16):
        lags.append(2 * lags[-1])
    found = np.array([_variance(measured, lag) for lag in lags])
    asked = np.isfinite(found).all(axis=0) & (found > _NOTHING).all(axis=0)
    if not asked.any():
        return None
    return Fourth(np.array(lags), found, asked, np.median(np.diff(np.log2(found[:, asked]), axis=0), axis=1))


def _variance(measured: Floats, lag: int) -> Floats:
    """(C,) variance of white noise by the low quantile of fourth differences over a lag; NaN where there are none."""

    def fourth(one: Floats) -> Floats:
        for _ in range(ORDER):
            one = one[lag:] - one[:-lag]
        return one

    return quiet_variance(measured, fourth) / _OF_WHITE
