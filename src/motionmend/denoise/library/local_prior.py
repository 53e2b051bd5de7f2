"""From a large mixed library, what this recording needs: the windows most like it, and what they have in common.

The dissertation's local models (section 3.4) tolerate general databases; here they serve the filter bases.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...numerics.ssa import Eigenbases, at_rate
from .exemplars import Library, typical_bends
from .learning import at_rate as series_at_rate

COORDINATES = 40  # leading patterns in which windows are compared
NEAREST = 60  # exemplars taken for each window of the recording
FEWEST = 120  # exemplars that make bases of their own
WHOLE = 0.6  # of the library: so much of it is like the recording that it is the library that is wanted
ENERGY = 0.99
FEWER = 4  # times: with so many more windows it is sooner done than by all their inner products
SPARE = 24  # random patterns beside those of the whole library, for what is rare there and common here
ENOUGH = 0.994  # of the energy: so much the sought patterns have to hold, not to lose any that is needed


@dataclass(frozen=True, eq=False)
class Prior:
    """What clean motion is like at a recording's rate.

    Attributes
    ----------
    bends : (C, C) covariance of second differences.
    bases : patterns at that rate; None without a library.
    stride : frames between windows.
    own : the bases were learned from a first repair of the very recording, and share what that missed.
    still : (C,) True for channels that bend less than what counts as motion elsewhere; None = none does.
    elsewhere : patterns for what is filled, learned where gaps were laid into the recording; None = `bases` serve.
    """

    bends: Floats
    bases: Eigenbases | None
    stride: int = 1
    own: bool = False
    still: Bools | None = None
    elsewhere: Eigenbases | None = None


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """A library whose windows can be looked up.

    Attributes
    ----------
    library : with exemplar windows at `rate` Hz.
    bases : of the whole library, at `rate`.
    rate : Hz.
    places : (N, K) the exemplars' coordinates in the leading patterns.
    """

    library: Library
    bases: Eigenbases
    rate: float
    places: Floats


@lru_cache(maxsize=1)  # files of a folder ask the same library, and so do the windows of a stream
def neighbourhood(library: Library, bases: Eigenbases, rate: float) -> Neighbourhood:
    """Make a library's windows ready to be looked up."""
    windows = library.exemplars.reshape(len(library.exemplars), -1).astype(float)
    return Neighbourhood(library, bases, rate, _coordinates(windows, bases))


def local_prior(near: Neighbourhood, values: Floats, fps: float) -> Prior | None:
    """Bends and bases of the exemplars most like a recording; None where that is the whole library, or too few.

    Parameters
    ----------
    near : the library.
    values : (T, C) a first estimate at `fps` Hz, finite.
    fps : Hz.
    """
    exemplars = near.library.exemplars
    window = exemplars.shape[1]
    series = series_at_rate(values, fps, near.rate)[0]
    if len(series) < window or len(exemplars) < FEWEST:
        return None
    starts = np.unique(np.append(np.arange(0, len(series) - window, window // 2), len(series) - window))
    own = np.stack([series[s : s + window].ravel() for s in starts])
    chosen = _nearest(_coordinates(own, near.bases), near.places)
    if not FEWEST <= len(chosen) < WHOLE * len(exemplars):
        return None
    windows = exemplars[chosen].astype(float)
    here, there = (np.diag(near.library.curvature(rate)) for rate in (near.rate, fps))
    ratio = np.sqrt(there / np.where(here > 0, here, np.inf))
    bends = typical_bends(windows) * np.multiply.outer(ratio, ratio)
    bases, stride = at_rate(_few_window_bases(windows, near.bases.vectors), near.rate, fps)
    return Prior(bends, bases, stride)


def _coordinates(windows: Floats, bases: Eigenbases) -> Floats:
    leading = bases.vectors[:COORDINATES].reshape(-1, windows.shape[1])
    return np.asarray((windows - bases.mean.ravel()) @ leading.T)


def _nearest(wanted: Floats, places: Floats) -> Ints:
    """Exemplars that are among the nearest of some window, in their order."""
    away = np.square(wanted).sum(axis=1)[:, None] - 2.0 * wanted @ places.T + np.square(places).sum(axis=1)
    count = min(NEAREST, places.shape[0])
    return np.unique(np.argpartition(away, count - 1, axis=1)[:, :count])


def _few_window_bases(windows: Floats, alike: Floats) -> Eigenbases:
    """Bases of windows (N, M, C), sought near patterns (K, M, C) that are known to hold most of them.

    One round of subspace iteration from the known patterns and some more; where these hold too little, all of the
    windows' inner products are taken apart.

    Source
    ------
    Halko, Martinsson and Tropp, Finding structure with randomness, SIAM Review 53(2), 2011, algorithm 4.4.
    """
    count, shape = len(windows), windows.shape[1:]
    mean = windows.mean(axis=0)
    flat = (windows - mean).reshape(count, -1) / np.sqrt(count)
    total = float(np.square(flat).sum())
    more = np.random.default_rng(0).normal(size=(SPARE, flat.shape[1])) / np.sqrt(flat.shape[1])
    sought = np.concatenate([alike.reshape(len(alike), -1), more])
    few = FEWER * len(sought) < min(flat.shape)
    if few:
        sides = np.linalg.qr(flat @ np.linalg.qr(flat.T @ np.linalg.qr(flat @ sought.T)[0])[0])[0]
        within = sides.T @ flat
        values, turns = np.linalg.eigh(within @ within.T)
        sides = sides @ turns
    if not few or values.sum() < ENOUGH * total:
        values, sides = np.linalg.eigh(flat @ flat.T)
    values, sides = np.clip(values[::-1], 0.0, None), sides[:, ::-1]
    kept = min(int(np.searchsorted(np.cumsum(values), ENERGY * total)) + 1, count - 1)
    vectors = (sides[:, :kept] / np.sqrt(np.maximum(values[:kept], 1e-12 * max(total, 1e-12)))).T @ flat
    left = np.square(flat).sum(axis=0) - np.einsum("kd,k->d", np.square(vectors), values[:kept])
    discarded = np.clip(left, 0.0, None).reshape(shape).mean(axis=0)
    return Eigenbases(mean, vectors.reshape(kept, *shape), values[:kept], total, discarded)
