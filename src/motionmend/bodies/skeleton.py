"""A body as a tree of one-DOF joints."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Bytes, Floats, Ints, frozen
from ..errors import MismatchError

ROTATION, TRANSLATION = 0, 1


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of joints, each moved by zero or more one-DOF rotations and translations.

    The joint's frame in the world is  T_parent · Trans(offset) · D_1(q_1) · D_2(q_2) ···, its DOF rows taken
    in the order of the table (first row = nearest the parent). A rotation row turns about `dof_axis`, a
    translation row moves along it; both are written in the frame of the joint at rest, which for every joint
    is parallel to the world.

    Attributes
    ----------
    names : (J,) joint names; a bone's far end without a joint of its own is a joint without DOFs,
        `<bone>_end`.
    parents : (J,) index of the parent, -1 = root, `parents[j] < j`.
    offsets : (J, 3) m, from the parent joint at rest.
    dof_names : (D,) `<joint>.<channel>` as the file names it, e.g. `lfemur.rx`, `Hips.Zrotation`.
    dof_joint : (D,) index of the joint each row moves, not decreasing.
    dof_axis : (D, 3) unit vectors.
    dof_kind : (D,) 0 rotation, 1 translation.
    limits : (D, 2) rad or m, -inf/inf where there is none.
    up : (3,) unit vector against gravity.
    """

    names: tuple[str, ...]
    parents: Ints
    offsets: Floats
    dof_names: tuple[str, ...]
    dof_joint: Ints
    dof_axis: Floats
    dof_kind: Bytes
    limits: Floats
    up: Floats = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "dof_names", tuple(self.dof_names))
        for name, dtype in (("parents", np.int64), ("dof_joint", np.int64), ("dof_kind", np.uint8)):
            object.__setattr__(self, name, frozen(getattr(self, name), dtype))
        for name in ("offsets", "dof_axis", "limits", "up"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        joints, dofs = len(self.names), len(self.dof_names)
        wanted = {
            "parents": (joints,),
            "offsets": (joints, 3),
            "dof_joint": (dofs,),
            "dof_axis": (dofs, 3),
            "dof_kind": (dofs,),
            "limits": (dofs, 2),
        }
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise MismatchError(f"skeleton {name} must be {shape}, came {getattr(self, name).shape}")
        if np.any(self.parents >= np.arange(joints)):
            raise MismatchError("a skeleton lists every parent before its children")
        if dofs and np.any(np.diff(self.dof_joint) < 0):
            raise MismatchError("a skeleton lists its DOF rows joint by joint")

    def dofs_of(self, joint: int) -> Ints:
        """Rows of the DOF table that move `joint`, in chain order."""
        return np.flatnonzero(self.dof_joint == joint).astype(np.int64)


def turned_in_other_order(skeleton: Skeleton, names: Sequence[str]) -> Ints:
    """Joints whose rotations follow each other otherwise than among other channels' names: their angles mean another
    thing, though they are called the same.

    Parameters
    ----------
    skeleton : D degrees of freedom.
    names : channels of another skeleton, in its order; those that it has not do not matter.

    Returns
    -------
    (N,) joints.
    """
    place = {name: k for k, name in enumerate(names)}
    there = np.array([place.get(name, -1) for name in skeleton.dof_names], dtype=np.int64)
    turns = (skeleton.dof_kind == ROTATION) & (there >= 0)
    back = (np.diff(there[turns]) < 0) & (np.diff(skeleton.dof_joint[turns]) == 0)
    return np.unique(skeleton.dof_joint[turns][1:][back])


def forward(skeleton: Skeleton, q: Floats) -> tuple[Floats, Floats]:
    """World frames of all joints over time.

    Parameters
    ----------
    skeleton : the body, J joints and D degrees of freedom.
    q : (T, D) rad and m. A NaN makes the joints below it NaN, and of the joint itself what the missing DOF
        moves: a translation its position, a rotation its rotation.

    Returns
    -------
    positions : (T, J, 3) m.
    rotations : (T, J, 3, 3), joint to world.

    Raises
    ------
    MismatchError : when q is not (T, D).
    """
    from ..kernels import chain

    q = _checked(skeleton, q)
    joints = len(skeleton.names)
    position = np.empty((q.shape[0], joints, 3))
    rotation = np.empty((q.shape[0], joints, 3, 3))
    chain.forward(*_chain(skeleton), q, position, rotation)
    return position, rotation


def positions(skeleton: Skeleton, q: Floats) -> Floats:
    """World positions (T, J, 3) in m for q (T, D) in rad and m: `forward` without the rotations."""
    from ..kernels import chain

    q = _checked(skeleton, q)
    position = np.empty((q.shape[0], len(skeleton.names), 3))
    chain.positions(*_chain(skeleton), q, position)
    return position


def jacobian(skeleton: Skeleton, q: Floats) -> Floats:
    """Derivative of all joint positions by all degrees of freedom, in one pose.

    Parameters
    ----------
    skeleton : the body.
    q : (D,) rad and m.

    Returns
    -------
    (J, 3, D) m/rad for rotations, m/m for translations; zero where the DOF does not move the joint.

    Raises
    ------
    MismatchError : when q is not (D,).
    """
    from ..kernels import chain

    joints, dofs = len(skeleton.names), len(skeleton.dof_names)
    q = frozen(q)
    if q.shape != (dofs,):
        raise MismatchError(f"one pose of this skeleton has {dofs} values, came an array of shape {q.shape}")
    derivative = np.empty((joints, 3, dofs))
    chain.jacobian(*_chain(skeleton), q, np.empty((joints, 3)), derivative)
    return derivative


def wrapped(angles: Floats) -> Floats:
    """The same angles of any shape, rad, in [-pi, pi)."""
    return np.asarray((angles + np.pi) % (2 * np.pi) - np.pi)


def rest_positions(skeleton: Skeleton) -> Floats:
    """Joint positions (J, 3) in m with every degree of freedom at zero."""
    rest = np.array(skeleton.offsets)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            rest[joint] += rest[parent]
    return rest


def height(skeleton: Skeleton) -> float:
    """Extent of the rest pose along `up`, in m."""
    return float(np.ptp(rest_positions(skeleton) @ skeleton.up))


def same(one: Skeleton, other: Skeleton, tolerance: float = 1e-6) -> bool:
    """Whether joints and degrees of freedom are the same, all numbers within `tolerance` (m, rad)."""
    if (one.names, one.dof_names) != (other.names, other.dof_names):
        return False
    if any(not np.array_equal(getattr(one, n), getattr(other, n)) for n in ("parents", "dof_joint", "dof_kind")):
        return False
    return all(
        np.allclose(getattr(one, name), getattr(other, name), rtol=0.0, atol=tolerance)
        for name in ("offsets", "dof_axis", "limits", "up")
    )


def _checked(skeleton: Skeleton, q: Floats) -> Floats:
    q = frozen(q)  # read-only always: the kernels are compiled once, not once more for writeable arrays
    if q.ndim != 2 or q.shape[1] != len(skeleton.dof_names):
        raise MismatchError(
            f"poses of this skeleton are (frames, {len(skeleton.dof_names)}), came an array of shape {q.shape}"
        )
    return q


def _chain(skeleton: Skeleton) -> tuple[Ints, Floats, Ints, Floats, Bytes]:
    """The skeleton as the kernels take it: sorted by joint, each joint owns one stretch of the rows."""
    first = np.searchsorted(skeleton.dof_joint, np.arange(len(skeleton.names) + 1)).astype(np.int64)
    return skeleton.parents, skeleton.offsets, first, skeleton.dof_axis, skeleton.dof_kind
