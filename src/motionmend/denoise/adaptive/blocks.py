"""Channels repaired by the adaptive method: recordings of any length, rate and amount missing."""

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np

from ...arrays import Bools, Bytes, Floats, Ints, away_from
from ...bodies.motion import Origin
from ..bases.repair import MUCH_MISSED, ChannelRepair
from ..bases.support import missed_by
from ..channels.pieces import blocks
from ..gaps.likeliest import Process
from ..library.local_prior import Neighbourhood, Prior, local_prior
from .beliefs import Heard, in_short
from .rounds import Adapted, adapt
from .traits import UNKNOWN, Traits

Item = TypeVar("Item")

BLOCK = 68.0  # s repaired at once; longer recordings go in blocks, so that memory stays bounded
AT_ONCE = 2  # blocks, each on a core of its own as far as there are
MARGIN = 2.0  # s of the neighbours that a block sees on each side
LEAST_FRAMES = 24  # fewer are set among missing frames
FAR = 1.0  # degrees or cm; what leaps by less nobody would miss
NEAR = 2 / 3  # s: a sample missing further from anything seen has no support


@dataclass(frozen=True, eq=False)
class Grounds:
    """What a repair of a recording by itself went by: what its channels are and how it moves, and what was heard of
    each block."""

    traits: Traits
    prior: Prior
    heard: tuple[Heard, ...]


@dataclass(frozen=True, eq=False)
class Mended:
    """A channel repair and what the recording told of itself.

    Attributes
    ----------
    found : the repair.
    noise : (C,) standard deviations, channel units; the median over blocks.
    unseen_bends : (C,) mean variance of second differences that the samples leave open; the mean over blocks.
    missed : root mean square of what the library misses, channel units; 0 without a library.
    leaps : (C,) samples that look like outliers and were taken for leaps of the recording's own, `FAR` or farther.
    farthest : (C,) of these leaps, channel units.
    swings, pace : (C,) as `Adapted` has them, of the block in which a channel swings most; of none by default.
    tried : (T, C) as `Adapted` has it, and none (0, C) where it was not asked for.
    heard : of each block, as `Adapted` has it; none where it was not asked for.
    grounds : of a repair without a library; None = not kept.
    """

    found: ChannelRepair
    noise: Floats
    unseen_bends: Floats
    missed: float
    leaps: Ints
    farthest: Floats
    tried: Floats
    swings: Floats = field(default_factory=lambda: np.zeros(0))
    pace: Floats = field(default_factory=lambda: np.zeros(0))
    heard: tuple[Heard, ...] = ()
    grounds: Grounds | None = None

    @property
    def still(self) -> Bools:
        """(C,) True for channels that are taken to stand still: nothing is left open of how they bend."""
        return np.asarray(self.unseen_bends == 0.0)


def mend_channels(
    measured: Floats,
    prior: Prior,
    fps: float,
    *,
    traits: Traits = UNKNOWN,
    near: Neighbourhood | None = None,
    process: Process | None = None,
    into: Floats | None = None,
    deviations: bool = True,
    trying: bool = False,
    whole: bool = True,
    hearing: bool = False,
    resumed: bool = False,
    heard: tuple[Heard, ...] = (),
) -> Mended:
    """Repair channels without being told how noisy they are.

    Parameters
    ----------
    measured : (T, C) in degrees and centimetres at `fps` Hz, NaN = missing.
    prior : what clean motion is like at `fps`.
    fps : Hz.
    traits : what the channels are.
    near : a library to pick from what is most like the recording; None takes the prior as it is.
    process : of clean motion, for gaps.
    into : (T, C) where the values are written; it may be `measured`, which is lost then. None = a new array.
    deviations : False leaves them out, where nobody asks how sure the values are.
    trying : True gives `tried` too.
    whole : False where the recording goes on before and after these frames.
    hearing : True gives `heard` too.
    resumed : whether a repair that gets this goes on where this one ended; else it only need not listen again.
    heard : of these samples, or of these and a few more, by an earlier repair; none where nothing was repaired.

    Returns
    -------
    Every frame of the input. A sample stays open where nothing is seen near it, or of its channel nothing is known.
    """
    least = max(LEAST_FRAMES, 0 if prior.bases is None else prior.bases.window)
    closer = None if near is None else partial(local_prior, near, fps=fps)
    values = np.empty(measured.shape) if into is None else into
    std = np.empty(measured.shape if deviations else (0, measured.shape[1]), np.float32)
    origin = np.empty(measured.shape, np.uint8)
    tried = np.empty(measured.shape if trying else (0, measured.shape[1]))
    noises, unseen, listened, missed, weight, steps = [], [], list[Heard](), 0.0, 0, 0
    leaps, farthest = np.zeros(measured.shape[1], dtype=np.int64), np.zeros(measured.shape[1])
    swings, pace = np.zeros(measured.shape[1]), np.zeros(measured.shape[1])

    def block(part: tuple[Floats, Floats | None, tuple[bool, bool], Heard | None]) -> Adapted:
        padded, rounding, ends, known = part
        if known is not None and known.loud.shape != padded.shape:  # a short one, set among other missing frames
            known = None
        return adapt(
            padded,
            prior,
            fps,
            traits=traits,
            closer=closer,
            process=process,
            rounding=rounding,
            whole=ends,
            heard=known,
        )

    places = blocks(len(measured), max(1, round(BLOCK * fps)), round(MARGIN * fps))
    parts = (
        (
            _among_missing(measured[seen], least),
            None if traits.rounded is None else _among_missing(traits.rounded(seen), least),
            (whole and seen.start == 0, whole and seen.stop == len(measured)),
            known,
        )
        for (_, seen), known in zip(places, heard or [None] * len(places), strict=True)
    )
    for (core, seen), ((padded, *_), adapted) in zip(places, _at_once(block, parts, len(places)), strict=True):
        before = (len(padded) - (seen.stop - seen.start)) // 2 - seen.start
        own = slice(before + core.start, before + core.stop)
        values[core] = adapted.values[own]
        if trying:
            tried[core] = adapted.tried[own]
        if deviations:
            std[core] = np.sqrt(adapted.variance[own])
        present = np.isfinite(padded)
        kind = np.where(adapted.outlier[own], Origin.REPAIRED, Origin.MEASURED)
        origin[core] = np.where(present[own], kind, Origin.FILLED)
        noises.append(adapted.noise)
        unseen.append(adapted.unseen_bends)
        if hearing and adapted.heard is not None and adapted.ended is not None:
            listened.append(replace(adapted.heard, ended=in_short(adapted.ended) if resumed else None))
        leaps += (adapted.leaps[own] >= FAR).sum(axis=0)
        farthest = np.maximum(farthest, adapted.leaps[own].max(axis=0, initial=0.0))
        pace = np.where(adapted.swings > swings, adapted.pace, pace)
        swings = np.maximum(swings, adapted.swings)
        size = core.stop - core.start
        if prior.bases is not None:
            missed += size * missed_by(adapted.supported, present & ~adapted.outlier, adapted.values) ** 2
        weight, steps = weight + size, steps + adapted.steps
    missed = float(np.sqrt(missed / max(weight, 1)))
    _open_unsupported(origin, fps, prior.bases is not None)
    opened = origin == Origin.LEFT_OPEN
    values[opened] = np.nan
    if deviations:
        std[opened] = np.nan
    said = _unknown(missed, "cm" if traits.together > 1 else "degrees or cm")
    found = ChannelRepair(values, std, origin == Origin.MEASURED, origin, steps, np.empty(0), True, warnings=said)
    noise, bends = np.median(noises, axis=0), np.mean(unseen, axis=0)
    return Mended(found, noise, bends, missed, leaps, farthest, tried, swings, pace, tuple(listened))


def _unknown(missed: float, unit: str) -> tuple[str, ...]:
    """The sentence that says that a library misses the recording; none where it hardly does."""
    if missed <= MUCH_MISSED:
        return ()
    return (
        f"the library misses this recording by {missed:.1f} {unit} (root mean square): it may not know this motion or "
        "person and was believed accordingly; long gaps are as unsure as their deviations say",
    )


def _at_once(task: Callable[[Item], Adapted], items: Iterator[Item], count: int) -> Iterator[tuple[Item, Adapted]]:
    """Every item and its task's result, in order, a few side by side; no more results wait than are worked on.

    An item is taken before the result of the one before it is given out.
    """
    if count == 1:
        for item in items:
            yield item, task(item)
        return
    with ThreadPoolExecutor(max_workers=min(AT_ONCE, os.cpu_count() or 1)) as pool:
        waiting: deque[tuple[Item, Future[Adapted]]] = deque()
        for item in items:
            waiting.append((item, pool.submit(task, item)))
            if len(waiting) == AT_ONCE:
                first, result = waiting.popleft()
                yield first, result.result()
        for last, result in waiting:
            yield last, result.result()


def _among_missing(block: Floats, least: int) -> Floats:
    """A copy of a block, a short one with missing frames on both sides."""
    short = max(least - len(block), 0)
    return np.pad(block, ((short // 2, short - short // 2), (0, 0)), constant_values=np.nan)


def _open_unsupported(origin: Bytes, fps: float, library: bool) -> None:
    """Open the gaps (T, C) that nothing supports, in place."""
    # with a library any channel speaks for all; without one each speaks for itself
    anywhere = away_from((origin == Origin.MEASURED).any(axis=1)) if library else None
    for c in np.flatnonzero((origin == Origin.FILLED).any(axis=0)):
        away = away_from(origin[:, c] == Origin.MEASURED) if anywhere is None else anywhere
        origin[(origin[:, c] == Origin.FILLED) & (away > NEAR * fps), c] = Origin.LEFT_OPEN
