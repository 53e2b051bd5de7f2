"""Who trembles: changes that are stronger about one frequency than below it, or than noise would be about others."""

import numpy as np
from scipy.fft import dct
from scipy.special import fdtrc

from ...arrays import Bools, Floats
from ..bases.support import interpolated, running_median

# Times as strong in a band as in one below it, half of the channels or one alone: a tremble. Bands are half an octave
# wide, from the edge down to `SLOWEST` Hz; of one channel they may be so by chance.
TREMBLES, BY_CHANCE = (1.5, 2.0), 1e-3
BAND, SLOWEST, FEWEST_COSINES = np.sqrt(0.5), 1.0, 6
# Noise that was smoothed down to an edge fades over the band up to there, to 0.2 of its strength in the next one at
# least (four takes at three rates, smoothed in three ways, half of their channels), and is no weaker anywhere below:
# there it shows at least 0.28 of its strength.
FADES, WEAKEST = 0.12, 0.2
SPAN, FAR = 5, 6.0  # frames, and times the median distance from their median: beyond it a sample tells nothing
_NOTHING = 1e-12


def trembling(measured: Floats, edge: float, fps: float, strength: Floats | None = None) -> tuple[bool, Bools]:
    """Whether changes are stronger in a band below an edge than further below, as neither noise nor motion is; or in
    some band weaker than the noise that they are taken for.

    Parameters
    ----------
    measured : (T, C) samples, NaN = missing. Single ones that are far off would hide all else, and are left out.
    edge : radians a frame.
    fps : Hz.
    strength : (C,) of such noise below the edge, as the variance of white noise that is as strong; None = not told.

    Returns
    -------
    Of most channels, and (C,) of each.
    """
    known = _without_spikes(interpolated(measured))
    power = np.square(dct(known - known.mean(axis=0), axis=0, norm="ortho"))
    bands: list[Floats] = []
    counts: list[int] = []
    most, each = False, np.zeros(measured.shape[1], dtype=np.bool_)
    upper = edge * len(measured) / np.pi  # a cosine of index k makes k half turns in T frames
    while upper * BAND >= 2.0 * SLOWEST * len(measured) / fps and upper * (1.0 - BAND) >= FEWEST_COSINES:
        here = power[round(upper * BAND) + 1 : round(upper) + 1]
        for above, count in zip(bands, counts, strict=True):
            stronger = above / np.maximum(here.mean(axis=0), _NOTHING)
            most |= bool(np.median(stronger) > TREMBLES[0])
            each |= (stronger > TREMBLES[1]) & (fdtrc(count, len(here), stronger) < BY_CHANCE)
        bands.append(here.mean(axis=0))
        counts.append(len(here))
        upper *= BAND
    if strength is not None and bands:
        share = np.median(np.array(bands) / np.maximum(strength, _NOTHING), axis=1)
        most |= bool(share[0] < FADES * np.append(share, 1.0)[1] or (share[1:] < WEAKEST).any())
    return most, each


def _without_spikes(known: Floats) -> Floats:
    """(T, C) with samples far from the median of those about them bridged by straight lines."""
    off = np.abs(known - running_median(known, SPAN))
    return interpolated(np.where(off > FAR * np.median(off, axis=0), np.nan, known))
