"""Several ways to fill the gaps of joint angles, mixed as the recording's own gaps, laid elsewhere, say.

No way is best everywhere: bases know whole motions, dynamics know how poses follow each other, and a line is best where
the library knows neither. How much each of them errs, and how alike they err, is looked up where the truth is there.
"""

import numpy as np
from scipy.optimize import nnls

from ...arrays import Bools, Floats
from ..bases.support import interpolated
from .likeliest import Process, fill_likeliest
from .moved import Gap, alike

# Mean products of the errors of the smoother, of lines and of learned dynamics in gaps, relative to the smoother's
# mean square, as gaps laid in clean clips of CMU's showed them, and so many gaps' worth they count against what the
# recording shows.
USUAL = np.array([[1.0, 1.0, 0.55], [1.0, 3.2, 0.6], [0.55, 0.6, 0.7]])
USUALLY = 40.0


def fillings(values: Floats, gone: Bools, process: Process | None, fps: float) -> tuple[Floats, Floats]:
    """The gaps as the smoother has them, as lines, and as the likeliest under a process if there is one.

    Parameters
    ----------
    values : (T, C) of the smoother.
    gone : (T, C) True in gaps.
    process : of clean motion.
    fps : Hz.

    Returns
    -------
    (F, T, C), and (T, C) the variance of what a process filled; 0 where none says anything.
    """
    sure = np.zeros(values.shape)
    found = [values, np.where(gone, interpolated(np.where(gone, np.nan, values)), values)]
    if process is not None:
        likeliest, sure = fill_likeliest(process, values, gone, fps)
        found.append(likeliest)
    return np.stack(found), sure


def shares(gaps: list[Gap], moved: list[Gap], away: Floats, telling: Bools) -> Floats:
    """(F, T, C) how much each filling counts in each gap; not below 0, 1 together, the first alone elsewhere.

    Parameters
    ----------
    gaps : of the recording, or moved ones, of which each is told by the others.
    moved : gaps laid where samples are.
    away : (F, T, C) errors of each filling inside the moved gaps.
    telling : (T, C) False for samples that say nothing of how far a repair errs.

    Source
    ------
    Bates and Granger, The combination of forecasts, Operational Research Quarterly 20(4), 1969: weights of least mean
    square error, here not below 0 and drawn towards what is usual.
    """
    count = len(away)
    usual = USUAL[:count, :count]
    shares = np.zeros(away.shape)
    shares[0] = 1.0
    told = [(gap, errors) for gap in moved if (errors := _errors(gap, away, telling)).size]
    weights = np.sqrt([errors.shape[1] for _, errors in told])
    products = np.array([errors @ errors.T / errors.shape[1] for _, errors in told]).reshape(-1, count, count)
    for gap in gaps:
        like = weights * [alike(gap, other) if other is not gap else 0.0 for other, _ in told]
        seen = np.tensordot(like, products, axes=1)
        unit = seen[0, 0] / like.sum() if seen[0, 0] > 0 else 1.0
        shares[:, gap.start : gap.stop, gap.channels] = _least(seen / unit + USUALLY * usual)[:, None, None]
    return shares


def mixed(fillings: Floats, shares: Floats) -> Floats:
    """(T, C) the fillings (F, T, C) by their shares."""
    return np.asarray((shares * fillings).sum(axis=0))


def unsure(fillings: Floats, shares: Floats, smoother: Floats, process: Floats) -> Floats:
    """(T, C) variance of what is mixed, but for a factor: what both say of their own, and how far the fillings differ.

    The smoother knows when a motion is lively but not of the other channels, the process knows of those but takes every
    moment for alike: the geometric mean of both goes with the errors better than either.

    Parameters
    ----------
    fillings, shares : (F, T, C).
    smoother : (T, C) its variance.
    process : (T, C) its variance, 0 where it says nothing.
    """
    differ = (shares * np.square(fillings - mixed(fillings, shares))).sum(axis=0)
    return np.asarray(np.sqrt(smoother * np.where(process > 0.0, process, smoother)) + differ)


def _errors(gap: Gap, away: Floats, telling: Bools) -> Floats:
    """(F, N) errors on the samples of a gap that tell something."""
    return np.stack([gap.inside(one)[gap.inside(telling)] for one in away])


def _least(products: Floats) -> Floats:
    """(F,) shares with the least mean square error, not below 0 and 1 together."""
    root = np.linalg.cholesky(products).T
    heavy = 1e3 * np.sqrt(np.trace(products))  # the sum is 1 to a millionth
    found = nnls(np.vstack([root, np.full(len(root), heavy)]), np.append(np.zeros(len(root)), heavy))[0]
    return np.asarray(found / found.sum())
