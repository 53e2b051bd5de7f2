"""Joints moved so that bones have given lengths, and made steady."""

from math import exp, isfinite, sqrt
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled

STEADY = 0.35  # temporal weight of a live frame by that of the posture, at 30 Hz; at higher rates for each frame
MOVING = 0.5  # m/s; what was put out last tells speed less well than a whole recording does
SLOW_SECONDS = 0.16  # how slowly joints give way live: 1 / (2 pi 1 Hz)
ROUNDS = 20  # of relaxation
LOOSE = 4.0  # how much more a joint moves that is not trusted
BREAK_STEPS = 5.0  # usual steps of time; nothing is steadied over longer breaks
ACQUAINTED = 600.0  # frames after which lengths no longer follow


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
def followed_slowly(before: Floats, now: Floats, seconds: float, lasting: float) -> Floats:
    """A correction (J, 3) m that follows what is asked for, smoothly.

    Parameters
    ----------
    before : (J, 3) as it was; NaN = not known.
    now : (J, 3) what is asked for.
    seconds : since then; NaN = not known.
    lasting : s, in which all but a share of 1 / e of a change is followed.
    """
    share = 1.0 - exp(-max(seconds, 0.0) / lasting) if seconds < 1.0 else 1.0
    after = np.empty(now.shape)
    for j in range(now.shape[0]):
        for d in range(3):
            slow = before[j, d] + share * (now[j, d] - before[j, d])
            after[j, d] = slow if isfinite(slow) else now[j, d]
    return after


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
) -> Any:
    """One live frame made steady, its bones kept.

    Parameters
    ----------
    positions, trust : (J, 3) m, NaN = missing; (J,) in [0, 1].
    bones, prior : (B, 2) parent and child, parents' bones first; (B,) m, lengths to begin with, NaN = not known.
    first, second : s since the frame before, and from the one before that; NaN = none.
    last, earlier : (J, 3) m, what was put out then.
    sums : (2, B) of lengths in m, and how many.
    yielded : (J, 3) m, how far joints gave way to their bones.

    Returns
    -------
    positions (J, 3), sums of lengths and counts (2, B), how far joints gave way (J, 3).
    """
    joints, count = positions.shape[0], bones.shape[0]
    calm, begun, lengths = positions.copy(), np.empty((1, joints, 3)), np.empty((1, count))
    after, mobility = np.empty(sums.shape), np.empty((1, joints))
    if 0.0 < first < BREAK_STEPS * second and second < BREAK_STEPS * first:
        most = STEADY * min((1.0 / (30.0 * first)) ** 4, 1.0)  # more would ring: the past alone cannot damp it
        for j in range(joints):
            square = 0.0
            for d in range(3):
                square += (last[j, d] - earlier[j, d]) ** 2
            rest = 1.0 / (1.0 + (square / (second * MOVING) ** 2) ** 2)
            weight = most * (1.0 - (1.0 - rest) * trust[j])  # a believed joint that moves needs no steadying
            for d in range(3):  # eq. 20, whose minimum is a division
                ahead = last[j, d] + (last[j, d] - earlier[j, d]) * (first / second)
                if isfinite(ahead):
                    calm[j, d] += weight * (ahead - positions[j, d]) / (1.0 + weight)
    for b in range(count):
        p, c = bones[b, 0], bones[b, 1]
        length = sqrt((calm[c, 0] - calm[p, 0]) ** 2 + (calm[c, 1] - calm[p, 1]) ** 2 + (calm[c, 2] - calm[p, 2]) ** 2)
        there = isfinite(length)
        share = min(trust[p], trust[c]) if there else 0.0
        fade = ACQUAINTED / max(sums[1, b], ACQUAINTED)
        after[0, b] = sums[0, b] * fade + (share * length if share > 0.0 else 0.0)
        after[1, b] = sums[1, b] * fade + share
        start = prior[b] if isfinite(prior[b]) else (length if there else 0.0)
        lengths[0, b] = (after[0, b] + 5.0 * start) / (after[1, b] + 5.0)
    for j in range(joints):
        mobility[0, j] = 1.0 + LOOSE * (1.0 - trust[j])
        for d in range(3):
            begun[0, j, d] = calm[j, d] + (yielded[j, d] if isfinite(yielded[j, d]) else 0.0)
    relaxed = settle(begun, bones, lengths, mobility, ROUNDS)
    gave = followed_slowly(yielded, relaxed[0] - calm, first, SLOW_SECONDS)
    for j in range(joints):
        for d in range(3):
            begun[0, j, d] = calm[j, d] + gave[j, d]
    return settle(begun, bones, lengths, mobility, 0)[0], after, gave
