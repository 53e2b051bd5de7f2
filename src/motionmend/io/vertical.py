"""Which way is up in a marker recording: no marker format says so, it must be guessed."""

import re
from collections.abc import Sequence

import numpy as np

from ..arrays import Floats

_HEAD = re.compile(r"HEAD|HD$|ARIEL|^TOP|NOSE", re.IGNORECASE)
_FOOT = re.compile(r"TOE|FOOT|ANK|HEE|HEL$|MT[15]$", re.IGNORECASE)
_CLEAR = 0.3  # m; heads this far above the feet, in the median, settle the matter


def up_of(names: Sequence[str], positions: Floats, screen: str | None = None) -> tuple[Floats, str | None]:
    """Guess the direction against gravity.

    Parameters
    ----------
    names : (M,) marker names, with or without a subject before a colon.
    positions : (T, M, 3) m, NaN = missing.
    screen : the axis that points up on the screen by the file's own setting (C3D's POINT:Y_SCREEN), such as "+Z".

    Returns
    -------
    up : (3,) unit vector along an axis: the one along which heads lie above feet, by name, in the median of all
        frames; else the screen's; else the one along which the lowest marker keeps its height best, as on a floor.
    guess : a sentence; None when names and screen say the same.
    """
    rise = _rise(names, positions)
    on_screen = _axis(screen)
    if rise is not None:
        axis = int(np.argmax(np.abs(rise)))
        up = np.sign(rise[axis]) * np.eye(3)[axis]
        if on_screen is not None and np.array_equal(up, on_screen):
            return up, None
        other = f"; the screen's {screen} was not followed" if on_screen is not None else ""
        return up, f"up is taken as {_letter(up)}: heads are {abs(rise[axis]):.2f} m above feet along it{other}"
    if on_screen is not None:
        return on_screen, f"up is taken as {_letter(on_screen)}, the screen's upward axis"
    up = _off_the_floor(positions)
    return up, f"up is taken as {_letter(up)}: along it the lowest marker keeps its height best"


def _rise(names: Sequence[str], positions: Floats) -> Floats | None:
    """(3,) m from feet to heads in the median frame; None when names or the recording do not tell."""
    bare = [name.rsplit(":", 1)[-1] for name in names]
    heads = [k for k, name in enumerate(bare) if _HEAD.search(name)]
    feet = [k for k, name in enumerate(bare) if _FOOT.search(name) and k not in heads]
    if not heads or not feet:
        return None
    seen = np.asarray(np.isfinite(positions).all(axis=2))
    whole = np.flatnonzero(np.any(seen[:, heads], axis=1) & np.any(seen[:, feet], axis=1))
    if not whole.size:
        return None
    across = np.nanmean(positions[whole][:, heads], axis=1) - np.nanmean(positions[whole][:, feet], axis=1)
    rise = np.asarray(np.median(across, axis=0), np.float64)
    return rise if np.abs(rise).max() >= _CLEAR else None


def _axis(screen: str | None) -> Floats | None:
    spelt = re.fullmatch(r"([+-]?)([XYZ])", (screen or "").strip().upper())
    if spelt is None:
        return None
    return np.asarray((-1.0 if spelt[1] == "-" else 1.0) * np.eye(3)["XYZ".index(spelt[2])])


def _off_the_floor(positions: Floats) -> Floats:
    """The direction of the six in which the lowest marker of a frame varies least; +z when there is none."""
    seen = np.flatnonzero(np.isfinite(positions).any(axis=(1, 2)))
    if not seen.size:
        return np.array([0.0, 0.0, 1.0])
    lowest = np.hstack([np.nanmin(positions[seen], axis=1), -np.nanmax(positions[seen], axis=1)])
    spread = np.percentile(lowest, 90, axis=0) - np.percentile(lowest, 10, axis=0)
    side, axis = divmod(int(np.argmin(spread)), 3)
    return np.asarray((-1.0 if side else 1.0) * np.eye(3)[axis])


def _letter(up: Floats) -> str:
    axis = int(np.argmax(np.abs(up)))
    return ("+" if up[axis] > 0 else "-") + "xyz"[axis]
