"""Joints moved so that bones have given lengths."""

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
