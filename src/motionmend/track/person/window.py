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

from ...arrays import Bools, Ints, Singles, frozen
from ...bodies.camera import Camera

KNIFE = 0.85  # times as wide as farther within is the end of somebody cut off, at least; what is round is half as wide
WITHIN = 0.03  # m, farther within
# m, at least, is cut through at the ends, in `Window`'s order: a trunk, for heads end straight; shins; most of a body,
# for the side of a leg or a hanging arm is straight, too.
WIDE = (0.2, 0.12, 0.7, 0.7)
TALL = 1.45  # m, of somebody is seen at least whose feet are, too
CLEFT, CLEFT_WIDE = 0.7, 0.12  # for KNIFE and m for WIDE on either side of WITHIN or more that cuts somebody in two
INSIDE = 0.15  # share of the image's height or width that is without anything beyond such a line, at least

_OUTWARDS = (-1, 1, -1, 1)


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


@final
@dataclass(frozen=True, eq=False)
class Lines:
    """How much is measured in each row and column of an image.

    Attributes
    ----------
    counts : (H,) and (W,) px.
    box : (4,) px, first and last row, first and last column with anything.
    area : m², of what is measured, as if it faced the camera.
    pixels : of a metre at its distance.
    """

    counts: tuple[Ints, Ints]
    box: Ints
    area: float
    pixels: float


def lines_of(depth: Singles, camera: Camera) -> Lines | None:
    """The lines of an image (H, W) in m, NaN = no return; None = nothing is measured."""
    from ...kernels import regions

    counts = np.empty(depth.shape[0], np.int64), np.empty(depth.shape[1], np.int64)
    squares = regions.tally(frozen(depth, np.float32), *counts)
    rows, columns = (np.flatnonzero(count) for count in counts)
    if not len(rows):
        return None
    box = np.array([rows[0], rows[-1], columns[0], columns[-1]])
    away = float(np.sqrt(squares / counts[0].sum()))
    return Lines(counts, box, squares / (camera.fx * camera.fy), camera.fx / away)


def reached(window: Window | None, lines: Lines | None) -> Window | None:
    """The window as known with one more image.

    Parameters
    ----------
    window : as known so far; None = not at all.
    lines : of an image of a recording whose background was taken away.

    Returns
    -------
    The same kind; what was cut off is so no longer where something is measured beyond. None while nothing ever was.
    """
    if lines is None:
        return window
    found, within = lines.box.tolist(), _within(lines.pixels)
    first, last, left, right = found
    down, across = lines.counts
    height, width = len(down), len(across)
    feet = last - first > TALL * lines.pixels
    cut = [
        beyond >= INSIDE * size and _knife(counts, within, KNIFE, wide * lines.pixels)
        for beyond, size, counts, wide in (
            (first, height, down[first : first + within + 1], WIDE[0]),
            (height - 1 - last, height, down[max(last - within, 0) : last + 1][::-1], WIDE[1]),
            (left, width, across[left : left + within + 1], WIDE[2]),
            (width - 1 - right, width, across[max(right - within, 0) : right + 1][::-1], WIDE[3]),
        )
    ]
    ends = found
    if window is not None:
        known, before = window.ends.tolist(), window.cut.tolist()
        farther = [sign * (now - then) for sign, now, then in zip(_OUTWARDS, found, known, strict=True)]
        feet = (feet and farther[1] >= 0) or (window.feet and farther[1] <= 0)
        cut = [(far >= 0 and now) or (far <= 0 and then) for far, now, then in zip(farther, cut, before, strict=True)]
        ends = [now if far > 0 else then for far, now, then in zip(farther, found, known, strict=True)]
    cut[1] &= not feet
    if window is not None and (ends, cut, feet) == (known, before, window.feet):
        return window
    return Window(np.array(ends), np.array(cut), feet)


def untold(window: Window, lines: Lines | None) -> Bools | None:
    """Pixels that say nothing though nothing is measured in them.

    Parameters
    ----------
    window : with this image. lines : of the image.

    Returns
    -------
    (H, W) True beyond an end at which somebody was cut off, and in rows and columns without anything that cut somebody
    in two; None = there are no such pixels.
    """
    if lines is None:
        return None
    found: tuple[list[slice], list[slice]] = ([], [])
    within, least = _within(lines.pixels), CLEFT_WIDE * lines.pixels
    for axis, counts in enumerate(lines.counts):
        if window.cut[2 * axis]:
            found[axis].append(slice(0, int(window.ends[2 * axis])))
        if window.cut[2 * axis + 1]:
            found[axis].append(slice(int(window.ends[2 * axis + 1]) + 1, None))
        where = np.flatnonzero(counts)
        if len(where) == where[-1] - where[0] + 1:
            continue
        for k in np.flatnonzero(np.diff(where) > within):
            begin, end = int(where[k]), int(where[k + 1])
            sides = counts[max(begin - within, 0) : begin + 1][::-1], counts[end : end + within + 1]
            if all(_knife(side, within, CLEFT, least) for side in sides):
                found[axis].append(slice(begin + 1, end))
    if not any(found):
        return None
    out = np.zeros((len(lines.counts[0]), len(lines.counts[1])), np.bool_)
    for rows in found[0]:
        out[rows] = True
    for columns in found[1]:
        out[:, columns] = True
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
    if len(counts) <= within or counts[0] < max(least, 3.0):
        return False
    return bool(counts[0] >= share * counts[1:].mean())
