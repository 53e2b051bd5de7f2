"""Distances from one query to every sample, samples lying as columns so that the sums run along memory."""

from ..arrays import Singles
from .compile import compiled


@compiled
def squared_distances(columns: Singles, query: Singles, weights: Singles, squared: Singles) -> None:
    """Weighted squared distances.

    Parameters
    ----------
    columns : (n, N), sample i in column i.
    query, weights : (n,); weights of the squared differences, not negative.
    squared : (N,) is written.
    """
    squared[:] = 0.0
    for k in range(columns.shape[0]):
        column, q, w = columns[k], query[k], weights[k]
        if w == 0.0:
            continue
        for i in range(columns.shape[1]):
            difference = column[i] - q
            squared[i] += w * difference * difference
