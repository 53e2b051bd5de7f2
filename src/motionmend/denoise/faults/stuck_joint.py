"""A joint that froze by itself: all its angles, or one, repeat to the last digit while the rest goes on, and then leap.

A joint rests at a limit as well, and leaves it by a leap when others kick. But a limit is where it comes back to, or as
far as it ever goes. Several that hold and leap together, as a foot and its toes, were recorded so, or froze as a whole;
but for long no solver leaves a limb behind.
"""

from collections.abc import Iterator

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ..channels.joints import root_rows
from .frozen import LEAPS, at_limit, parts_of, repeats

FEWEST = 2  # repeats of a joint
ALONE = 0.2  # s of repeats of one of its angles, which digits of 0.1 to 1 degree repeat for less
RECORDED_SO = 1.3  # s for which several joints may hold and leap together


def stuck_joints(motion: Motion, lost: Bools) -> Bools:
    """Samples of single joints that are frozen.

    Parameters
    ----------
    motion : T frames, D channels.
    lost : (T, D) samples known to be wrong.

    Returns
    -------
    (T, D) True where a joint repeats the sample before in all its angles, or in one, which then leap on. The first of
    such a run is good.
    """
    stuck: dict[tuple[int, int], dict[int, list[Ints]]] = {}
    root = np.concatenate(root_rows(motion.skeleton))
    for columns, values, step in parts_of(motion):
        if np.isin(columns, root).any():
            continue
        joint = int(motion.skeleton.dof_joint[columns[0]])
        for some, of_these, fewest in _together_and_alone(columns, values, motion.fps):
            runs = repeats(of_these, step, motion.fps)
            for n in np.flatnonzero((runs.out > LEAPS) & (runs.stop - runs.start >= fewest)):
                start, stop = int(runs.start[n]) + 1, int(runs.stop[n]) + 1
                if not lost[start:stop, some].any() and not at_limit(of_these, start - 1, stop):
                    stuck.setdefault((start, stop), {}).setdefault(joint, []).append(some)
    found: Bools = np.zeros(lost.shape, dtype=np.bool_)
    for (start, stop), joints in stuck.items():
        if len(joints) == 1 or stop - start > RECORDED_SO * motion.fps:  # of others `frozen` has judged
            found[start:stop, np.concatenate([some for of_joint in joints.values() for some in of_joint])] = True
    return found


def _together_and_alone(columns: Ints, values: Floats, fps: float) -> Iterator[tuple[Ints, Floats, float]]:
    """A joint's channels (N,) and samples (T, N), and each of several by itself, with the fewest repeats asked."""
    yield columns, values, FEWEST
    if len(columns) > 1:
        for n in range(len(columns)):
            yield columns[[n]], values[:, [n]], max(FEWEST, ALONE * fps)
