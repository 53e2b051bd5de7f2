"""Random bodies for the tests."""

import numpy as np
from hypothesis import strategies as st

from motionmend.bodies.skeleton import Skeleton


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
