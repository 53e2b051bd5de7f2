"""Markers that hardly move, as of somebody who stands: how sharply they bend at most, by the likelihood of all frames.

Differences over a few frames show nothing but noise there, and no more can be said of them than that the motion is
less. The slow changes of the whole recording say more: steps of variance q under white noise of variance r have cosine
coefficients of variance q / (2 - 2 cos w)² + r.
"""

from functools import lru_cache

import numpy as np
from scipy.fft import dct
from scipy.special import chdtrc

from ...arrays import Floats, frozen
from ..channels.pieces import pieces

PIECE = 4096  # frames of a long recording that are looked at together
FEWEST = 64  # frames that tell
RATIOS = np.logspace(-12.0, 2.0, 71)  # q / r that are tried
NATS = 2.0  # of log-likelihood below its most, up to which a ratio may be
BY_CHANCE = 1e-3  # at which changes that such steps do not explain, as of a small swing, are taken for motion


def most_bends(values: Floats) -> Floats:
    """(G,) the largest variance of second differences that the slow changes of some channels allow; inf where unknown.

    It is not known where samples are left open, in fewer than `FEWEST` frames, and where some changes are larger than
    any such steps under white noise have them: then the channels do move.

    Parameters
    ----------
    values : (T, G) samples of channels that bend alike, as a marker's coordinates, what was rejected or missing among
        them replaced; NaN = left open.

    Source
    ------
    Whittle, Estimation and information in stationary time series, Arkiv för Matematik 2, 1953: the likelihood of
    independent frequencies, here of cosines, in which white noise is white whatever the motion at the ends.
    """
    unknown = np.full(values.shape[1], np.inf)
    parts = [values[part] for part in pieces(len(values), PIECE) if part.stop - part.start >= FEWEST]
    if not parts or not np.isfinite(values).all() or not all(part.std(axis=0).all() for part in parts):
        return unknown
    powers = [_powers(part) for part in parts]
    count = sum(map(len, powers))
    noise = np.sum([_shares(len(p))[0] @ p for p in powers], axis=0) / count  # (ratios, G) variance r
    if not noise.all():  # constant but for what rounding makes of a deviation
        return unknown
    spread = np.sum([_shares(len(p))[1] for p in powers], axis=0)
    likely = -0.5 * (values.shape[1] * spread + count * np.log(noise).sum(axis=1))
    at = int(np.flatnonzero(likely >= likely.max() - NATS)[-1])
    explained = (p * _shares(len(p))[0][at, :, None] / noise[at] for p in powers)
    return unknown if any(map(_swings, explained)) else np.asarray(RATIOS[at] * noise[at])


def _powers(values: Floats) -> Floats:
    """(T - 1, G) squares of the cosine coefficients of values (T, G) about their straight line."""
    at = np.arange(len(values)) - (len(values) - 1) / 2.0
    away = values - values.mean(axis=0)
    away = away - np.outer(at, at @ away / (at @ at))
    return np.asarray(np.square(dct(away, axis=0, norm="ortho")[1:]))


@lru_cache(maxsize=2)  # whole pieces and the last one, the same for every marker
def _shares(count: int) -> tuple[Floats, Floats]:
    """(ratios, N) variance of the noise by what N such squares are on average, and (ratios,) sums of the logarithms of
    its inverse."""
    steps = np.square(2.0 - 2.0 * np.cos(np.pi * np.arange(1, count + 1) / (count + 1)))
    expected = RATIOS[:, None] / steps + 1.0
    return frozen(1.0 / expected), frozen(np.log(expected).sum(axis=1))


def _swings(explained: Floats) -> bool:
    """True where neighbouring squares (N, G), 1 on average, are together larger than chance makes them."""
    sums = np.concatenate([np.zeros((1, explained.shape[1])), np.cumsum(explained, axis=0)])
    width = 1
    while 4 * width <= len(explained):
        largest = (sums[width:] - sums[:-width]).max()
        if chdtrc(width, largest) * len(explained) / width < BY_CHANCE:
            return True
        width *= 2
    return False
