"""Noise of markers, told by distances that hardly change: however fast a body moves, skin keeps its markers apart."""

import numpy as np
from scipy.special import ndtri

from ...arrays import Bools, Floats, Ints
from ...numerics.quantiles import quantile_of_known

NEAREST = 8  # markers that are tried as partners, by their median distance
LOOKED_AT = 64  # frames for that
MOMENTS = 256  # at most, of which means tell which distance is steady
HALVES = 16  # frames on end; a partner is chosen in every other such stretch and asked in the rest
FEWEST = 8  # differences that tell anything
PARTNERS = 4  # that are asked of each half, at most
ALIKE = 1.4  # times the least change of any distance; one that changes more is no distance on the same bone
QUANTILE = 0.75  # of the differences, by which noise is told: outliers that were overlooked do not reach it
_FOURTH, _SECOND = 70.0, 6.0  # variance of fourth and second differences of white noise of variance one
WHITE = 4.0  # power of the share of second differences that fourth ones leave, by which less is believed
_TURNS = 10  # that share what a pair says among the two
_NOTHING = 1e-12


def noise_by_distances(measured: Floats, believed: Bools, loudness: Floats) -> tuple[Floats, Floats]:
    """Variance of each marker's noise as its distance to a near one tells it, and how many samples' worth that is.

    Parameters
    ----------
    measured : (T, C) in cm, NaN = missing; three columns a marker.
    believed : (T, C) True where a sample is no outlier.
    loudness : (T, C) of the noise at each moment relative to what is asked for.

    Returns
    -------
    (C,) variance in cm^2 of each column, and the weight (C,), 0 where nothing is told.

    Notes
    -----
    Fourth differences of what moves smoothly are less than those of noise by more than second ones are. Where they
    leave less of a distance than noise does, it is not white: it changes, as between limbs, and so much less is
    believed.
    """
    frames, columns = measured.shape
    markers = columns // 3
    variance, weight = np.zeros(columns), np.zeros(columns)
    if markers < 2 or frames < 2 * HALVES:
        return variance, weight
    places = np.where(believed, measured, np.nan).reshape(frames, markers, 3)
    louder = np.square(loudness).reshape(frames, markers, 3).mean(axis=2)
    near = _nearest(places)
    scale = np.sqrt(0.5 * (louder[:, :, None] + louder[:, near]))[2:-2]
    bend = np.diff(_apart(places, near), n=2, axis=0)
    fourth, second = np.diff(bend, n=2, axis=0), bend[1:-1]
    for differences, of_noise in ((fourth, _FOURTH), (second, _SECOND)):
        np.abs(differences, out=differences)
        differences /= scale
        differences /= np.sqrt(of_noise)
    half = np.arange(len(fourth)) // HALVES % 2 == 0
    parts = half, ~half
    swift, slow = ([_sizes(one[part]) for part in parts] for one in (fourth, second))
    told: list[Floats] = []
    slowly: list[Floats] = []
    partner: list[Ints] = []
    for chosen, asked in ((0, 1), (1, 0)):
        # slow changes show in second differences: of two on one bone they are noise alone
        by = np.argsort(slow[chosen], axis=1)[:, :PARTNERS]
        sizes = np.take_along_axis(slow[chosen], by, 1)
        alike = sizes < ALIKE * sizes[:, :1]
        partner.append(np.take_along_axis(near, by, 1))
        for found, of in ((told, swift), (slowly, slow)):
            size = np.take_along_axis(of[asked], by, 1)
            found.append(np.where(alike & np.isfinite(size), np.square(size), np.nan))
        seen = np.isfinite(fourth[parts[asked]]).sum(axis=0)
        weight.reshape(markers, 3)[:] += np.take_along_axis(seen, by[:, :1], 1)
    pairs, other = np.hstack(told), np.hstack(partner)
    known = np.isfinite(pairs).any(axis=1)
    if not known.any():
        return variance, np.zeros(columns)
    share = np.nanmedian(pairs / np.maximum(np.hstack(slowly), _NOTHING))
    weight *= np.repeat(known, 3) * min(1.0, float(share)) ** WHITE
    pairs[~known] = np.nanmedian(pairs)
    own = 0.5 * np.nanmean(pairs, axis=1)  # as noisy as each other, until others tell more
    for _ in range(_TURNS):
        own = np.maximum(own + 0.5 * np.nanmean(pairs - own[:, None] - own[other], axis=1), _NOTHING)
    return np.repeat(own, 3), weight


def steadiest_distances(places: Floats, moment: int) -> Floats:
    """(T, M) cm, how far each marker is from that near one from which this changes least.

    Chosen by means of some frames, for by single ones noise would choose what hides it.

    Parameters
    ----------
    places : (T, M, 3) cm, NaN = missing; two markers at least.
    moment : frames, of which the means are taken; two moments at least.
    """
    near = _nearest(places)
    count = len(places) // moment
    begins = moment * np.unique(np.linspace(0, max(count - 1, 0), min(count, MOMENTS)).astype(int))
    means = np.full((len(begins), *near.shape), np.nan)
    for k, begin in enumerate(begins):
        some = places[begin : begin + moment]
        away = np.linalg.norm(some[:, :, None] - some[:, near], axis=-1)
        known = np.isfinite(away).any(axis=0)
        means[k, known] = np.nanmean(away[:, known], axis=0)
    told = np.isfinite(means).sum(axis=0) >= 2
    spread = np.full(told.shape, np.inf)
    spread[told] = np.nanstd(means[:, told], axis=0)
    partner = np.take_along_axis(near, np.argmin(spread, axis=1)[:, None], 1)[:, 0]
    apart = np.zeros(places.shape[:2])
    for k in range(3):
        apart += np.square(places[:, :, k] - places[:, partner, k])
    return np.sqrt(apart)


def _apart(places: Floats, near: Ints) -> Floats:
    """(T, M, K) how far each marker of (T, M, 3) is from those near it (M, K)."""
    square = np.zeros((len(places), *near.shape))
    for k in range(3):
        along = np.ascontiguousarray(places[:, :, k])
        between = along[:, near]
        between -= along[:, :, None]
        square += np.square(between, out=between)
    return np.asarray(np.sqrt(square, out=square))


def _nearest(places: Floats) -> Ints:
    """(M, K) the markers that each is nearest to, by the median of some frames."""
    some = places[np.unique(np.linspace(0, len(places) - 1, LOOKED_AT).astype(int))]
    away = np.linalg.norm(some[:, :, None] - some[:, None], axis=-1)
    together = np.isfinite(away).any(axis=0)
    apart = np.full(together.shape, np.inf)
    apart[together] = np.nanmedian(away[:, together], axis=0)
    np.fill_diagonal(apart, np.inf)
    return np.argsort(apart, axis=1)[:, : min(NEAREST, len(apart) - 1)]


def _sizes(differences: Floats) -> Floats:
    """(M, K) deviation of noise by a quantile of scaled differences (N, M, K); infinite where too few tell."""
    enough = np.isfinite(differences).sum(axis=0) >= FEWEST
    found = np.full(enough.shape, np.inf)
    found[enough] = quantile_of_known(differences[:, enough], QUANTILE) / ndtri(0.5 + 0.5 * QUANTILE)
    return found
