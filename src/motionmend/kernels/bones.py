"""Joints moved so that bones have given lengths, and made steady."""

from math import exp, isfinite, sqrt
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled


@compiled
def settle(positions: Floats, bones: Ints, lengths: Floats, mobility: Floats, rounds: int) -> Floats:
    """Positions whose bones have the lengths given, near to those that came.

    Each round goes through the bones and moves both ends along the bone, each by its mobility; what is left after the
    last round is taken up from the root outward, so that lengths are exact.

    Parameters
    ----------
    positions : (T, J, 3) m; bones with an end that is NaN are passed over.
    bones : (B, 2) parent and child, parents' bones first.
    lengths : (T, B) m; a bone of length NaN or 0 is free.
    mobility : (T, J) above 0; a joint moves the more the larger.
    rounds : of the relaxation.

    Returns
    -------
    (T, J, 3).

    Source
    ------
    Mueller et al., Position based dynamics, 2007, section 3.3.
    """
    settled = positions.copy()
    for t in range(len(positions)):
        for turn in range(rounds + 1):
            for b in range(len(bones)):
                p, c = bones[b, 0], bones[b, 1]
                wanted = lengths[t, b]
                square = 0.0
                for d in range(3):
                    apart = settled[t, c, d] - settled[t, p, d]
                    square += apart * apart
                if not (square > 1e-12 and wanted > 0.0):
                    continue
                over = 1.0 - wanted / np.sqrt(square)
                share = mobility[t, p] / (mobility[t, p] + mobility[t, c])
                if turn == rounds:
                    share = 0.0
                for d in range(3):
                    apart = settled[t, c, d] - settled[t, p, d]
                    settled[t, p, d] += share * over * apart
                    settled[t, c, d] -= (1.0 - share) * over * apart
    return settled


@compiled
def settle_frame(
    positions: Floats,
    trust: Floats,
    bones: Ints,
    prior: Floats,
    first: float,
    second: float,
    last: Floats,
    earlier: Floats,
    sums: Floats,
    yielded: Floats,
    steady: float,
    break_steps: float,
    acquainted: float,
    loose: float,
    slow_seconds: float,
    rounds: int,
) -> Any:
    """One live frame of `correct.settling.settled_frame`, where the parameters are told.

    Returns
    -------
    positions (J, 3), sums of lengths and counts (2, B), how far joints gave way (J, 3).
    """
    joints, count = positions.shape[0], bones.shape[0]
    calm, begun, lengths = positions.copy(), np.empty((1, joints, 3)), np.empty((1, count))
    after, mobility = np.empty(sums.shape), np.empty((1, joints))
    if 0.0 < first < break_steps * second and second < break_steps * first:
        weight = min(steady * (1.0 / (30.0 * first)) ** 4, 10.0)
        for j in range(joints):
            for d in range(3):  # eq. 20, whose minimum is a division
                ahead = last[j, d] + (last[j, d] - earlier[j, d]) * (first / second)
                if isfinite(ahead):
                    calm[j, d] += weight * (ahead - positions[j, d]) / (1.0 + weight)
    for b in range(count):
        p, c = bones[b, 0], bones[b, 1]
        length = sqrt((calm[c, 0] - calm[p, 0]) ** 2 + (calm[c, 1] - calm[p, 1]) ** 2 + (calm[c, 2] - calm[p, 2]) ** 2)
        there = isfinite(length)
        share = min(trust[p], trust[c]) if there else 0.0
        fade = acquainted / max(sums[1, b], acquainted)
        after[0, b] = sums[0, b] * fade + (share * length if share > 0.0 else 0.0)
        after[1, b] = sums[1, b] * fade + share
        start = prior[b] if isfinite(prior[b]) else (length if there else 0.0)
        lengths[0, b] = (after[0, b] + 5.0 * start) / (after[1, b] + 5.0)
    for j in range(joints):
        mobility[0, j] = 1.0 + loose * (1.0 - trust[j])
        for d in range(3):
            begun[0, j, d] = calm[j, d] + (yielded[j, d] if isfinite(yielded[j, d]) else 0.0)
    relaxed = settle(begun, bones, lengths, mobility, rounds)
    follows = 1.0 - exp(-max(first, 0.0) / slow_seconds) if first < 1.0 else 1.0
    gave = np.empty((joints, 3))
    for j in range(joints):
        for d in range(3):
            asked = relaxed[0, j, d] - calm[j, d]
            slow = yielded[j, d] + follows * (asked - yielded[j, d])
            gave[j, d] = slow if isfinite(slow) else asked
            begun[0, j, d] = calm[j, d] + gave[j, d]
    return settle(begun, bones, lengths, mobility, 0)[0], after, gave
