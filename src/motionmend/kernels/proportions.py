"""How long a person's bones are by what a sensor shows of them, and whether it is the sensor that was learned from."""

from math import exp, isfinite, log, sqrt
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from . import rising
from .compile import compiled

PRIOR_FRAMES = 5.0  # frames' worth of trust in the standard body's proportions
ENOUGH = 30.0  # frames beyond which a bone's length counts no more for the size
LONGEST = 300.0  # frames after which older lengths fade
LONE = 1.5  # deviations from the mean so far, beyond which a length counts the less the farther off it is
MIDDLE = 0.6745  # median of the absolute value of a normal variable
RESTLESS_SECONDS = 1.5  # in which what lengths vary by is believed to have grown, or fallen, by a factor of e
CALMEST = 0.2  # of what is usual, and no less
PEOPLE, SENSORS = 0.015, 0.045  # standard m, by how much bones of other people, and of other sensors, mostly differ
ODD = 0.05  # standard m; a bone is off by no more than this and its twin, or it is of a limb that fails
OFTEN = 0.6  # as often as the bone that is trusted most often; one that varies more is trusted less, and tells as much
TRUSTED = 3.0  # log-odds that a recording is of the sensor that was learned from, before it is looked at

_insert, _middle = rising.insert, rising.middle


@compiled
def usual_lengths(sums: Floats, standard_lengths: Floats, usual: Floats) -> float:
    """The person's bones (B,) m into `usual` as far as they are known, and the size by that of the standard body.

    Parameters
    ----------
    sums : (2, B) of trusted lengths in m, and how many.
    standard_lengths : (B,) m.

    Returns
    -------
    0 when no bone is known; `usual` is not touched then.
    """
    mine, other = 0.0, 0.0
    for b in range(len(usual)):
        if sums[1, b] > 0.0:
            share = min(sums[1, b], ENOUGH)
            mine += share * sums[0, b] / sums[1, b]
            other += share * standard_lengths[b]
    if other == 0.0:
        return 0.0
    size = mine / other if isfinite(mine) and mine > 0.0 else 1.0
    for b in range(len(usual)):
        usual[b] = (sums[0, b] + PRIOR_FRAMES * size * standard_lengths[b]) / (sums[1, b] + PRIOR_FRAMES)
    return size


@compiled
def kinship(sums: Floats, standard_lengths: Floats, twins: Ints, parts: Ints) -> float:
    """The probability that a person is seen by the sensor that the standard body was learned from.

    Where a sensor has its joints shows in its bones: people's proportions differ less than sensors' habits do. Either
    difference follows Laplace's distribution. A sensor's habits are those of both sides: of two bones the one counts
    that is off by less, for the other may be of a limb that failed, and the limbs that speak most against it are not
    heard, for both may fail: legs of who sits.

    Parameters
    ----------
    sums : (2, B) of trusted lengths in m, and how many.
    standard_lengths : (B,) m.
    twins : (B,) the bone on the other side, its own number in the middle.
    parts : (B,) of the body, 0 the trunk, the same on both sides.
    """
    usual = np.empty(len(standard_lengths))
    size = usual_lengths(sums, standard_lengths, usual)
    if size == 0.0:
        return 1.0 / (1.0 + exp(-TRUSTED))
    for b in range(len(usual)):
        known = sums[1, b] > 0.0
        usual[b] = abs(sums[0, b] / sums[1, b] / size - standard_lengths[b]) if known else np.inf
    says, most = np.zeros(len(usual) + 1), sums[1].max()
    for b in range(len(usual)):
        off = min(usual[b], usual[twins[b]])
        if twins[b] >= b and off < np.inf:
            seen = min(max(sums[1, b], sums[1, twins[b]]) / (OFTEN * most), 1.0)
            says[parts[b]] += seen * (log(SENSORS / PEOPLE) - off * (1.0 / PEOPLE - 1.0 / SENSORS))
    odds = TRUSTED + says.sum() - min(says[1:].min(), 0.0)
    return 1.0 / (1.0 + exp(-max(min(odds, 30.0), -30.0)))


@compiled
def met(rows: Floats, bones: Ints, standard_lengths: Floats, usual: Floats) -> float:
    """As `usual_lengths` of a person just met: by the median of the bones (B, 2) of one frame's joints (J, 3) m."""
    ratios, known = np.empty(len(usual)), 0
    for b in range(len(usual)):
        one = length(rows, bones[b, 0], bones[b, 1])
        if one > 0.0 and standard_lengths[b] > 0.0:  # not NaN either
            _insert(ratios, known, one / standard_lengths[b])
            known += 1
    size = _middle(ratios, known) if known > 0 else 1.0
    for b in range(len(usual)):
        usual[b] = size * standard_lengths[b]
    return size


@compiled
def likely(usual: Floats, size: float, standard_lengths: Floats, twins: Ints) -> Floats:
    """Usual bones (B,) m, none farther from the standard body's of that size (B,) than people and sensors go.

    A limb that fails from the beginning would make its own lengths usual. What is a person's or a sensor's own is of
    both sides: a bone may be off by as much as its twin (B,), and by `ODD` more.
    """
    found = np.empty(len(usual))
    for b in range(len(usual)):
        ours, other = usual[b] - size * standard_lengths[b], usual[twins[b]] - size * standard_lengths[twins[b]]
        most = ODD * size + abs(other) if twins[b] != b else np.inf
        found[b] = size * standard_lengths[b] + min(max(ours, -most), most)
    return found


@compiled
def length(rows: Floats, one: int, other: int) -> float:
    """The distance in m between two of some joints (J, 3), NaN where one is missing."""
    square = 0.0
    for d in range(3):
        square += (rows[other, d] - rows[one, d]) ** 2
    return sqrt(square)


@compiled
def counted(
    sums: Floats, spread: Floats, lengths: Floats, failing: Floats, bones: Ints, usual: Floats, seconds: float
) -> Any:
    """Trusted lengths, this frame's included, and by how much lengths vary.

    A limb that is drawn in slowly would take its usual lengths along: what is far from the mean so far counts less.

    Parameters
    ----------
    sums : (2, B) of trusted lengths in m, and how many; of many, old ones fade.
    spread : (B,) deviation of the logarithm of lengths, trusted or not: its median follows step by step.
    lengths : (B,) m of this frame, NaN = missing.
    failing : (J,) probability that joints fail.
    bones : (B, 2).
    usual : (B,) deviation that is usual.
    seconds : since the frame before.

    Returns
    -------
    sums (2, B) and spread (B,) after this frame.
    """
    after, wide = np.empty(sums.shape), spread.copy()
    grown = exp(max(seconds, 0.0) / RESTLESS_SECONDS)
    for b in range(bones.shape[0]):
        share = (1.0 - failing[bones[b, 0]]) * (1.0 - failing[bones[b, 1]])
        share = share if isfinite(lengths[b]) and share > 0.5 else 0.0
        if isfinite(lengths[b]) and sums[1, b] > 0.0:
            off = abs(log(max(lengths[b], 1e-6) * sums[1, b] / max(sums[0, b], 1e-6)))
            wide[b] = spread[b] * grown if off > MIDDLE * spread[b] else max(spread[b] / grown, CALMEST * usual[b])
            share *= min(1.0, LONE * max(spread[b], usual[b]) / max(off, 1e-9))
        fade = LONGEST / sums[1, b] if sums[1, b] > LONGEST else 1.0
        after[0, b] = sums[0, b] * fade + (share * lengths[b] if share > 0.0 else 0.0)
        after[1, b] = sums[1, b] * fade + share
    return after, wide


@compiled
def unsteadiness(spread: Floats, usual: Floats, most: float) -> Floats:
    """(B,) usual deviations of bones' lengths, wider by the variance of the median bone beyond `most` times the usual.

    Parameters
    ----------
    spread, usual : (B,) deviations, here and usually.
    """
    times = np.empty(len(usual))
    for b in range(len(usual)):
        _insert(times, b, spread[b] / usual[b])
    wider = sqrt(max(1.0, _middle(times, len(usual)) ** 2 - most**2)) if len(usual) > 0 else 1.0
    return usual * wider
