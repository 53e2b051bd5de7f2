"""Markers that slide slowly from their place: nothing leaps, so that only the markers about them can tell.

Skin moves by a centimetre or two, further where a body bends as it never did before, and nobody can tell that from a
marker that comes loose. So none is moved: who strays much further from where its neighbours have it than nearly all
others do from theirs is named, with where and how far, for somebody to look at.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...arrays import Bools, Bytes, Floats, runs
from ...bodies.motion import Markers, Motion, Origin
from ..channels.joints import CENTIMETRES
from ..gaps.markers import LEAST_FRAMES
from .displaced import place_by_guides, steadiest_guides
from .held import SAID

LEAST = 0.02  # m; skin moves as far
BEYOND = 3.0  # times as far as nearly all others stray
NEARLY_ALL = 0.9  # of them
FEWEST = 10  # markers, for some to be nearly all
TOGETHER = 0.08  # s of frames that are taken as one: what slides is slow
AVERAGED = 5  # such moments, over which a slide is told from noise
LASTS = 8  # moments; honest markers stray further for a shorter time
AWAY = 0.35  # of the furthest, from which it counts as away
_FEW = 1e-6


@dataclass(frozen=True)
class Slide:
    """A marker that strays.

    Attributes
    ----------
    marker : its number.
    first, last : frames between which it is away.
    away : m, at the furthest.
    """

    marker: int
    first: int
    last: int
    away: float


def slides(positions: Floats, believed: Bools, fps: float) -> tuple[Slide, ...]:
    """Markers that seem to slide from their place, the furthest first.

    Parameters
    ----------
    positions : (T, M, 3) m, repaired; NaN = left open.
    believed : (T, M) True where a sample was measured and believed: what was filled in cannot slide.
    fps : Hz.
    """
    length = max(1, round(TOGETHER * fps))
    moments, seen = _moments(positions, believed, length)
    if len(moments) < 2 * LEAST_FRAMES or positions.shape[1] < FEWEST:
        return ()
    strays = _strays(moments, seen)
    furthest = strays.max(axis=0)
    told = furthest > 0.0
    if told.sum() < FEWEST:
        return ()
    limit = max(LEAST, BEYOND * float(np.quantile(furthest[told], NEARLY_ALL)))
    found = []
    for marker in np.argsort(-furthest, kind="stable").tolist():
        if furthest[marker] <= limit:
            break
        at = int(strays[:, marker].argmax())
        away = runs(strays[:, marker] > AWAY * furthest[marker])
        start, stop = next((start, stop) for start, stop in away if start <= at < stop)
        if stop - start >= LASTS:
            last = min(stop * length, len(positions)) - 1
            found.append(Slide(marker, int(start) * length, int(last), float(furthest[marker])))
    return tuple(found)


def _moments(positions: Floats, believed: Bools, length: int) -> tuple[Floats, Bools]:
    """The mean of every `length` frames (N, M, 3) m, NaN where a frame is open, and where (N, M) most were believed."""
    short = -len(positions) % length  # the last frame stands for those that are wanting
    parts = np.pad(positions, ((0, short), (0, 0), (0, 0)), mode="edge").reshape(-1, length, *positions.shape[1:])
    told = np.pad(believed, ((0, short), (0, 0)), mode="edge").reshape(-1, length, believed.shape[1])
    mean = parts.mean(axis=1)
    return mean, np.asarray((2 * told.sum(axis=1) >= length) & np.isfinite(mean).all(axis=2))


def _strays(moments: Floats, seen: Bools) -> Floats:
    """(N, M) m by which each marker is away from where those about it have it, for a while; 0 = not told."""
    places, guides = steadiest_guides(moments)
    found = np.zeros(seen.shape)
    none = np.empty(0, dtype=np.int64)
    for marker, (who, unsteady) in guides.items():
        if seen[:, marker].sum() < LEAST_FRAMES:
            continue
        away = place_by_guides(places, marker, who, unsteady, seen[:, marker], none)
        shown, total = (
            uniform_filter1d(one, AVERAGED, mode="nearest")
            for one in (seen[:, marker].astype(np.float64), np.where(seen[:, marker], away, 0.0))
        )
        found[:, marker] = np.where(shown > _FEW, total / np.maximum(shown, _FEW), 0.0)
    return found


def said_of_sliding(repaired: Motion | Markers, origin: Bytes) -> tuple[str, ...]:
    """A sentence for each marker that seems to slide from its place, as far as it was believed."""
    if not isinstance(repaired, Markers):
        return ()
    found = slides(repaired.positions, origin == Origin.MEASURED, repaired.fps)
    return tuple(
        f"{repaired.names[slide.marker]}: in frames {slide.first} to {slide.last} it strays by up to "
        f"{CENTIMETRES * slide.away:.0f} cm from where the markers about it have it else; it may have slid and was "
        "left; look at it"
        for slide in found[:SAID]
    )
