"""Postures told by their bones, and how far apart they are bone by bone."""

from math import sqrt

import numpy as np

from ..arrays import Floats, Ints, Singles
from .compile import compiled


@compiled
def directions(postures: Floats, bones: Ints, weight: float) -> Floats:
    """(T, B, 4) unit directions of bones times a weight, and their lengths.

    Parameters
    ----------
    postures : (T, J, 3) m.
    bones : (B, 2) parent and child.
    weight : m.
    """
    found = np.empty((postures.shape[0], bones.shape[0], 4))
    for t in range(postures.shape[0]):
        for b in range(bones.shape[0]):
            p, c = bones[b, 0], bones[b, 1]
            square = 0.0
            for d in range(3):
                along = postures[t, c, d] - postures[t, p, d]
                square += along * along
            length = sqrt(square)
            for d in range(3):
                found[t, b, d] = weight * (postures[t, c, d] - postures[t, p, d]) / max(length, 1e-9)
            found[t, b, 3] = length
    return found


@compiled
def apart(features: Floats, centre: Floats, columns: Singles) -> Singles:
    """How far postures are from samples, bone by bone.

    Parameters
    ----------
    features, centre : (T, B, 4), and what to take from them, (B, 4).
    columns : (4, B, M) of the samples, less that.

    Returns
    -------
    (T, B, M) squared distances.
    """
    found = np.empty((features.shape[0], columns.shape[1], columns.shape[2]), dtype=np.float32)
    query = np.empty(4, dtype=np.float32)
    for t in range(features.shape[0]):
        for b in range(columns.shape[1]):
            for d in range(4):
                query[d] = features[t, b, d] - centre[b, d]
            x, y, z, length = query[0], query[1], query[2], query[3]
            for m in range(columns.shape[2]):
                found[t, b, m] = (
                    (x - columns[0, b, m]) * (x - columns[0, b, m])
                    + (y - columns[1, b, m]) * (y - columns[1, b, m])
                    + (z - columns[2, b, m]) * (z - columns[2, b, m])
                    + (length - columns[3, b, m]) * (length - columns[3, b, m])
                )
    return found


@compiled
def told(
    like: Singles,
    weights: Floats,
    joints: Ints,
    mean: Floats,
    scouts: Singles,
    spread: Floats,
    floor: Floats,
    familiar: float,
    offsets: Floats,
    variance: Floats,
) -> None:
    """What points tell of joints (K,): offsets, and the variance of a coordinate.

    Where the whole posture is like none of the points, what some of its bones have in common with them tells little.

    Parameters
    ----------
    like : (T, K + 1, M) kernels of the joints, and last that of the whole posture.
    weights : (K, M, 3).
    mean : (J, 3) offsets far from all points.
    scouts : (S, S) inverse covariance of the first points.
    spread, floor : (J,) variance far from all points, and what stays however near they are.
    familiar : share of the variance that points take away from a posture that is known well enough to believe them all.
    offsets, variance : (T, J, 3), (T, J) written.
    """
    points, few = weights.shape[1], scouts.shape[0]
    near = np.empty(few, dtype=np.float32)
    for t in range(like.shape[0]):
        near[:] = 0.0
        for s in range(few):
            for r in range(few):
                near[r] += like[t, -1, s] * scouts[s, r]
        unknown = 1.0
        for s in range(few):
            unknown -= like[t, -1, s] * near[s]
        unknown = max(unknown, 0.0)
        share = min((1.0 - unknown) / familiar, 1.0)
        for j in range(mean.shape[0]):
            variance[t, j] = unknown * spread[j] + floor[j]
            for d in range(3):
                offsets[t, j, d] = mean[j, d]
        for k in range(len(joints)):
            x, y, z = 0.0, 0.0, 0.0  # many that cancel: their sum needs more than single precision
            for m in range(points):
                x += like[t, k, m] * weights[k, m, 0]
                y += like[t, k, m] * weights[k, m, 1]
                z += like[t, k, m] * weights[k, m, 2]
            offsets[t, joints[k], 0] += share * x
            offsets[t, joints[k], 1] += share * y
            offsets[t, joints[k], 2] += share * z
