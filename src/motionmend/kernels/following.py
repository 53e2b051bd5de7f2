"""A posture followed through failures for one frame: what each joint's failing is to be believed, and what follows."""

from math import exp, log, log1p, sqrt
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled
from .factors import expected, left_out, seen

HOLD_SECONDS = 2.0  # in which a person's own shape is learned while it is seen: sooner, what drifts off would be it
DOUBT_SECONDS = 1.5  # the same for a joint out of place of which nothing else is wrong: it may be this sensor's way
STRANGER = 0.05  # standard metres, of a joint's place in people and sensors not met yet, beside the factors' noise
UNMET = 0.12  # the same of a joint that was never seen going well: it may be in a posture that nobody showed
MET_SECONDS = 0.5  # how long a joint is a stranger
SETTLED = 0.02  # change of the probability to fail below which nothing is weighed again
ROUNDS = 2  # of weighing the joints by what the others say
LEAPT, LEAPT_SECONDS = 6.0, 3.0  # evidence that a joint that leapt away from where it went well fails, and how it fades
FORGIVEN = 3.0  # of those times after which a leap hardly counts: as one does that seems to lead back
RETURNED = 2.0  # standard deviations from where it is expected: a joint that leapt is back
# A joint that was well for a while, did not leap, and of which nothing but its place is wrong, so surely, went there;
# more strangeness than that, as a feature, says no more.
KNOWN_SECONDS, CALM, CAP = 1.0, 0.8, 1.8
COUPLED = 0.5  # probability that a joint fails from which a bone that is nobody's leads to one that does
SURELY, HELD_SECONDS = 4.6, 5.0  # log-odds that one that failed does as long as both do, and in which they are gone
MOST = 8.0  # logarithm of the likelihood ratio that one frame can give


class Signs(NamedTuple):
    """What a frame shows of J joints and B bones beside where the joints are.

    Attributes
    ----------
    raw : (J,) size of the joint's second difference by the usual one; 0 where not known.
    bone, best_bone : (J,) how far the bone to the parent is off, and the bone at the joint that is least so.
    told : (J, 3) one where the sensor says inferred, not tracked, tracked.
    repeated : (J,) where it says what it said before: it does not see the joint.
    gone, back : (J,) where the joint leapt as none can, away from where it was well, and back there.
    bones, nobodys : (B, 2) parent and child, and (B,) how far the bone has a length that is nobody's, 0 to 1.
    """

    raw: Floats
    bone: Floats
    best_bone: Floats
    told: Floats
    repeated: Bools
    gone: Bools
    back: Bools
    bones: Ints
    nobodys: Floats


@compiled
def follow(
    mean: Floats,
    loadings: Floats,
    noise: Floats,
    weights: Floats,
    lasting: Floats,
    own: Floats,
    failed: Floats,
    jerky: Floats,
    met: Floats,
    belief_mean: Floats,
    belief_cov: Floats,
    place: Floats,
    place_cov: Floats,
    standard: Floats,
    seconds: float,
    signs: Signs,
    leapt: Floats,
) -> Any:
    """One frame of `correct.follow.follow`: failing (section 4.4) as a hidden Markov chain, the factors by Kalman.

    Parameters
    ----------
    mean, loadings, noise : (J, 3), (J, 3, K), (J,) of the factors.
    weights : (F + 1,) of the evidence, in the order of the features, the last a constant.
    lasting : (2,) s, how long joints go well and how long they fail.
    own, failed, jerky, met : (J, 3), (J,), (J,), (J,) of the frame before: the person's own shape, the probability to
        fail, the running second difference, s seen well.
    belief_mean, belief_cov : (2K,), (2K, 2K) the forecast of the factors.
    place, place_cov : (J, 3), (J, 3, 3) where it expects the joints.
    standard : (J, 3) what the sensor says, NaN = missing.
    seconds : since the frame before.
    signs : of this frame.
    leapt : (J,) s since the joint left as none can where it went well, infinite = never, or it is back.

    Returns
    -------
    mean (2K,), covariance (2K, 2K), own (J, 3), failing (J,), its forecast (J,), jerk (J,), posture (J, 3), std (J,),
    met (J,), leapt (J,).
    """
    raw, bone, best_bone, told, repeated, gone, back, bones, nobodys = signs
    joints = mean.shape[0]
    present = np.empty(joints, dtype=np.bool_)
    values, rest = np.empty((joints, 3)), np.empty((joints, 3))
    own_variance, nothing, trust, precision = np.empty(joints), np.zeros(joints), np.empty(joints), np.empty(joints)
    jerk, features = np.empty(joints), np.empty((joints, 8))
    fade, stranger = exp(-seconds / 0.1), STRANGER**2
    for j in range(joints):
        present[j] = np.isfinite(standard[j, 0]) and np.isfinite(standard[j, 1]) and np.isfinite(standard[j, 2])
        for d in range(3):
            values[j, d] = (standard[j, d] - mean[j, d] if present[j] else 0.0) - own[j, d]
            rest[j, d] = values[j, d] - place[j, d]
        jerk[j] = raw[j] + (jerky[j] - raw[j]) * fade
        own_variance[j] = noise[j] + stranger * exp(-met[j] / MET_SECONDS)
    away, _ = left_out(rest, place_cov, own_variance, nothing)
    since, left = np.empty(joints), np.zeros(joints)
    for j in range(joints):
        since[j] = leapt[j] + seconds
        if back[j]:
            since[j] = FORGIVEN * LEAPT_SECONDS
        elif gone[j] and failed[j] < 0.5:
            since[j] = 0.0
        left[j] = LEAPT * exp(-since[j] / LEAPT_SECONDS)
        features[j, 0] = features[j, 1] = log1p(away[j])
        features[j, 2], features[j, 3] = bone[j], best_bone[j]
        features[j, 4] = log1p(max(raw[j], jerk[j]))
        for d in range(3):
            features[j, 5 + d] = told[j, d]
    into, out = 1.0 - exp(-seconds / lasting[0]), 1.0 - exp(-seconds / lasting[1])
    forecast, failing = np.empty(joints), np.empty(joints)
    for j in range(joints):
        forecast[j] = min(max(failed[j] * (1.0 - out) + (1.0 - failed[j]) * into, 1e-6), 1.0 - 1e-6)
    beyond, doubted = np.zeros(joints), SURELY * seconds / HELD_SECONDS
    _judge(features, weights, forecast, repeated, left, met, beyond, failed, doubted, failing)
    after_mean, after_cov, there, there_cov = belief_mean, belief_cov, place, place_cov
    for _ in range(ROUNDS):
        for j in range(joints):
            trust[j] = 1.0 - failing[j] if present[j] else 0.0
            precision[j] = trust[j] / own_variance[j] if trust[j] > 0.02 else 0.0
        after_mean, after_cov = seen(loadings, belief_mean, belief_cov, values, precision)
        there, there_cov = expected(loadings, after_mean, after_cov)
        for j in range(joints):
            for d in range(3):
                rest[j, d] = values[j, d] - there[j, d]
        away, _ = left_out(rest, there_cov, own_variance, precision)
        for j in range(joints):
            features[j, 0] = log1p(away[j])
            if away[j] < RETURNED:
                since[j], left[j] = np.inf, 0.0
        _failing_beyond(bones, nobodys, failing, beyond)
        if _judge(features, weights, forecast, repeated, left, met, beyond, failed, doubted, failing) < SETTLED:
            break
    posture, std, ours, known = np.empty((joints, 3)), np.empty(joints), np.empty((joints, 3)), np.empty(joints)
    passed = seconds if seconds > 0.0 else 1.0 / 30.0  # the first frame is one of a sensor at 30 Hz
    hold, doubt = 1.0 - exp(-passed / HOLD_SECONDS), 1.0 - exp(-passed / DOUBT_SECONDS)
    for j in range(joints):
        if not present[j]:
            failing[j] = 1.0
        good = 1.0 - failing[j]
        gain = 0.0
        if good > 0.5:
            gain = good * hold
        elif _steady(features[j], weights) > 0.8 and not repeated[j] and left[j] < 1.0 and beyond[j] < 0.5:
            gain = doubt
        for d in range(3):
            shape = good * values[j, d] if present[j] else 0.0
            posture[j, d] = shape + failing[j] * there[j, d] + mean[j, d] + own[j, d]
            ours[j, d] = own[j, d] + (gain * (values[j, d] - there[j, d]) if present[j] else 0.0)
        unsure = (there_cov[j, 0, 0] + there_cov[j, 1, 1] + there_cov[j, 2, 2]) / 3.0 + noise[j]
        unsure += UNMET**2 * exp(-met[j] / MET_SECONDS)
        std[j] = failing[j] * sqrt(unsure)
        known[j] = met[j] + passed * good
    return after_mean, after_cov, ours, failing, forecast, jerk, posture, std, known, since


@compiled
def _judge(
    features: Floats,
    weights: Floats,
    forecast: Floats,
    repeated: Bools,
    left: Floats,
    met: Floats,
    beyond: Floats,
    failed: Floats,
    doubted: float,
    failing: Floats,
) -> float:
    """The probability to fail (J,) in place, by the evidence, that of having left where it was well (J,), the time for
    which it was met (J,) in s, how far what is beyond fails (J,), that it failed before (J,), by how much that is
    `doubted` as log-odds, and what was forecast; the largest change of it."""
    most = 0.0
    for j in range(features.shape[0]):
        evidence = MOST if repeated[j] else min(_evidence(features[j], weights, False) + left[j], MOST)
        known = met[j] > KNOWN_SECONDS and left[j] == 0.0 and beyond[j] < 0.5 and not repeated[j]
        if known and _steady(features[j], weights) > CALM:
            evidence = min(evidence, _capped(features[j], weights))
        odds = log(forecast[j] / (1.0 - forecast[j]))
        if beyond[j] > 0.5 and failed[j] > 0.5:  # it did not come back: its bone would be somebody's again
            still = min(log(failed[j] / max(1.0 - failed[j], 1e-9)), SURELY) - doubted
            evidence, odds = max(evidence, 0.0), max(odds, still)
        elif beyond[j] > 0.0:
            odds = max(odds, log(COUPLED * beyond[j] / (1.0 - COUPLED * beyond[j])))
        now = _chance(evidence + odds)
        most = max(most, abs(now - failing[j]))
        failing[j] = now
    return most


@compiled
def _failing_beyond(bones: Ints, nobodys: Floats, failing: Floats, beyond: Floats) -> None:
    """Into (J,) how far a joint next outward fails and the bone to it is nobody's (B,): then either end is wrong."""
    beyond[:] = 0.0
    for b in range(bones.shape[0]):
        inner, outer = bones[b, 0], bones[b, 1]
        beyond[inner] = max(beyond[inner], nobodys[b] * failing[outer])


@compiled
def _steady(features: Floats, weights: Floats) -> float:
    """The probability that the joint goes well by all that is seen but its place."""
    return 1.0 - _chance(_evidence(features, weights, True))


@compiled
def _evidence(features: Floats, weights: Floats, blind: bool) -> float:
    """Logarithm of the likelihood ratio of failing to going well; blind to its place, it is as far off as 1."""
    total = weights[-1]
    for f in range(features.shape[0]):
        total += weights[f] * (1.0 if blind and f < 2 else features[f])
    held: float = min(max(total, -MOST), MOST)
    return held


@compiled
def _capped(features: Floats, weights: Floats) -> float:
    """The same with a place that is at most so far off that a joint may have gone there."""
    total = weights[-1]
    for f in range(features.shape[0]):
        total += weights[f] * (min(features[f], CAP) if f < 2 else features[f])
    held: float = min(max(total, -MOST), MOST)
    return held


@compiled
def _chance(odds: float) -> float:
    chance: float = 1.0 / (1.0 + exp(-odds))
    return chance
