"""What was cleaned, once more: learned dynamics have their share, and gaps are filled as the recording's own say."""

from dataclasses import replace

import numpy as np

from ...arrays import Bools, Floats
from ...numerics.coupled import lone_step_variance, smooth_coupled
from ..bases.support import interpolated
from ..dynamics.steady import mixed_in, smooth_steadily
from ..gaps.likeliest import Process
from ..gaps.moved import excess, gaps_of, hidden_by, laid_elsewhere
from ..gaps.shares import fillings, mixed, shares, unsure
from ..library.local_prior import Prior
from .smoothing import certainty, joined, told_by_library

# Variances come from a model told its own noise, outliers and liveliness; being found, they add this much doubt.
DOUBT = 1.12
LEAST_BELIEVED = 0.1  # of a channel's samples
AT_REST = 1.0  # degrees or cm; channels that stray less tell nothing of how far a repair errs


def with_dynamics(
    measured: Floats,
    outlier: Bools,
    values: Floats,
    variance: Floats,
    process: Process | None,
    noise: Floats,
    fps: float,
) -> tuple[Floats, Floats]:
    """(T, C) values and variance once learned dynamics, run on what was cleaned, have their share.

    Parameters
    ----------
    measured, outlier : (T, C) in degrees and cm, NaN = missing, and True where a sample is rejected.
    values, variance : (T, C) as smoothed.
    process : of clean motion; None = nothing is known of it, and all stays.
    noise : (T, C) its standard deviation.
    fps : Hz.
    """
    if process is None or process.dynamics is None or round(fps / process.fps) != 1:
        return values, variance
    present = np.isfinite(measured)
    believed = present & ~outlier
    # what replaces a sample tells nothing; the noisier one is than usual, the nearer it is brought to the repair
    usual = 1.0 / np.sqrt(np.square(1.0 / noise).mean(axis=0))
    tells = np.where(believed, np.square(usual / noise), 0.0)
    thinned = usual / np.sqrt(np.maximum(tells.mean(axis=0), LEAST_BELIEVED))
    seen = values + np.minimum(tells, 1.0) * np.where(believed, measured - values, 0.0)
    steady, sure = smooth_steadily(process.dynamics, seen, thinned, values[:2])
    return mixed_in(steady, sure, values, variance, present)


def in_gaps(
    measured: Floats,
    outlier: Bools,
    values: Floats,
    variance: Floats,
    liveliness: Floats,
    calm: Floats,
    prior: Prior,
    process: Process | None,
    noise: Floats,
    fps: float,
) -> tuple[Floats, Floats, Floats, int]:
    """The channels with gaps filled as the recording's own say.

    The gaps are laid elsewhere and filled once more, by all that was found but what is hidden now; outliers stay
    what they are, so that no history has to be searched again.

    Parameters
    ----------
    measured, outlier : (T, C) in degrees and cm, NaN = missing, and True where a sample is rejected.
    values, variance, liveliness : (T, C) as smoothed.
    calm : (C, C) covariance of second differences that `liveliness` multiplies.
    prior, process : of clean motion.
    noise : (T, C) its standard deviation.
    fps : Hz.

    Returns
    -------
    (T, C) values and their variance, (T, C) the values as they were filled where gaps were laid elsewhere, and steps of
    conjugate gradients.
    """
    present = np.isfinite(measured)
    gaps = gaps_of(present)
    if not gaps:
        return values, variance, values, 0
    moved = laid_elsewhere(gaps, present)
    hidden = hidden_by(moved, measured.shape)
    left = np.where(hidden, np.nan, measured)
    begin = interpolated(np.where(hidden, np.nan, values))
    blind = prior if prior.elsewhere is None else replace(prior, bases=prior.elsewhere)
    # of `values` only what is believed is looked at
    told = told_by_library(left, outlier, begin, values, blind, noise, fps)
    weight = np.where(np.isfinite(left) & ~outlier, 1.0 / np.square(noise), 0.0)
    everything, goal = joined(np.nan_to_num(left), weight, told)
    lively = np.exp(interpolated(np.where(hidden, np.nan, np.log(liveliness))))
    filled, steps = smooth_coupled(goal, everything, calm, np.sqrt(lively), begin)
    sure = DOUBT * certainty(everything, lone_step_variance(everything, calm) * lively)[0]
    telling = present & ~outlier & (values.std(axis=0) > AT_REST)
    tried, own = fillings(filled, hidden | ~present, process, fps)
    counts = shares(gaps + moved, moved, tried - values, telling)
    found, sure_here = fillings(values, ~present, process, fps)
    best = mixed(found, counts)
    if not moved:
        return best, variance, best, steps
    there = mixed(tried, counts)
    away = np.sqrt(np.square(there - values) + variance)  # they are not the truth themselves
    beyond = excess(gaps, moved, away, unsure(tried, counts, sure, own), telling)
    return best, unsure(found, counts, variance, sure_here) * beyond, np.where(hidden, there, best), steps
