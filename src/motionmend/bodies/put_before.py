"""A rest pose that stands before a recording: many exporters put one there, to show the body by it."""

import numpy as np

from ..arrays import Floats
from .motion import Motion
from .skeleton import ROTATION, wrapped

LOOKED_AT = 1000  # frames the first one is compared with
AFTER = 5  # frames whose median tells where the body was next, noise and outliers or not
MOST = 4.0  # usual distances that an angle counts at most, so that a few outliers do not make a pose
FINEST = np.radians(0.5)  # added to what is usual, so that an angle that hardly moves is not told by rounding


def rest_frames(motion: Motion) -> int:
    """How many frames at the beginning are a rest pose that was put before the recording.

    It is further from the frames after it than any other frame is from those after it, in the joints' angles and in
    what is usual for each; and in no other frame are the angles as small. It may stand there several times.

    Parameters
    ----------
    motion : with noise and outliers or without, NaN = missing.

    Returns
    -------
    Their number; 0 where there is none, or where too little of the first frame is there to tell.
    """
    skeleton = motion.skeleton
    joints = (skeleton.dof_kind == ROTATION) & (skeleton.dof_joint != 0)
    others = (motion.q[:LOOKED_AT, joints] != motion.q[:1, joints]).any(axis=1)
    rested = max(int(others.argmax()), 1) if others.any() else 1  # frames like the first
    angles = motion.q[rested - 1 : LOOKED_AT, joints]
    angles = angles[:, np.isfinite(angles).any(axis=0)]
    angles = angles[:, np.nanmax(angles, axis=0, initial=-np.inf) > np.nanmin(angles, axis=0, initial=np.inf)]
    if len(angles) <= 2 * AFTER or angles.shape[1] == 0 or np.isfinite(angles[0]).mean() < 0.5:
        return 0
    away, bent = _away(angles), _medians(np.abs(wrapped(angles)))
    return rested if away[0] > np.nanmax(away[1:]) and bent[0] < np.nanmin(bent[1:]) else 0


def _away(angles: Floats) -> Floats:
    """(T - `AFTER`,) how far frames are from the median of those after them, in what is usual for each angle."""
    following = np.lib.stride_tricks.sliding_window_view(angles[1:], AFTER, axis=0)
    distance = np.abs(wrapped(angles[:-AFTER] - _medians(following)))
    usual = _medians(distance[1:].T)
    known = np.isfinite(distance)
    counted = np.where(known, np.minimum(distance / (usual + FINEST), MOST), 0.0)
    return np.asarray(counted.sum(axis=1) / np.maximum(known.sum(axis=1), 1))


def _medians(values: Floats) -> Floats:
    """Medians over the last axis of what is there; NaN where nothing is."""
    ordered = np.sort(values, axis=-1)  # what is missing comes last
    count = (~np.isnan(ordered)).sum(axis=-1, keepdims=True)
    low, high = (np.take_along_axis(ordered, np.maximum(at, 0), axis=-1) for at in ((count - 1) // 2, count // 2))
    return np.asarray((low + high)[..., 0] / 2.0)
