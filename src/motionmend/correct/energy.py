"""The energy of section 4.5: what the offsets, the past and the reliable joints say, weighed against each other.

The spatial term is a log-probability (eq. 7): what the mixture is less sure of weighs less. The paper gives no units,
so that v is the variance by the usual one, and the weights mean what they say for a joint that is known as usual.
Eq. 22 is quadratic in the offset Y, and each joint's coordinates stand alone in it, so its minimum is one division:

    (w_S / v + w_T + w_R r^2) Y = w_S mu / v + w_T (2 M_1 - M_2 - X)

That takes the last two postures for true. Theirs are energies too: summed over a recording they are least where a
banded system says so, and no posture is then thrown on by the errors of the two before it.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solveh_banded

from ..arrays import Bools, Floats
from .normalise import Placement


class Weights(NamedTuple):
    """Of the spatial, the temporal and the reliability term (section 4.5)."""

    spatial: float = 0.6
    temporal: float = 0.2
    reliability: float = 0.2


def adapted(doubt: Floats, weights: Weights) -> tuple[Floats, Floats, Floats]:
    """Weights of each joint, as section 6 asks for them.

    The sensor's own position counts as far as the mixture does not know the offset: where the offset is known, what is
    reliable is as biased as ever.

    Parameters
    ----------
    doubt : (..., J) variance of the offset by the usual one.
    weights : at their most.

    Returns
    -------
    Of the spatial, the temporal and the reliability term, (..., J) each.
    """
    return (
        np.full(doubt.shape, weights.spatial),
        np.full(doubt.shape, weights.temporal),
        weights.reliability * doubt / (1.0 + doubt),
    )


class Terms(NamedTuple):
    """What the energy of one frame is made of, or of T frames with a T before every shape.

    observed (J, 3) is the sensor's posture, offset (J, 3) what the spatial term says, steady (J, 3) where the posture
    would be if it went on as it did (2 M_1 - M_2), reliability (J,) in [0, 1], doubt (J,) the variance of the offset by
    the usual one (eq. 7, 9).
    """

    observed: Floats
    offset: Floats
    steady: Floats | None
    reliability: Floats
    doubt: Floats


def energy(offset: Floats, terms: Terms, weights: Weights) -> float:
    """The value of eq. 22 at an offset (J, 3)."""
    value = weights.spatial * float(((offset - terms.offset) ** 2 / terms.doubt[:, None]).sum())
    value += weights.reliability * float((terms.reliability[:, None] ** 2 * offset**2).sum())
    if terms.steady is not None:
        value += weights.temporal * float(((offset + terms.observed - terms.steady) ** 2).sum())
    return value


def solved(terms: Terms, weights: Weights | tuple[Floats, Floats, Floats]) -> Floats:
    """(J, 3) the offset at which the energy is least.

    Parameters
    ----------
    terms : of the frame.
    weights : the same for all joints, or three arrays (J,).
    """
    spatial, temporal, reliability = (np.broadcast_to(w, terms.reliability.shape)[:, None] for w in weights)
    spatial = spatial / terms.doubt[:, None]
    matrix = spatial + reliability * terms.reliability[:, None] ** 2
    right = spatial * terms.offset
    if terms.steady is not None:
        matrix = matrix + temporal
        right = right + temporal * (terms.steady - terms.observed)
    return np.asarray(right / matrix)


def solved_together(
    terms: Terms, weights: Weights | tuple[Floats, Floats, Floats], tied: Bools, placed: Placement
) -> Floats:
    """(T, J, 3) the offsets, standard metres, at which eq. 22 summed over all frames of a recording is least.

    Parameters
    ----------
    terms : of T frames; their `steady` is not used.
    weights : the same for all joints and frames, or three arrays (T, J).
    tied : (T,) frames whose two predecessors say how they would go on.
    placed : of the frames, all of one scale: people go on as they went in the room, not in standard form.
    """
    spatial, temporal, reliability = (np.broadcast_to(w, terms.reliability.shape) for w in weights)
    spatial = spatial / terms.doubt
    alone = spatial + reliability * terms.reliability**2
    seen = placed.outward(terms.observed)
    right = alone[..., None] * seen + spatial[..., None] * (placed.outward(terms.observed + terms.offset) - seen)
    temporal = np.where(tied[:, None], temporal, 0.0)[2:]
    bands = np.zeros((3, *alone.shape))  # of the lower triangle: (1, -2, 1) of eq. 20 with itself
    bands[0] = alone
    for first, share in enumerate((1.0, 4.0, 1.0)):
        bands[0, first : first + len(temporal)] += share * temporal
    bands[1, : len(temporal)] -= 2.0 * temporal
    bands[1, 1 : 1 + len(temporal)] -= 2.0 * temporal
    bands[2, : len(temporal)] = temporal
    postures = np.empty(right.shape)
    for j in range(right.shape[1]):
        postures[:, j] = solveh_banded(bands[..., j], right[:, j], lower=True, check_finite=False)
    return placed.inward(postures) - terms.observed


def sampled(
    terms: Terms, weights: Weights, start: Floats, rng: np.random.Generator, samples: int = 24, rounds: int = 40
) -> Floats:
    """(J, 3) the paper's descent: postures about the best one so far are tried, the best one leads the next round.

    Parameters
    ----------
    terms, weights : of the energy.
    start : (J, 3) the offset that leads from the sensor's posture to the last result.
    rng : of the postures tried.
    samples : tried in a round.
    rounds : at most.

    Notes
    -----
    The reach of a round doubles when it finds a better posture and halves when not; it starts at the distance to the
    spatial term's offset. Every other sample goes along the gradient.
    """
    best = np.array(start)
    least = energy(best, terms, weights)
    reach = max(float(np.sqrt(((terms.offset - start) ** 2).mean())), 1e-4)
    for _ in range(rounds):
        slope = _gradient(best, terms, weights)
        norm = float(np.sqrt((slope**2).mean()))
        steps = reach * rng.standard_normal((samples, *best.shape)) * rng.uniform(0.1, 1.0, (samples, 1, 1))
        if norm > 0:
            steps[::2] -= slope / norm * reach * rng.uniform(0.0, 4.0, (len(steps[::2]), 1, 1))
            steps[0] = -slope / norm * reach
        values = [energy(best + step, terms, weights) for step in steps]
        k = int(np.argmin(values))
        if values[k] < least:
            best, least, reach = best + steps[k], values[k], 1.5 * reach
        else:
            reach *= 0.5
        if reach < 1e-5:
            break
    return best


def _gradient(offset: Floats, terms: Terms, weights: Weights) -> Floats:
    slope = weights.spatial / terms.doubt[:, None] * (offset - terms.offset)
    slope = slope + weights.reliability * terms.reliability[:, None] ** 2 * offset
    if terms.steady is not None:
        slope = slope + weights.temporal * (offset + terms.observed - terms.steady)
    return np.asarray(2.0 * slope)
