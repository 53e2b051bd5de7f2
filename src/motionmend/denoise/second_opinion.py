"""Where the library misses a recording: what the recording shows of itself counts too (section 2.4)."""

from dataclasses import replace

import numpy as np

from ..bodies.motion import Origin
from ..numerics.risk import share_of_second
from .mending import Mended
from .repair import MUCH_MISSED
from .support import bridged

SAID = "; what it shows of itself was believed beside it"


def doubtful(library: Mended) -> bool:
    """True if the library may not know this motion or person."""
    return library.missed > MUCH_MISSED


def of_one_mind(library: Mended, own: Mended) -> Mended:
    """Two repairs of one recording as one: each channel's mean of both, as sure as each is of it.

    Two repairs that take different samples for outliers err in different places. A mean is seldom much worse
    than the better of them and often better than both.

    Parameters
    ----------
    library : the repair by a library that misses the recording. Its arrays are written anew with the result, so that
        no more of a long recording is held.
    own : by what the recording shows of itself. Both without a sample left open.

    Returns
    -------
    In gaps the library's values, shifted by what the other says at their edges.
    """
    first, second = library.found, own.found
    for c in range(first.values.shape[1]):
        seen = (first.origin[:, c] == Origin.MEASURED) | (first.origin[:, c] == Origin.REPAIRED)
        apart = second.values[:, c] - first.values[:, c]
        one, other = (np.square(found.std[:, c].astype(np.float64)) for found in (first, second))
        share = float(share_of_second(*(each[seen, None].sum(axis=0) for each in (one, other, np.square(apart))))[0])
        shift = bridged(np.where(seen, share * apart, np.nan)[:, None])[:, 0]
        first.values[:, c] += shift
        both = (1.0 - share) * one + share * other + share * (1.0 - share) * np.square(apart)
        first.std[:, c] = np.sqrt(np.where(seen, both, one + np.square(shift)))
        first.weights[seen, c] = np.minimum(first.weights[seen, c], second.weights[seen, c])  # believed by both
        first.origin[seen, c] = second.origin[seen, c]
    return replace(
        library,
        found=replace(
            first,
            iterations=first.iterations + second.iterations,
            warnings=tuple(said + SAID for said in first.warnings),
        ),
        noise=0.5 * (library.noise + own.noise),
    )
