"""Plain NumPy twins of correction's kernels: slow, short, and plainly right."""

import numpy as np

import naive_one_side
from motionmend.kernels import origins

# ---- kernels/mixture.py ----------------------------------------------------------


def mixture_predict(inputs, outputs, hyper, query, nearest):
    """Mean (P,) and variance of one joint's local models, each solved anew, from lists of (n, D), (n, P), (4,)."""
    likeness, means, variances = [], [], []
    for x, y, (signal, bias, width, noise) in zip(inputs, outputs, hyper, strict=True):

        def k(a, b, signal=signal, bias=bias, width=width):
            return signal * np.exp(-0.5 * width * np.sum((a[:, None] - b[None]) ** 2, axis=2)) + bias

        noisy = k(x, x) + noise * np.eye(len(x))
        cross = k(query[None], x)
        means.append((cross @ np.linalg.inv(noisy) @ y)[0])
        variances.append(float(signal + bias - (cross @ np.linalg.inv(noisy) @ cross.T)[0, 0]))
        likeness.append(-0.5 * width * np.sum((query - x.mean(axis=0)) ** 2))
    best = np.argsort(likeness)[::-1][:nearest]
    weight = np.exp(np.array(likeness)[best] - max(likeness))
    weight /= weight.sum()
    means, variances = np.array(means)[best], np.array(variances)[best]
    mean = weight @ means
    return mean, weight @ variances + (weight @ (means - mean) ** 2).mean()


# ---- kernels/factors.py ----------------------------------------------------------


def factors_ahead(mean, cov, rates, seconds):
    """The Matern-3/2 process by the matrix exponential of its drift."""
    from scipy.linalg import expm

    count = len(rates)
    drift = np.zeros((2 * count, 2 * count))
    for k, rate in enumerate(rates):
        drift[k, k + count] = 1.0
        drift[k + count, k], drift[k + count, k + count] = -(rate**2), -2.0 * rate
    matrix = expm(drift * seconds)
    lasting = np.diag(np.concatenate([np.ones(count), rates**2]))
    return matrix @ mean, matrix @ cov @ matrix.T + lasting - matrix @ lasting @ matrix.T


def factors_seen(loadings, mean, cov, values, precision):
    """Kalman's update with every coordinate that is seen."""
    joints, depth, count = loadings.shape
    seen = np.repeat(precision, depth) > 0
    rows = np.hstack([loadings.reshape(-1, count), np.zeros((joints * depth, count))])[seen]
    noise = np.diag(1.0 / np.repeat(precision, depth)[seen])
    gain = cov @ rows.T @ np.linalg.inv(rows @ cov @ rows.T + noise)
    return mean + gain @ (values.ravel()[seen] - rows @ mean), cov - gain @ rows @ cov


def group_distance(loadings, mean, cov, value, group, noise):
    """Mahalanobis distance and log-determinant of one group's value under a belief that has not seen it."""
    count = loadings.shape[2]
    rest = value - loadings[group] @ mean[:count]
    whole = loadings[group] @ cov[:count, :count] @ loadings[group].T + noise * np.eye(len(value))
    return np.sqrt(rest @ np.linalg.inv(whole) @ rest), np.log(np.linalg.det(whole))


# ---- kernels/bones.py ------------------------------------------------------------


def settle(positions, bones, lengths, mobility, rounds):
    """The same relaxation, bone by bone."""
    settled = positions.copy()
    for t in range(len(settled)):
        for turn in range(rounds + 1):
            for (p, c), wanted in zip(bones, lengths[t], strict=True):
                apart = settled[t, c] - settled[t, p]
                length = np.linalg.norm(apart)
                if not (length > 1e-6 and wanted > 0):
                    continue
                share = 0.0 if turn == rounds else mobility[t, p] / (mobility[t, p] + mobility[t, c])
                pull = apart * (1.0 - wanted / length)
                settled[t, p] += share * pull
                settled[t, c] -= (1.0 - share) * pull
    return settled


def at_rest(last, earlier, between, moving):
    """(J,) how far joints are at rest, 0 where nobody knows."""
    rest = 1.0 / (1.0 + (np.linalg.norm(last - earlier, axis=1) / between / moving) ** 4)
    return np.where(np.isfinite(rest), rest, 0.0)


def followed_slowly(before, now, seconds, lasting, resting, last, earlier, between):
    """A correction that follows what is asked for, by each joint's own time."""
    from motionmend.kernels.bones import STILL

    long = lasting + (resting - lasting) * at_rest(last, earlier, between, STILL)[:, None]
    follows = 1.0 - np.exp(-max(seconds, 0.0) / long) if seconds < 1.0 else 1.0
    slow = before + follows * (now - before)
    return np.where(np.isfinite(slow), slow, now)


def steady_frame(positions, seconds, motion, later, steps, shaking):
    """One live frame made steady: a Kalman filter for each joint, then smoothed back from the frames after it."""
    from motionmend.kernels import steadying as kernel

    def drifted(drift, frames):
        return drift * np.array([[frames**3 / 3, frames**2 / 2], [frames**2 / 2, frames]])

    def ahead(state, cov, drift, innovation, frames):
        moved = np.array([[1.0, frames], [0.0, 1.0]])
        return moved, moved @ state, moved @ cov @ moved.T + drifted(drift, frames)

    noise = max(shaking, kernel.NOISE) ** 2

    def met(state, cov, drift, innovation, where, frames):
        off = where - state[0]
        alike = off @ innovation / 3.0 - (noise - kernel.NOISE**2)
        lively = max(alike / frames**2, kernel.CALMEST**2)
        after = lively + np.exp(-frames / (kernel.ROUSED if lively > drift else kernel.RESTED)) * (drift - lively)
        cov = cov + drifted(max(after - drift, 0.0), frames)
        gain = cov[:, 0] / (cov[0, 0] + noise / min(frames, 1.0))
        return cov, (state + np.outer(gain, off), cov - np.outer(gain, cov[0]), after, off)

    calm, after = positions.copy(), np.full(motion.shape, np.nan)
    usable = np.array([kernel.told(step) for step in steps], dtype=bool)
    usable = len(steps) if usable.all() else int(np.argmin(usable))
    for j in np.flatnonzero(np.isfinite(positions).all(axis=1)):
        begun = np.diag([noise, kernel.BEGUN**2]), kernel.CALMEST**2, np.zeros(3)
        state = np.array([positions[j], np.zeros(3)]), *begun
        if kernel.told(seconds) and np.isfinite(motion[j]).all():
            frames, rest = kernel.RATE * seconds, (motion[j, 9], motion[j, 10:])
            cov = np.array([[motion[j, 6], motion[j, 8]], [motion[j, 8], motion[j, 7]]])
            _, *there = ahead(motion[j, :6].reshape(2, 3), cov, *rest, frames)
            state = met(*there, *rest, positions[j], frames)[1]
        values, cov, drift, innovation = state
        after[j] = [*values.ravel(), cov[0, 0], cov[1, 1], cov[0, 1], drift, *innovation]
        passed = []
        for where, step in zip(later[:usable, j], steps[:usable], strict=True):
            frames = kernel.RATE * step
            moved, values, cov = ahead(*state, frames)
            before, state = state, (values, cov, *state[2:])
            if np.isfinite(where).all():
                cov, state = met(*state, where, frames)
            passed.append((before, moved, values, cov))
        values = state[0]
        for (filtered, before, *_), moved, expected, cov in reversed(passed):
            values = filtered + before @ moved.T @ np.linalg.inv(cov) @ (values - expected)
        calm[j] = values[0]
    return calm, after


def settle_frame(
    positions, trust, bones, prior, belief, times, last, earlier, known, yielded, step, motion, later, steps, shaking
):
    """One live frame made steady, its bones brought to their lengths."""
    from motionmend.kernels import bones as kernel

    LOOSE, ROUNDS = kernel.LOOSE, kernel.ROUNDS
    first, second = times
    calm, going = steady_frame(positions, step, motion, later, steps, shaking)
    lengths = np.linalg.norm(positions[bones[:, 1]] - positions[bones[:, 0]], axis=1)
    passed = 1.0 / 30.0 if np.isnan(first) else min(first, kernel.LONG_SECONDS)
    share = np.where(np.isfinite(lengths), passed * trust[bones].min(axis=1), 0.0)
    enough = kernel.ACQUAINTED_SECONDS
    spent = np.minimum(known[1] + share, enough)
    gain = np.minimum(kernel.LATER * share / np.maximum(spent, 1e-12), 1.0)
    gain = np.where(known[1] < enough, gain, share / kernel.MEMORY_SECONDS)
    after = np.stack([known[0] + gain * np.nan_to_num(lengths - known[0]), spent])
    seen = np.where(spent > 0, after[0], np.nan_to_num(lengths))
    begun = belief * kernel.PRIOR_SECONDS / (spent + belief * kernel.PRIOR_SECONDS)
    usual = np.where(np.isfinite(prior), seen + begun * (prior - seen), seen)
    mobility = 1.0 + LOOSE * (1.0 - trust)[None]
    relaxed = settle(calm[None], bones, usual[None], mobility, ROUNDS)[0] - calm
    gave = followed_slowly(yielded, relaxed, first, kernel.SLOW_SECONDS, kernel.REST_SECONDS, last, earlier, second)
    return settle((calm + gave)[None], bones, usual[None], mobility, 0)[0], after, gave, going, calm


# ---- kernels/shaking.py ----------------------------------------------------------


def turned_back(rows, last, earlier, before):
    """Second differences, and the variance of white noise that turns back as the median joint does."""
    from motionmend.kernels import shaking as kernel

    bent = rows - 2.0 * last + earlier
    turns = -np.einsum("jd,jd->j", bent, before)
    turns = turns[np.isfinite(turns)]
    return bent, np.median(turns) / kernel.WHITE if len(turns) >= kernel.FEWEST else np.nan


# ---- kernels/following.py --------------------------------------------------------


def chain_ahead(failing, seconds, lasting):
    """Probability to fail one frame on, before the evidence: a Markov chain of going well and failing."""
    into, out = 1.0 - np.exp(-seconds / lasting)
    return np.clip(failing * (1.0 - out) + (1.0 - failing) * into, 1e-6, 1.0 - 1e-6)


def chance_after(evidence, forecast):
    """The same after the evidence, a log-likelihood ratio of failing to going well."""
    return 1.0 / (1.0 + np.exp(-(np.log(forecast / (1.0 - forecast)) + evidence)))


def follow(
    factors, weights, lasting, before, belief, standard, seconds, raw, bone, best_bone, told, repeated, leaps, apart
):
    """One frame of a posture followed through failures; every group is judged by a belief that has not seen it."""
    from motionmend.kernels.following import DOUBT_SECONDS, HOLD_SECONDS, MET_SECONDS, ROUNDS, SETTLED, STRANGER, UNMET

    mean, loadings, noise = factors
    own, failed, jerky, met = before
    gone, back, leapt = leaps
    bones, nobodys = apart
    since = np.where(back, 9.0, np.where(gone & (failed < 0.5), 0.0, leapt + seconds))
    joints, count = len(mean), loadings.shape[2]
    present = np.isfinite(standard).all(axis=1)
    values = np.where(present[:, None], standard, mean) - mean - own
    jerk = raw + (jerky - raw) * np.exp(-seconds / 0.1)
    variance = noise + STRANGER**2 * np.exp(-met / MET_SECONDS)

    def away(precision):
        found = np.empty(joints)
        for j in range(joints):
            others = np.where(np.arange(joints) == j, 0.0, precision)
            without = factors_seen(loadings, *belief, values, others)
            found[j] = group_distance(loadings, *without, values[j], j, variance[j])[0]
        return np.log1p(found)

    def evidence(features):
        return np.where(repeated, 8.0, np.clip(features @ weights[:-1] + weights[-1], -8.0, 8.0))

    def failing_beyond(failing):
        found = np.zeros(joints)
        np.maximum.at(found, bones[:, 0], nobodys * failing[bones[:, 1]])
        return found

    def with_leaps(features, beyond):
        left = 6.0 * np.exp(-since / 3.0)
        found = np.minimum(evidence(features) + left, 8.0)
        blind, capped = features.copy(), features.copy()
        blind[:, :2], capped[:, :2] = 1.0, np.minimum(features[:, :2], 1.8)
        calm = (1.0 / (1.0 + np.exp(evidence(blind))) > 0.8) & (left == 0.0) & (met > 1.0) & ~repeated
        calm &= beyond < 0.5
        return np.where(calm, np.minimum(found, evidence(capped)), found)

    first = away(np.zeros(joints))
    features = np.column_stack([first, first, bone, best_bone, np.log1p(np.maximum(raw, jerk)), told])
    forecast = chain_ahead(failed, seconds, lasting)
    beyond = np.zeros(joints)
    failing = chance_after(with_leaps(features, beyond), forecast)
    for _ in range(ROUNDS):
        trust = np.where(present & (1.0 - failing > 0.02), 1.0 - failing, 0.0)
        after = factors_seen(loadings, *belief, values, trust / variance)
        features[:, 0] = away(trust / variance)
        since = np.where(features[:, 0] < np.log1p(2.0), np.inf, since)
        beyond = failing_beyond(failing)
        still = (beyond > 0.5) & (failed > 0.5)
        odds = np.minimum(np.log(failed / (1.0 - failed)), 4.6) - 4.6 * seconds / 5.0
        likely_before = np.maximum(forecast, np.where(still, 1.0 / (1.0 + np.exp(-odds)), 0.5 * beyond))
        said = with_leaps(features, beyond)
        judged, failing = failing, chance_after(np.where(still, np.maximum(said, 0.0), said), likely_before)
        if np.abs(failing - judged).max() < SETTLED:
            break
    there = loadings @ after[0][:count]
    spread = np.array([np.trace(row @ after[1][:count, :count] @ row.T) / 3.0 for row in loadings])
    failing = np.where(present, failing, 1.0)
    good = 1.0 - failing
    posture = np.where(present[:, None], good[:, None] * values, 0.0) + failing[:, None] * there + mean + own
    blind = np.column_stack([np.ones((joints, 2)), features[:, 2:]])
    steady = 1.0 / (1.0 + np.exp(evidence(blind)))
    passed = seconds if seconds > 0.0 else 1.0 / 30.0  # the first frame is one of a sensor at 30 Hz
    hold, doubt = 1.0 - np.exp(-passed / HOLD_SECONDS), 1.0 - np.exp(-passed / DOUBT_SECONDS)
    calm = (steady > 0.8) & (6.0 * np.exp(-since / 3.0) < 1.0) & (beyond < 0.5)
    gain = np.where(good > 0.5, good * hold, np.where(calm, doubt, 0.0))
    ours = own + gain[:, None] * np.where(present[:, None], values - there, 0.0)
    std = failing * np.sqrt(spread + noise + UNMET**2 * np.exp(-met / MET_SECONDS))
    return *after, ours, failing, forecast, jerk, posture, std, met + passed * good, since


# ---- kernels/sighting.py ---------------------------------------------------------


def origin_of(posture):
    """The joint from which all others are given, -1 for none."""
    zero = np.flatnonzero(~posture.any(axis=1))
    others = posture[posture.any(axis=1) & np.isfinite(posture).all(axis=1)]
    if len(zero) != 1 or len(others) < 3:
        return -1
    size = np.ptp(others, axis=0).max()
    near = np.linalg.norm(others, axis=1) < origins.NEAR * size
    return zero[0] if near.sum() > 1 and np.linalg.norm(others.mean(axis=0)) < origins.ABOUT * size else -1


def believable(positions, far, point):
    """NaN where no person can be."""
    there = (np.abs(positions) < far).all(axis=-1) & positions.any(axis=-1)
    for t, some in enumerate(there):
        if origin_of(positions[t]) >= 0:
            some[origin_of(positions[t])] = True
        if some.sum() > 2 and (np.ptp(positions[t, some], axis=0) < point).all():
            there[t] = False
    return np.where(there[..., None], positions, np.nan)


def received(positions, states, to_model, far, point):
    """A frame, and the same by the model's joints."""
    given, have = believable(positions[None], far, point)[0], to_model >= 0
    told = np.where(have, states[to_model], 0) if len(states) else states
    return given, np.where(have[:, None], given[to_model], np.nan), told


def place(rows, failing, sums, bones, across, trunk, lengths, standard_trunk, direction, turn, origin, scale):
    """Size, heading and place of a person."""
    present = np.isfinite(rows).all(axis=1)
    trust = np.where(present, 1.0 - failing, 0.0)
    known = sums[1] > 0
    if known.any():
        share = np.minimum(sums[1][known], 30.0)
        size = (share * sums[0][known] / sums[1][known]).sum() / (share * lengths[known]).sum()
        usual = (sums[0] + 5.0 * size * lengths) / (sums[1] + 5.0)
    else:
        ratio = np.linalg.norm(rows[bones[:, 1]] - rows[bones[:, 0]], axis=1) / lengths
        size = np.median(ratio[np.isfinite(ratio)]) if np.isfinite(ratio).any() else 1.0
        usual = size * lengths
    now = np.zeros(2)
    for left, right in across:
        if trust[left] * trust[right] > 0:
            now += trust[left] * trust[right] * (rows[left, ::2] - rows[right, ::2])
    if not now.any():
        now = naive_one_side.facing(rows, trust, trunk, across, standard_trunk, direction)
    if trust.any():
        cos, sin = now / np.linalg.norm(now) if now.any() else (1.0, 0.0)
        turn, scale = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]), size
        weights = np.where(trunk, trust, 0.0)
        weights = weights if weights.sum() > 0 else trust
        says = np.where(weights[:, None] > 0, rows - scale * standard_trunk @ turn, 0.0)
        origin = (weights[:, None] * says).sum(axis=0) / weights.sum()
    return usual, size, now, turn, origin, scale, (rows - origin) @ turn.T / scale


def kinship(sums, lengths, twins, parts):
    """The probability that bones are those of the sensor that was learned from."""
    known = sums[1] > 0
    if not known.any():
        return 1.0 / (1.0 + np.exp(-3.0))
    mine = np.divide(sums[0], sums[1], out=np.zeros(len(lengths)), where=known)
    share = np.minimum(sums[1], 30.0)
    off = np.where(known, np.abs(mine * (share * lengths).sum() / (share * mine).sum() - lengths), np.inf)
    off, seen = np.minimum(off, off[twins]), np.minimum(np.maximum(sums[1], sums[1][twins]) / sums[1].max() / 0.6, 1)
    one = np.isfinite(off) & (twins >= np.arange(len(twins)))
    off, seen, parts = off[one], seen[one], parts[one]
    ratio = seen * (np.log(3.0) - off / 0.015 + off / 0.045)
    least = min([0.0, *(ratio[parts == part].sum() for part in set(parts) - {0})])
    return 1.0 / (1.0 + np.exp(-np.clip(3.0 + ratio.sum() - least, -30.0, 30.0)))


def leapt(rows, before, seconds):
    """Whether the middle joint went farther than anybody does."""
    step = (rows - before)[np.isfinite(rows - before).all(axis=1)]
    return len(step) > 0 and bool(np.linalg.norm(np.median(step, axis=0)) > 0.4 + 6.0 * max(seconds, 0.0))


def strayed(rows, before, seconds, reach):
    """Which joints went farther from the middle one than anybody's do."""
    step = rows - before
    known = np.isfinite(step).all(axis=1)
    if not known.any():
        return np.zeros(len(rows), dtype=bool)
    far = np.linalg.norm(step - np.median(step[known], axis=0), axis=1)
    return np.nan_to_num(far) > 0.4 + 6.0 * max(seconds, 0.0) + reach


def leaps(rows, before, earlier, seconds, mirror):
    """Who is farther than any gets from where they were and went, but for sides that changed places."""
    from motionmend.kernels.hops import BESIDE, HOP, SHARPEST

    least = HOP + 0.5 * SHARPEST * max(seconds, 0.0) ** 2
    stayed, went = np.linalg.norm(rows - before, axis=1), np.linalg.norm(rows - 2 * before + earlier, axis=1)
    over, back = np.linalg.norm(rows - before[mirror], axis=1), np.linalg.norm(rows[mirror] - before, axis=1)
    exchanged = (mirror != np.arange(len(rows))) & (np.maximum(over, back) < BESIDE * stayed)
    return (np.minimum(stayed, went) > least) & ~exchanged


def hopped(rows, before, earlier, seconds, mirror):
    """Which joints are where they can be neither by staying nor by going on, nor as their other sides."""
    stay, go = before, 2.0 * before - earlier
    off = [np.linalg.norm(rows - place, axis=1) for place in (stay, go)]
    beside = np.fmin(*(np.linalg.norm(rows - place[mirror], axis=1) for place in (stay, go)))
    far = np.minimum(*off) > 0.12 + 50.0 * max(seconds, 0.0) ** 2
    return far & ~(beside < 0.5 * off[1])


def crossed(rows, last, standard, place, place_cov, mean, own, noise, before, mirror):
    """Which pairs stand in each other's place."""
    expected, variance = place + mean + own, np.trace(place_cov, axis1=1, axis2=2) / 3.0 + noise
    swapped, unsure = np.zeros(len(mean), dtype=bool), False

    def far(one, there):
        return np.minimum(((standard[one] - expected[there]) ** 2).sum() / variance[there], 60.0)

    for left, right in enumerate(mirror):
        if right <= left:
            continue
        pair = [left, right]
        stayed, went = (np.linalg.norm(rows[pair] - last[there], axis=1).sum() for there in (pair, pair[::-1]))
        if not before[left] and stayed <= went:
            continue
        over = far(left, right) + far(right, left)
        ratio = 0.5 * (far(left, left) + far(right, right) - over)
        if over < 60.0 and ratio > (0.0 if before[left] else 12.0):
            swapped[[left, right]] = True
        elif over < 60.0 and ratio > 6.0:
            unsure = True
    return swapped, unsure


def signs(rows, before, earlier, size, usual, bones, twins, spread, jerk, states):
    """What tells of failures but the place of a joint."""
    lengths = np.linalg.norm(rows[bones[:, 1]] - rows[bones[:, 0]], axis=1)
    off = np.minimum(np.abs(np.log(np.maximum(lengths, 1e-6) / np.maximum(usual, 1e-6))) / spread, 50.0)
    off = np.where(np.isfinite(off), off, 0.0)
    longer = lengths - usual
    apart = np.abs(longer - longer[twins])
    odd = np.minimum(np.abs(longer), apart) / (np.maximum(0.3, 7.0 * spread) * usual + 0.03 * size)
    odd = np.where(np.isfinite(odd), odd, 0.0)
    own, best, broken = np.zeros(len(rows)), np.full(len(rows), np.inf), np.full(len(rows), np.inf)
    own[bones[:, 1]] = off
    for end in bones.T:
        np.minimum.at(best, end, off)
        np.minimum.at(broken, end, odd)
    bent = np.linalg.norm(rows - 2.0 * before + earlier, axis=1) / size / jerk
    told = np.column_stack([states == 1, states == 0, states == 2]) if len(states) else np.zeros((len(rows), 3))
    best = np.log1p(np.where(np.isfinite(best), best, 0.0))
    asked = np.bincount(bones[np.isfinite(longer)].ravel(), minlength=len(rows))
    best += np.where(asked > 1, 4.0 * np.maximum(best - 2.0, 0.0), 0.0)
    nobodys = np.clip(odd - 0.4, 0.0, 1.0)
    best += 10.0 * np.clip(np.where(np.isfinite(broken), broken, 0.0) - 0.4, 0.0, 1.0)
    return lengths, np.nan_to_num(bent), np.log1p(own), best, nobodys, told, repeated(rows, before, earlier)


def repeated(rows, before, earlier):
    """Joints that stand still to the last digit while most others move, unless positions are rounded."""
    alike = rows == before
    seen = np.isfinite(rows + before).all(axis=1)
    still, moved = alike.all(axis=1), (seen & ~alike.any(axis=1)).sum()
    rounded = (alike.any(axis=1) & ~still).sum()
    return still & (before == earlier).all(axis=1) & (still.sum() < moved) & (rounded <= 0.1 * moved)


def counted(sums, spread, lengths, failing, bones, usual, seconds):
    """Trusted lengths summed, many of them fading, those far off counting less; and by how much lengths vary."""
    share = (1.0 - failing[bones[:, 0]]) * (1.0 - failing[bones[:, 1]])
    share = np.where(np.isfinite(lengths) & (share > 0.5), share, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.abs(np.log(np.maximum(lengths, 1e-6) * sums[1] / np.maximum(sums[0], 1e-6)))
    known = np.isfinite(lengths) & (sums[1] > 0.0)
    share = share * np.where(known, np.minimum(1.0, 1.5 * np.maximum(spread, usual) / np.maximum(off, 1e-9)), 1.0)
    grown = np.exp(max(seconds, 0.0) / 1.5)
    wide = np.where(off > 0.6745 * spread, spread * grown, np.maximum(spread / grown, 0.2 * usual))
    after = sums * np.minimum(1.0, 300.0 / np.maximum(sums[1], 1e-9)) + share * np.stack(
        [np.nan_to_num(lengths), np.ones(len(share))]
    )
    return after, np.where(known, wide, spread)


def unsteadiness(spread, usual, most):
    """Usual deviations, wider by the variance of the median bone beyond what is usual."""
    return usual * np.sqrt(max(1.0, np.median(spread / usual) ** 2 - most**2))


def likely(usual, size, standard_lengths, twins):
    """Usual bones no farther from the standard body's than their twins are, and a little."""
    off = usual - size * standard_lengths
    most = np.where(twins == np.arange(len(twins)), np.inf, 0.05 * size + np.abs(off[twins]))
    return size * standard_lengths + np.clip(off, -most, most)


def given_back(given, rows, swapped, turn, origin, scale, upright, moved, std, failing, to_model, spread):
    """A corrected posture in the recording's joints and axes."""
    here = (scale * moved @ turn + origin) @ upright
    old = np.where((to_model >= 0)[:, None], given[to_model], np.nan)
    seen = np.isfinite(rows).all(axis=1)
    placed = given + spread @ np.where(seen[:, None], np.nan_to_num(here - old), 0.0)
    have = to_model >= 0
    placed[to_model[have]] = here[have] if (seen & have).any() else np.nan
    trust = np.where(seen & ~swapped, 1.0 - failing, 0.0)
    share = np.abs(spread)
    whole = np.isfinite(given).all(axis=1)
    return placed, share @ std * scale, np.where(whole, np.clip(share @ trust, 0.0, 1.0), 0.0)
