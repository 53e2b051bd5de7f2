"""Rejected samples whose pose is smoother than the repair's: angles that jump where the body does not.

A chain of joints can pass from one set of angles to another while its bones hardly move: a thigh that turns about
itself is undone by the foot, an upper arm by the wrist, the root by both thighs. Each of these angles jumps for itself.
An outlier moves what hangs on it; so samples rejected together are taken as measured where the body moves more
smoothly with them than with what would replace them.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints, runs
from ...bodies.skeleton import Skeleton, forward
from ..channels.joints import root_angles, root_rows, unit

ONE_SIDED = 2  # frames at either end, where smoothness tells little
RIGHT_ANGLE, HALF_TURN, IN_PLACE, CALM = 90.0, 160.0, 0.15, 20.0  # degrees, degrees, m, degrees a frame
LEVER = 0.06  # m from a joint's axis, where its turns are looked at


def smoother_as_pose(measured: Floats, outlier: Bools, values: Floats, skeleton: Skeleton, columns: Ints) -> Bools:
    """Rejected samples without which the body would move less smoothly.

    Parameters
    ----------
    measured : (T, C) degrees and centimetres, NaN = missing; column c holds the skeleton's row `columns[c]`.
    outlier : (T, C) rejected.
    values : (T, C) the repair of an earlier round.
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.

    Returns
    -------
    (T, C) True where a rejected sample is no outlier.
    """
    ours = np.flatnonzero(columns >= 0)
    rejected = np.zeros((len(outlier), len(skeleton.dof_names)), dtype=bool)
    rejected[:, columns[ours]] = outlier[:, ours]
    moved = _moved(rejected, skeleton)
    if not moved.any():
        return np.zeros_like(outlier)
    together = _together(moved, skeleton)
    with_them = _bends(np.where(outlier, measured, values), skeleton, columns)
    without = _bends(values, skeleton, columns)
    count = int(together.max()) + 1
    costs = np.zeros((2, count))
    for later in range(3):  # the bend at t is of t - 1, t and t + 1
        label = together[later : len(together) - 2 + later]
        for cost, bend in zip(costs, (with_them, without), strict=True):
            cost += np.bincount(label.ravel(), bend.ravel(), count)
    better = costs[0] < costs[1]
    better[0] = False  # of what is not moved
    better[np.unique(together[[*range(ONE_SIDED), *range(-ONE_SIDED, 0)]])] = False
    joints = _joints_of(better[together[:, skeleton.dof_joint]] & rejected, skeleton)
    owner = np.where(columns >= 0, skeleton.dof_joint[columns], -1)
    # of what hangs together some may be outliers all the same; the other angles of a joint were measured with it
    joints &= _needed(joints, np.where(outlier & joints[:, owner], measured, values), values, owner, skeleton, columns)
    joints |= _turned_over(outlier, measured, values, owner, skeleton, columns)
    found = np.zeros_like(outlier)
    found[:, ours] = joints[:, owner[ours]]
    return found


def _turned_over(
    outlier: Bools, measured: Floats, values: Floats, owner: Ints, skeleton: Skeleton, columns: Ints
) -> Bools:
    """(T, J) rejected joints of a limb that is turned over: one by half a turn, and one that hangs on it with it.

    A solver finds two poses for the same markers: a thigh half a turn about itself, the knee bent the other way and the
    foot turned back. The knee leaps by it, so that the body moves no more smoothly with it than without.
    """
    away = np.abs(np.nan_to_num(measured - values)) > RIGHT_ANGLE
    away[:-1] &= np.abs(np.diff(np.nan_to_num(measured), axis=0)) < CALM
    rejected = np.zeros((len(outlier), len(skeleton.names)), dtype=np.bool_)
    far = np.zeros_like(rejected)
    for joint in range(len(skeleton.names)):
        own = owner == joint
        rejected[:, joint] = outlier[:, own].any(axis=1)
        far[:, joint] = (outlier & away)[:, own].any(axis=1)
    found = np.zeros_like(rejected)
    for joint in np.flatnonzero(far.any(axis=0)).tolist():
        above = int(skeleton.parents[joint])
        while above > 0:
            for start, stop in runs(far[:, joint] & far[:, above]):
                here = slice(start, stop)
                poses = np.where(outlier, measured, values)[here], values[here]
                if _half_a_turn(*poses, above, joint, skeleton, columns):
                    for one in (joint, above):
                        for first, last in runs(rejected[:, one]):
                            found[first:last, one] |= first < stop and last > start
            above = int(skeleton.parents[above])
    return found


def _half_a_turn(one: Floats, other: Floats, above: int, joint: int, skeleton: Skeleton, columns: Ints) -> bool:
    """Whether a joint is half a turn from another pose (T, C), and one that hangs on it, or one between, in its place
    where that begins or ends."""
    (place, rotation), (places, rotations) = (
        forward(skeleton, _angles(pose, skeleton, columns)) for pose in (one, other)
    )
    parent = int(skeleton.parents[above])
    first, second = (turns[:, parent].transpose(0, 2, 1) @ turns[:, above] for turns in (rotation, rotations))
    cosine = 0.5 * (np.einsum("tij,tij->t", first, second) - 1.0)
    if np.median(cosine) > np.cos(np.radians(HALF_TURN)):
        return False
    off = np.linalg.norm(place - places, axis=2)[[0, -1]].min(axis=0)
    while joint != above:
        if off[joint] < IN_PLACE:
            return True
        joint = int(skeleton.parents[joint])
    return False


def of_one_limb(skeleton: Skeleton, columns: Ints) -> Bools:
    """(C, C) True for two channels of one joint, or of joints of which one carries the other.

    Parameters
    ----------
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.
    """
    carries = np.eye(len(skeleton.names), dtype=np.bool_)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            carries[:, joint] |= carries[:, parent]
    owner = skeleton.dof_joint[columns]
    either = (carries | carries.T)[owner[:, None], owner]
    return np.asarray(either & (columns >= 0) & (columns >= 0)[:, None])


def _needed(joints: Bools, measured: Floats, values: Floats, owner: Ints, skeleton: Skeleton, columns: Ints) -> Bools:
    """Joints (T, J) without whose own samples, all others kept, the body would move less smoothly."""
    needed = np.zeros_like(joints)
    for joint in np.flatnonzero(joints.any(axis=0)):
        frames = np.flatnonzero(joints[:, joint])
        kept = measured[frames[:, None] + np.arange(-2, 3)]  # each with the two frames before and after it
        left = kept.copy()
        left[:, 2] = np.where(owner == joint, values[frames], kept[:, 2])
        first = 5 * np.arange(len(frames))[:, None] + np.arange(3)
        costs = (
            _bends(some.reshape(-1, len(columns)), skeleton, columns)[first].sum(axis=(1, 2)) for some in (kept, left)
        )
        needed[frames, joint] = np.less_equal(*costs)
    return needed


def _moved(rejected: Bools, skeleton: Skeleton) -> Bools:
    """(T, J) True where a joint's frame hangs on a rejected sample (T, D)."""
    moved = _joints_of(rejected, skeleton)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            moved[:, joint] |= moved[:, parent]
    return moved


def _joints_of(samples: Bools, skeleton: Skeleton) -> Bools:
    """(T, J) True for the joints that have one of these samples (T, D)."""
    return np.asarray(samples @ (skeleton.dof_joint[:, None] == np.arange(len(skeleton.names))))


def _together(moved: Bools, skeleton: Skeleton) -> Ints:
    """(T, J) which rejected samples a joint's frame hangs on: numbers from 1, one for all that share a limb, 0 = none.

    Samples belong together where one's joint carries the other's, in one frame or the next.
    """
    number = np.arange(moved.size).reshape(moved.shape)
    child = np.flatnonzero(skeleton.parents >= 0)
    parent = skeleton.parents[child]
    both = moved[:, child] & moved[:, parent]
    next_too = moved[1:] & moved[:-1]
    one = np.concatenate([number[:, child][both], number[1:][next_too]])
    other = np.concatenate([number[:, parent][both], number[:-1][next_too]])
    links = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(moved.size, moved.size))
    label = connected_components(links, directed=False)[1].reshape(moved.shape)
    found = np.zeros(moved.shape, dtype=np.int64)
    found[moved] = 1 + np.unique(label[moved], return_inverse=True)[1]
    return found


def _bends(values: Floats, skeleton: Skeleton, columns: Ints) -> Floats:
    """(T - 2, J) m^2: squared second differences of the joints' places, and of the ends' turns on a lever.

    Between its ends a limb turns about itself unseen, but for what hangs on it.
    """
    place, rotation = forward(skeleton, _angles(values, skeleton, columns))
    ends = np.setdiff1d(np.arange(len(skeleton.names)), skeleton.parents)
    bends = _squared_bends(place)
    bends[:, ends] += LEVER**2 * _squared_bends(rotation[:, ends].reshape(len(place), len(ends), 9))
    return bends


def _squared_bends(path: Floats) -> Floats:
    """(T - 2, J) squared second differences of paths (T, J, N)."""
    bend = path[:-2] - 2.0 * path[1:-1] + path[2:]
    return np.asarray(np.einsum("tji,tji->tj", bend, bend))


def _angles(values: Floats, skeleton: Skeleton, columns: Ints) -> Floats:
    """(T, D) rad and m: the skeleton's own angles in the travelling frame; what no channel holds is 0."""
    ours = columns >= 0
    q = np.zeros((len(values), len(skeleton.dof_names)))
    q[:, columns[ours]] = np.nan_to_num(values[:, ours])
    turns, moves = root_rows(skeleton)
    if len(turns):
        root = Rotation.from_rotvec(q[:, turns], degrees=True).as_matrix()
        q[:, turns] = root_angles(skeleton, turns, root)
    if len(moves):
        q[:, moves] = q[:, moves] @ np.linalg.inv(skeleton.dof_axis[moves])
    return np.asarray(q / unit(skeleton))
