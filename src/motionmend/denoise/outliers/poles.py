"""Where the angles of a ball joint jump although the joint does not: near the pole of its three angles.

Near the pole (the middle angle at a right angle) the outer two angles turn against each other by any amount while the
rotation hardly changes. An outlier in one angle turns the joint by just as much. So a sample that jumps in its
angles but not as a rotation is no outlier.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints
from ...bodies.skeleton import Skeleton
from ..channels.joints import DEGREES, triples
from ..channels.travel import turn

JUMP = 20.0  # degrees from between its neighbours: a step of the angles worth a look
AS_ROTATION = 1.0 / 3.0  # of the jump: as a rotation the sample is this much nearer
# frames before and after from which a sample is foretold: between two neighbours, or on from two on one side
NEIGHBOURS = ((-1, 1), (-2, -1), (1, 2), (-1, 2), (-2, 1))


def pole_crossings(angles: Floats, skeleton: Skeleton, columns: Ints) -> Bools:
    """Samples that jump in their angles but are smooth as rotations.

    Parameters
    ----------
    angles : (T, C) degrees, NaN = missing; column c holds the skeleton's row `columns[c]`.
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.

    Returns
    -------
    (T, C) True where a sample is no outlier.
    """
    vouched = np.zeros(angles.shape, dtype=bool)
    at = {int(row): c for c, row in enumerate(columns) if row >= 0}
    for rows in triples(skeleton):
        if not all(int(row) in at for row in rows):
            continue
        three = [at[int(row)] for row in rows]
        vouched[:, three] = _smooth_as_rotation(angles[:, three], skeleton.dof_axis[rows])[:, None]
    return vouched


def bends_of(samples: Bools) -> Bools:
    """(T, C) True where a second difference ends that one of the samples (T, C) takes part in."""
    touched = samples.copy()
    for later in (1, 2):
        touched[later:] |= samples[:-later]
    return touched


def _smooth_as_rotation(angles: Floats, axes: Floats) -> Bools:
    """(T,) True where three angles (T, 3) degrees jump and the rotation they make does not."""
    frames = len(angles)
    smooth = np.zeros(frames, dtype=bool)
    bend = np.abs(angles[:-2] - 2.0 * angles[1:-1] + angles[2:]).max(axis=1, initial=0.0)
    if frames < 3 or not (bend > JUMP).any():
        return smooth
    known: Bools = np.asarray(np.isfinite(angles).all(axis=1, keepdims=True))
    turns = np.where(known, angles, 0.0) / DEGREES
    first, second, third = (turn(turns[:, i], axes[i]) for i in range(3))
    rotations = first @ second @ third
    for before, after in NEIGHBOURS:
        t = np.arange(max(0, -before), frames - max(0, after))
        share = -before / (after - before)
        foretold = angles[t + before] + share * (angles[t + after] - angles[t + before])
        jump = np.abs(angles[t] - foretold).max(axis=1)
        t, jump = t[jump > JUMP], jump[jump > JUMP]
        one, other = rotations[t + before], rotations[t + after]
        between = Rotation.from_matrix(one.transpose(0, 2, 1) @ other).as_rotvec()
        expected = one @ Rotation.from_rotvec(share * between).as_matrix()
        cosine = (np.einsum("tij,tij->t", expected, rotations[t]) - 1.0) / 2.0
        apart = np.arccos(np.clip(cosine, -1.0, 1.0)) * DEGREES
        smooth[t[apart < AS_ROTATION * jump]] = True
    return smooth
