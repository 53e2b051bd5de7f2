"""A body that stands still to the last digit: the sensor says again what it said before, and measures nobody.

Who stands still sways, and sensors are noisy: no two frames are alike. Some sensors go on to say the last posture they
saw, or one of their own, once they have lost somebody, every joint tracked. Where the body is then nobody knows, the
less the longer it lasts.
"""

import numpy as np

from ..arrays import Bools, Floats
from .leaps import stirred
from .sight import Sight

LONGEST = 0.5  # s; slow sensors say each posture several times
SPEED = 0.8  # m/s, of each coordinate of somebody who walks on at 1.4


def repeated(positions: Floats, times: Floats) -> tuple[Bools, Floats]:
    """Frames of a recording in which nobody is measured, and for how long by then.

    Parameters
    ----------
    positions : (T, J, 3) m, NaN = missing. times : (T,) s.

    Returns
    -------
    (T,) True from the second of some frames on that are alike for more than half a second, where any frames before them
    are not; and (T,) s since the first of them.
    """
    there: Bools = np.asarray(np.isfinite(positions).any(axis=(1, 2)), np.bool_)
    stirs: Bools = np.asarray(stirred(positions[1:], positions[:-1]).any(axis=1), np.bool_)
    again = np.append(False, ~stirs & there[1:] & there[:-1])
    first = np.maximum.accumulate(np.where(again, 0, np.arange(len(times))))
    since = times - times[first]
    lasts = np.zeros(len(times))
    np.maximum.at(lasts, first, since)
    began = int(np.argmax(stirs)) if stirs.any() else len(times)
    return np.asarray(again & (lasts[first] > LONGEST) & (first > began)), since


def is_repeated(sight: Sight) -> bool:
    """The same live, of the last frame: of one who has moved before."""
    return sight.stale > LONGEST and bool(sight.moved.any() and np.isfinite(sight.rows).any())


def unmeasured(again: Bools, since: Floats, std: Floats, reliable: Floats) -> tuple[Floats, Floats]:
    """Deviations and reliability where some frames measure nobody: somebody may have gone on.

    Parameters
    ----------
    again, since : (T,) which frames do, and s since anybody was measured, of `repeated`.
    std, reliable : (T, J) m of a coordinate, and 0 to 1.
    """
    wider = np.sqrt(np.square(std) + np.square(SPEED * since)[:, None])
    return np.where(again[:, None], wider, std), np.where(again[:, None], 0.0, reliable)
