"""Where the library misses a recording: what the recording shows of itself counts as much (section 2.4)."""

from dataclasses import replace

import numpy as np

from ..bodies.motion import Origin
from .mending import Mended
from .repair import MUCH_MISSED
from .support import bridged

SAID = "; what it shows of itself was believed as much"


def doubtful(library: Mended) -> bool:
    """True if the library may not know this motion or person."""
    return library.missed > MUCH_MISSED


def of_one_mind(library: Mended, own: Mended) -> Mended:
    """Two repairs of one recording as one: the mean of what they say, as unsure as they are at odds.

    Two repairs that take different samples for outliers err in different places. Half of each is seldom much worse
    than the better of them and often better than both.

    Parameters
    ----------
    library : the repair by a library that misses the recording.
    own : by bases and bends of that repair itself. Both without a sample left open.

    Returns
    -------
    In gaps the library's values, shifted by what the other says at their edges.
    """
    first, second = library.found, own.found
    seen = (first.origin == Origin.MEASURED) | (first.origin == Origin.REPAIRED)
    half = bridged(np.where(seen, 0.5 * (second.values - first.values), np.nan))
    variance = 0.5 * (np.square(first.std) + np.square(second.std))
    variance = np.where(seen, variance, np.square(first.std)) + np.square(half)
    return replace(
        library,
        found=replace(
            first,
            values=first.values + half,
            std=np.sqrt(variance),
            weights=np.where(seen, np.minimum(first.weights, second.weights), first.weights),  # believed by both
            origin=np.where(seen, second.origin, first.origin).astype(np.uint8),
            iterations=first.iterations + second.iterations,
            warnings=tuple(said + SAID for said in first.warnings),
        ),
        noise=0.5 * (library.noise + own.noise),
    )
