"""The part of the images in which anything is ever measured: beyond it the person goes on, though nothing shows them.

Where the background was taken away a pixel without depth says that nobody is there: beside a body, but not where the
camera measures nothing at all. A sensor's own window is narrower than its images, a black table returns nothing, images
are blanked. There the person is cut off along rows or columns as if with a knife, as no outline of a body ends; and who
is seen above and below of rows without any depth is in these rows, too.

Feet end as straight where the floor was taken away with what touches it, in the blocks that it was told by: so do those
of nearly all in UTD-MHAD, at most 0.13 of an image's height from its border. Heads do, at most 0.19 m wide. So a line
tells only farther within and where it cuts through more, and never below somebody who is seen as tall as people are.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bools, Ints, Singles, frozen

KNIFE = 0.85  # times as wide as farther within is the end of somebody cut off, at least; what is round is half as wide
WITHIN = 0.03  # m, farther within
WIDE = np.array(
    [0.2, 0.12, 0.2, 0.2]
)  # m, at least, is cut through at the ends, in `Window`'s order: below it is shins
TALL = 1.45  # m, of somebody is seen at least whose feet are, too
CLEFT, CLEFT_WIDE = 0.7, 0.06  # for KNIFE and m for WIDE on either side of lines that cut somebody in two
INSIDE = 0.15  # share of the image's height or width that is without anything beyond such a line, at least

_BELOW = np.array([False, True, False, False])


@final
@dataclass(frozen=True, eq=False)
class Window:
    """Rows and columns of the images that hold all that was ever measured.

    Attributes
    ----------
    ends : (4,) px, first and last row, first and last column.
    cut : (4,) whether somebody was ever seen cut off at that end.
    feet : whether the last row is where somebody's feet end.
    """

    ends: Ints
    cut: Bools
    feet: bool = False

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
    pixels = focal / float(np.median(depth[on][::7]))  # of a metre
    within = _within(pixels)
    ends, cut = np.empty(4, np.int64), np.zeros(4, np.bool_)
    for axis in (0, 1):
        counts = np.count_nonzero(on, axis=1 - axis)
        first, last = np.flatnonzero(counts)[[0, -1]].tolist()
        ends[2 * axis : 2 * axis + 2] = first, last
        inwards = counts[first : first + within + 1], counts[max(last - within, 0) : last + 1][::-1]
        for end, beyond in ((0, first), (1, len(counts) - 1 - last)):
            least = WIDE[2 * axis + end] * pixels
            cut[2 * axis + end] = beyond >= INSIDE * len(counts) and _knife(inwards[end], within, KNIFE, least)
    feet = bool(ends[1] - ends[0] > TALL * pixels)
    if window is None:
        return Window(ends, cut & ~(_BELOW & feet), feet)
    farther = np.array([1, -1, 1, -1]) * (window.ends - ends)  # > 0 where this image reaches beyond
    feet = (feet and farther[1] >= 0) or (window.feet and farther[1] <= 0)
    known = np.where(farther > 0, cut, np.where(farther == 0, cut | window.cut, window.cut)) & ~(_BELOW & feet)
    return Window(np.where(farther > 0, ends, window.ends), known, feet)


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
    pixels = focal / float(np.median(depth[on][::7])) if on.any() else 1.0
    within, least = _within(pixels), CLEFT_WIDE * pixels
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
            if all(_knife(one, within, CLEFT, least) for one in ends):
                lines[begin + 1 : end] = True
    return out


def _within(pixels: float) -> int:
    """How many lines farther within an outline are looked at, of so many pixels for a metre."""
    return max(2, round(WITHIN * pixels))


def _knife(counts: Ints, within: int, share: float, least: float) -> bool:
    """Whether an outline ends as if cut.

    Parameters
    ----------
    counts : (n,) pixels of its lines from the end inwards. within : lines that are looked at.
    share : of the others' pixels that the end has. least : pixels that are cut through.
    """
    return len(counts) > within and bool(counts[0] >= max(share * counts[1:].mean(), least, 3.0))
