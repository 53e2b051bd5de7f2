"""All channels smoothed at once: what the library says and the samples joined, how motion bends, and how sure it is."""

import numpy as np

from ...arrays import Bools, Floats
from ..bases.support import Support, interpolated, line_support, support, supported
from ..library.local_prior import Prior

UNCOUPLED = 0.1  # share of the covariance of second differences that is not believed
BEND = 0.03  # degrees or cm a frame at 30 Hz: second differences no smaller count as motion
STILL = 0.1  # times that where it was seen how little a channel moves
VAGUE = 400.0  # square of channel units: where a channel begins, beside how far it strays
_NOTHING = 1e-300


def told_by_library(
    measured: Floats,
    outlier: Bools,
    begin: Floats | None,
    smooth: Floats | None,
    prior: Prior,
    noise: Floats,
    fps: float,
) -> Support:
    """What the library says of a recording, or without one the lines across gaps.

    Parameters
    ----------
    measured : (T, C) in degrees and cm, NaN = missing.
    outlier : (T, C) True where a sample is not believed.
    begin : (T, C) where the fit begins; None = lines between the samples.
    smooth : (T, C) the smoothed channels, to tell how far the library misses them; None = not known yet.
    noise : (T, C) its standard deviation.
    fps : Hz.
    """
    present, believed = np.isfinite(measured), np.where(outlier, np.nan, measured)
    bases = prior.bases
    if bases is None:
        return line_support(believed, present)
    begin = interpolated(believed, bases.mean.mean(axis=0)) if begin is None else begin
    values = supported(believed, begin, bases, prior.stride)
    return support(measured, present & ~outlier, smooth, values, bases, noise, fps, own=prior.own)


def calm_bends(prior: Prior, fps: float) -> Floats:
    """(C, C) covariance of second differences in the calm mode: somewhat uncoupled, and nowhere nothing."""
    bends, least = prior.bends, np.full(len(prior.bends), least_bend(fps))
    if prior.still is not None:
        least[prior.still] *= STILL**2
    return np.asarray((1.0 - UNCOUPLED) * bends + np.diag(UNCOUPLED * np.diag(bends) + least))


def least_bend(fps: float) -> float:
    """Variance of second differences at `fps` Hz, in channel units, up to which nothing counts as motion."""
    return float((BEND * (30.0 / fps) ** 2) ** 2)


def joined(filled: Floats, weight: Floats, told: Support) -> tuple[Floats, Floats]:
    """Weights (T, C) of samples `filled` and library together, and the values (T, C) they weigh."""
    library = 1.0 / told.variance
    total = weight + library
    return total, (weight * filled + library * told.values) / np.maximum(total, _NOTHING)


def certainty(weight: Floats, step_var: Floats) -> tuple[Floats, Floats]:
    """(T, C) variance of what is smoothed, and of its second differences, by weights and step variance (T, C)."""
    from ...kernels.banded import walk_certainty

    vague = np.full(weight.shape[1], VAGUE)
    return walk_certainty(np.ascontiguousarray(weight), np.ascontiguousarray(step_var), vague, vague)
