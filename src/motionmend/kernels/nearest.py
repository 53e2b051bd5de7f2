"""Distances from one query to every sample, samples lying as columns so that the sums run along memory."""

from ..arrays import Ints, Singles
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


@compiled
def smallest(values: Singles, index: Ints, least: Singles) -> None:
    """The k smallest of some values, the smallest first; of equal ones the earlier.

    Parameters
    ----------
    values : (N,).
    index, least : (k,), k at most N, are written: where they are, and what they are.
    """
    known, most = 0, len(index)
    for i in range(len(values)):
        value = values[i]
        if known == most and not value < least[most - 1]:
            continue
        at = min(known, most - 1)
        while at > 0 and least[at - 1] > value:
            least[at], index[at] = least[at - 1], index[at - 1]
            at -= 1
        least[at], index[at] = value, i
        known = min(known + 1, most)
