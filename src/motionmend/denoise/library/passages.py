"""A bounded sample of the clips' series, in passages of several seconds, for what cannot be learned from sums."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from ...arrays import Floats
from ..channels.thinning import MOST_VALUES, Sample, sample

FRAMES = 256  # of a passage, at the model's rate


@dataclass(frozen=True, eq=False)
class Passage:
    """Consecutive frames of a clip.

    Attributes
    ----------
    clip : the number its clip begins at.
    place : of the passage in the clip, 0 is the first.
    phases : each (T, C) at the model's rate.
    """

    clip: int
    place: int
    phases: tuple[Floats, ...]


def passages(series: Sequence[Floats], clip: int) -> Sample[Passage]:
    """A clip's series as passages.

    Parameters
    ----------
    series : each (T, C), the phases of one clip.
    clip : where the numbering of its items begins.
    """
    places = np.arange(-(-max(len(phase) for phase in series) // FRAMES))
    sizes = np.array([sum(p[FRAMES * i : FRAMES * (i + 1)].size for p in series) for i in places], dtype=np.int64)

    def passage(place: int) -> Passage:
        cut = slice(FRAMES * place, FRAMES * (place + 1))
        return Passage(clip, place, tuple(phase[cut].copy() for phase in series))

    return sample(clip + places, sizes, MOST_VALUES, passage)


def rejoined(kept: Sample[Passage]) -> list[Floats]:
    """The series that passages were cut from, phase after phase; a missing frame stands for what was left out."""
    series: list[Floats] = []
    for _, found in groupby(kept.items, key=lambda passage: passage.clip):
        together = list(found)
        for phase in range(len(together[0].phases)):
            parts: list[Floats] = []
            for k, passage in enumerate(together):
                part = passage.phases[phase]
                if k and passage.place != together[k - 1].place + 1:
                    parts.append(np.full((1, part.shape[1]), np.nan))
                parts.append(part)
            series.append(np.concatenate(parts))
    return series
