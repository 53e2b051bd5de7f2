"""A joint that froze by itself: all its angles repeat to the last digit while the rest goes on, and then leap after it.

A joint rests at a limit as well, and leaves it by a leap when others kick. But a limit is where it comes back to, or as
far as it ever goes. Several that hold and leap together, as a foot and its toes, were recorded so, or froze as a whole.
"""

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ..channels.joints import root_rows
from .frozen import LEAPS, parts_of, repeats

FEWEST, LONGEST = 2, 1.3  # repeats and s; what is still for longer could not be filled without a library


def stuck_joints(motion: Motion, lost: Bools) -> Bools:
    """Samples of single joints that are frozen.

    Parameters
    ----------
    motion : T frames, D channels.
    lost : (T, D) samples known to be wrong.

    Returns
    -------
    (T, D) True where a joint repeats the sample before in all its angles, and then leaps on. The first of such a run is
    good.
    """
    stuck: dict[tuple[int, int], list[Ints]] = {}
    root = np.concatenate(root_rows(motion.skeleton))
    for columns, values, step in parts_of(motion):
        if np.isin(columns, root).any():
            continue
        runs = repeats(values, step, motion.fps)
        length = runs.stop - runs.start
        for some in np.flatnonzero((runs.out > LEAPS) & (length >= FEWEST) & (length <= LONGEST * motion.fps)):
            start, stop = int(runs.start[some]) + 1, int(runs.stop[some]) + 1
            if not lost[start:stop, columns].any() and not _limit(values, start - 1, stop):
                stuck.setdefault((start, stop), []).append(columns)
    found: Bools = np.zeros(lost.shape, dtype=np.bool_)
    for (start, stop), joints in stuck.items():
        if len(joints) == 1:  # of several that hold and leap as one `frozen` has judged
            found[start:stop, joints[0]] = True
    return found


def _limit(values: Floats, start: int, stop: int) -> bool:
    """Whether a joint (T, N) that is still in some frames is at a limit there, or where it is in others, too."""
    held = values[start]
    others = np.delete(values, slice(start, stop), axis=0)
    if (others == held).all(axis=1).any():
        return True
    far = (held >= np.nanmax(others, axis=0)) | (held <= np.nanmin(others, axis=0))
    return bool((far | (held == 0.0)).all())
