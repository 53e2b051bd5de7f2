"""Where the library misses a recording: what the recording shows of itself counts too (section 2.4)."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...arrays import Bools, Floats
from ...bodies.motion import Origin
from ...numerics.risk import share_of_second
from ..bases.repair import MUCH_MISSED
from ..bases.support import RARE, interpolated
from ..noise.own_bends import own_bends
from .blocks import Mended
from .smoothing import least_bend

SAID = "; what it shows of itself was believed beside it"
WRONG = 1.5  # times its stated variance: a repair that errs by more is more wrong than it says
CALMER = 0.25  # of the clips' variance of second differences, geometric mean: a recording that moves less holds a pose
TINY = 1e-9  # degrees or cm
REACH = 0.1  # s about a sample that one repair believes and the other does not, within which both bear its mark


def doubtful(library: Mended) -> bool:
    """True if the library may not know this motion or person."""
    return library.missed > MUCH_MISSED


def calmer(first: Mended, usual: Floats, fps: float) -> bool:
    """True if a recording moves so much less than clips do that it holds a pose, which they know little about.

    Parameters
    ----------
    first : its repair by the library.
    usual : (C, C) covariance of the clips' second differences at `fps`.
    fps : Hz.
    """
    bends, usual = np.diag(own_bends(first.found.values, first.unseen_bends)), np.diag(usual)
    asked = np.isfinite(bends) & (usual > least_bend(fps))
    ratio = np.maximum(bends[asked], least_bend(fps)) / usual[asked]
    return bool(asked.any()) and float(np.log(ratio).mean()) < np.log(CALMER)


def of_one_mind(library: Mended, own: Mended) -> Mended:
    """Two repairs of one recording as one: each channel's mean of both, as sure as each is of it.

    Two repairs that take different samples for outliers err in different places. A mean is seldom much worse
    than the better of them and often better than both. But outliers that are rare come one by one: where the library
    alone rejects several on end it is the library that strays, and what was measured stays.

    Parameters
    ----------
    library : the repair by a library that misses the recording. Its arrays are written anew with the result, so that
        no more of a long recording is held.
    own : by what the recording shows of itself. Both without a sample left open.

    Returns
    -------
    In gaps both are shifted to where they meet at the edges, and the surer counts for more: of a motion that the
    library does not know, what comes before and after may tell more. What is never seen is the library's.
    """
    first, second = library.found, own.found
    rejected = int((second.origin == Origin.REPAIRED).sum())
    rate = rejected / max(rejected + int((second.origin == Origin.MEASURED).sum()), 1)
    common = rate / (rate + RARE)
    for c in range(first.values.shape[1]):
        seen = (first.origin[:, c] == Origin.MEASURED) | (first.origin[:, c] == Origin.REPAIRED)
        apart = second.values[:, c] - first.values[:, c]
        one, other = (np.square(found.std[:, c].astype(np.float64)) for found in (first, second))
        told = float(share_of_second(*(each[seen, None].sum(axis=0) for each in (one, other, np.square(apart))))[0])
        strays = _on_end((first.origin[:, c] == Origin.REPAIRED) & (second.origin[:, c] == Origin.MEASURED))
        share = np.where(strays, 1.0 - common * (1.0 - told), told)
        shift, meets = interpolated(np.where(seen, [share * apart, apart], np.nan).T).T
        surer = first.std[:, c] / np.maximum(first.std[:, c] + second.std[:, c], TINY)
        inside = np.where(seen | ~seen.any(), 0.0, surer)
        first.values[:, c] += shift + inside * (apart - meets)
        share, apart = np.where(seen, share, inside), np.where(seen, apart, apart - meets)
        both = (1.0 - share) * one + share * other + share * (1.0 - share) * np.square(apart)
        first.std[:, c] = np.sqrt(both + np.where(seen, 0.0, np.square(shift)))
        first.weights[seen, c] = np.minimum(first.weights[seen, c], second.weights[seen, c])  # believed by both
        first.origin[seen, c] = second.origin[seen, c]
    return _said_as_one(library, own)


def of_one_cloud(library: Mended, own: Mended, measured: Floats, fps: float) -> Mended:
    """Two repairs of markers as one: each marker's mean of both, as sure as each is and as wrong as each shows to be.

    Where one believes a sample that the other rejects, one of them is right. A sample that is believed alone is an
    outlier, as a rule; only where the library rejects several on end it is the library that strays.

    Parameters
    ----------
    library : the repair by a library that misses the recording. Its arrays are written anew with the result.
    own : by what the recording shows of itself.
    measured : (T, C) what both were made of, cm, NaN = missing; three columns a marker.
    fps : Hz.

    Returns
    -------
    What is missing stays the library's: it is filled from the markers about it afterwards.
    """
    first, second = library.found, own.found
    noise = np.minimum(library.noise, own.noise)
    reach = 2 * round(REACH * fps) + 1
    for column in range(0, measured.shape[1], 3):
        c = slice(column, column + 3)
        seen = np.isfinite(measured[:, c]).all(axis=1)
        if not seen.any():
            continue
        believed = (first.origin[:, column] == Origin.MEASURED, second.origin[:, column] == Origin.MEASURED)
        apart = second.values[seen, c] - first.values[seen, c]
        one, other = (np.square(found.std[seen, c].astype(np.float64)) for found in (first, second))
        both = (believed[0] & believed[1])[seen]
        share = np.full((int(seen.sum()), 3), 0.5)
        if both.any():
            told, its = (
                _errs((measured[seen, c] - found.values[seen, c])[both], variance[both], noise[c])
                for found, variance in ((first, one), (second, other))
            )
            share[:] = share_of_second(told, its, np.square(apart[both]).mean(axis=0))
        for wins, runs in enumerate(_at_odds(believed[0][seen], believed[1][seen])):
            at = np.zeros(len(measured), dtype=bool)
            at[np.flatnonzero(seen)[runs]] = True
            share[maximum_filter1d(at, reach)[seen]] = wins
        first.values[seen, c] += share * apart
        mixed = (1.0 - share) * one + share * other + share * (1.0 - share) * np.square(apart)
        first.std[seen, c] = np.sqrt(mixed)
        owns = np.flatnonzero(seen)[share.mean(axis=1) > 0.5]
        first.origin[owns, c] = second.origin[owns, c]
        first.weights[owns, c] = second.weights[owns, c]
    return _said_as_one(library, own)


def _said_as_one(library: Mended, own: Mended) -> Mended:
    """What is said of a repair whose arrays are those of both in one."""
    found = replace(
        library.found,
        iterations=library.found.iterations + own.found.iterations,
        warnings=tuple(said + SAID for said in library.found.warnings),
    )
    noise = 0.5 * (library.noise + own.noise)
    return replace(library, found=found, noise=noise, leaps=own.leaps, farthest=own.farthest)


def _errs(left: Floats, variance: Floats, noise: Floats) -> Floats:
    """(3,) mean square error of a marker's repair: as stated, and what it shows to be wrong beyond that.

    Parameters
    ----------
    left : (N, 3) recorded less repaired.
    variance : (N, 3) as stated.
    noise : (3,) standard deviations.

    Source
    ------
    Stein's estimate, as in `numerics.risk`; here of samples that no one takes for outliers, so that their mean serves.
    """
    own = np.minimum(variance / np.square(noise), 1.0)  # by how much a repaired sample follows its own
    stated = variance.mean(axis=0)
    risk = (np.square(left) - (1.0 - 2.0 * own) * np.square(noise)).mean(axis=0)
    return np.asarray(stated + max(float((risk - WRONG * stated).mean()), 0.0))


def _on_end(samples: Bools) -> Bools:
    """(T,) True for those of the samples that have another of them beside them."""
    padded = np.pad(samples, 1)
    return np.asarray(samples & (padded[:-2] | padded[2:]))


def _at_odds(library: Bools, own: Bools) -> tuple[Bools, Bools]:
    """Samples (N,) that one believes and the other rejects: where the library is right, and where the own repair is."""
    alone = np.pad(own & ~library, 1)
    lone = alone[1:-1] & ~alone[:-2] & ~alone[2:]
    return lone, (own != library) & ~lone
