"""One frame of a sensor: the person's place and size, what tells of failures, and sides taken for each other."""

from math import hypot, isfinite, log, log1p, sqrt
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints
from . import one_side, origins, proportions, rising
from .compile import compiled

LENGTHS_OFF = 50.0  # z-score of a bone's length beyond which it says nothing more
SHARE, LENGTH = 0.3, 0.03  # of a bone's usual length, and standard m: off by both together it is nobody's
SPREADS = 7.0  # deviations of the logarithm of its length that are the share, where sensors are restless
SUSPECT = 0.4  # of that: nearer bones only tell by their z-scores, for sensors stretch them
NOBODYS = 10.0  # by how much more a joint is off none of whose bones are anybody's, as a logarithm of z-scores
SELDOM = 2.0  # logarithm of z-scores that all of several bones at a joint seldom have together
ALL = 4.0  # by how much more counts what is beyond
SURE = 12.0  # log-likelihood ratio at which sides are changed back; half of it decides nothing
STAYS = 0.0  # the same for a pair that was changed back a frame ago
OPPOSED = -0.5  # cosine between trunk directions of successive frames at which the trunk has been turned around
REVERSED = 0.5  # of how far a pair's line is from what it was, at most, is that from the same turned around
WIDE = 0.05  # m between the two sides, below which the trunk is seen edge-on and shows no direction
LEAP, FASTEST = 0.4, 6.0  # m and m/s; who is farther from where somebody was a moment ago is somebody else
ROUNDED = 0.1  # of the joints: when so many repeat a coordinate, positions are rounded
CAP = 60.0  # squared Mahalanobis distance beyond which distance says nothing more

_insert, _middle = rising.insert, rising.middle
_by_one_side = one_side.facing
_origin_of = origins.origin_of
_length, _met, _usual_lengths = proportions.length, proportions.met, proportions.usual_lengths


@compiled
def believable(positions: Floats, far: float, point: float) -> Floats:
    """Postures (T, J, 3) in m, NaN where no person can be.

    Parameters
    ----------
    far : m from the sensor; what is farther, not finite or at the sensor itself is no person, but for a joint from
        which all others are given.
    point : m; more than two joints that are all within this are no person either.
    """
    found = np.full(positions.shape, np.nan)
    low, high = np.empty(3), np.empty(3)
    for t in range(positions.shape[0]):
        low[:], high[:] = np.inf, -np.inf
        there, root = 0, _origin_of(positions[t])
        for j in range(positions.shape[1]):
            x, y, z = positions[t, j, 0], positions[t, j, 1], positions[t, j, 2]
            if abs(x) < far and abs(y) < far and abs(z) < far and (x != 0.0 or y != 0.0 or z != 0.0 or j == root):
                there += 1
                for d in range(3):
                    found[t, j, d] = positions[t, j, d]
                    low[d], high[d] = min(low[d], positions[t, j, d]), max(high[d], positions[t, j, d])
        if there > 2 and high[0] - low[0] < point and high[1] - low[1] < point and high[2] - low[2] < point:
            found[t] = np.nan
    return found


@compiled
def received(positions: Floats, states: Bytes, to_model: Ints, far: float, point: float) -> Any:
    """A frame as it came in, and by the model's joints.

    Parameters
    ----------
    positions : (N, 3) m.
    states : (N,) 2 tracked, 1 inferred, 0 not tracked; empty when the sensor does not say.
    to_model : (J,) the recording's joint of each of the model's, -1 = none.
    far, point : as of `believable`.

    Returns
    -------
    What is believable (N, 3), that by the model's joints (J, 3), and states by those (J,); what is missing is NaN, and
    not tracked.
    """
    given = believable(positions.reshape((1, *positions.shape)), far, point)[0]
    rows = np.full((to_model.shape[0], 3), np.nan)
    told = np.zeros(to_model.shape[0] if states.shape[0] > 0 else 0, dtype=np.uint8)
    for j in range(to_model.shape[0]):
        if to_model[j] >= 0:
            for d in range(3):
                rows[j, d] = given[to_model[j], d]
            if states.shape[0] > 0:
                told[j] = states[to_model[j]]
    return given, rows, told


@compiled
def place(
    rows: Floats,
    failing: Floats,
    sums: Floats,
    bones: Ints,
    across: Ints,
    trunk: Bools,
    standard_lengths: Floats,
    standard_trunk: Floats,
    facing: Floats,
    turn: Floats,
    origin: Floats,
    scale: float,
) -> Any:
    """Size, heading and place of the person in one frame, and the posture in standard form (section 3.1).

    Parameters
    ----------
    rows : (J, 3) m, y up, NaN = missing.
    failing : (J,) probability that the joint fails.
    sums : (2, B) of trusted lengths so far in m, and how many.
    bones, across : (B, 2), (P, 2) ends of bones; left and right joints of the trunk.
    trunk : (J,) joints of the trunk.
    standard_lengths, standard_trunk : (B,), (J, 3) of the standard body.
    facing : (2,) where the trunk pointed last from right to left, 0 = not known.
    turn, origin, scale : (3, 3), (3,), of the last placement, which stays when nothing is trusted.

    Returns
    -------
    usual (B,) m, size, direction (2,), turn (3, 3), origin (3,), scale, standard (J, 3).
    """
    joints = rows.shape[0]
    trust = np.zeros(joints)
    for j in range(joints):
        if isfinite(rows[j, 0]) and isfinite(rows[j, 1]) and isfinite(rows[j, 2]):
            trust[j] = 1.0 - failing[j]
    usual = np.empty(bones.shape[0])
    size = _usual_lengths(sums, standard_lengths, usual)
    if size == 0.0:
        size = _met(rows, bones, standard_lengths, usual)
    direction = np.zeros(2)
    for p in range(across.shape[0]):
        left, right = across[p, 0], across[p, 1]
        share = trust[left] * trust[right]
        if share > 0.0:
            direction[0] += share * (rows[left, 0] - rows[right, 0])
            direction[1] += share * (rows[left, 2] - rows[right, 2])
    if direction[0] == 0.0 and direction[1] == 0.0:
        direction = _by_one_side(rows, trust, trunk, across, standard_trunk, facing)
    now, there, large = np.zeros((3, 3)), np.zeros(3), scale
    total, trusted = 0.0, 0.0
    for j in range(joints):
        total += trust[j]
        trusted += trust[j] if trunk[j] else 0.0
    if total > 0.0:
        length, large = hypot(direction[0], direction[1]), size
        cos, sin = (direction[0] / length, direction[1] / length) if length > 0.0 else (1.0, 0.0)
        now[0, 0] = now[2, 2] = cos
        now[0, 2], now[2, 0] = sin, -sin
        now[1, 1] = 1.0
        weight = trusted if trusted > 0.0 else total
        for j in range(joints):
            if trust[j] > 0.0 and (trunk[j] or trusted <= 0.0):
                x, y, z = size * standard_trunk[j, 0], size * standard_trunk[j, 1], size * standard_trunk[j, 2]
                there[0] += trust[j] / weight * (rows[j, 0] - (x * cos - z * sin))
                there[1] += trust[j] / weight * (rows[j, 1] - y)
                there[2] += trust[j] / weight * (rows[j, 2] - (x * sin + z * cos))
    else:
        for d in range(3):
            there[d] = origin[d]
            for e in range(3):
                now[d, e] = turn[d, e]
    standard = np.empty((joints, 3))
    for j in range(joints):
        for d in range(3):
            along = 0.0
            for e in range(3):
                along += now[d, e] * (rows[j, e] - there[e])
            standard[j, d] = along / large
    return usual, size, direction, now, there, large, standard


@compiled
def crossed(
    rows: Floats,
    last: Floats,
    standard: Floats,
    place: Floats,
    place_cov: Floats,
    mean: Floats,
    own: Floats,
    noise: Floats,
    before: Bools,
    mirror: Ints,
) -> Any:
    """Which pairs of joints stand where the other one is expected (J,), and whether it could not be told for some.

    Sides are confused from one frame to the next: a pair that went on as it went is not, wherever it is expected.

    Parameters
    ----------
    rows, last : (J, 3) m, where the sensor has the joints, and where they were a frame ago, NaN = missing.
    standard : (J, 3) what the sensor says, in standard form, NaN = missing.
    place, place_cov : (J, 3), (J, 3, 3) deviations that the frames before let expect.
    mean, own, noise : (J, 3), (J, 3), (J,) of all people, this person's own, and what stays open.
    before : (J,) changed back a frame ago.
    mirror : (J,) the joint on the other side.
    """
    joints = standard.shape[0]
    expected, variance = np.empty((joints, 3)), np.empty(joints)
    for j in range(joints):
        variance[j] = (place_cov[j, 0, 0] + place_cov[j, 1, 1] + place_cov[j, 2, 2]) / 3.0 + noise[j]
        for d in range(3):
            expected[j, d] = place[j, d] + mean[j, d] + own[j, d]
    swapped, unsure = np.zeros(joints, dtype=np.bool_), False
    for left in range(joints):
        right = mirror[left]
        if right <= left:
            continue
        stayed = _apart(rows, last, left, left) + _apart(rows, last, right, right)
        if not before[left] and stayed <= _apart(rows, last, left, right) + _apart(rows, last, right, left):
            continue
        straight = _far(standard, expected, variance, left, left) + _far(standard, expected, variance, right, right)
        over = _far(standard, expected, variance, left, right) + _far(standard, expected, variance, right, left)
        ratio = 0.5 * (straight - over)
        if not isfinite(ratio) or over >= CAP:
            continue
        if ratio > (STAYS if before[left] else SURE):
            swapped[left] = swapped[right] = True
        elif ratio > 0.5 * SURE:
            unsure = True
    return swapped, unsure


@compiled
def _apart(rows: Floats, last: Floats, one: int, there: int) -> float:
    square = 0.0
    for d in range(3):
        square += (rows[one, d] - last[there, d]) ** 2
    return sqrt(square)


@compiled
def _far(standard: Floats, expected: Floats, variance: Floats, one: int, there: int) -> float:
    square = 0.0
    for d in range(3):
        square += (standard[one, d] - expected[there, d]) ** 2
    square /= variance[there]
    return CAP if square > CAP else square  # NaN stays


@compiled
def signs(
    rows: Floats,
    before: Floats,
    earlier: Floats,
    size: float,
    usual: Floats,
    bones: Ints,
    twins: Ints,
    spread: Floats,
    jerk: Floats,
    states: Bytes,
) -> Any:
    """What tells of failures but the place of a joint.

    A bone far from its usual length is nobody's, unless its twin on the other side is off alike: that is a habit of the
    sensor.

    Parameters
    ----------
    rows : (J, 3) m, NaN = missing.
    before, earlier : (J, 3) m, the two frames before.
    size : of the person.
    usual : (B,) m.
    bones : (B, 2). twins : (B,) the bone on the other side, its own number in the middle.
    spread : (B,) usual deviation of the logarithm of a bone's length.
    jerk : (J,) usual size of the second difference, standard metres.
    states : (J,) 2 tracked, 1 inferred, 0 not tracked; empty when the sensor does not say.

    Returns
    -------
    lengths (B,) m; second differences by the usual ones (J,); how far the bone to the parent is off, and the bone at
    the joint that is least so (J,), (J,), logarithms of z-scores, the latter more where it is nobody's bone, or where
    all of several bones are far off; (B,) how far each bone is nobody's, from 0 to 1; (J, 3) one for inferred, not
    tracked, tracked; (J,) whether the sensor repeats where it had the joint.
    """
    joints, count = rows.shape[0], bones.shape[0]
    lengths, raw, told = np.empty(count), np.empty(joints), np.zeros((joints, 3))
    own, best, broken = np.zeros(joints), np.full(joints, np.inf), np.full(joints, np.inf)
    nobodys, asked = np.zeros(count), np.zeros(joints, dtype=np.int64)
    for b in range(count):
        lengths[b] = _length(rows, bones[b, 0], bones[b, 1])
    for b in range(count):
        off, odd = 0.0, 0.0
        if isfinite(lengths[b]) and isfinite(usual[b]):
            longer, other = lengths[b] - usual[b], lengths[twins[b]] - usual[twins[b]]
            if isfinite(other):
                odd = min(abs(longer), abs(longer - other))
                odd /= max(SHARE, SPREADS * spread[b]) * usual[b] + LENGTH * size
            off = min(abs(log(max(lengths[b], 1e-6) / max(usual[b], 1e-6))) / spread[b], LENGTHS_OFF)
            asked[bones[b, 0]] += 1
            asked[bones[b, 1]] += 1
        nobodys[b] = min(max(odd - SUSPECT, 0.0), 1.0)
        own[bones[b, 1]] = off
        best[bones[b, 0]] = min(best[bones[b, 0]], off)
        best[bones[b, 1]] = min(best[bones[b, 1]], off)
        broken[bones[b, 0]] = min(broken[bones[b, 0]], odd)
        broken[bones[b, 1]] = min(broken[bones[b, 1]], odd)
    for j in range(joints):
        square = 0.0
        for d in range(3):
            square += (rows[j, d] - 2.0 * before[j, d] + earlier[j, d]) ** 2
        raw[j] = sqrt(square) / size / jerk[j] if isfinite(square) else 0.0
        own[j], best[j] = log1p(own[j]), log1p(best[j]) if isfinite(best[j]) else 0.0
        best[j] += ALL * max(best[j] - SELDOM, 0.0) if asked[j] > 1 else 0.0
        best[j] += NOBODYS * min(max(broken[j] - SUSPECT, 0.0), 1.0) if isfinite(broken[j]) else 0.0
        if states.shape[0] > 0:
            told[j, 0], told[j, 1], told[j, 2] = states[j] == 1, states[j] == 0, states[j] == 2
    return lengths, raw, own, best, nobodys, told, _repeated(rows, before, earlier)


@compiled
def _repeated(rows: Floats, before: Floats, earlier: Floats) -> Bools:
    """(J,) joints that are where they were in the two frames before (J, 3), to the last digit, while others are not.

    No sensor sees a joint so: it does not see it, and says again what it said. Where single coordinates repeat too,
    positions are rounded, and where most joints do, the frame was said twice.
    """
    found = np.zeros(rows.shape[0], dtype=np.bool_)
    moved, still, rounded = 0, 0, 0
    for j in range(rows.shape[0]):
        same = 0
        for d in range(3):
            same += rows[j, d] == before[j, d]
        found[j] = same == 3
        for d in range(3):
            found[j] = found[j] and before[j, d] == earlier[j, d]
        moved += same == 0 and isfinite(rows[j, 0] + before[j, 0])
        still += same == 3
        rounded += 0 < same < 3
    if still >= moved or rounded > ROUNDED * moved:
        found[:] = False
    return found


@compiled
def given_back(
    given: Floats,
    rows: Floats,
    swapped: Bools,
    turn: Floats,
    origin: Floats,
    scale: float,
    upright: Floats,
    moved: Floats,
    std: Floats,
    failing: Floats,
    to_model: Ints,
    spread: Floats,
    placed: Floats,
    deviation: Floats,
    reliable: Floats,
) -> None:
    """One frame of `correct.joining.outward`: a corrected posture in the recording's joints and axes.

    Parameters
    ----------
    given : (N, 3) m, as the sensor gave it.
    rows : (J, 3) m, by the model's joints, upright; NaN = missing.
    swapped : (J,) sides changed back.
    turn, origin, scale : of the placement.
    upright : (3, 3) from the sensor's axes.
    moved, std, failing : (J, 3), (J,), (J,) corrected, in standard form; its deviation; probability to fail.
    to_model : (J,) the recording's joint, -1 = none.
    spread : (N, J) how the model's shifts move the recording's joints.
    placed, deviation, reliable : (N, 3) m, (N,) m, (N,) written.
    """
    joints, count = moved.shape[0], given.shape[0]
    here, shift, trust = np.empty((joints, 3)), np.zeros((joints, 3)), np.zeros(joints)
    anyone = False
    level = np.empty(3)
    for j in range(joints):
        for d in range(3):
            level[d] = origin[d]
            for e in range(3):
                level[d] += scale * moved[j, e] * turn[e, d]
        for d in range(3):
            here[j, d] = level[0] * upright[0, d] + level[1] * upright[1, d] + level[2] * upright[2, d]
        seen = isfinite(rows[j, 0]) and isfinite(rows[j, 1]) and isfinite(rows[j, 2])
        if seen:
            anyone = anyone or to_model[j] >= 0
            trust[j] = 0.0 if swapped[j] else 1.0 - failing[j]
            for d in range(3):  # whose sides were changed back may have come where the sensor has no joint
                step = here[j, d] - given[to_model[j], d]
                shift[j, d] = step if isfinite(step) else 0.0
    for n in range(count):
        whole = isfinite(given[n, 0]) and isfinite(given[n, 1]) and isfinite(given[n, 2])
        deviation[n] = reliable[n] = 0.0
        for d in range(3):
            placed[n, d] = given[n, d] if isfinite(given[n, d]) else np.nan
        for j in range(joints):
            share = abs(spread[n, j])
            if share == 0.0:
                continue
            deviation[n] += std[j] * scale * share
            reliable[n] += trust[j] * share
            for d in range(3):
                placed[n, d] += spread[n, j] * shift[j, d]
        reliable[n] = min(max(reliable[n], 0.0), 1.0) if whole else 0.0
    for j in range(joints):
        if to_model[j] >= 0:
            for d in range(3):
                placed[to_model[j], d] = here[j, d] if anyone else np.nan


@compiled
def turned_around(rows: Floats, before: Floats, across: Ints, last: Floats) -> Bools:
    """(P,) which left-right pairs of the trunk face against where it faced a moment ago.

    A joint that is thrown turns the line between a narrow pair as well, but does not leave it as long as it was: where
    the pair was seen a frame ago, each has to be nearer to the other one's place.

    Parameters
    ----------
    rows : (J, 3) m, y up, NaN = missing.
    before : (2,) horizontal direction from right to left; zero = not known: none does.
    across : (P, 2) left and right joints.
    last : (J, 3) m, where they were a frame ago, NaN = missing.
    """
    found = np.zeros(across.shape[0], dtype=np.bool_)
    for p in range(across.shape[0]):
        left, right = across[p, 0], across[p, 1]
        x, z = rows[left, 0] - rows[right, 0], rows[left, 2] - rows[right, 2]
        size = hypot(x, z)
        found[p] = size > WIDE and x * before[0] + z * before[1] < OPPOSED * size * hypot(before[0], before[1])
        stayed, over = 0.0, 0.0
        for d in range(3):
            now, then = rows[left, d] - rows[right, d], last[left, d] - last[right, d]
            stayed += (now - then) ** 2
            over += (now + then) ** 2
        found[p] = found[p] and not over > REVERSED**2 * stayed
    return found


@compiled
def middle_step(rows: Floats, before: Floats, middle: Floats) -> bool:
    """How far the middle joint went, (3,) m, is written: of each axis the median. Whether there is any.

    Parameters
    ----------
    rows, before : (J, 3) m, NaN = missing.
    """
    apart = np.empty(rows.shape[0])
    for d in range(3):
        known = 0
        for j in range(rows.shape[0]):
            step = rows[j, d] - before[j, d]
            if isfinite(step):
                _insert(apart, known, step)
                known += 1
        if known == 0:
            return False
        middle[d] = _middle(apart, known)
    return True


@compiled
def leapt(rows: Floats, before: Floats, seconds: float) -> bool:
    """Whether the middle joint is farther from where it was than anybody goes in that time.

    Parameters
    ----------
    rows, before : (J, 3) m, NaN = missing.
    seconds : between them.
    """
    middle = np.empty(3)
    if not middle_step(rows, before, middle):
        return False
    return sqrt(middle[0] ** 2 + middle[1] ** 2 + middle[2] ** 2) > LEAP + FASTEST * max(seconds, 0.0)


@compiled
def strayed(rows: Floats, before: Floats, seconds: float, reach: Floats) -> Bools:
    """(J,) which joints went farther from the middle joint than anybody's do in that time.

    Parameters
    ----------
    rows, before, seconds : as of `leapt`.
    reach : (J,) m, by which each may besides have been taken for another.
    """
    found, middle = np.zeros(rows.shape[0], dtype=np.bool_), np.empty(3)
    if not middle_step(rows, before, middle):
        return found
    for j in range(rows.shape[0]):
        square = 0.0
        for d in range(3):
            square += (rows[j, d] - before[j, d] - middle[d]) ** 2
        found[j] = sqrt(square) > LEAP + FASTEST * max(seconds, 0.0) + reach[j]
    return found
