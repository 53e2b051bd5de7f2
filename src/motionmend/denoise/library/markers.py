"""What clean clips of a marker set teach a gap filler: examples of postures with what came before and after."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Floats, Ints, frozen
from ...errors import MismatchError

OFFSETS = (-0.4, -0.2, 0.0, 0.2, 0.4)  # s; an example shows the body at these moments
SPACING = 1.0 / 30.0  # s; examples of one clip nearer to each other teach nothing new
MOST = 1500  # examples of a library


@dataclass(frozen=True, eq=False)
class MarkerLibrary:
    """Examples of postures. E examples, W moments, M markers.

    Attributes
    ----------
    windows : (E, W, M, 3) m, float32, NaN = missing; about the middle of the posture at the moment 0.
    clip : (E,) number of the clip an example is from.
    time : (E,) s, when in its clip.
    rank : (E,) how late an example is given up when there are too many: 0 is the last.
    up : (3,) against gravity.
    most : E at most.
    """

    windows: NDArray[np.float32]
    clip: Ints
    time: Floats
    rank: Ints
    up: Floats
    most: int = MOST

    def __post_init__(self) -> None:
        object.__setattr__(self, "windows", frozen(self.windows, np.float32))
        object.__setattr__(self, "clip", frozen(self.clip, np.int64))
        object.__setattr__(self, "time", frozen(self.time))
        object.__setattr__(self, "rank", frozen(self.rank, np.int64))
        object.__setattr__(self, "up", frozen(self.up))
        if self.windows.ndim != 4 or self.windows.shape[1::2] != (len(OFFSETS), 3):
            raise MismatchError(f"examples must be (examples, {len(OFFSETS)}, markers, 3), came {self.windows.shape}")
        if not len(self.windows) == len(self.clip) == len(self.time) == len(self.rank):
            raise MismatchError("each example needs a clip, a time and a rank")

    @property
    def markers(self) -> int:
        """M."""
        return int(self.windows.shape[2])

    @property
    def postures(self) -> Floats:
        """(E, M, 3) m: the examples at their moment 0."""
        return np.asarray(self.windows[:, OFFSETS.index(0.0)], dtype=np.float64)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Plain arrays from which `from_arrays` makes the library again."""
        return {
            "windows": self.windows,
            "clip": self.clip,
            "time": self.time,
            "rank": self.rank,
            "up": self.up,
            "most": np.array([self.most], dtype=np.int64),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "MarkerLibrary":
        """The library that `to_arrays` took apart."""
        most = int(np.asarray(arrays["most"]).ravel()[0])
        return cls(arrays["windows"], arrays["clip"], arrays["time"], arrays["rank"], arrays["up"], most)


def learn_marker_library(clips: Iterable[tuple[Floats, float]], up: Floats, most: int = MOST) -> MarkerLibrary:
    """Choose examples from clean clips; memory stays bounded however many there are.

    Parameters
    ----------
    clips : (T, M, 3) m, NaN = missing, and the rate in Hz of each; the same markers in the same order, turned so that
        all have the same `up`.
    up : (3,) unit vector against gravity.
    most : examples at most.

    Raises
    ------
    MismatchError : no clip, or clips of different markers.
    """
    learned = (library_of(positions, fps, up, most) for positions, fps in clips)
    first = next(learned, None)
    if first is None:
        raise MismatchError("a marker library learns from clean clips, came none")
    return reduce(merged, learned, first)


def library_of(positions: Floats, fps: float, up: Floats, most: int = MOST) -> MarkerLibrary:
    """The library of one clip; what `merged` puts together may be learned in parallel."""
    if positions.ndim != 3 or positions.shape[2] != 3:
        raise MismatchError(f"markers must be (frames, markers, 3), came {positions.shape}")
    seen = np.asarray(np.isfinite(positions).all(axis=2))
    step = max(1, round(SPACING * fps))
    # a frame that shows hardly any marker teaches nothing
    frames = np.arange(0, len(positions), step)
    frames = frames[seen[frames].mean(axis=1) >= 0.5] if len(frames) else frames
    order = _evenly_first(len(frames))[:most]
    frames = frames[order]
    windows = np.stack([at_offset(positions, fps, offset)[frames] for offset in OFFSETS], axis=1)
    known = np.where(seen[frames][..., None], positions[frames], 0.0)
    middle = known.sum(axis=1) / np.maximum(seen[frames].sum(axis=1), 1)[:, None]
    return MarkerLibrary(
        (windows - middle[:, None, None]).astype(np.float32),
        np.zeros(len(frames), dtype=np.int64),
        frames / fps,
        np.arange(len(frames)),
        up,
        most,
    )


def at_offset(positions: Floats, fps: float, offset: float) -> Floats:
    """(T, M, 3) each frame's positions `offset` seconds later; beyond the ends the first or last frame."""
    later = np.clip(np.arange(len(positions)) + round(offset * fps), 0, max(len(positions) - 1, 0))
    return np.asarray(positions[later])


def merged(one: MarkerLibrary, other: MarkerLibrary) -> MarkerLibrary:
    """Both libraries in one; when there are too many examples, every clip gives up its most crowded ones.

    Associative: however clips are grouped, the same examples remain.

    Raises
    ------
    MismatchError : different numbers of markers.
    """
    if one.markers != other.markers:
        raise MismatchError(f"libraries must be of the same markers, came {one.markers} and {other.markers}")
    most = min(one.most, other.most)
    windows = np.concatenate([one.windows, other.windows])
    beyond = int(one.clip.max()) + 1 if len(one.clip) else 0
    clip = np.concatenate([one.clip, other.clip + beyond])
    time = np.concatenate([one.time, other.time])
    rank = np.concatenate([one.rank, other.rank])
    kept = np.sort(np.argsort(rank, kind="stable")[:most])
    return MarkerLibrary(windows[kept], clip[kept], time[kept], rank[kept], one.up, most)


def _evenly_first(count: int) -> Ints:
    """0..count-1 in such an order that any beginning of it is spread evenly (van der Corput's sequence)."""
    bits = max(1, int(count - 1).bit_length()) if count else 1
    index = np.arange(1 << bits)
    back = np.zeros_like(index)
    for bit in range(bits):
        back |= ((index >> bit) & 1) << (bits - 1 - bit)
    return np.asarray(back[back < count], dtype=np.int64)


def examples_like(library: MarkerLibrary, positions: Floats, most: int) -> tuple[Floats, Ints]:
    """The postures (E', M, 3) that are most like a recording's, and their clips (E',) from 1 on.

    Postures are compared by the distances between a dozen markers, which know neither place nor heading.

    Parameters
    ----------
    library : of the recording's markers.
    positions : (T, M, 3) m, NaN = missing.
    most : E' at most; a third of them is spread over all clips.
    """
    postures, clip = library.postures, library.clip + 1
    if len(postures) <= most:
        return postures, clip
    often = np.isfinite(positions).all(axis=2).mean(axis=0) * np.isfinite(postures).all(axis=2).mean(axis=0)
    landmarks = _far_apart(postures, often)
    some = positions[np.linspace(0, len(positions) - 1, min(60, len(positions))).astype(np.int64)]
    there, known = _distances(postures, landmarks)
    here, here_known = _distances(some, landmarks)
    shared = here_known @ known.T
    square = np.square(here) @ known.T + here_known @ np.square(there).T - 2.0 * here @ there.T
    unlike = np.where(shared > 0, square / np.maximum(shared, 1.0), np.inf)
    spread = np.argsort(library.rank, kind="stable")[: most // 3]
    rounds = np.argsort(unlike, axis=1, kind="stable")
    chosen = dict.fromkeys(spread.tolist())
    for nearest in rounds.T:  # the nearest of each frame, then the second nearest of each ...
        chosen |= dict.fromkeys(nearest.tolist()[: max(most - len(chosen), 0)])
        if len(chosen) >= most:
            break
    kept = np.sort(np.array(list(chosen), dtype=np.int64))
    return postures[kept], clip[kept]


def _far_apart(postures: Floats, often: Floats, count: int = 12) -> Ints:
    """Markers that lie far from each other and are often seen."""
    mean = np.nan_to_num(np.where(np.isfinite(postures), postures, 0.0).mean(axis=0))
    chosen = [int(np.argmax(often))]
    away = np.full(len(mean), np.inf)
    while len(chosen) < min(count, len(mean)):
        away = np.minimum(away, np.linalg.norm(mean - mean[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(np.where(np.isin(np.arange(len(mean)), chosen), -1.0, away * often))))
    return np.array(chosen, dtype=np.int64)


def _distances(postures: Floats, landmarks: Ints) -> tuple[Floats, Floats]:
    """(E, P) distances between landmarks with 0 where unknown, and 1 where known."""
    some = postures[:, landmarks]
    first, second = np.triu_indices(len(landmarks), 1)
    away = np.linalg.norm(some[:, first] - some[:, second], axis=2)
    known = np.isfinite(away)
    return np.where(known, away, 0.0), known.astype(np.float64)
