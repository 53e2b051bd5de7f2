"""Noise that another program has smoothed: new samples hardly differ from those before, and it passes for motion.

Up to the frequency down to which it was smoothed it is as strong as white noise, above there is none. Differences of
motion grow the more the longer the lag; those of such noise grow fast at first, and then no more. So do those of a
tremble, which is motion, but it is stronger about its own frequency than below; noise and motion beside it never are.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Floats, Ints
from .kept_distances import steadiest_distances
from .lasting import FEWEST_FRAMES, MOMENT, OF_CORRELATIONS, fourth_by_lag
from .trembling import trembling

# Doublings of a lag add this much to the logarithm (base 2) of the differences' variance: at least, before, and at
# most, once the lag is so long that noise shows no more than before.
ROSE, FLAT = 2.0, 1.2
LONGEST = 0.2  # s; noise smoothed to 6 Hz is flat from then on
ABOUT = 2  # lags before that one that tell to what frequency it was smoothed; shorter ones show what came upon it later
USUAL, LEAST = 0.35, 0.3  # degrees of such noise that clean recordings show as well, and of what is followed at least
OF_DISTANCES = 0.05, 0.08  # cm, the same of distances between markers
_EDGES = np.pi * np.geomspace(0.03, 0.95, 80)
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class BandLimited:
    """Noise that is as strong at all frequencies up to one, and not there above.

    Attributes
    ----------
    variance : (C,) of the noise, channel units squared; 0 where there is none.
    edge : that frequency, radians a frame.
    """

    variance: Floats
    edge: float

    @property
    def in_band(self) -> Floats:
        """(C,) variance of white noise that is as strong below the edge."""
        return np.asarray(self.variance * (np.pi / self.edge))

    def of_bends(self, lag: int) -> Floats:
        """(C,) variance of its second differences over so many frames."""
        once, twice = np.sinc(np.array([1.0, 2.0]) * lag * self.edge / np.pi)
        return np.asarray(self.variance * (6.0 - 8.0 * once + 2.0 * twice))

    def left_by(self, variance: Floats) -> Floats:
        """(T, C) variance of errors where a smoother that takes the noise for white, as `in_band`, states (T, C): what
        it lets through lies below the edge, and there the noise is as strong."""
        return variance


def band_limited_noise(measured: Floats, fps: float, usual: float = USUAL, least: float = LEAST) -> BandLimited | None:
    """Tell noise that was smoothed from noise that was not, and from motion.

    Parameters
    ----------
    measured : (T, C) in degrees (and cm, of a root that noise comes upon alike), NaN = missing.
    fps : Hz.
    usual, least : in the same unit, as `USUAL` and `LEAST`.

    Returns
    -------
    None where there is none, or motion hides it. A channel that trembles is as noisy as the others usually are.
    """
    if len(measured) < FEWEST_FRAMES:
        return None
    fourth = fourth_by_lag(measured, fps, LONGEST)
    if fourth is None:
        return None
    lags, found, asked, growth = fourth.lags, fourth.found, fourth.asked, fourth.growth
    rose = np.maximum.accumulate(growth)
    flat = 1 + np.flatnonzero((growth[1:] <= FLAT) & (rose[:-1] >= ROSE))
    if not len(flat):
        return None
    at = int(flat[0])
    near = slice(max(0, at - ABOUT), at + 1)
    own = _variance_by_lag(lags[near.start : at + 2])
    # Noise whose differences would grow on is not what is flat here. A spline through fewer samples has next to none
    # over short lags, and noise below an edge that lets so little through were hundreds of degrees.
    kept = own[:, -1] <= 2.0**FLAT * own[:, -2]
    edges, own = _EDGES[kept], own[kept]
    if not len(edges):
        return None
    expected = own[:, :-1]
    apart = np.log(expected / expected[:, -1:]) - np.log(np.median(found[near, asked] / found[at, asked], axis=1))
    best = int(np.square(apart).sum(axis=1).argmin())
    variance = np.zeros(measured.shape[1])
    variance[asked] = np.maximum(found[at, asked] / expected[best, -1] - usual**2, 0.0)
    if np.median(variance[asked]) < least**2:
        return None
    edge = float(edges[best])
    most, each = trembling(measured[:, asked], edge, fps, BandLimited(variance, edge).in_band[asked])
    if most:
        return None
    trembles = np.zeros(len(asked), dtype=np.bool_)
    trembles[asked] = each
    if not trembles[asked].all():
        variance[trembles] = np.minimum(variance[trembles], np.median(variance[asked & ~trembles]))
    return BandLimited(variance, edge)


def band_limited_by_distances(measured: Floats, fps: float) -> BandLimited | None:
    """The same of markers, by the distance of each to the one near it from which that changes least.

    Motion, and a tremble, which hide such noise in places, hardly show there. Both markers of a distance have an equal
    part in its noise.

    Parameters
    ----------
    measured : (T, C) in cm, NaN = missing; three columns a marker.
    fps : Hz.

    Returns
    -------
    None where there are too few frames or markers, or distances do not change as such noise makes them.
    """
    if len(measured) < FEWEST_FRAMES or measured.shape[1] < 6:
        return None
    apart = steadiest_distances(measured.reshape(len(measured), -1, 3), max(2, round(MOMENT * fps)))
    between = band_limited_noise(apart, fps, *OF_DISTANCES)
    return None if between is None else replace(between, variance=np.repeat(0.5 * between.variance, 3))


def _variance_by_lag(lags: Ints) -> Floats:
    """(E, L) variance of fourth differences over lags (L,), of noise of variance one below each of the edges."""
    turns = np.arange(len(OF_CORRELATIONS)) * _EDGES[:, None, None] * lags[:, None] / np.pi
    return np.asarray(np.sinc(turns) @ OF_CORRELATIONS)
