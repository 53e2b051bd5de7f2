"""Long recordings a piece at a time, so that what is worked out on the way needs no more memory than a piece."""

from collections.abc import Iterator

PIECE = 1 << 13  # frames


def pieces(frames: int, most: int = PIECE) -> Iterator[slice]:
    """Frames 0 to `frames` in order, at most so many at a time; one empty piece of none."""
    for start in range(0, max(frames, 1), most):
        yield slice(start, min(start + most, frames))
