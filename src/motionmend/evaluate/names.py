"""Which of two recordings' names are one: as they stand, else without the subject's prefix, else in another case."""

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Ints


def same_names(wanted: Sequence[str], came: Sequence[str]) -> Ints:
    """(C,) where each wanted name stands among those that came, -1 for nowhere; no place is given twice.

    Names that are equal match in their order. The others match without what stands before the last colon, and then
    without regard to case, where that names one on each side alone.

    Parameters
    ----------
    wanted, came : (C,) and (D,) names.
    """
    place = np.full(len(wanted), -1, dtype=np.int64)
    known = {key: d for d, key in enumerate(numbered(came))}
    for c, key in enumerate(numbered(wanted)):
        place[c] = known.get(key, -1)
    ways: tuple[Callable[[str], str], ...] = (_bare, lambda name: _bare(name).lower())
    for way in ways:
        ours, theirs = ([way(name) for name in names] for names in (wanted, came))
        counts = Counter(ours), Counter(theirs)
        taken = set(place.tolist())
        for c in np.flatnonzero(place < 0).tolist():
            if counts[0][ours[c]] == counts[1][ours[c]] == 1 and (d := theirs.index(ours[c])) not in taken:
                place[c] = d
    return place


def numbered(names: Sequence[str]) -> list[tuple[str, int]]:
    """Each name with how often it came before."""
    seen: Counter[str] = Counter()
    keys = []
    for name in names:
        keys.append((name, seen[name]))
        seen[name] += 1
    return keys


def _bare(name: str) -> str:
    """A name without the subject's in front."""
    return name.rpartition(":")[2].strip()
