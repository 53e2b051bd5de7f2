"""Joints that are farther off than any gets in the time: did they leave where they went well, or are they back?

One of the two places was wrong. A failure that begins with a leap ends with one, so in a recording the last leap for a
while brings a joint back, unless it lies on its other side's. Live, where joints lie to those that did not leap tells,
as it does of confused sides; neither the past nor what is this person's own is asked, for both may have been learned
from the wrong place.
"""

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..kernels import hops
from ..kernels.following import STRANGER
from ..numerics import factors as process
from ..numerics.factors import Factors

CLEARLY = 3.0  # squared z-scores by which the new place must be less likely than the former one
ONTO = 0.05  # standard metres; a joint that leaps so near to its other side was taken for it
LONGEST = 5.0  # s that a failure lasts
FARTHEST = 25.0  # squared z-score of a coordinate beyond which a place says nothing more


def left_behind(
    factors: Factors, standard: Floats, before: Floats, hop: Bools, failing: Floats, mirror: Ints, again: Bools | None
) -> tuple[Bools, Bools]:
    """Which joints left where they were well, and which are back.

    Parameters
    ----------
    standard, before : (J, 3) of this frame and the one before in standard form, NaN = missing.
    hop : (J,) joints that are farther off than any gets in the time.
    failing : (J,) probability to fail before this frame.
    mirror : (J,) the joint's other side, or itself.
    again : (J,) joints that leap once more within `LONGEST`; None = what comes is not known.

    Returns
    -------
    (J,) and (J,), of those that leapt.
    """
    there = np.asarray(np.isfinite(standard).all(axis=1))
    variance = factors.noise + STRANGER**2
    values = np.where(there[:, None], standard - factors.mean, 0.0)
    belief = process.seen(
        factors, process.start(factors), values, np.where(there & ~hop, 1.0 - failing, 0.0) / variance
    )
    place, cov = process.expected(factors, belief)
    spread = np.trace(cov, axis1=1, axis2=2) / 3.0 + variance
    now, then = (
        np.minimum(np.square(one - factors.mean - place).sum(axis=1) / spread, FARTHEST) for one in (standard, before)
    )
    beside = np.sqrt(np.square(standard - standard[mirror]).sum(axis=1)) < ONTO
    onto = hop & beside & (mirror != np.arange(len(mirror)))
    if again is None:
        gone = hop & (onto | (now - then > CLEARLY))
        return gone, hop & ~gone
    gone = hop & (onto | again)
    return gone, hop & ~onto & (~again | ((now < then) & (failing > 0.5)))


def leaps_again(rows: Floats, times: Floats, mirror: Ints) -> Bools:
    """(T, J) joints that leap once more within `LONGEST` after each frame.

    Parameters
    ----------
    rows : (T, J, 3) m, NaN = missing.
    times : (T,) s.
    mirror : (J,) the joint's other side, or itself.
    """
    rows, found = np.ascontiguousarray(rows), np.zeros(rows.shape[:2], dtype=np.bool_)
    last = np.full(rows.shape[1], np.inf)  # when each leaps next
    new = np.append(0, 1 + np.flatnonzero(stirred(rows[1:], rows[:-1]).any(axis=1)))  # a slow sensor repeats postures
    until = np.append(new[1:], len(rows))
    for k in range(len(new) - 1, -1, -1):
        t = new[k]
        found[t : until[k]] = last - times[t] < LONGEST
        if k > 1:
            before, earlier = new[k - 1], new[k - 2]
            leapt = hops.leaps(rows[t], rows[before], rows[earlier], times[t] - times[before], mirror)
            last = np.where(leapt, times[t], last)
    return found


def stirred(rows: Floats, before: Floats) -> Bools:
    """(..., J) joints that are elsewhere than in the frame before, of positions (..., J, 3), NaN = missing."""
    apart = rows - before
    return np.asarray((np.isfinite(apart) & (apart != 0.0)).any(axis=-1))
