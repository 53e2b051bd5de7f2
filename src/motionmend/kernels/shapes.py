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
def apart(queries: Singles, columns: Singles) -> Singles:
    """(T, B, M) squared distances bone by bone, of queries (T, B, 4) from samples (4, B, M) that lie as columns."""
    found = np.empty((queries.shape[0], columns.shape[1], columns.shape[2]), dtype=np.float32)
    for t in range(queries.shape[0]):
        for b in range(columns.shape[1]):
            x, y, z, length = queries[t, b, 0], queries[t, b, 1], queries[t, b, 2], queries[t, b, 3]
            for m in range(columns.shape[2]):
                found[t, b, m] = (
                    (x - columns[0, b, m]) * (x - columns[0, b, m])
                    + (y - columns[1, b, m]) * (y - columns[1, b, m])
                    + (z - columns[2, b, m]) * (z - columns[2, b, m])
                    + (length - columns[3, b, m]) * (length - columns[3, b, m])
                )
    return found
