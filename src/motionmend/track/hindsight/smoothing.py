"""Poses of a whole recording made steady: what comes after a frame says something of it too.

A tracker decides frame by frame, and its errors of a few millimetres change sides from one frame to the next. Here
every degree of freedom follows a parabola fitted to the frames about it (Savitzky and Golay 1964, with tricube weights
and the frames' own times, as Cleveland 1979), so that bones keep their lengths. A parabola follows any acceleration
that lasts.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...arrays import Bools, Floats, runs
from ...bodies.performer import LANDMARKS, Performer, Poses, landmarks, rotation, rotation_vector
from ..limbs.other_poses import SEARCHED

REACH = 0.10  # s to either side: shorter than the quickest swing of a limb
FASTEST = 12.0  # m/s of a joint between two frames; more is a limb found anew, and no motion


def smoothed(poses: Poses, performer: Performer, times: Floats, whole: Bools, held: Bools) -> tuple[Poses, Floats]:
    """Poses with each degree of freedom smoothed over 0.1 s to either side, and the joints they lead to.

    A limb that was out of sight has come, by the time it is seen again, to where it is seen: what it is off by then
    it has gathered on the way, and is brought to it from there.

    Parameters
    ----------
    poses : T poses; NaN where there is none.
    performer : whose.
    times : (T,) s.
    whole : (T,) which of them count; all others stay as they are, and nothing is smoothed across them.
    held : (T, 16) which joints nothing was seen of.

    Returns
    -------
    poses, and landmarks (T, 16, 3) m, NaN where there is no pose.
    """
    poses = replace(poses, joints=_brought(poses.joints, times, whole, held))
    translation, root, joints = poses.translation.copy(), poses.root.copy(), poses.joints.copy()
    for first, last in _runs(poses, performer, times, whole):
        rows = slice(first, last)
        parts = poses.translation[rows], poses.root[rows], poses.joints[rows]
        translation[rows], root[rows], joints[rows] = _steadied(*parts, times[rows])
    steady = Poses(translation, root, joints)
    return steady, _places(steady, performer)


def _brought(joints: Floats, times: Floats, whole: Bools, held: Bools) -> Floats:
    """Joint coordinates (T, 28) of which those of limbs out of sight lead to where the limb is seen again.

    As for a random walk between two measurements, what is off at its end is shared out evenly over the time.
    """
    out = joints.copy()
    for limb in SEARCHED:
        hidden = held[:, limb.landmarks].any(axis=1) & whole
        for first, after in runs(hidden):
            if first == 0 or after == len(joints) or not (whole[first - 1] and whole[after]):
                continue
            share = (times[first:after] - times[first - 1]) / (times[after] - times[first - 1])
            leap = joints[after, limb.columns] - joints[after - 1, limb.columns]
            out[first:after, limb.columns] += share[:, None] * leap
    return out


def _steadied(translation: Floats, root: Floats, joints: Floats, times: Floats) -> tuple[Floats, Floats, Floats]:
    """A stretch of poses without gaps, each fitted to those about it."""
    placed, turned, bent = translation.copy(), root.copy(), joints.copy()
    for t in range(len(times)):
        near = np.flatnonzero(np.abs(times - times[t]) <= REACH * (1 + 1e-6))
        if len(near) < 4:  # a parabola through three points is no fit
            continue
        at = (times[near] - times[t]) / REACH
        weight = (1 - (np.abs(at) / 1.2) ** 3) ** 3
        basis = np.stack((np.ones_like(at), at, at**2), axis=1)
        share = np.linalg.lstsq(basis * np.sqrt(weight)[:, None], np.diag(np.sqrt(weight)), rcond=None)[0][0]
        placed[t], bent[t] = share @ translation[near], share @ joints[near]
        about = rotation_vector(root[near] @ root[t].T)
        turned[t] = rotation(share @ about) @ root[t]
    return placed, turned, bent


def _runs(poses: Poses, performer: Performer, times: Floats, whole: Bools) -> list[tuple[int, int]]:
    """First and one past the last frame of each stretch to be smoothed."""
    at = _places(poses, performer)
    step = np.diff(times)
    with np.errstate(invalid="ignore"):
        speed = np.linalg.norm(np.diff(at, axis=0), axis=2).max(axis=1) / np.maximum(step, 1e-9)
    parted = ~whole[1:] | ~whole[:-1] | ~(speed < FASTEST) | (step > REACH)
    ends = [0, *(np.flatnonzero(parted) + 1).tolist(), len(times)]
    return [(one, other) for one, other in pairwise(ends) if whole[one] and other - one > 3]


def _places(poses: Poses, performer: Performer) -> Floats:
    places = np.full((len(poses), len(LANDMARKS), 3), np.nan)
    for t in np.flatnonzero(np.isfinite(poses.joints).all(axis=1)).tolist():
        places[t] = landmarks(performer, poses[t])
    return places
