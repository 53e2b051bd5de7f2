"""Channels that never move: joints nobody measures, fingers, bones of one piece. Under noise they are best known.

How sharply a channel bends is told only as far as noise lets it be seen, so that a smoother follows the noise of what
does not move. But a constant under noise that is new in every sample is white, and where slow changes are no larger
than quick ones nothing moves by more than its mean over the recording is sure of.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import dct
from scipy.special import fdtrc

from ...arrays import Bools, Floats
from ...bodies.motion import Origin
from ..channels.travel import slow_part
from .blocks import Mended

FEWEST = 24  # samples that tell that nothing moves
BELIEVED = 0.6  # of a channel's samples
BY_CHANCE = 0.05  # at which slow changes are taken for motion: rather too often, for that only costs what it did before
NO_LOUDER = 1.2  # times the noise that was found
LEFT = 0.3  # of a cosine; of which less is left tells nothing of what was there
QUICK = 4  # of all changes the slowest fourth is asked at most


@dataclass(frozen=True, eq=False)
class Unmoving:
    """What does not move in a recording.

    Attributes
    ----------
    still : (C,) True for the channels that never move.
    place : (C,) where they are, channel units; NaN for the others.
    std : (C,) of that.
    """

    still: Bools
    place: Floats
    std: Floats


def nothing_still(channels: int) -> Unmoving:
    """Of as many channels, none."""
    return Unmoving(np.zeros(channels, dtype=np.bool_), np.full(channels, np.nan), np.full(channels, np.nan))


def unmoving(measured: Floats, mended: Mended, asked: Bools, travelling: Bools, fps: float) -> Unmoving:
    """Find the channels in which nothing but noise is to be seen.

    Parameters
    ----------
    measured : (T, C) channel units, NaN = missing.
    mended : a repair of these samples: only what it believed is looked at, and by how noisy it found the channels.
    asked : (C,) the channels that may be still.
    travelling : (C,) those in the travelling frame, which has taken the slow part of them, and of their noise.
    fps : Hz.

    Source
    ------
    The cumulated periodogram of white noise rises evenly: Bartlett, An introduction to stochastic processes, 1955,
    section 9.2. Here by cosines, whose lowest show a drift too, and by the ratio of the mean power below a frequency to
    that above, which of white noise is F-distributed.
    """
    rest = nothing_still(measured.shape[1])
    for c in np.flatnonzero(asked).tolist():
        # what is constant but for white noise stays so without the samples that are left out
        seen = measured[mended.found.origin[:, c] == Origin.MEASURED, c]
        if len(seen) < BELIEVED * np.isfinite(measured[:, c]).sum():
            continue  # but the few that lie where it is expected are no constant
        left = 1.0 - slow_part(len(seen), fps) if travelling[c] else np.ones(max(len(seen) - 1, 0))
        if len(seen) >= FEWEST and seen.std() <= NO_LOUDER * mended.noise[c] and _white(seen, left):
            rest.still[c], rest.place[c] = True, seen.mean()
            rest.std[c] = seen.std(ddof=1) / np.sqrt(len(seen))
    return rest


def _white(values: Floats, left: Floats) -> bool:
    """True where slow changes of values (N,) are no larger than quick ones.

    `left` (N - 1,) is the share of each cosine that is left in them, slowest first; those with little are not asked.
    """
    cosines = dct(values - values.mean(), norm="ortho")[1:]
    power = np.cumsum(np.square((cosines / np.maximum(left, LEFT))[left >= LEFT]))
    total, count = power[-1], len(power)
    slow = 2 ** np.arange(int(np.log2(count // QUICK)) + 1)  # how many of the slowest are asked
    below, above = power[slow - 1] / slow, (total - power[slow - 1]) / (count - slow)
    if (above <= 0.0).any():
        return False
    return bool((fdtrc(slow, count - slow, below / above) > BY_CHANCE).all())


def kept_still(mended: Mended, rest: Unmoving) -> Mended:
    """The repair with what never moves in its place throughout, written into its arrays: recordings may be long.

    In gaps deviations stay: what was not seen may have moved.
    """
    found = mended.found
    for c in np.flatnonzero(rest.still).tolist():
        known = found.origin[:, c] != Origin.LEFT_OPEN
        found.values[known, c] = rest.place[c]
        if len(found.std):
            found.std[known & (found.origin[:, c] != Origin.FILLED), c] = rest.std[c]
    return replace(mended, unseen_bends=np.where(rest.still, 0.0, mended.unseen_bends))
