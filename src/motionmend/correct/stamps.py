"""When a recording's frames were taken, where their times do not tell: rounded, or those of when frames came in."""

import numpy as np

from ..arrays import Floats
from ..kernels.steadying import SHORTEST

MANY = 60  # frames whose mean step is that of the recording, whatever their times say one by one
UNBROKEN = 0.25  # of the stretches of so many frames are without a break, at least
TOGETHER = 0.25  # of that step; frames that are no farther apart, and less than sensors are, were stamped together
OFTEN = 0.2  # of the steps; fewer are a sensor's that says some frames twice
EARLY = 0.98  # of that step, by which frames that were stamped together follow each other at least


def taken(times: Floats) -> Floats:
    """When frames were taken that are said to be of these times.

    Where many were stamped together, as by clocks that know no parts of a second, or by who stamps what comes in at
    once, they are spread to the next; elsewhere the times are believed.

    Parameters
    ----------
    times : (T,) s, finite.

    Returns
    -------
    (T,) s.
    """
    steps = np.diff(times)
    many = min(len(steps), MANY)
    if many < MANY // 2:
        return times
    usual = float(np.quantile(times[many:] - times[:-many], UNBROKEN)) / many
    if usual <= 0.0 or (steps <= min(TOGETHER * usual, SHORTEST)).mean() < OFTEN:
        return times
    found = times.astype(np.float64)
    for t in range(1, len(found)):
        found[t] = max(found[t], found[t - 1] + EARLY * usual)
    return found
