"""Random bodies for the tests."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.skeleton import ROTATION, Skeleton


def random_skeleton(rng, joints=8, translations=True):
    """A tree with 0 to 4 DOFs a joint about random axes; the root has at least one."""
    parents = np.array([-1] + [int(rng.integers(0, j)) for j in range(1, joints)])
    owners = np.sort(rng.integers(0, joints, size=2 * joints))
    owners[0] = 0
    axes = rng.normal(size=(len(owners), 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    kinds = rng.integers(0, 2 if translations else 1, size=len(owners))
    return Skeleton(
        names=tuple(f"j{j}" for j in range(joints)),
        parents=parents,
        offsets=rng.normal(size=(joints, 3)) * 0.3,
        dof_names=tuple(f"j{j}.d{i}" for i, j in enumerate(owners)),
        dof_joint=owners,
        dof_axis=axes,
        dof_kind=kinds,
        limits=np.tile([-np.inf, np.inf], (len(owners), 1)),
    )


@st.composite
def skeletons(draw, max_joints=9):
    """A random tree and a generator seeded alike."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return random_skeleton(rng, draw(st.integers(1, max_joints))), rng


def turned_otherwise(motion, joints):
    """The same motion with the first and last rotation of these joints exchanged, each of three about square axes."""
    skeleton, q = motion.skeleton, motion.q.copy()
    names, axes, limits = list(skeleton.dof_names), skeleton.dof_axis.copy(), skeleton.limits.copy()
    for joint in joints:
        rows = [row for row in skeleton.dofs_of(joint) if skeleton.dof_kind[row] == ROTATION]
        assert len(rows) == 3
        turns = Rotation.identity(motion.frames)
        for row in rows:
            turns = turns * Rotation.from_rotvec(q[:, row, None] * skeleton.dof_axis[row])
        back = rows[::-1]
        q[:, rows] = np.unwrap(turns.as_davenport(skeleton.dof_axis[back], "intrinsic"), axis=0)
        axes[rows], limits[rows] = skeleton.dof_axis[back], skeleton.limits[back]
        for row, other in zip(rows, back, strict=True):
            names[row] = skeleton.dof_names[other]
    return replace(motion, skeleton=replace(skeleton, dof_names=tuple(names), dof_axis=axes, limits=limits), q=q)
