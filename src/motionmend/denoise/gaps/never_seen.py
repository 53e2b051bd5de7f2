"""Channels of which nothing is seen: how far off they may be, as joints that are seen are when they are hidden.

A library's people hold an arm otherwise than this person does, and nothing in the recording says how. What the bases
leave open of a channel when all others are known is too little by a factor that is much the same for all joints; it is
found by hiding joints that are there.
"""

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...numerics.ssa import Eigenbases
from ..bases.support import CARRIED, LEAST, interpolated, supported
from ..channels.pieces import middle_frames

TRIED = 8  # joints that are hidden
LONGEST = 5.0  # s of the recording in which they are
AT_REST = 1.0  # degrees or cm; joints that stray less tell nothing
# What is believed before any joint was hidden: errors in 16 clips of nine people of CMU's, four of them in the library,
# were so many times as large, which counts as much as one joint.
USUAL, BELIEVED = 6.5**2, 1.0


def never_seen(
    measured: Floats, outlier: Bools, values: Floats, bases: Eigenbases, stride: int, joints: Ints | None, fps: float
) -> Floats:
    """(C,) variance of the errors in channels without any sample, channel units; 0 for the others.

    Parameters
    ----------
    measured : (T, C), NaN = missing. outlier : (T, C) True where a sample is rejected.
    values : (T, C) the repair, which is what is compared with where joints are hidden.
    bases, stride : of the library at the recording's rate, least frames between windows.
    joints : (C,) alike where columns are angles of one joint; None = each has one of its own.
    fps : Hz.

    Source
    ------
    What is left open: the variance of a Gaussian's part, its covariance that of eq. 2.3, given the rest.
    """
    gone: Bools = np.asarray(~np.isfinite(measured).any(axis=0))
    if not gone.any() or gone.all():
        return np.zeros(len(gone))
    joints = np.arange(len(gone)) if joints is None else joints
    some = middle_frames(len(values), max(bases.window, round(LONGEST * fps)))
    believed, values = np.where(outlier, np.nan, measured)[some], values[some]
    left = _left_open(bases, ~gone)
    usual = float(np.exp(np.log(left[gone]).mean()))
    seen = [joint for joint in np.unique(joints) if not gone[joints == joint].any()]
    moving = [joint for joint in seen if values[:, joints == joint].std(axis=0).max() > AT_REST]
    tried, like = list[float](), list[float]()
    open_of = {joint: _left_open(bases, ~gone & (joints != joint))[joints == joint] for joint in moving}
    apart = {joint: abs(float(np.log(open_of[joint]).mean()) - np.log(usual)) for joint in moving}
    for joint in sorted(moving, key=lambda one: (apart[one], one))[:TRIED]:
        own = joints == joint
        without = believed.copy()
        without[:, own] = np.nan
        told = supported(without, interpolated(without, bases.mean.mean(axis=0)), bases, stride)
        off = np.square(told - values)[:, own].mean(axis=0)
        tried.append(float((off / open_of[joint]).mean()))
        like.append(float(np.exp(-0.5 * apart[joint] ** 2)))
    beyond = (BELIEVED * USUAL + np.dot(like, tried)) / (BELIEVED + sum(like))
    return np.where(gone, beyond * left, 0.0)


def _left_open(bases: Eigenbases, seen: Bools) -> Floats:
    """(C,) mean variance over a window that the bases leave open, the channels `seen` being known."""
    floor = bases.discarded + LEAST**2
    known = bases.vectors[:, :, seen]
    precision = np.einsum("kmc,lmc,c->kl", known, known, 1.0 / (CARRIED * floor[seen]), optimize=True)
    spread = np.linalg.inv(precision + np.diag(1.0 / np.maximum(bases.values, np.finfo(float).tiny)))
    over_window = np.einsum("kmc,kl,lmc->c", bases.vectors, spread, bases.vectors, optimize=True)
    return np.asarray(over_window / bases.window + floor)
