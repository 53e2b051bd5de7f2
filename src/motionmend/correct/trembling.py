"""Joints that tremble throughout a recording: calmed before they are looked at, for their mean is good.

A sensor may see a joint worse than all others and still about where it is. Frame by frame that looks like failing; in a
recording as a whole it is white noise, which differences of a high order tell from motion: those of white noise grow
with the order, those of motion fall. As the noise is known, Stein's estimate of the risk says how far to smooth.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ..arrays import Bools, Floats
from ..numerics.whittaker import response
from .steadying import USUAL, difference_squares, smoothed

LEAST, TIMES = 0.006, 3.0  # m, and times as much as the median joint: less noise is left as it is
MOST = 0.015  # m, that is not left, however much the others tremble; sensors' joints that are seen do by 1.3 cm at most
WHITE = 0.8  # of what differences of the third order say those of the fourth do, where it is noise
FEWEST = 30  # frames that tell
WEIGHTS = 4.0 ** np.arange(-1, 6)  # of second differences, at 30 Hz
CALMEST = (0.1, 0.584), (0.2, 1.005), (0.3, 1.424)  # quantiles of the same
THROUGHOUT = 0.7  # of the noise that the calmest frames show as well: who fails for a while shakes then, and not else
WHILE, SURELY = 0.25, 3.0  # s to either side, and deviations of chance, by which a joint is off more than it usually is
FAR = 4.0  # standard deviations of the noise beyond which a place counts no more


@dataclass(frozen=True, eq=False)
class Calmed:
    """Positions (T, J, 3) in m, and the variance (J,) in m² of a coordinate that the noise leaves in them."""

    positions: Floats
    variance: Floats

    def only(self, joints: Bools, given: Floats) -> "Calmed":
        """The same for joints (J,) alone, all others as they were given (T, J, 3)."""
        return Calmed(np.where(joints[:, None], self.positions, given), np.where(joints, self.variance, 0.0))


def calmed(positions: Floats, times: Floats) -> Calmed:
    """A recording with joints that tremble throughout made calm.

    Parameters
    ----------
    positions : (T, J, 3) m, NaN = missing.
    times : (T,) s.
    """
    found, left = np.array(positions), np.zeros(positions.shape[1])
    noise = _noise(positions)
    known = noise[np.isfinite(noise)]
    if len(known):
        alone = max(LEAST, TIMES * float(np.median(known)))
        for j in np.flatnonzero(noise > min(alone, MOST)):
            calm, left[j] = _least_risk(positions[:, [j]], times, float(noise[j]) ** 2)
            more = _more(positions[:, j] - calm[:, 0], times) & (noise[j] <= alone)
            found[:, [j]] = np.where(more[:, None, None], positions[:, [j]], calm)
    return Calmed(found, left)


def _noise(positions: Floats) -> Floats:
    """(J,) m, standard deviation of a coordinate's white noise; 0 where what is quick is motion, NaN where few frames
    tell."""
    sizes = [difference_squares(positions, order) for order in (3, 4)]
    enough: Bools = np.isfinite(sizes[1]).sum(axis=0) >= FEWEST
    found = np.full(positions.shape[1], np.nan)
    for j in np.flatnonzero(enough):
        by_third, by_fourth = (float(np.sqrt(np.nanmedian(one[:, j]))) for one in sizes)
        calmest = min(float(np.nanquantile(sizes[1][:, j], share)) * USUAL / size for share, size in CALMEST)
        found[j] = by_fourth if by_fourth > WHITE * by_third and calmest > (THROUGHOUT * by_fourth) ** 2 else 0.0
    return found


def _more(rest: Floats, times: Floats) -> Bools:
    """(T,) where a joint is farther off its calm course (T, 3), for a while, than it usually is: it fails, or goes
    quickly."""
    usual = float(np.median(np.diff(times)))
    frames = 2 * max(1, round(WHILE / usual)) + 1 if usual > 0 else 1
    square = np.square(rest).sum(axis=1)
    known = np.isfinite(square)
    total = uniform_filter1d(np.where(known, square, 0.0), frames, mode="reflect")
    here = total / np.maximum(uniform_filter1d(known.astype(np.float64), frames, mode="reflect"), 1.0 / frames)
    more = here > (1.0 + SURELY * np.sqrt(2.0 / (3.0 * frames))) * np.median(here)
    return np.asarray(maximum_filter1d(more, frames))


def _least_risk(positions: Floats, times: Floats, variance: float) -> tuple[Floats, float]:
    """Positions (T, 1, 3) smoothed as far as their noise, of this variance in m², makes worth while, and what is left
    of it."""
    steps = np.diff(times)
    usual = float(np.median(steps)) if len(steps) else 0.0
    best, least, left = positions, variance, variance
    for weight in WEIGHTS if usual > 0 else ():
        passed = response(weight * (1.0 / (30.0 * usual)) ** 4)
        calm = smoothed(positions, times, float(weight))
        rest = np.square(positions - calm).sum(axis=2)
        rest = np.minimum(rest[np.isfinite(rest)], 3.0 * FAR**2 * variance)
        risk = float(rest.mean()) / 3.0 - variance + 2.0 * variance * float(passed.mean())
        if risk < least:
            best, least, left = calm, risk, variance * float(np.square(passed).mean())
    return best, left
