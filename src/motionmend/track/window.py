"""The part of the images in which anything is ever measured: beyond it the person goes on, though nothing shows them.

Where the background was taken away a pixel without depth says that nobody is there: beside a body, but not where the
camera measures nothing at all. A sensor's own window is narrower than its images, a black table returns nothing, images
are blanked. There the person is cut off along rows or columns as if with a knife, as no outline of a body ends; and who
is seen above and below of rows without any depth is in these rows, too.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bools, Ints, Singles, frozen

KNIFE = 0.7  # times as wide as farther within is the end of somebody cut off, at least; what is round is half as wide
WITHIN = 0.03  # m, farther within
WIDE = 0.06  # m, at least, is cut through: a child's forearm


@final
@dataclass(frozen=True, eq=False)
class Window:
    """Rows and columns of the images that hold all that was ever measured.

    Attributes
    ----------
    ends : (4,) px, first and last row, first and last column.
    cut : (4,) whether somebody was ever seen cut off at that end.
    """

    ends: Ints
    cut: Bools

    def __post_init__(self) -> None:
        object.__setattr__(self, "ends", frozen(self.ends, np.int64))
        object.__setattr__(self, "cut", frozen(self.cut, np.bool_))


def reached(window: Window | None, depth: Singles, focal: float) -> Window | None:
    """The window as known with one more image.

    Parameters
    ----------
    window : as known so far; None = not at all.
    depth : (H, W) m, NaN = no return; of a recording whose background was taken away.
    focal : px.

    Returns
    -------
    The same kind; what was cut off is so no longer where something is measured beyond. None while nothing ever was.
    """
    on = np.isfinite(depth)
    if not on.any():
        return window
    within, least = _within(depth, on, focal)
    ends, cut = np.empty(4, np.int64), np.zeros(4, np.bool_)
    for axis in (0, 1):
        counts = np.count_nonzero(on, axis=1 - axis)
        first, last = np.flatnonzero(counts)[[0, -1]].tolist()
        ends[2 * axis : 2 * axis + 2] = first, last
        cut[2 * axis] = _knife(counts[first : first + within + 1], within, least)
        cut[2 * axis + 1] = _knife(counts[last - within : last + 1][::-1], within, least)
    if window is None:
        return Window(ends, cut)
    farther = np.array([1, -1, 1, -1]) * (window.ends - ends)  # > 0 where this image reaches beyond
    known = np.where(farther > 0, cut, np.where(farther == 0, cut | window.cut, window.cut))
    return Window(np.where(farther > 0, ends, window.ends), known)


def untold(window: Window, depth: Singles, focal: float) -> Bools:
    """Pixels that say nothing though nothing is measured in them.

    Parameters
    ----------
    window, depth, focal : as for `reached`, the window with this image.

    Returns
    -------
    (H, W) True beyond an end at which somebody was cut off, and in rows and columns without anything that cut somebody
    in two.
    """
    on, out = np.isfinite(depth), np.zeros(depth.shape, np.bool_)
    within, least = _within(depth, on, focal) if on.any() else (0, 0.0)
    for axis in (0, 1):
        lines = out if axis == 0 else out.T
        first, last = window.ends[2 * axis : 2 * axis + 2].tolist()
        if window.cut[2 * axis]:
            lines[:first] = True
        if window.cut[2 * axis + 1]:
            lines[last + 1 :] = True
        counts = np.count_nonzero(on, axis=1 - axis)
        where = np.flatnonzero(counts)
        for k in np.flatnonzero(np.diff(where) > 1):
            begin, end = int(where[k]), int(where[k + 1])
            ends = counts[max(begin - within, 0) : begin + 1][::-1], counts[end : end + within + 1]
            if all(_knife(one, within, least) for one in ends):
                lines[begin + 1 : end] = True
    return out


def _within(depth: Singles, on: Bools, focal: float) -> tuple[int, float]:
    """How many lines farther within an outline are looked at, and how many pixels at least are cut through."""
    within = max(2, round(WITHIN * focal / float(np.median(depth[on][::7]))))
    return within, max(3.0, WIDE / WITHIN * within)


def _knife(counts: Ints, within: int, least: float) -> bool:
    """Whether an outline ends as if cut: pixels of its lines (n,) from the end inwards, and how many are to be cut."""
    return len(counts) > within and bool(counts[0] >= max(KNIFE * counts[1:].mean(), least))
