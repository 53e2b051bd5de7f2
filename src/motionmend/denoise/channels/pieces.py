"""Long recordings a piece at a time, so that what is worked out on the way needs no more memory than a piece."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

PIECE = 1 << 13  # frames


def pieces(frames: int, most: int = PIECE) -> Iterator[slice]:
    """Frames 0 to `frames` in order, at most so many at a time; one empty piece of none."""
    for start in range(0, max(frames, 1), most):
        yield slice(start, min(start + most, frames))


def blocks(frames: int, most: int, margin: int) -> list[tuple[slice, slice]]:
    """Blocks of about the same length, none longer than `most`: frames that are its own, and with its neighbours' seen.

    Parameters
    ----------
    frames : of a recording; none are one empty block.
    most : frames of a block, at least 1.
    margin : frames of the neighbours that are seen on each side.
    """
    count = max(1, -(-frames // most))
    edges = np.linspace(0, frames, count + 1).astype(np.int64).tolist()
    return [(slice(a, b), slice(max(0, a - margin), min(frames, b + margin))) for a, b in pairwise(edges)]


def middle_frames(frames: int, most: int) -> slice:
    """The middle frames of a recording, at most so many."""
    start = max(0, (frames - most) // 2)
    return slice(start, start + most)
