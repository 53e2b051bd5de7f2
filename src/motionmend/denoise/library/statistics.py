"""What a model is made of, as sums and bounded samples of clips: those of parts add up to those of the whole."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from ...arrays import Floats, Ints, Singles, frozen
from ...bodies.motion import Markers, Motion
from ...numerics.ssa import LagCovariance, lag_covariance
from ..channels.cloud import righting
from ..channels.layout import Layout, names_of
from ..channels.thinning import MOST_VALUES, Sample, nothing, sample
from .exemplars import Library, typical_bends
from .learning import BRIDGED, Example, at_rate, examples
from .markers import MarkerLibrary, library_of, merged
from .passages import Passage, passages

MOST_EXEMPLARS = 4000
OCTAVES = (-1, 0, 1, 2)  # rates of the second differences, from the model's own
_TOGETHER = 16384  # frames whose lag sums are taken at once: the sums are large, and most clips are short
_PIECE = 1 << 16  # frames of a clip whose postures are looked at together
_RATE_SLACK = 1.5e-3  # of a rate: 59.94 Hz will do for 60 Hz


@dataclass(frozen=True, eq=False)
class Statistics:
    """Sums over clips, and samples of them that stay within a bound. C channels, M frames of a window.

    Sums of parts are those of the whole to rounding, samples exactly; added in the same order they are the same.

    Attributes
    ----------
    kind : "motion" or "markers".
    fps : the model's rate, Hz.
    clips, frames : how many.
    barren : numbers of the clips, in their order, in which no whole window lies: they teach no bases.
    lost, bridged : samples of joints that fall to zeros, and samples in short gaps.
    lag : sums over lag windows.
    bend_counts : (R,) second differences at each rate `fps` * 2 ** `OCTAVES`.
    bends : (R, C, C) sums of their outer products.
    windows : (M, C) float32 each.
    passages : of the series at the model's rate.
    postures : examples of marker sets; None for motions.
    """

    kind: str
    fps: float
    clips: int
    frames: int
    lost: int
    bridged: int
    lag: LagCovariance
    bend_counts: Ints
    bends: Floats
    windows: Sample[Singles]
    passages: Sample[Passage]
    postures: MarkerLibrary | None
    barren: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bend_counts", frozen(self.bend_counts, np.int64))
        object.__setattr__(self, "bends", frozen(self.bends))

    def __add__(self, other: "Statistics") -> "Statistics":
        return Statistics(
            self.kind,
            self.fps,
            self.clips + other.clips,
            self.frames + other.frames,
            self.lost + other.lost,
            self.bridged + other.bridged,
            self.lag + other.lag,
            self.bend_counts + other.bend_counts,
            self.bends + other.bends,
            self.windows + other.windows,
            self.passages + other.passages,
            _both(self.postures, other.postures),
            self.barren + tuple(self.clips + number for number in other.barren),
        )

    def notes(self) -> tuple[str, ...]:
        """One sentence for each thing that was left out of the clips or bridged in them."""
        said = []
        if self.lost:
            said.append(
                f"{self.lost} samples of joints that fall to exact zeros, or of rest poses before a clip, were left out"
            )
        if self.bridged:
            what = "channel samples" if self.kind == "motion" else "marker coordinates"
            said.append(f"{self.bridged} {what} in gaps of up to {BRIDGED} s were bridged by splines")
        return tuple(said)

    def library(self) -> Library:
        """Second differences and exemplar windows as a model keeps them."""
        seen = np.flatnonzero(self.bend_counts > 0)
        counts = self.bend_counts[seen]
        exemplars = np.array(self.windows.items, dtype=np.float32).reshape(-1, self.lag.window, self.lag.channels)
        return Library(
            rates=self.fps * 2.0 ** np.array(OCTAVES)[seen],
            counts=counts,
            bends=self.bends[seen] / counts[:, None, None],
            exemplars=exemplars,
            typical=typical_bends(exemplars),
            rate=self.fps,
        )


def statistics(clips: Iterable[Motion | Markers], layout: Layout, window: int, fps: float) -> Statistics:
    """Statistics of clips, in their order; one at a time is held, however long, in pieces.

    Parameters
    ----------
    clips : clean clips of the layout's channels.
    layout : of the model.
    window : M, frames of a lag window at `fps`.
    fps : the model's rate, Hz.
    """
    channels = layout.columns
    most = channels * window * MOST_EXEMPLARS
    clip_count = frames = lost = bridged = 0
    lag = lag_covariance(np.empty((0, channels)), window)
    pending: list[Floats] = []
    counts, bends = np.zeros(len(OCTAVES), dtype=np.int64), np.zeros((len(OCTAVES), channels, channels))
    windows: Sample[Singles] = nothing(min(most, 8 * MOST_VALUES))
    kept: Sample[Passage] = nothing(MOST_VALUES)
    postures: MarkerLibrary | None = None
    barren: list[int] = []
    for clip in clips:
        barren.append(clip_count)
        clip_count += 1
        if isinstance(clip, Markers):
            postures = _both(postures, _postures(clip, layout))
        for example in examples(clip, layout, (window - 1) / fps):
            frames += example.frames
            lost += example.lost
            bridged += example.bridged
            series = at_rate(example.values, example.fps, fps)
            pending += series
            if sum(map(len, pending)) > _TOGETHER:
                lag, pending = lag + lag_covariance(pending, window), []
            found_counts, found = _bends(example, fps)
            counts, bends = counts + found_counts, bends + found
            begins = [_begins(values, window) for values in series]
            if any(map(len, begins)) and barren[-1:] == [clip_count - 1]:
                barren.pop()
            windows = windows + _windows(series, begins, example.number, window, windows)
            kept = kept + passages(at_rate(example.values[: example.frames], example.fps, fps), example.number)
    if pending:
        lag = lag + lag_covariance(pending, window)
    sums = (clip_count, frames, lost, bridged, lag, counts, bends, windows, kept, postures)
    return Statistics(layout.kind, fps, *sums, barren=tuple(barren))


def _postures(clip: Markers, layout: Layout) -> MarkerLibrary:
    """Example postures of a clip, turned upright as the layout has it; long clips in pieces."""
    names = names_of(clip)
    order, upright = [names.index(n) for n in layout.names], righting(clip.up, layout.up).T
    pieces = range(0, max(clip.frames, 1), _PIECE)
    found = [library_of(clip.positions[at : at + _PIECE, order] @ upright, clip.fps, layout.up) for at in pieces]
    return reduce(merged, found)


def _both(one: MarkerLibrary | None, other: MarkerLibrary | None) -> MarkerLibrary | None:
    return merged(one, other) if one is not None and other is not None else one if other is None else other


def _bends(example: Example, fps: float) -> tuple[Ints, Floats]:
    """Counts (R,) and sums (R, C, C) of outer products of a clip's second differences at the rates it reaches."""
    values = example.values[: example.frames]
    counts, sums = np.zeros(len(OCTAVES), dtype=np.int64), np.zeros((len(OCTAVES), *(values.shape[1:] * 2)))
    for k, octave in enumerate(OCTAVES):
        rate = fps * 2.0**octave
        if rate > (1.0 + _RATE_SLACK) * example.fps:
            break
        for series in at_rate(values, example.fps, rate):
            bend = np.diff(series, n=2, axis=0)
            bend = bend[np.isfinite(bend).all(axis=1)]
            counts[k] += len(bend)
            sums[k] += bend.T @ bend
    return counts, sums


def _begins(values: Floats, window: int) -> Ints:
    """First frames of a series' whole windows."""
    if len(values) < window:
        return np.zeros(0, dtype=np.int64)
    whole = np.concatenate([[0], np.cumsum(np.isfinite(values).all(axis=1))])
    return np.flatnonzero(whole[window:] - whole[:-window] == window)


def _windows(
    series: Sequence[Floats], begins: Sequence[Ints], number: int, window: int, so_far: Sample[Singles]
) -> Sample[Singles]:
    """A sample of a clip's whole windows, numbered as their first frames follow each other in the clip."""
    if not any(map(len, begins)):
        return nothing(so_far.most)
    numbered = np.concatenate([number + len(series) * starts + phase for phase, starts in enumerate(begins)])
    places = [np.stack([np.full(len(starts), phase), starts], axis=1) for phase, starts in enumerate(begins)]
    order = np.argsort(numbered, kind="stable")
    at = np.concatenate(places)[order]

    def item(i: int) -> Singles:
        phase, start = at[i]
        return np.array(series[phase][start : start + window], dtype=np.float32)

    sizes = np.full(len(at), window * series[0].shape[1])
    return sample(numbered[order], sizes, so_far.most, item, so_far.level)
