"""Positions, rotations and Jacobians down a tree of one-DOF joints.

Throughout: J joints, D degrees of freedom, T frames. `parents` (J,) int64 with -1 = root and parents before
children; `offsets` (J, 3) m; `first` (J + 1,) int64: joint j owns DOF rows first[j] to first[j + 1];
`axes` (D, 3) unit vectors; `kinds` (D,) uint8, 0 = rotation, 1 = translation; q in rad and m.
"""

from math import cos, sin

import numpy as np

from ..arrays import Bytes, Floats, Ints
from .compile import compiled


@compiled
def _turn(rotation: Floats, axis: Floats, angle: float) -> None:
    """Multiply `rotation` (3, 3) from the right by the rotation about the unit vector `axis`, in place."""
    c, s = cos(angle), sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    v = 1.0 - c
    # Rodrigues' formula, written out.
    m00, m01, m02 = x * x * v + c, x * y * v - z * s, x * z * v + y * s
    m10, m11, m12 = y * x * v + z * s, y * y * v + c, y * z * v - x * s
    m20, m21, m22 = z * x * v - y * s, z * y * v + x * s, z * z * v + c
    for i in range(3):
        a, b, d = rotation[i, 0], rotation[i, 1], rotation[i, 2]
        rotation[i, 0] = a * m00 + b * m10 + d * m20
        rotation[i, 1] = a * m01 + b * m11 + d * m21
        rotation[i, 2] = a * m02 + b * m12 + d * m22


@compiled
def _pose(
    parents: Ints,
    offsets: Floats,
    first: Ints,
    axes: Floats,
    kinds: Bytes,
    q: Floats,
    position: Floats,
    rotation: Floats,
) -> None:
    """One frame: q (D,) to `position` (J, 3) and `rotation` (J, 3, 3), both of the world.

    T_parent · Trans(offset) · D_1(q_1) · D_2(q_2) ···; a NaN spreads to whatever is multiplied after it.
    """
    for j in range(parents.shape[0]):
        p = parents[j]
        for i in range(3):
            if p < 0:
                position[j, i] = offsets[j, i]
                for k in range(3):
                    rotation[j, i, k] = 1.0 if i == k else 0.0
            else:
                position[j, i] = position[p, i]
                for k in range(3):
                    position[j, i] += rotation[p, i, k] * offsets[j, k]
                    rotation[j, i, k] = rotation[p, i, k]
        for d in range(first[j], first[j + 1]):
            if kinds[d] == 0:
                _turn(rotation[j], axes[d], q[d])
            else:
                for i in range(3):
                    along = 0.0
                    for k in range(3):
                        along += rotation[j, i, k] * axes[d, k]
                    position[j, i] += along * q[d]


@compiled
def forward(
    parents: Ints,
    offsets: Floats,
    first: Ints,
    axes: Floats,
    kinds: Bytes,
    q: Floats,
    position: Floats,
    rotation: Floats,
) -> None:
    """All frames: q (T, D) to `position` (T, J, 3) and `rotation` (T, J, 3, 3)."""
    for t in range(q.shape[0]):
        _pose(parents, offsets, first, axes, kinds, q[t], position[t], rotation[t])


@compiled
def positions(
    parents: Ints, offsets: Floats, first: Ints, axes: Floats, kinds: Bytes, q: Floats, position: Floats
) -> None:
    """All frames: q (T, D) to `position` (T, J, 3) only; the rotations are not kept."""
    rotation = np.empty((parents.shape[0], 3, 3))
    for t in range(q.shape[0]):
        _pose(parents, offsets, first, axes, kinds, q[t], position[t], rotation)


@compiled
def jacobian(
    parents: Ints,
    offsets: Floats,
    first: Ints,
    axes: Floats,
    kinds: Bytes,
    q: Floats,
    position: Floats,
    derivative: Floats,
) -> None:
    """One frame: q (D,) to `position` (J, 3) and its `derivative` (J, 3, D) by each DOF, in m/rad and m/m."""
    joints, dofs = parents.shape[0], axes.shape[0]
    rotation = np.empty((joints, 3, 3))
    _pose(parents, offsets, first, axes, kinds, q, position, rotation)
    axis = np.empty((dofs, 3))  # of the row, in the world
    origin = np.empty((dofs, 3))  # the point a rotation row turns about, in the world
    turned = np.empty((3, 3))
    point = np.empty(3)
    for j in range(joints):
        p = parents[j]
        for i in range(3):
            point[i] = offsets[j, i] if p < 0 else position[p, i]
            for k in range(3):
                if p < 0:
                    turned[i, k] = 1.0 if i == k else 0.0
                else:
                    point[i] += rotation[p, i, k] * offsets[j, k]
                    turned[i, k] = rotation[p, i, k]
        for d in range(first[j], first[j + 1]):
            for i in range(3):
                axis[d, i] = turned[i, 0] * axes[d, 0] + turned[i, 1] * axes[d, 1] + turned[i, 2] * axes[d, 2]
                origin[d, i] = point[i]
            if kinds[d] == 0:
                _turn(turned, axes[d], q[d])
            else:
                for i in range(3):
                    point[i] += axis[d, i] * q[d]
    derivative[:] = 0.0
    for j in range(joints):
        above = j
        while above >= 0:
            for d in range(first[above], first[above + 1]):
                if kinds[d] == 0:
                    x = position[j, 0] - origin[d, 0]
                    y = position[j, 1] - origin[d, 1]
                    z = position[j, 2] - origin[d, 2]
                    derivative[j, 0, d] = axis[d, 1] * z - axis[d, 2] * y
                    derivative[j, 1, d] = axis[d, 2] * x - axis[d, 0] * z
                    derivative[j, 2, d] = axis[d, 0] * y - axis[d, 1] * x
                else:
                    for i in range(3):
                        derivative[j, i, d] = axis[d, i]
            above = parents[above]
