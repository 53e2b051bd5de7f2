"""What a library's bases say of a recording, and how far they can be believed, by channel and moment."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from ...arrays import Bools, Floats
from ...numerics.ssa import Eigenbases
from .optimise import fit_windows, window_starts

SCALE = 5.0  # p of eq. 2.9, degrees or cm: wider than the dissertation's, since misfit comes on top of noise
MEMORY = 0.3  # s over which misfit lasts: the running median that finds it spans so much
CARRIED = 10.0  # times its variance: what the bases say errs alike for several frames and joints
TRIMMED = 0.1  # share of the largest misfits left out of a channel's usual one
LEAST = 0.3  # degrees or cm; no library knows a body better
MOST_LEVERAGE = 0.98
OVERLAP = 4  # windows over each frame: more cost time and tell nothing new
TOLERANCE = 0.03  # of the fit's cost; the support is not sure to more
RARE = 0.02  # share of outliers that is neither rare nor common
SCATTER_LEFT = 4.0  # times the variance a median leaves of white noise, not to take noise for misfit
DEVIATION = 1.0 / 0.6745  # standard deviation of normal errors to the median of their sizes


@dataclass(frozen=True, eq=False)
class Support:
    """What the library expects; (T, C) each, channel units and their square.

    Attributes
    ----------
    values : expected.
    variance : of their errors.
    verdict : the same, for telling outliers: less than half a moment in which samples are believed far from the
        values silences no library, for an outlier believed by mistake speaks for itself.
    """

    values: Floats
    variance: Floats
    verdict: Floats


def supported(believed: Floats, start: Floats, bases: Eigenbases, stride: int) -> Floats:
    """(T, C) the recording as the bases can tell it: diagonal average of its windows' projections.

    Parameters
    ----------
    believed : (T, C) samples, NaN = missing or rejected; T >= the bases' window.
    start : (T, C) finite, where the fit begins.
    bases : at the recording's rate.
    stride : least frames between windows.

    Source
    ------
    Section 2.2.3-2.2.4: the fit of eq. 2.16. Not its z, which holds on to each sample, but what the windows'
    coefficients alone rebuild, so that a sample speaks less for itself.
    """
    from ...kernels.lagged import coverage, overlap_add, project

    stride = max(stride, bases.window // OVERLAP)
    fit = fit_windows(believed, start, bases, stride, scale=SCALE, tolerance=TOLERANCE)
    frames, centre = len(believed), bases.mean.mean(axis=0)
    starts = window_starts(frames, bases.window, stride)
    mean = (bases.mean - centre)[None]
    vectors = np.ascontiguousarray(bases.vectors)
    c = project(np.ascontiguousarray(fit.values - centre), vectors, starts) - np.tensordot(vectors, mean[0], axes=2)
    rebuilt = overlap_add(c, vectors, starts, frames) + overlap_add(np.ones((len(starts), 1)), mean, starts, frames)
    return np.asarray(rebuilt / coverage(starts, bases.window, frames)[:, None] + centre)


def support(
    measured: Floats,
    believed: Bools,
    smooth: Floats | None,
    values: Floats,
    bases: Eigenbases,
    noise: Floats,
    fps: float,
    *,
    own: bool = False,
) -> Support:
    """How far the library's values can be off, judged by what they miss of the recording round about.

    Parameters
    ----------
    measured : (T, C), NaN = missing; outliers and all, a median forgives them.
    believed : (T, C) samples that are there and not rejected.
    smooth : (T, C) the last estimate; None in the first round.
    values : (T, C) of `supported`.
    bases : they came from.
    noise : (C,) or (T, C) standard deviations.
    fps : Hz.
    own : the bases are the recording's own: what they miss is their fault, however short.
    """
    span = 2 * round(0.5 * MEMORY * fps) + 1
    # what a sample says of itself through the bases is no support for it
    leverage = np.minimum(np.square(bases.vectors).sum(axis=0).mean(axis=0), MOST_LEVERAGE)

    def variance(missed: Floats) -> Floats:
        kept = max(1, round((1.0 - TRIMMED) * len(missed)))
        usual = np.sort(missed, axis=0)[:kept].mean(axis=0)
        return np.asarray(CARRIED * (np.maximum(missed, usual) + bases.discarded + LEAST**2) / (1.0 - leverage) ** 2)

    away = interpolated(measured - values)
    middle = running_median(away, span)
    # what a library misses is smooth; what scatters is noise, or a burst of outliers, and moves the median by chance
    scatter = np.maximum(noise, DEVIATION * running_median(np.abs(away - middle), span))
    missed = np.maximum(np.square(middle) - SCATTER_LEFT * np.pi / (2.0 * span) * np.square(scatter), 0.0)
    if smooth is None:
        known = variance(missed)
        return Support(values, known, known)
    # in a gap the estimate is no evidence against the library: what is missed on both sides counts
    apart = np.square(interpolated(np.where(believed, smooth - values, np.nan)))
    known = variance(np.maximum(missed, apart))
    if own:
        return Support(values, known, known)
    return Support(values, known, variance(np.maximum(missed, np.minimum(apart, running_median(apart, span)))))


def ends_alone(verdict: Floats, rate: Floats) -> Floats:
    """(T, C) variance for verdicts, the ends' taken once, not `CARRIED` times, where outliers are common.

    Errors that several frames share are counted once in all by giving each frame little weight. Beside an end there
    are fewer frames to share them, and beyond it no samples that bear on what the end's own say: its frame stands for
    those beyond. Where outliers are rare an end that flies off is the motion's own.

    Parameters
    ----------
    verdict : (T, C) of a support.
    rate : (C,) share of outliers.
    """
    variance = verdict.copy()
    variance[[0, -1]] /= 1.0 + (CARRIED - 1.0) * rate / (rate + RARE)
    return variance


def as_alike_for_long(told: Support, averaged: Floats) -> Support:
    """The support where estimates are means over many frames: what all of these have in common no mean takes away.

    Parameters
    ----------
    told : of the library.
    averaged : (T, C) samples' worth of each estimate; beyond `CARRIED` of them the variance grows with their number.
    """
    return replace(told, variance=told.variance * np.maximum(1.0, averaged / CARRIED))


def line_support(believed: Floats, present: Bools) -> Support:
    """What is known without a library: in a gap a motion stays about the line across it, as far as the channel strays.

    Parameters
    ----------
    believed : (T, C), NaN = missing or rejected.
    present : (T, C) False in gaps; where samples are, even rejected ones, nothing is said.
    """
    known = np.isfinite(believed)
    strays = [np.var(believed[known[:, c], c]) if known[:, c].any() else np.inf for c in range(known.shape[1])]
    variance = np.where(present, np.inf, CARRIED * (np.array(strays) + LEAST**2))
    return Support(interpolated(believed), variance, variance)


def missed_by(support: Support, believed: Bools, smooth: Floats) -> float:
    """Root mean square of what the library misses where samples are believed, channel units."""
    apart = np.square(smooth - support.values)
    return float(np.sqrt(apart[believed].mean())) if believed.any() else 0.0


def running_median(values: Floats, span: int) -> Floats:
    """(T, C) median of the `span` frames, odd, about each; near an end that of the outermost `span`.

    Mirrored frames would count twice there, and two outliers in four frames be most of them.
    """
    columns = np.ascontiguousarray(values.T)
    if len(values) >= span:
        from ...kernels.medians import running_median

        return np.ascontiguousarray(running_median(columns, span).T)
    return np.stack([median_filter(one, size=span, mode="mirror") for one in columns], axis=1)


def interpolated(values: Floats, centre: Floats | None = None) -> Floats:
    """(T, C) with gaps bridged by straight lines, held at the ends; an empty channel is at its centre (C,), or 0."""
    filled, frames = values.copy(), np.arange(len(values))
    for c in np.flatnonzero(~np.isfinite(values).all(axis=0)):
        known = np.isfinite(values[:, c])
        if known.any():
            filled[:, c] = np.interp(frames, frames[known], values[known, c])
        else:
            filled[:, c] = 0.0 if centre is None else centre[c]
    return filled
