"""Joints moved so that bones have given lengths."""

from math import exp, isfinite, sqrt
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from .compile import compiled
from .steadying import steady_frame

SLOW_SECONDS, REST_SECONDS = 0.16, 0.3  # how slowly joints give way live, when they move and at rest
STILL = 0.1  # m/s; what is slower is at rest: what others do is then no reason for it to tremble
ROUNDS = 20  # of relaxation
LOOSE = 4.0  # how much more a joint moves that is not trusted
PRIOR_SECONDS = 0.1  # for which lengths must be seen to count as much as those to begin with
ACQUAINTED_SECONDS = 0.6  # in which lengths are learned: bones that go on changing are none
LATER = 1.5  # how much more than the mean so far the latest frame counts then: the first ones know the person least
LONG_SECONDS = 0.2  # a frame speaks for no longer time than this
MEMORY_SECONDS = 60.0  # in which lengths follow from then on


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
def followed_slowly(
    before: Floats,
    now: Floats,
    seconds: float,
    lasting: float,
    resting: float,
    last: Floats,
    earlier: Floats,
    between: float,
) -> Floats:
    """A correction (J, 3) m that follows what is asked for, smoothly, and the more slowly where a joint is at rest.

    Parameters
    ----------
    before : (J, 3) as it was; NaN = not known.
    now : (J, 3) what is asked for.
    seconds : since then; NaN = not known.
    lasting, resting : s, in which all but a share of 1 / e of a change is followed; of joints that move and at rest.
    last, earlier, between : (J, 3) m, where joints were in two frames, and s between these; NaN = they move.
    """
    after = np.empty(now.shape)
    for j in range(now.shape[0]):
        long = lasting + (resting - lasting) * _rest(last[j], earlier[j], between)
        share = 1.0 - exp(-max(seconds, 0.0) / long) if seconds < 1.0 else 1.0
        for d in range(3):
            slow = before[j, d] + share * (now[j, d] - before[j, d])
            after[j, d] = slow if isfinite(slow) else now[j, d]
    return after


@compiled
def _rest(last: Floats, earlier: Floats, between: float) -> float:
    """How far a joint (3,) that came from `earlier` to `last` rests: 1 if it stays, half at `STILL`; 0 = unknown."""
    square = 0.0
    for d in range(3):
        square += (last[d] - earlier[d]) ** 2
    if not (between > 0.0 and isfinite(square)):
        return 0.0
    rest: float = 1.0 / (1.0 + (square / (between * STILL) ** 2) ** 2)
    return rest


@compiled
def settle_frame(
    positions: Floats,
    trust: Floats,
    bones: Ints,
    prior: Floats,
    belief: float,
    first: float,
    second: float,
    last: Floats,
    earlier: Floats,
    known: Floats,
    yielded: Floats,
    step: float,
    motion: Floats,
    later: Floats,
    steps: Floats,
    shaking: float,
) -> Any:
    """One live frame made steady, its bones kept.

    Parameters
    ----------
    positions, trust : (J, 3) m, NaN = missing; (J,) in [0, 1].
    bones, prior : (B, 2) parent and child, parents' bones first; (B,) m, lengths to begin with, NaN = not known.
    belief : in [0, 1], in those.
    first, second : s since the frame before, and from the one before that; NaN = none.
    last, earlier : (J, 3) m, what was put out then.
    known : (2, B) lengths so far in m, and s for which they were seen, 0 at first.
    yielded : (J, 3) m, how far joints gave way to their bones.
    step, motion, later, steps, shaking : s, (J, 13), (N, J, 3) m, (N,) s and m, of `steady_frame`.

    Returns
    -------
    positions (J, 3), lengths and seconds (2, B), how far joints gave way (J, 3), motion (J, 13), and where joints were
    before they gave way (J, 3).
    """
    joints, count = positions.shape[0], bones.shape[0]
    lengths = np.empty((1, count))
    calm, going = steady_frame(positions, step, motion, later, steps, shaking)
    steadied = calm.copy().reshape(1, joints, 3)
    after, mobility = np.empty(known.shape), np.empty((1, joints))
    passed = min(first, LONG_SECONDS) if first >= 0.0 else 1.0 / 30.0  # the first frame is one of a sensor at 30 Hz
    for b in range(count):
        p, c = bones[b, 0], bones[b, 1]
        length = sqrt(
            (positions[c, 0] - positions[p, 0]) ** 2
            + (positions[c, 1] - positions[p, 1]) ** 2
            + (positions[c, 2] - positions[p, 2]) ** 2
        )
        there = isfinite(length)
        share = passed * min(trust[p], trust[c]) if there else 0.0
        after[0, b], after[1, b] = known[0, b], min(known[1, b] + share, ACQUAINTED_SECONDS)
        if known[1, b] >= ACQUAINTED_SECONDS:
            after[0, b] += share / MEMORY_SECONDS * (length - known[0, b] if there else 0.0)
        elif share > 0.0:
            after[0, b] += min(LATER * share / after[1, b], 1.0) * (length - known[0, b])
        if isfinite(prior[b]) and after[1, b] + belief > 0.0:
            usual = PRIOR_SECONDS * belief
            lengths[0, b] = (after[1, b] * after[0, b] + usual * prior[b]) / (after[1, b] + usual)
        elif after[1, b] > 0.0:
            lengths[0, b] = after[0, b]
        else:
            lengths[0, b] = length if there else 0.0
    for j in range(joints):
        mobility[0, j] = 1.0 + LOOSE * (1.0 - trust[j])
    # Not from where joints gave way to before: what bones have nothing against would stay for ever.
    asked = settle(steadied, bones, lengths, mobility, ROUNDS)[0] - calm
    gave = followed_slowly(yielded, asked, first, SLOW_SECONDS, REST_SECONDS, last, earlier, second)
    return settle(steadied + gave, bones, lengths, mobility, 0)[0], after, gave, going, calm
