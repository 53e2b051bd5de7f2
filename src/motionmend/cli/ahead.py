"""One piece of a recording read while the one before it is worked on."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Piece = TypeVar("Piece")


def ahead(read: Callable[[int], Piece], count: int) -> Iterator[Piece]:
    """The pieces 0 .. count - 1 in order, the next one being read by another thread meanwhile.

    Parameters
    ----------
    read : the piece of a number; what it raises is raised where that piece is asked for. It is called from one other
        thread only, and of no number twice.
    count : how many; none for 0.
    """
    if count == 0:
        return
    with ThreadPoolExecutor(1) as reader:
        coming = reader.submit(read, 0)
        for number in range(1, count + 1):
            here = coming.result()
            if number < count:
                coming = reader.submit(read, number)
            yield here
