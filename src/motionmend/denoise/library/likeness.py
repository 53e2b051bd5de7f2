"""Whose clip it is: how far the proportions of bodies lie apart, by the distances that hardly change in motion."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...arrays import Floats, Ints

SAME = 0.02  # relative difference of steady distances; clips of one person differ by less, people by more
LEAST_DISTANCE = 0.03  # m; markers nearer to each other say nothing
_STEADY = 0.01  # relative change; distances steadier than this count the same


@dataclass(frozen=True, eq=False)
class Likeness:
    """A recording among the clips of a library.

    Attributes
    ----------
    unlike : relative difference of proportions to the most similar clip.
    person : (C,) number of the person that clip shows.
    larger : (C,) how many times as large as that person the recording's is.
    """

    unlike: float
    person: Ints
    larger: Floats

    @property
    def stranger(self) -> bool:
        """True if the library does not know the person."""
        return self.unlike > SAME

    @property
    def persons(self) -> int:
        """How many people the library shows."""
        return len(np.unique(self.person))


def likeness(recording: Floats, clips: list[Floats]) -> Likeness:
    """Compare (T, V, 3) with clips (N, V, 3) of the same markers, all seen; m.

    Two bodies are as unlike as the root mean square of the relative differences of their mean distances, each weighed
    by how steady it is.
    """
    pairs = np.triu_indices(recording.shape[1], 1)
    mean, spread = (np.array(part) for part in zip(*(_distances(c, pairs) for c in (recording, *clips)), strict=True))
    usual = mean.mean(axis=0)
    apart = usual > LEAST_DISTANCE
    if not apart.any():
        return Likeness(0.0, np.zeros(len(clips), dtype=np.int64), np.ones(len(clips)))
    unsteady = (np.square(spread[0]) + np.square(spread[1:]).mean(axis=0))[apart] / np.square(usual[apart])
    weight = 1.0 / (unsteady + _STEADY**2)
    weight = weight / weight.sum()
    logs = np.log(np.maximum(mean[:, apart], 1e-6))
    size = logs * np.sqrt(weight)
    unlike = np.sqrt(np.square(size[:, None] - size).sum(axis=2))
    _, person = connected_components(unlike[1:, 1:] < SAME, directed=False)
    larger = np.exp((logs[0] - logs[1:]) @ weight)
    return Likeness(float(unlike[0, 1:].min()), np.asarray(person, dtype=np.int64), larger)


def _distances(positions: Floats, pairs: tuple[Ints, Ints]) -> tuple[Floats, Floats]:
    """Mean and standard deviation of the distance of each pair."""
    some = positions[np.unique(np.linspace(0, len(positions) - 1, min(200, len(positions))).astype(np.int64))]
    away = np.linalg.norm(some[:, pairs[0]] - some[:, pairs[1]], axis=2)
    return away.mean(axis=0), away.std(axis=0)
