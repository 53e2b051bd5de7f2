"""Lines between markers that stay the same distance apart, so that a cloud of points reads as a body."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.joint_sets import meanings

_LOOKED_AT = 240  # frames, spread evenly over the recording
_LOOSE = 0.04  # m, a pair across a joint that still belongs together (thigh and pelvis)
_REACH = 0.65  # m, longer than any bone segment
_STIFF, _NEAR = 0.006, 0.30  # m, pairs that also close triangles (head, pelvis, feet)


def are_joints(names: Sequence[str]) -> bool:
    """Whether most of these points are joints of a body by name; otherwise they are markers on its skin."""
    return 2 * sum(map(bool, meanings(names))) > len(names)


def rigid_edges(names: Sequence[str], positions: Floats) -> Ints:
    """Pairs of markers to join by a line.

    The pairs whose distance hardly changes form a graph; its minimum spanning forest (stiff and short pairs
    first) joins every marker to its neighbours on the same bone, and very stiff, short pairs among a
    marker's three nearest close the triangles of head, pelvis and feet.

    Parameters
    ----------
    names : (M,); two markers whose names begin with L and R are joined only when they are stiff, so that feet
        that stand still are not.
    positions : (T, M, 3) m, NaN = missing.

    Returns
    -------
    (E, 2) indices of markers, lower first, sorted.
    """
    frames, markers = positions.shape[:2]
    if frames == 0 or markers < 2:
        return np.empty((0, 2), np.int64)
    looked = positions[np.unique(np.linspace(0, frames - 1, min(frames, _LOOKED_AT)).astype(np.int64))]
    distance, spread = _distances(looked)
    side = np.array([name.rpartition(":")[2][:1].upper() for name in names])
    opposite = (side[:, None] == "L") & (side[None, :] == "R")
    near = (spread < np.where(opposite | opposite.T, _STIFF, _LOOSE)) & (distance < _REACH)
    first, second = np.nonzero(np.triu(near, 1))
    order = np.lexsort((second, first, (spread + 0.05 * distance)[first, second]))
    group = np.arange(markers)
    edges = set()
    for i, j in zip(first[order], second[order], strict=True):  # Kruskal's minimum spanning forest
        if group[i] != group[j]:
            group[group == group[j]] = group[i]
            edges.add((int(i), int(j)))
    stiff = near & (spread < _STIFF) & (distance < _NEAR)
    reach = np.where(stiff, distance, np.inf)
    for i in range(markers):
        nearest = np.argsort(reach[i], kind="stable")[:3]
        edges.update((min(i, int(j)), max(i, int(j))) for j in nearest if stiff[i, j])
    return np.array(sorted(edges), np.int64).reshape(-1, 2)


def _distances(looked: Floats) -> tuple[Floats, Floats]:
    """Median distance (M, M) of each pair and its robust spread (M, M), in m; inf where hardly ever seen."""
    markers = looked.shape[1]
    distance = np.full((markers, markers), np.inf)
    spread = np.full((markers, markers), np.inf)
    for i in range(markers):
        apart = np.linalg.norm(looked - looked[:, i : i + 1], axis=2)
        often = np.isfinite(apart).sum(axis=0) >= max(1, len(looked) // 5)
        if not often.any():
            continue
        low, distance[i, often], high = np.nanpercentile(apart[:, often], (5, 50, 95), axis=0)
        spread[i, often] = (high - low) / 3.3  # the standard deviation of normal noise, deaf to rare outliers
    np.fill_diagonal(distance, np.inf)
    return distance, spread
