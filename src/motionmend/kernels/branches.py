"""The path of least steps through the branches of three angles."""

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled


@compiled
def steadiest(triples: Floats, turns: Floats, centre: Floats, hold: float) -> Ints:
    """Which of the triples that mean the same rotation to take in each frame, so that they change least.

    A path costs its steps, the sum over the three angles, and for each frame how much further its triple lies from
    the centre than the nearest does, divided by `hold`.

    Parameters
    ----------
    triples : (T, W, 3) finite, T > 0; the twins of each frame.
    turns : (V, 3) what may be added to each of them.
    centre : (3,) in the same unit.
    hold : frames, above 0.

    Returns
    -------
    (T,) w V + v; the first of those that cost the same.

    Source
    ------
    Viterbi, IEEE Transactions on Information Theory 13(2), 1967.
    """
    frames, twins = triples.shape[:2]
    count = len(turns)
    branches = twins * count
    here, there = np.empty((branches, 3)), np.empty((branches, 3))
    cost, through, away = np.empty(branches), np.empty(branches), np.empty(branches)
    came = np.empty((frames, branches), dtype=np.uint8)
    for t in range(frames):
        nearest = np.inf
        for b in range(branches):
            away[b] = 0.0
            for i in range(3):
                here[b, i] = triples[t, b // count, i] + turns[b % count, i]
                away[b] += abs(here[b, i] - centre[i])
            nearest = min(nearest, away[b])
        for b in range(branches):
            best, least = 0, np.inf
            for a in range(branches):
                if t == 0:
                    break
                step = 0.0
                for i in range(3):
                    step += abs(there[a, i] - here[b, i])
                if cost[a] + step < least:
                    best, least = a, cost[a] + step
            came[t, b] = best
            through[b] = (0.0 if t == 0 else least) + (away[b] - nearest) / hold
        for b in range(branches):
            cost[b] = through[b]
            for i in range(3):
                there[b, i] = here[b, i]
    chosen = np.empty(frames, dtype=np.int64)
    best = 0
    for b in range(branches):
        if cost[b] < cost[best]:
            best = b
    for t in range(frames - 1, -1, -1):
        chosen[t] = best
        best = came[t, best]
    return chosen
