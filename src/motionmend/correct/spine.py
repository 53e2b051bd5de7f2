"""Joints along the spine, which every maker puts where it likes: what lies elsewhere than the learned sensor's is
another joint, whatever it is called.

Along the way from the pelvis to the neck's base, UI-PRMD has `Spine` at 0.57 and `Chest` at 0.99, the second Kinect
`SpineMid` at 0.57, the first one `Spine` at 0.16, Azure Kinect `SPINE_NAVEL` at about 0.3 and `SPINE_CHEST` at 0.6. Of
one sensor they stay within 0.03 in all postures.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.joint_sets import meanings
from .anatomy import Anatomy
from .joining import Joining, joined
from .normalise import Standard
from .sight import rows_of

ELSEWHERE = 0.25  # of the way from the pelvis to the neck's base
ALONG = ("spine", "chest")
DECIDE = 9  # frames do, live


def heights(rows: Floats, body: Anatomy) -> Floats:
    """(..., J) how far along from the pelvis to the neck's base, or to the middle of the shoulders where that is
    missing, the spine's joints lie; NaN for all other joints, and where that cannot be told.

    Parameters
    ----------
    rows : (..., J, 3) in whatever axes, NaN = missing.
    """
    found = np.full(rows.shape[:-1], np.nan)
    ends, along = _places(body.names)
    if not along:
        return found
    pelvis, left, right, base = ends
    low, high = rows[..., pelvis, :], 0.5 * (rows[..., left, :] + rows[..., right, :])
    if base >= 0:
        high = np.where(np.isfinite(rows[..., base, :]), rows[..., base, :], high)
    way = high - low
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in along:
            found[..., k] = ((rows[..., k, :] - low) * way).sum(axis=-1) / (way * way).sum(axis=-1)
    return found


def can_tell(joining: Joining, body: Anatomy) -> bool:
    """Whether a recording has joints along the spine, and what tells how far along they lie."""
    (pelvis, left, right, base), along = _places(body.names)
    have = joining.meant >= 0
    ends = bool(along) and have[pelvis] and ((base >= 0 and have[base]) or (have[left] and have[right]))
    return bool(ends and have[list(along)].any())


def elsewhere(seen: Floats, joining: Joining, standard: Standard, body: Anatomy) -> Bools:
    """(J,) joints of the spine that lie elsewhere than the learned sensor's that mean the same.

    Parameters
    ----------
    seen : (T, J) of `heights`, in some frames.
    """
    told = np.asarray(np.isfinite(seen).any(axis=0))
    usual = heights(np.where((joining.meant >= 0)[:, None], standard.trunk, np.nan), body)
    off = np.zeros(len(told))
    off[told] = np.nanmedian(seen[:, told], axis=0) - usual[told]
    return np.asarray(np.abs(off) > ELSEWHERE)


def joined_as_seen(names: Sequence[str], positions: Floats, standard: Standard, body: Anatomy) -> Joining:
    """How a recording's joints (T, J, 3) go with a model's, by what they mean and by where they lie."""
    joining = joined(names, body)
    other = elsewhere(heights(rows_of(joining.meant, positions), body), joining, standard, body)
    return joined(names, body, other) if other.any() else joining


@lru_cache(maxsize=64)
def _places(names: tuple[str, ...]) -> tuple[tuple[int, int, int, int], tuple[int, ...]]:
    """Pelvis, shoulders and the neck's base (-1 = none), and the spine's joints; none where no way is known."""
    place = {meaning: k for k, meaning in enumerate(meanings(names)) if meaning}
    if not {"pelvis", "l_shoulder", "r_shoulder"} <= place.keys():
        return (-1, -1, -1, -1), ()
    ends = place["pelvis"], place["l_shoulder"], place["r_shoulder"], place.get("neck_base", -1)
    return ends, tuple(place[one] for one in ALONG if one in place)
