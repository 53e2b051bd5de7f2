"""A joint that stays as it is, in noise, while it should go on, and leaps to where the motion goes on afterwards.

A solver that has lost a limb says its last word, or zero, for a while, and noise comes upon it later. Neither is an
outlier, for it lasts, nor a slip, for it is off by another amount in every frame. What stands ends with a leap: a step
many times as long as the steps after it, of which no joint is capable. Where it began with such a leap, too, the joint
had fallen to some value; else it had moved just before. Angles that leap near a pole, while the joint does not, are no
leap; and toes, which rest and snap by themselves, are not asked, nor is any other end of a limb.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Motion
from ...bodies.skeleton import ROTATION, Skeleton
from ...numerics.quantiles import median
from ..channels.joints import joint_rotation, root_rows, unit
from ..noise.level import first_noise

NOISY = 0.3  # degrees; a joint less noisy than that in all its angles repeats itself, or rests
SHORTEST, FRAMES = 0.12, 8  # s and frames; who rests for less may leap so
LONGEST = 1.3  # s; what is still for longer could not be filled without a library
WITHIN = 4.0  # deviations of the noise about a place within which who stands stays
LEAST, LEAPS = 12.0, 10.0  # degrees and deviations of the noise; no leap is shorter, of an angle and of the joint
STEPS, AFTER = 4.0, 4  # times the longest of so many steps after it: the least that a leap is
AWAY = 0.5  # of the leap, that the frames after it stay away
MOVED, BEFORE = 6.0, 0.3  # deviations by which a joint moved in so many seconds before it stood


def stood_joints(motion: Motion) -> Bools:
    """Samples of joints that stood while they should have gone on.

    Parameters
    ----------
    motion : T frames, D channels.

    Returns
    -------
    (T, D) True where a joint stood, or had fallen to some value, in all of its angles.
    """
    found = np.zeros(motion.q.shape, dtype=np.bool_)
    least = max(FRAMES, round(SHORTEST * motion.fps))
    if motion.frames < 4 * least:
        return found
    skeleton = motion.skeleton
    rows = np.setdiff1d(np.flatnonzero(skeleton.dof_kind == ROTATION), np.concatenate(root_rows(skeleton)))
    if not len(rows):
        return found
    angles = motion.q[:, rows] * unit(skeleton)[rows]
    noise = first_noise(angles)
    stands: dict[int, list[tuple[int, int, list[int]]]] = {}
    joints = np.unique(skeleton.dof_joint[rows]).tolist()
    for joint in sorted(set(joints) & _borne_by(skeleton, joints)):
        own = np.flatnonzero(skeleton.dof_joint[rows] == joint)
        if noise[own].max() < NOISY:
            continue
        leaps = _leaps(motion, rows[own], angles[:, own], noise[own])
        for start, leap in _stands(angles[:, own], leaps, noise[own], motion.fps, least):
            stands.setdefault(leap, []).append((start, leap, rows[own].tolist()))
    for same in stands.values():
        if len(same) == 1:  # several that leap at once are a limb in its solver's other pose
            start, leap, own_rows = same[0]
            found[start:leap, own_rows] = True
    return found


def _borne_by(skeleton: Skeleton, joints: Sequence[int]) -> set[int]:
    """Joints on which some of these hang."""
    found: set[int] = set()
    for joint in joints:
        while (joint := int(skeleton.parents[joint])) >= 0:
            found.add(joint)
    return found


def _stands(angles: Floats, leaps: Bools, noise: Floats, fps: float, least: int) -> list[tuple[int, int]]:
    """First frames of stands of a joint (T, N) degrees, and the frames after them; `leaps` (T,) as of `_leaps`."""
    steps, found = np.diff(angles, axis=0), []
    longest, before = round(LONGEST * fps), max(2, round(BEFORE * fps))
    frames = np.flatnonzero(leaps)
    for leap in _after_rest(angles, frames[frames >= least], WITHIN * noise, least):
        start = _since(angles, leap, WITHIN * noise, least)
        length = leap - start
        if length > longest or start < 2:
            continue
        jump = steps[leap - 1]
        back = np.linalg.norm(steps[leap : leap + longest] + jump, axis=1)
        if (back < AWAY * np.linalg.norm(jump)).any():
            continue  # it leaps away and back: who stands is right
        earlier = frames[frames <= start]
        if leaps[start]:
            first = int(earlier[-2]) if len(earlier) > 1 else 0
            if start - first > length:
                found.append((start, leap))
        elif (np.ptp(angles[max(0, start - before) : start], axis=0) > MOVED * noise).any():
            found.append((start + 1, leap))
    return found


def _leaps(motion: Motion, rows: Ints, angles: Floats, noise: Floats) -> Bools:
    """(T,) True in the frames to which a joint leaps as none can, and does not come back at once.

    Parameters
    ----------
    rows, angles, noise : (N,), (T, N) and (N,) degrees, of the joint.
    """
    steps = np.diff(angles, axis=0)
    far = (np.abs(steps) > np.maximum(LEAST, LEAPS * noise)).any(axis=1)
    far &= np.isfinite(steps).all(axis=1)  # else it is not known where the joint is
    frames = np.flatnonzero(far) + 1
    before, now = (joint_rotation(motion.skeleton, rows, motion.q[some]) for some in (frames - 1, frames))
    turned = np.degrees(Rotation.from_matrix(before.swapaxes(1, 2) @ now).magnitude())
    size = np.linalg.norm(steps, axis=1)
    leaps = np.zeros(len(angles), dtype=np.bool_)
    frames = frames[(turned > max(LEAST, LEAPS * float(noise.max()))) & (frames < len(angles) - AFTER)]
    beside = frames[:, None] + np.arange(AFTER + 1)
    gone = np.linalg.norm(angles[beside] - angles[frames - 1, None], axis=2)
    beyond = size[frames - 1] > STEPS * size[beside[:, :-1]].max(axis=1)
    leaps[frames[beyond & (gone > AWAY * gone[:, :1]).all(axis=1)]] = True
    return leaps


def _after_rest(angles: Floats, leaps: Ints, reach: Floats, least: int) -> list[int]:
    """The leaps (N,) before which a joint stands for so many frames at least."""
    before = angles[leaps[:, None] + np.arange(-least, 0)]
    place = np.median(before, axis=1, keepdims=True)
    return [int(leap) for leap in leaps[(np.abs(before - place) <= reach).all(axis=(1, 2))]]


def _since(angles: Floats, leap: int, reach: Floats, least: int) -> int:
    """The first frame from which a joint stands until it leaps; it does for so many frames at least."""
    start = leap - least
    place = median(angles[start:leap])
    while start > 0 and (np.abs(angles[start - 1] - place) <= reach).all():
        start -= 1
        if (leap - start) % least == 0:
            place = median(angles[start:leap])
    return start
