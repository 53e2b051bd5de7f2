"""A whole recording seen once more from its end: which joints failed, and where they were, knowing what came later."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Floats
from ..kernels.following import MET_SECONDS, UNMET
from ..numerics import factors as process
from ..numerics.factors import Belief, Factors
from .reliability import chain_backward
from .sight import Sight
from .watching import PATIENCE

STRETCH = 1024  # frames of which all that is known of the factors is kept at a time: 18 kB each, 2 GB in an hour


def judged_again(sights: Sequence[Sight]) -> Floats:
    """(T, J) the probability that each joint fails, by what came before and after."""
    forecasts = np.stack([one.followed.forecast for one in sights])
    filtered = np.stack([one.followed.failing for one in sights])
    return chain_backward(forecasts, filtered, gaps_between(sights))


def gaps_between(sights: Sequence[Sight]) -> Floats:
    """(T,) s since the frame before, 0 for the first; a clock that goes back stands still. Infinite where nothing of
    what was before is known of: after a long break, or of somebody else."""
    times = np.array([one.time for one in sights], dtype=np.float64)
    gaps = np.maximum(np.diff(times, prepend=times[0]), 0.0)
    return np.where((gaps > PATIENCE) | np.array([one.other for one in sights]), np.inf, gaps)


def placed_again(factors: Factors, sights: Sequence[Sight], failing: Floats) -> tuple[Floats, Floats]:
    """Postures (T, J, 3) in standard form with failing joints where both past and future expect them, and the standard
    deviation (T, J) of a coordinate.

    Frames without a failing joint stay as the sensor gave them.

    Parameters
    ----------
    failing : (T, J) of `judged_again`.
    """
    trust = trusted(sights, failing)
    own = _own_shapes(sights, trust)
    noise = factors.noise + UNMET**2 * np.exp(-met_in_all(trust, gaps_between(sights)) / MET_SECONDS)
    values = less_own(factors, sights, own)
    gaps = gaps_between(sights)
    begun: list[Belief | None] = [None]  # before each stretch
    beliefs: list[Belief] = []
    for first in range(0, len(sights), STRETCH):
        frames = slice(first, first + STRETCH)
        beliefs = _followed(factors, begun[-1], values[frames], trust[frames], gaps[frames])
        begun.append(beliefs[-1])
    posture, std = np.empty(values.shape), np.zeros(trust.shape)
    later = beliefs[-1]
    for t in range(len(sights) - 1, -1, -1):
        stretch, frame = divmod(t, STRETCH)
        if frame == STRETCH - 1 and t < len(sights) - 1:
            frames = slice(stretch * STRETCH, t + 1)
            beliefs = _followed(factors, begun[stretch], values[frames], trust[frames], gaps[frames])
        if t < len(sights) - 1 and gaps[t + 1] <= PATIENCE:
            later = process.backward(factors, later, beliefs[frame], float(gaps[t + 1]))
        else:
            later = beliefs[frame]
        there, cov = process.expected(factors, later)
        share = trust[t][:, None]
        posture[t] = share * values[t] + (1.0 - share) * there
        std[t] = (1.0 - trust[t]) * np.sqrt(np.trace(cov, axis1=1, axis2=2) / 3.0 + noise)
    return posture + factors.mean + own, std


def _followed(factors: Factors, before: Belief | None, values: Floats, trust: Floats, gaps: Floats) -> list[Belief]:
    """What is known of the factors after each of T frames, by those up to it.

    Parameters
    ----------
    before : after the frame before; None = there is none.
    values, trust, gaps : (T, J, 3), (T, J), (T,) of `less_own`, `trusted` and `gaps_between`.
    """
    found: list[Belief] = []
    for value, sure, gap in zip(values, trust, gaps, strict=True):
        if before is None or gap > PATIENCE:
            forecast = process.start(factors)
        else:
            forecast = process.ahead(factors, before, float(gap))
        before = process.seen(factors, forecast, value, np.where(sure > 0.02, sure, 0.0) / factors.noise)
        found.append(before)
    return found


def met_in_all(trust: Floats, gaps: Floats) -> Floats:
    """(J,) s for which joints are seen going well in all of a recording, by trust (T, J) and the gaps (T,) between
    its frames in s."""
    passed = np.where(np.isfinite(gaps), gaps, 0.0)
    return np.asarray((trust * passed[:, None]).sum(axis=0))


def trusted(sights: Sequence[Sight], failing: Floats) -> Floats:
    """(T, J) how far the sensor's joints are believed: 1 less the chance (T, J) to fail, 0 where there are none."""
    present = np.stack([np.asarray(np.isfinite(one.rows).all(axis=1)) for one in sights])
    return np.where(present, 1.0 - failing, 0.0)


def less_own(factors: Factors, sights: Sequence[Sight], own: Floats) -> Floats:
    """(T, J, 3) what the sensor gave, in standard form, less the factors' mean and what is the person's own (T, J, 3);
    0 where it gave nothing."""
    given = np.stack([one.placement.inward(one.rows[None])[0] for one in sights])
    return np.where(np.isfinite(given).all(axis=2)[..., None], given - factors.mean - own, 0.0)


def _own_shapes(sights: Sequence[Sight], trust: Floats) -> Floats:
    """(T, J, 3) what is this person's own in the shape: as learned from the nearest frames in which it was seen."""
    own = np.stack([one.followed.own for one in sights])
    total = np.maximum(trust.sum(axis=0), 1e-9)[:, None]
    usual = (own * trust[..., None]).sum(axis=0) / total
    after = np.cumsum(trust, axis=0) > 10.0  # the first frames' own shape is not known yet: hindsight knows the rest's
    return np.where(after[..., None], own, usual)
