"""How noisy each channel is and how often it is wrong, told from the recording alone."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from ...arrays import Bools, Floats
from ...numerics.quantiles import median, quantile_of_known
from ...numerics.walk import noise_level

LEAST_NOISE = 0.01  # degrees or cm
_QUIET, _LOUD = 0.2, 0.7  # quantiles of third differences: the one that outliers reach last, and one they reach soon
_SPOILT = np.linspace(0.0, 0.29, 30)  # shares of the differences that outliers may have reached
# Where so many are spoilt even the quiet quantile says too much, how much cannot be told: begin below, rounds raise it.
_CAUTION = 0.47
_PER_FREEDOM = 6.0  # samples that say as much of the noise by their quantiles as one residual would
_NOTHING = 1e-12
QUIETER = 0.5  # than usual: moments that tell little of how noisy a channel is else
_UNTOLD = 0.1  # degrees or cm, where too few samples tell anything
FEWEST = 8  # differences that tell anything
CHANNELS_ALIKE = 0.05  # variance of log noise between channels of a kind that is taken for granted at most
KINDS = 2.0  # deviation of log noise between kinds
ALIKE = 1.6  # logarithm of how much noisier a channel may look before any outlier is known and still be of a kind
MISREAD = 0.8  # and by which two channels of a kind may be misread: what moves fast looks noisy
LEAST_HELD, MOST_HELD = 0.01, 0.9  # of outliers after an outlier those that are off by as much
HELD_PRIOR = 4.0  # pairs that say as much as what is thought of it before
_PRIOR_SAMPLES = 2.0  # weight of the last estimate in the next
RATES_ALIKE = 300.0  # samples' worth of the whole recording's outlier rate in each channel's own
REACH, MARGIN = 3.5, 0.25  # deviations as far as noise goes, and the width of what is looked at beyond, twice
LEAST_RATE, MOST_RATE = 1e-4, 0.5
# Where fewer than these are followed by another the found ones are as likely fast motion: then they are taken for less,
# by the same power. Belief that they come one by one is worth some outliers, and no burst lasts for ever.
BURSTS, ALONE_PRIOR, MOST_FOLLOW = 0.5, 30.0, 0.9
# A share of outliers that falls by more than this has not fallen far enough: some were only found because so many were
# expected. It is taken further, by what it fell beyond that, to this power.
STEADY, FURTHER = 0.7, 3.0


def first_noise(measured: Floats, loudness: Floats | None = None) -> Floats:
    """Standard deviation of each channel's noise, low rather than high, before any outlier is known.

    Third differences of smooth motion are small and multiply white noise by the root of 20; every outlier spoils four
    of them, so only the smallest fifth is asked. Of white noise larger quantiles say the same: by how much more they
    say, here and in most channels, the share that is spoilt is told, and what the smallest fifth says is corrected.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing.
    loudness : (T, C) of the noise at each moment relative to what is asked for; None = it is the same throughout.

    Returns
    -------
    (C,) in channel units; a channel with too few samples takes the median of the others, or if all have what they say
    together.
    """
    quiet, loud = _told_by((_QUIET, _LOUD), measured, loudness)
    told = np.isfinite(quiet)
    if not told.any():  # a moment: what all channels say together has to do
        third = np.abs(np.diff(measured, n=3, axis=0)) / np.sqrt(20.0)
        moving = np.fmax.reduce(third, axis=0, initial=0.0) > _NOTHING
        if np.isfinite(third).any() and not moving.any():
            return np.full(measured.shape[1], LEAST_NOISE)
        third = third[:, moving]  # what never moves has no noise
        quiet = _size_by((_QUIET,), third[np.isfinite(third)])
        return np.full(measured.shape[1], np.fmax(quiet[0], LEAST_NOISE) if np.isfinite(quiet[0]) else _UNTOLD)
    apart = loud[told] / np.maximum(quiet[told], _NOTHING)
    level = np.log(np.maximum(quiet[told], LEAST_NOISE))
    kin = np.abs(level[:, None] - level) < ALIKE
    apart = np.maximum(apart, [median(apart[near]) for near in kin])
    # quantiles q of noise that shares its samples with so many spoilt ones are those at q / (1 - share) of its own
    too_much = size_of(_QUIET / (1.0 - _SPOILT)) / size_of(_QUIET)
    louder = size_of(_LOUD / (1.0 - _SPOILT)) / size_of(_LOUD) / too_much
    noise = np.full(measured.shape[1], np.nan)
    noise[told] = quiet[told] * np.where(apart < louder[-1], 1.0 / np.interp(apart, louder, too_much), _CAUTION)
    return np.maximum(np.where(told, noise, np.median(noise[told])), LEAST_NOISE)


def _told_by(quantiles: tuple[float, ...], measured: Floats, loudness: Floats | None = None) -> Floats:
    """(Q, C) standard deviation of white noise by quantiles of its third differences; NaN where they are too few."""
    third = np.abs(np.diff(measured, n=3, axis=0)) / np.sqrt(20.0)
    if loudness is not None:
        louder = _third_louder(loudness)
        third = np.where(louder > QUIETER, third / louder, np.nan)
    if len(third) < FEWEST:
        return np.full((len(quantiles), measured.shape[1]), np.nan)
    found = np.stack([quantile_of_known(third, share) / size_of(share) for share in quantiles])
    return np.where(np.isfinite(third).sum(axis=0) < FEWEST, np.nan, found)


def _size_by(quantiles: tuple[float, ...], third: Floats) -> Floats:
    """(Q,) standard deviation of white noise by quantiles of scaled third differences (N,); NaN where too few."""
    if len(third) < FEWEST:
        return np.full(len(quantiles), np.nan)
    return np.asarray(np.quantile(third, quantiles) / size_of(quantiles))


def _third_louder(loudness: Floats) -> Floats:
    """(T - 3, C) by how much third differences are larger where noise is louder by (T, C)."""
    square = np.square(loudness)
    return np.asarray(np.sqrt((square[:-3] + 9.0 * square[1:-2] + 9.0 * square[2:-1] + square[3:]) / 20.0))


def size_of(shares: ArrayLike) -> Floats:
    """Quantiles of |N(0, 1)| at shares in [0, 1)."""
    return np.asarray(ndtri(0.5 + 0.5 * np.asarray(shares)))


def alike_noise(measured: Floats) -> Floats:
    """Standard deviation of each channel's noise before any outlier is known, drawn towards that of the others.

    Of `noise_level`, which is exact without outliers, and what the smallest fifth of the third differences says, which
    holds with more of them, the smaller. A channel whose estimate breaks down is then held by the others: alone it
    would be trusted a hundred times less than they.

    Parameters
    ----------
    measured : (T, C) in channel units, NaN = missing.

    Returns
    -------
    (C,) in channel units; NaN for a channel with too few samples to tell.
    """
    level = noise_level(measured)
    told = np.isfinite(level)
    if not told.any():
        return level
    level[told] = np.fmin(level, _told_by((_QUIET,), measured)[0])[told]
    freedom = np.isfinite(measured).sum(axis=0) / _PER_FREEDOM
    said, doubt = np.log(np.maximum(level[told], LEAST_NOISE)), 0.5 / np.maximum(freedom[told], 1e-3)
    share = 1.0 / (doubt + CHANNELS_ALIKE)
    # so little is told by then that no kinds can be: all are drawn to all
    common = float(np.average(said, weights=share))
    apart = _apart(float(np.average(np.square(said - common) - doubt, weights=share)))
    level[told] = np.exp(_drawn(said, doubt, common, apart))
    return level


def next_noise(noise: Floats, square: Floats, freedom: Floats, misread: float = MISREAD) -> Floats:
    """Noise from the residuals of the samples believed; many channels of one recording are alike.

    Parameters
    ----------
    noise : (C,) last estimate.
    square : (C,) sum of squared residuals.
    freedom : (C,) samples less what the smoother took from them.
    misread : logarithm of the noise by which two channels of a kind may differ all the same.

    Returns
    -------
    (C,), each channel's own drawn towards those of its kind by how little it says.
    """
    own = (square + _PRIOR_SAMPLES * np.square(noise)) / (freedom + _PRIOR_SAMPLES)
    level = 0.5 * np.log(np.maximum(own, LEAST_NOISE**2))
    doubt = 0.5 / np.maximum(freedom, 1e-3)
    kin, common, apart = _kin(level, doubt, misread)
    return np.asarray(np.exp(level + kin * (_drawn(level, doubt, common, apart) - level)))


def _kin(level: Floats, doubt: Floats, misread: float) -> tuple[Floats, Floats, float]:
    """Which channels are alike, though they may be of several kinds: a limb that shakes is no kin of one that does not.

    Parameters
    ----------
    level, doubt : (C,) logarithm of the noise as each channel tells it, and the variance of that.
    misread : logarithm by which it may be misread.

    Returns
    -------
    kin : (C,) 0 to 1, how likely a channel has others of its kind.
    common : (C,) logarithm of the noise of its kind.
    apart : variance of the logarithm within a kind.

    Source
    ------
    The prior of each channel is the mixture of what the others say: Robbins, An empirical Bayes approach to
    statistics, Third Berkeley Symposium, 1956.
    """
    share = 1.0 / (doubt + CHANNELS_ALIKE)
    usual = float(np.average(level, weights=share))
    square = np.square(level[:, None] - level)
    both = doubt[:, None] + doubt
    others = share * (1.0 - np.eye(len(level)))
    like = others * _normal(square, both + 2.0 * (CHANNELS_ALIKE + misread**2))
    apart = float((like * (square - both)).sum() / (2.0 * max(like.sum(), _NOTHING)))
    of_kind = like.sum(axis=1) / np.maximum(others.sum(axis=1), _NOTHING)
    alone = _normal(np.square(level - usual), doubt + KINDS**2) / len(level)
    near = like + np.diag(share * _normal(np.zeros(len(level)), 2.0 * (doubt + CHANNELS_ALIKE + misread**2)))
    common = near @ level / np.maximum(near.sum(axis=1), _NOTHING)
    return of_kind / np.maximum(of_kind + alone, _NOTHING), common, _apart(apart)


def _drawn(level: Floats, doubt: Floats, common: Floats | float, apart: float) -> Floats:
    """What channels tell (C,), with the variance of that, drawn to what is `common`, from which they are `apart`."""
    return np.asarray((level / doubt + common / apart) / (1.0 / doubt + 1.0 / apart))


def _apart(variance: float) -> float:
    """The variance of log noise between channels that are alike, within what is believed of it."""
    return min(max(variance, 1e-3), CHANNELS_ALIKE)


def _normal(square: Floats, variance: Floats) -> Floats:
    """Density of N(0, variance) where the square is this."""
    return np.asarray(np.exp(-0.5 * square / variance) / np.sqrt(2.0 * np.pi * variance))


def next_rate(outlier: Bools, present: Bools, expected: Floats | None = None) -> Floats:
    """(C,) share of each channel's samples that are outliers, drawn towards that of the recording.

    Parameters
    ----------
    outlier, present : (T, C).
    expected : (C,) the share with which these outliers were found; None = a guess that tells nothing.
    """
    hits, samples = outlier.sum(axis=0), present.sum(axis=0)
    overall = (hits.sum() + 0.5) / (samples.sum() + 50.0)
    rate = (hits + RATES_ALIKE * overall) / (samples + RATES_ALIKE)
    if expected is not None:
        rate = rate * min(1.0, overall / (STEADY * expected.mean())) ** FURTHER
    return np.asarray(np.clip(rate, LEAST_RATE, MOST_RATE))


def next_follow(outlier: Bools, present: Bools) -> float:
    """Share of the samples after an outlier that are outliers too: of all samples, or more in bursts.

    Parameters
    ----------
    outlier, present : (T, C).
    """
    before, both = outlier[:-1], present[1:] & present[:-1]
    hits, samples = (before & outlier[1:] & both).sum(), (before & both).sum()
    overall = (outlier.sum() + 0.5) / (present.sum() + 50.0)
    found = (hits + ALONE_PRIOR * overall) / (samples + ALONE_PRIOR)
    found *= min(1.0, found / BURSTS) ** FURTHER
    return float(np.clip(max(found, overall), LEAST_RATE, MOST_FOLLOW))


def next_held(
    off: Floats, outlier: Bools, spread: Floats, density: float, together: int, before: float, first: float
) -> float:
    """Share of the outliers after an outlier that are off by as much as the one before, as in a slip that lasts.

    Parameters
    ----------
    off : (T, C) samples less the motion beneath.
    outlier : (T, C).
    spread : (T, C) variance of the change of `off` where it stays.
    density : of an outlier anywhere, per unit to the power `together`.
    together : G, neighbouring columns that are outliers together.
    before, first : the last estimate, and what is thought before anything is known.
    """
    frame, group = np.nonzero((outlier[1:] & outlier[:-1])[:, ::together])
    away, var = (one.reshape(len(off), -1, together) for one in (off, spread))
    change, var = away[frame + 1, group] - away[frame, group], var[frame + 1, group]
    stays = before * np.exp(-0.5 * (np.square(change) / var + np.log(2.0 * np.pi * var)).sum(axis=1))
    share = stays / (stays + (1.0 - before) * density)
    return float(np.clip((share.sum() + HELD_PRIOR * first) / (share.size + HELD_PRIOR), LEAST_HELD, MOST_HELD))


def overlooked(measured: Floats, values: Floats, outlier: Bools, noise: Floats) -> float:
    """Variance of what is believed, outliers that pass for noise included, relative to that of noise.

    As many are taken to lie just within what noise reaches as are found just beyond; no more than a little further
    out, where nothing is rejected that was only noise.

    Parameters
    ----------
    measured, values, outlier : (T, C) samples, NaN = missing, the motion beneath, and which are rejected.
    noise : (T, C) or (C,) standard deviations.
    """
    size = np.where(outlier, np.abs(measured - values) / noise, 0.0)
    beyond = np.histogram(size, REACH * (1.0 + MARGIN * np.arange(3)))[0].min()
    return 1.0 + REACH**2 * float(beyond) / max(1, int(np.isfinite(measured).sum()))
