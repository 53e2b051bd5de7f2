"""What Kalman filters and Rauch-Tung-Striebel smoothers settle to where noise never changes and nothing is missing."""

import numpy as np

from ..arrays import Floats

_ENOUGH = 1e-10  # of the trace: each doubling adds the square of what the one before left out
_DOUBLINGS = 60


def settled_covariance(transition: Floats, information: Floats, process_cov: Floats) -> Floats:
    """(N, N) covariance of the predicted state, P = A P (I + G P)⁻¹ Aᵀ + Q.

    Parameters
    ----------
    transition : (N, N), A; what it lets grow has to be observed.
    information : (N, N), G = Hᵀ R⁻¹ H of one frame's observations.
    process_cov : (N, N), Q.

    Source
    ------
    Anderson, Second-order convergent algorithms for the steady-state Riccati equation, Int. J. Control 28(2), 1978.
    """
    size = len(transition)
    ahead, gained, found = transition.T.copy(), information.copy(), process_cov.copy()
    for _ in range(_DOUBLINGS):
        both = np.linalg.solve(np.eye(size) + gained @ found, np.hstack([ahead, gained]))
        more = ahead.T @ found @ both[:, :size]
        found = found + 0.5 * (more + more.T)
        further = ahead @ both[:, size:] @ ahead.T
        gained = gained + 0.5 * (further + further.T)
        ahead = ahead @ both[:, :size]
        if np.trace(more) <= _ENOUGH * np.trace(found):
            break
    return found


def settled_sum(rule: Floats, first: Floats) -> Floats:
    """(N, N) S = rule S ruleᵀ + first.

    Parameters
    ----------
    rule : (N, N), under which everything dies out.
    first : (N, N), symmetric.

    Source
    ------
    Smith, Matrix equation XA + BX = C, SIAM J. Applied Mathematics 16(1), 1968: the sum of the powers, doubled.
    """
    found, power = first.copy(), rule.copy()
    for _ in range(_DOUBLINGS):
        more = power @ found @ power.T
        found, power = found + more, power @ power
        if np.trace(more) <= _ENOUGH * np.trace(found):
            break
    return found
