"""How alike two moments are, by where the markers about them are, by time and by whose they are."""

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled


@compiled
def moments_alike(
    one: Floats,
    other: Floats,
    clip: Ints,
    clips: Ints,
    frame: Ints,
    frames: Ints,
    edges: Ints,
    reach: Floats,
    linear: Floats,
    near: Floats,
    own_linear: Floats,
    own_near: Floats,
    lasting: Floats,
    alike: bool,
) -> Floats:
    """(N, N') covariance of moments of which features in groups are known.

    Parameters
    ----------
    one, other : (N, F) and (F, N') C-contiguous features; `other` has them in rows.
    clip, clips : (N,) and (N',) whose moment it is; 0 is the recording.
    frame, frames : (N,) and (N',) of moments of the recording.
    edges : (G + 1,) of the groups among the features.
    reach : (G,) of a bell in the features.
    linear, near : (G,) variances of what goes with the features, and with the bell, in all clips.
    own_linear, own_near : (G,) of what does in each clip for itself.
    lasting : (L,) covariance of two moments of the recording so many frames apart; longer than they are.
    alike : both are the same moments: what lies over the diagonal is not worked out anew.
    """
    rows, columns, groups = len(one), len(clips), len(reach)
    found = np.empty((rows, columns))
    inner = np.empty(columns)
    squares, square = np.zeros((groups, columns)), np.zeros(groups)
    for g in range(groups):
        for f in range(edges[g], edges[g + 1]):
            for j in range(columns):
                squares[g, j] += other[f, j] * other[f, j]
    for i in range(rows):
        count = i + 1 if alike else columns
        for j in range(count):
            found[i, j] = 0.0
            if clip[i] == 0 and clips[j] == 0:
                found[i, j] = lasting[abs(frame[i] - frames[j])]
        for g in range(groups):
            square[g] = 0.0
            for j in range(count):
                inner[j] = 0.0
            for f in range(edges[g], edges[g + 1]):
                value = one[i, f]
                square[g] += value * value
                for j in range(count):
                    inner[j] += value * other[f, j]
            narrow = -0.5 / (reach[g] * reach[g])
            for j in range(count):
                bell = np.exp(narrow * (square[g] + squares[g, j] - 2.0 * inner[j]))
                if clip[i] == clips[j]:
                    found[i, j] += (linear[g] + own_linear[g]) * inner[j] + (near[g] + own_near[g]) * bell
                else:
                    found[i, j] += linear[g] * inner[j] + near[g] * bell
    if alike:
        for i in range(rows):
            for j in range(i):
                found[j, i] = found[i, j]
    return found
