"""How wrong a repair is inside gaps: the same gaps laid elsewhere in the recording, where the truth is known."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import erfinv, stdtrit

from ...arrays import Bools, Floats, Ints

MOST = 24  # gaps that are laid elsewhere
TIMES = 4  # that one is laid elsewhere, where there are few
MOST_HIDDEN = 0.15  # of a recording's samples hidden by it; the first gap may hide more
LEAST_LENGTH = 0.5  # of a gap's; where there is no more room it tells too little
ALIKE = 1.0  # gaps whose lengths, or numbers of channels, differ by a factor e still tell of each other
# What is believed before any gap was looked at: deviations as they are count as much as one channel of one gap, and an
# error is Student-distributed with so many degrees of freedom, one more for each gap looked at.
BELIEVED, FREEDOM = 1.0, 4.0
LEAST, MOST_EXCESS = 0.3, 10.0  # of a deviation
MIDDLE, FAR = 0.6827, 0.9545  # of normal errors lie within one and two standard deviations
BY_MIDDLE = 0.7  # how much the former says of a deviation; by both alike three quarters of the errors lie within one
_NORMAL = np.sqrt(2.0) * erfinv((np.arange(40) + 0.5) / 40)  # sizes of errors that are as stated


@dataclass(frozen=True, eq=False)
class Gap:
    """Channels missing together from `start` up to `stop`, frames."""

    start: int
    stop: int
    channels: Ints

    def inside(self, values: Any) -> Any:
        """(L, K) its part of an array (T, C)."""
        return values[self.start : self.stop, self.channels]

    def unlike(self, other: "Gap") -> float:
        """Squared difference in length and in number of channels, both as logarithms."""
        length = np.log((self.stop - self.start) / (other.stop - other.start))
        width = np.log(len(self.channels) / len(other.channels))
        return float(length**2 + width**2)


def gaps_of(present: Bools) -> list[Gap]:
    """The gaps of a recording (T, C) by when they begin; channels that are gone from and to the same frames are one.

    Channels without any sample are no gap: nothing of the recording tells of them.
    """
    some = np.flatnonzero(present.any(axis=0) & ~present.all(axis=0))
    edges = np.diff(np.pad(~present[:, some], ((1, 1), (0, 0))).astype(np.int8), axis=0)
    found: dict[tuple[int, int], list[int]] = {}
    for column, channel in enumerate(some.tolist()):
        starts, stops = (np.flatnonzero(edges[:, column] == way).tolist() for way in (1, -1))
        for when in zip(starts, stops, strict=True):
            found.setdefault(when, []).append(channel)
    return [Gap(*when, np.array(channels)) for when, channels in sorted(found.items())]


def laid_elsewhere(gaps: list[Gap], present: Bools) -> list[Gap]:
    """Some of the gaps at places where all of their channels are there, with a frame to spare at both ends.

    Few gaps are laid several times, as evenly over the recording as there is room. A moved gap keeps away from the
    others, so that no channel loses more at once than it does by itself.

    Parameters
    ----------
    gaps : of `gaps_of`.
    present : (T, C).
    """
    few = min(MOST, len(gaps))
    chosen = [gaps[number] for number in np.unique(np.linspace(0, len(gaps) - 1, few).astype(np.int64))]
    times = min(TIMES, MOST // max(few, 1))
    free, left, found = present.copy(), MOST_HIDDEN * present.sum(), list[Gap]()
    for time in range(times):
        for gap in chosen:
            lost = np.concatenate([[0], np.cumsum(~free[:, gap.channels].all(axis=1))])
            room = int(np.unique(lost, return_counts=True)[1].max()) - 3  # frames on end, less the two to spare
            length = min(gap.stop - gap.start, room)
            size = length * len(gap.channels)
            if length < max(1, LEAST_LENGTH * (gap.stop - gap.start)) or (found and size > left):
                continue
            starts = 1 + np.flatnonzero(lost[length + 2 :] == lost[: -length - 2])
            wanted = (gap.start + len(free) * time // times) % len(free)
            start = int(starts[np.argmin(np.abs(starts - wanted))])
            found.append(Gap(start, start + length, gap.channels))
            free[start - 1 : start + length + 1, gap.channels] = False
            left -= size
    return found


def hidden_by(moved: list[Gap], shape: tuple[int, ...]) -> Bools:
    """(T, C) True inside the gaps."""
    hidden = np.zeros(shape, dtype=bool)
    for gap in moved:
        hidden[gap.start : gap.stop, gap.channels] = True
    return hidden


def alike(gap: Gap, other: Gap) -> float:
    """How much one gap tells of another, in (0, 1]."""
    return float(np.exp(-0.5 * gap.unlike(other) / ALIKE**2))


def excess(gaps: list[Gap], moved: list[Gap], away: Floats, variance: Floats, telling: Bools) -> Floats:
    """(T, C) factor on the variance inside gaps; 1 elsewhere.

    For each gap the square of how far errors in the moved gaps, weighed by how alike they are, go beyond those stated
    by the quantiles 68 and 95 %, times the same of a Student distribution: the fewer gaps tell, the less is known of
    how far the next one errs.

    Parameters
    ----------
    gaps : of the recording.
    moved : gaps laid where samples are.
    away, variance : (T, C) error of the samples inside the moved gaps, and the variance stated for them.
    telling : (T, C) False for samples that say nothing of how far a repair errs.
    """
    factor = np.ones(away.shape)
    if not moved:
        return factor
    sizes, shares = [_NORMAL], [np.full(len(_NORMAL), 1.0 / len(_NORMAL))]
    for gap in moved:
        looked_at = gap.inside(telling)
        sizes.append((np.abs(gap.inside(away)) / np.sqrt(gap.inside(variance)))[looked_at])
        # every channel of every gap counts alike, as if it were that many samples of an error that hardly changes
        shares.append((looked_at / np.maximum(looked_at.sum(axis=0), 1))[looked_at])
    size, share = np.concatenate(sizes), np.concatenate(shares)
    whose = np.repeat(np.arange(len(sizes)), [len(s) for s in sizes])
    order = np.argsort(size, kind="stable")
    size, share, whose = size[order], share[order], whose[order]
    for gap in gaps:
        like = np.array([alike(gap, other) for other in moved])
        below = np.cumsum(share * np.concatenate([[BELIEVED], like])[whose])
        inside = beyond_normal(size, below) * _beyond_of_student(FREEDOM + float(like.sum()))
        factor[gap.start : gap.stop, gap.channels] = np.clip(inside, LEAST**2, MOST_EXCESS**2)
    return factor


def beyond_normal(sizes: Floats, below: Floats) -> float:
    """Variance of standardised errors by their quantiles 68 and 95 %; 1 for a standard normal's.

    Errors in gaps have heavier tails than any deviation tells. The quantiles are weighed so that intervals of 68 and
    of 95 % both hold nearly what they promise.

    Parameters
    ----------
    sizes : (N,) their absolute values, ascending.
    below : (N,) weight of all up to each, in any unit.
    """
    return _by_quantiles(*np.interp([MIDDLE, FAR], below / below[-1], sizes))


def _beyond_of_student(freedom: float) -> float:
    """`beyond_normal` of errors that are Student-distributed with so many degrees of freedom."""
    return _by_quantiles(*stdtrit(freedom, [0.5 + 0.5 * MIDDLE, 0.5 + 0.5 * FAR]))


def _by_quantiles(middle: float, far: float) -> float:
    return float(np.square(middle) ** BY_MIDDLE * np.square(far / 2.0) ** (1.0 - BY_MIDDLE))
