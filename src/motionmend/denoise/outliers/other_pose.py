"""Where a limb passes to another of its solver's poses: the ball joint leaps, and what its limb ends in does not.

Markers that hide leave a thigh free to turn about the line from hip to ankle. A solver then writes one pose after
another, with the knee a hand's breadth and more apart, and the ankle where it was. An outlier takes what hangs on it
with it: of angles that are off by chance, not one in a hundred leaves the limb's end where it is.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints, runs
from ...bodies.skeleton import Skeleton, forward, wrapped
from ..channels.joints import DEGREES, triples, unit

TURN, STEP = 45.0, 20.0  # degrees that the joint turns from one frame to the next, and two of its angles step
IN_PLACE = 0.15  # of the way that a turn by so much takes the limb's end if its axis is at right angles to the limb
SHORTEST, LONGEST = 2, 1.0  # frames from the first such leap to the last, and s from each to the next


def other_poses(angles: Floats, skeleton: Skeleton, columns: Ints, fps: float) -> Bools:
    """Samples between leaps of a limb from one pose to another.

    Parameters
    ----------
    angles : (T, C) degrees, NaN = missing; column c holds the skeleton's row `columns[c]`.
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.
    fps : Hz.

    Returns
    -------
    (T, C) True where a sample is no outlier: those of the ball joint, of the hinge and of the limb's end.
    """
    vouched = np.zeros(angles.shape, dtype=np.bool_)
    held = np.flatnonzero(columns >= 0)
    at = {int(columns[c]): int(c) for c in held}
    q = np.zeros((len(angles), len(skeleton.dof_names)))
    q[:, columns[held]] = np.nan_to_num(angles[:, held])
    q /= unit(skeleton)
    owner = skeleton.dof_joint[np.where(columns >= 0, columns, 0)]
    poses = None
    for rows in triples(skeleton):
        limb = _limb(skeleton, int(skeleton.dof_joint[rows[0]]))
        if not limb or not all(int(row) in at for row in rows):
            continue
        three = angles[:, [at[int(row)] for row in rows]]
        step = np.abs(wrapped(np.diff(three / DEGREES, axis=0))) * DEGREES
        leaps = (step > STEP).sum(axis=1) >= 2  # what is missing does not leap
        if leaps.sum() < 2:
            continue
        poses = poses or forward(skeleton, q)
        turn, in_place = _turns(*poses, limb, int(skeleton.parents[limb[0]]))
        leap = np.flatnonzero(leaps & (turn > TURN))
        for start, stop in runs(in_place[leap]):
            for some in np.split(leap[start:stop], np.flatnonzero(np.diff(leap[start:stop]) > LONGEST * fps) + 1):
                if some[-1] - some[0] >= SHORTEST:
                    vouched[some[0] + 1 : some[-1] + 1, np.isin(owner, limb) & (columns >= 0)] = True
    return vouched & np.isfinite(angles)


def _limb(skeleton: Skeleton, ball: int) -> tuple[int, ...]:
    """A ball joint, the only joint that hangs on it and the only one on that; none where a body branches or ends."""
    limb = [ball]
    while len(limb) < 3:
        hanging = np.flatnonzero(skeleton.parents == limb[-1])
        if ball == 0 or len(hanging) != 1:
            return ()
        limb.append(int(hanging[0]))
    return tuple(limb)


def _turns(place: Floats, axes: Floats, limb: tuple[int, ...], parent: int) -> tuple[Floats, Bools]:
    """(T - 1,) degrees that the ball joint turns to the next frame, and where the limb's end, seen from the body, does
    not go with it.

    Parameters
    ----------
    place, axes : (T, J, 3) m and (T, J, 3, 3) of all joints.
    limb : the ball joint, the next, and the limb's end.
    parent : the joint that carries the limb.
    """
    body = axes[:, parent].transpose(0, 2, 1)
    turned = body @ axes[:, limb[0]]
    turn = Rotation.from_matrix(turned[:-1].transpose(0, 2, 1) @ turned[1:]).magnitude()
    end = np.einsum("tij,tj->ti", body, place[:, limb[-1]] - place[:, limb[0]])
    way = np.linalg.norm(np.diff(end, axis=0), axis=1)
    by_turn = 2.0 * np.sin(0.5 * turn) * np.linalg.norm(end, axis=1)[1:]
    return np.asarray(turn * DEGREES), np.asarray(way < IN_PLACE * by_turn)
