"""A bounded sample of what clips hold, the same however the clips are dealt out.

Every item has a number; a sample of level k keeps the items whose number 2^k divides. Levels are nested, so samples
merge: the coarser level holds for both and is raised until the whole fits. What is kept in the end depends on the
whole alone.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ...arrays import Bools, Floats, Ints, frozen

MOST_VALUES = 1 << 22  # numbers in a sample: 65,536 frames of 64 channels, 32 MB

Item = TypeVar("Item")


@dataclass(frozen=True, eq=False)
class Sample(Generic[Item]):
    """Items of clips, in the order of the clips, and how thinly they were kept.

    Attributes
    ----------
    most : size of all items together that is not exceeded.
    level : k, one item in 2^k is kept.
    numbers, sizes : (N,) of each item.
    items : N.
    """

    most: int
    level: int
    numbers: Ints
    sizes: Ints
    items: tuple[Item, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", frozen(self.numbers, np.int64))
        object.__setattr__(self, "sizes", frozen(self.sizes, np.int64))

    def __add__(self, other: "Sample[Item]") -> "Sample[Item]":
        numbers = np.concatenate([self.numbers, other.numbers])
        sizes = np.concatenate([self.sizes, other.sizes])
        items = self.items + other.items
        most = min(self.most, other.most)
        level = _level(numbers, sizes, most, max(self.level, other.level))
        if level == self.level == other.level:
            return Sample(most, level, numbers, sizes, items)
        stay = _kept(numbers, level)
        found = tuple(items[i] for i in np.flatnonzero(stay))
        return Sample(most, level, numbers[stay], sizes[stay], found)


def sample(numbers: Ints, sizes: Ints, most: int, item: Callable[[int], Item], level: int = 0) -> Sample[Item]:
    """A sample of numbered items; only those that are kept are made.

    Parameters
    ----------
    numbers, sizes : (N,) of each item.
    most : size of all kept items together that is not exceeded.
    item : makes the i-th item; it must not hold on to the clip it is of.
    level : to begin with.
    """
    level = _level(numbers, sizes, most, level)
    stay = np.flatnonzero(_kept(numbers, level))
    return Sample(most, level, numbers[stay], sizes[stay], tuple(item(int(i)) for i in stay))


def nothing(most: int) -> "Sample[Item]":
    """The sample of no clips."""
    none = np.empty(0, dtype=np.int64)
    return Sample(most, 0, none, none, ())


def first_number(values: Floats) -> int:
    """Where the numbering of a clip's items begins: as if by chance, so that short clips count as long ones do.

    Parameters
    ----------
    values : the clip as it was read; the same clip begins at the same number wherever it is met.
    """
    content = np.ascontiguousarray(values[:64]).tobytes() + len(values).to_bytes(8, "little")
    return int.from_bytes(hashlib.blake2b(content, digest_size=5).digest(), "little")


def _kept(numbers: Ints, level: int) -> Bools:
    return np.asarray(numbers % (1 << level) == 0)


def _level(numbers: Ints, sizes: Ints, most: int, level: int) -> int:
    """The lowest level from `level` on at which what is kept has at most the size `most`."""
    while level < 62 and int(sizes[_kept(numbers, level)].sum()) > most:
        level += 1
    return level
