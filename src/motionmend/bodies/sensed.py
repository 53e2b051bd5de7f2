"""What gives a sensor's joints away without any truth: bones that change their length, sides that change places."""

import numpy as np

from ..arrays import Floats
from .joint_sets import mirrored, parents
from .postures import Postures

_APART = 0.15  # m; joints nearer to their partners cannot be told to have changed places
_NEARER = 0.3  # times the way to its own place before, when a joint comes from its partner's
_MOMENT = 0.25  # s; between frames further apart people do turn around


def bone_lengths(postures: Postures) -> tuple[tuple[str, ...], Floats]:
    """Bones as `<joint>` at their far ends, and their lengths (T, B) m, NaN where an end is missing."""
    above = parents(postures.names)
    ends = np.flatnonzero(above >= 0)
    bones = postures.positions[:, ends] - postures.positions[:, above[ends]]
    return tuple(postures.names[k] for k in ends), np.linalg.norm(bones, axis=2)


def bone_variation(postures: Postures) -> tuple[tuple[str, ...], Floats, Floats]:
    """Of each bone the median length (B,) m and the standard deviation of its length by that; NaN where never seen.

    Parameters
    ----------
    postures : T frames.
    """
    names, lengths = bone_lengths(postures)
    middle, spread = np.full(len(names), np.nan), np.full(len(names), np.nan)
    for k in range(len(names)):
        seen = lengths[np.isfinite(lengths[:, k]), k]
        if len(seen):
            middle[k] = np.median(seen)
            spread[k] = seen.std() / middle[k] if middle[k] > 0 else np.nan
    return names, middle, spread


def side_changes(postures: Postures) -> list[int]:
    """Frames in which two or more left joints come from where their right partners were, and the right from the left.

    Parameters
    ----------
    postures : T frames.
    """
    other = mirrored(postures.names)
    left = np.flatnonzero(np.arange(len(other)) < other)
    right = other[left]
    if not len(left) or postures.frames < 2:
        return []
    before, now = postures.positions[:-1], postures.positions[1:]

    def far(one: Floats, two: Floats) -> Floats:
        return np.asarray(np.linalg.norm(one - two, axis=2))

    stay = far(now[:, left], before[:, left]) + far(now[:, right], before[:, right])
    change = far(now[:, left], before[:, right]) + far(now[:, right], before[:, left])
    apart = np.minimum(far(before[:, left], before[:, right]), far(now[:, left], now[:, right])) > _APART
    soon = np.diff(postures.times) < _MOMENT
    changed = apart & (change < _NEARER * stay) & soon[:, None]
    return [int(frame) + 1 for frame in np.flatnonzero(changed.sum(axis=1) >= 2)]
