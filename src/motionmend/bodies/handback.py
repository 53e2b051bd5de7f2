"""Poses of the performer as a motion of another skeleton, for .amc and .bvh files."""

import numpy as np

from ..arrays import Floats
from ..errors import MismatchError
from ..kernels.body import Posed
from .ik import solve
from .motion import Motion
from .performer import BONES, LANDMARK_BONES, Performer, Poses
from .rig import Rig, rig_of
from .skeleton import ROTATION, Skeleton, forward, positions

NEAR_START = 0.02  # m of miss that weigh as much as one radian away from the rotations' own answer
MET = 1e-3  # m; frames whose joints all lie within this are left as the rotations put them
ROUNDS, CHUNK = 30, 500  # of the search, and frames that are searched side by side


def motion_of(poses: Poses, performer: Performer, skeleton: Skeleton, fps: float) -> Motion:
    """Poses as a motion of a skeleton that has the 16 joints: bends of chest and head shared out over spine and neck.

    Parameters
    ----------
    poses : T, in world axes in which the skeleton's root is to move; NaN where the performer was not seen.
    performer : whose poses they are.
    skeleton : best that of the performer.
    fps : Hz.

    Returns
    -------
    Motion : the skeleton's rotations in closed form, then adjusted so that its joints lie where the performer's are as
        far as they can; joints that the performer has not are at rest. NaN in frames that are not seen.
    """
    rig = rig_of(skeleton)
    frames = performer_frames(poses, performer)
    bone, place = frames[:, :, :3, :3], frames[:, :, :3, 3]
    landmark = np.einsum("tbij,bj->tbi", bone[:, LANDMARK_BONES], performer.landmark_place) + place[:, LANDMARK_BONES]
    seen = np.flatnonzero(np.isfinite(landmark).all(axis=(1, 2)))
    q = np.full((len(poses), len(skeleton.dof_names)), np.nan)
    if len(seen):
        q[seen] = _angles(skeleton, rig, bone[seen] @ np.swapaxes(rig.rests, -1, -2))
        q[seen] += _shift(skeleton, rig.roles.pelvis, q[seen], landmark[seen, 0])
        joints, columns = _placed(rig)
        away = np.linalg.norm(positions(skeleton, q)[:, joints] - landmark[:, columns], axis=2).max(axis=1)
        missed = seen[away[seen] > MET]
        for some in np.array_split(missed, -(-len(missed) // CHUNK) or 1):
            targets = landmark[some][:, columns]
            q[some] = solve(skeleton, q[some], joints, targets, rest_weight=NEAR_START, max_iterations=ROUNDS).q
        for d in np.flatnonzero(skeleton.dof_kind == ROTATION):
            q[seen, d] = np.unwrap(q[seen, d])
    return Motion(skeleton, q, fps)


def _placed(rig: Rig) -> tuple[list[int], list[int]]:
    """The skeleton's joints that are to be placed, and which of `LANDMARKS` each is."""
    part = rig.roles
    joints, columns = [part.pelvis, part.chest, part.head], [0, 1, 2]
    if len(part.head_end) == 1:
        joints.append(part.head_end[0])
        columns.append(3)
    for arm in part.arms:
        joints += [arm.shoulder, arm.elbow, arm.wrist]
    for side in (0, 1):
        joints += [part.feet.hips[side], part.feet.knees[side], part.feet.ankles[side]]
    return joints, columns + list(range(4, 16))


def performer_frames(poses: Poses, performer: Performer) -> Floats:
    """World from bone, (T, 15, 4, 4), of many poses; NaN for those with NaN."""
    from ..kernels import articulated

    frames = np.full((len(poses), len(BONES), 4, 4), np.nan)
    for t in range(len(poses)):
        if np.isfinite(poses.translation[t]).all() and np.isfinite(poses.joints[t]).all():
            posed = Posed(poses.translation[t].copy(), poses.root[t].copy(), poses.joints[t].copy())
            articulated.frames(performer.chain, posed, frames[t])
    return frames


def _angles(skeleton: Skeleton, rig: Rig, turned: Floats) -> Floats:
    """(T, D) the angles whose rotations come nearest to those (T, 15, 3, 3), world from each bone's joint."""
    from scipy.spatial.transform import Rotation

    part, count = rig.roles, len(turned)
    # Of bones that turn with one joint, as all of a trunk without a spine do, the one nearest the pelvis says how.
    world = {int(rig.joints[b]): turned[:, b] for b in reversed(range(len(BONES)))}
    pelvis, chest = turned[:, 0], turned[:, BONES.index("chest")]
    for joints, begin, end in (
        (part.spine, pelvis, chest),
        (part.neck, chest, turned[:, BONES.index("head")]),
    ):
        bend = Rotation.from_matrix(np.swapaxes(begin, -1, -2) @ end).as_rotvec()
        for index, joint in enumerate(joints):
            world[joint] = begin @ Rotation.from_rotvec(bend * (index + 1) / len(joints)).as_matrix()
    q = np.zeros((count, len(skeleton.dof_names)))
    reached = np.empty((count, len(skeleton.names), 3, 3))
    for joint, parent in enumerate(skeleton.parents):
        above = np.broadcast_to(np.eye(3), (count, 3, 3)) if parent < 0 else reached[:, parent]
        rows = np.array([d for d in skeleton.dofs_of(joint) if skeleton.dof_kind[d] == ROTATION], dtype=np.int64)
        wanted = world.get(joint)
        if parent < 0 and wanted is None:
            wanted = pelvis  # a root above the pelvis carries it
        reached[:, joint] = above
        if len(rows) and wanted is not None:
            q[:, rows] = _decomposed(np.swapaxes(above, -1, -2) @ wanted, skeleton.dof_axis[rows])
            for d in rows:
                reached[:, joint] = (
                    reached[:, joint] @ Rotation.from_rotvec(q[:, d, None] * skeleton.dof_axis[d]).as_matrix()
                )
    return q


def _decomposed(between: Floats, axes: Floats) -> Floats:
    """Angles (T, n) about n axes, the first nearest the parent, whose product comes nearest to rotations (T, 3, 3)."""
    from scipy.spatial.transform import Rotation

    if len(axes) == 1:
        axis = axes[0]
        turned = Rotation.from_matrix(between).as_quat()
        angle = 2 * np.arctan2(turned[:, :3] @ axis, turned[:, 3])
        return np.asarray(angle - 2 * np.pi * np.round(angle / (2 * np.pi)))[:, None]
    if len(axes) == 2:
        axes = np.stack((axes[0], axes[1], np.cross(axes[0], axes[1])))
        return _decomposed(between, axes)[:, :2]
    if len(axes) != 3 or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6):
        raise MismatchError("joints must turn about one, two or three axes at right angles")
    # R = A1 A2 A3 about orthonormal axes: change to the axes' own coordinates, where it is a product about x, y, z.
    local = axes @ between @ axes.T
    handed = float(np.sign(np.linalg.det(axes)))
    first = np.arctan2(-handed * local[:, 1, 2], local[:, 2, 2])
    second = np.arctan2(handed * local[:, 0, 2], np.hypot(local[:, 0, 0], local[:, 0, 1]))
    third = np.arctan2(-handed * local[:, 0, 1], local[:, 0, 0])
    return _continued(np.stack((first, second, third), axis=1))


def _continued(angles: Floats) -> Floats:
    """The one of the two ways to write each rotation (T, 3) that lies nearest to the frame before."""
    twin = np.stack((angles[:, 0] + np.pi, np.pi - angles[:, 1], angles[:, 2] + np.pi), axis=1)
    chosen = np.empty_like(angles)
    before = np.zeros(3)
    for t in range(len(angles)):
        best = np.inf
        for one in (angles[t], twin[t]):
            near = one - 2 * np.pi * np.round((one - before) / (2 * np.pi))
            away = float(np.abs(near - before).sum())
            if away < best:
                best, chosen[t] = away, near
        before = chosen[t]
    return chosen


def _shift(skeleton: Skeleton, pelvis: int, q: Floats, wanted: Floats) -> Floats:
    """(T, D) what the root's translations must add for the pelvis to lie where it is wanted (T, 3)."""
    rows = [d for d in range(len(skeleton.dof_names)) if skeleton.dof_kind[d] != ROTATION]
    rows = [d for d in rows if skeleton.dof_joint[d] == skeleton.dof_joint[rows[0]]]
    if len(rows) < 3:
        raise MismatchError("a motion of the performer needs a skeleton whose root moves along three axes")
    added = np.zeros_like(q)
    axes = skeleton.dof_axis[rows]
    added[:, rows] = np.linalg.solve(axes.T, (wanted - forward(skeleton, q)[0][:, pelvis]).T).T
    return added
