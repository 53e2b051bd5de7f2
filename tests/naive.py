"""Plain NumPy twins of the kernels: slow, short, and plainly right. One section per kernel module."""

import numpy as np

# ---- kernels/chain.py ------------------------------------------------------------


def rotation_about(axis, angle):
    """Rodrigues' formula: 4x4 transform that turns by `angle` about the unit vector `axis`."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    transform = np.eye(4)
    transform[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return transform


def translation_along(vector):
    """4x4 transform that moves by `vector`."""
    transform = np.eye(4)
    transform[:3, 3] = vector
    return transform


def chain_transforms(skeleton, q):
    """T_parent · Trans(offset) · D_1 · D_2 ··· for each joint: q (D,) to (J, 4, 4)."""
    transforms = np.empty((len(skeleton.names), 4, 4))
    for j, parent in enumerate(skeleton.parents):
        transform = np.eye(4) if parent < 0 else transforms[parent]
        transform = transform @ translation_along(skeleton.offsets[j])
        for d in np.flatnonzero(skeleton.dof_joint == j):
            if skeleton.dof_kind[d] == 0:
                transform = transform @ rotation_about(skeleton.dof_axis[d], q[d])
            else:
                transform = transform @ translation_along(skeleton.dof_axis[d] * q[d])
        transforms[j] = transform
    return transforms


def chain_forward(skeleton, q):
    """q (T, D) to positions (T, J, 3) and rotations (T, J, 3, 3)."""
    transforms = np.array([chain_transforms(skeleton, row) for row in q])
    transforms = transforms.reshape(len(q), len(skeleton.names), 4, 4)
    return transforms[..., :3, 3], transforms[..., :3, :3]


def chain_jacobian(skeleton, q, step=1e-6):
    """Central finite differences of the positions: q (D,) to (J, 3, D)."""
    columns = []
    for d in range(len(q)):
        ahead, behind = q.copy(), q.copy()
        ahead[d] += step
        behind[d] -= step
        difference = chain_transforms(skeleton, ahead) - chain_transforms(skeleton, behind)
        columns.append(difference[:, :3, 3] / (2 * step))
    return np.stack(columns, axis=-1) if columns else np.zeros((len(skeleton.names), 3, 0))


def trajectory_matrix(series, window):
    """(S, M * C): every lag window as a row, time-major (eq. 2.1-2.2)."""
    return np.stack([series[s : s + window].ravel() for s in range(len(series) - window + 1)])


def project(series, bases, starts):
    """(S, K): c_s = E^T z_s, one dot product at a time (eq. 2.13)."""
    window = bases.shape[1]
    return np.array([[(series[s : s + window] * basis).sum() for basis in bases] for s in starts])


def overlap_add(coefficients, bases, starts, frames):
    """(T, C): the windows' reconstructions laid over each other."""
    window, channels = bases.shape[1:]
    total = np.zeros((frames, channels))
    for start, row in zip(starts, coefficients, strict=True):
        for weight, basis in zip(row, bases, strict=True):
            total[start : start + window] += weight * basis
    return total


def window_cost(z, y, mean, bases, starts, rho, scale, prior_weight):
    """Eq. 2.16 with the coefficients at their best for z, term by term."""
    seen = np.isfinite(y)
    cost = rho(np.where(seen, z - np.where(seen, y, 0.0), 0.0), scale)[seen].sum()
    window = len(mean)
    for start in starts:
        piece = z[start : start + window] - mean
        c = np.array([(piece * basis).sum() for basis in bases])
        rebuilt = sum(weight * basis for weight, basis in zip(c, bases, strict=True))
        cost += prior_weight * np.square(piece - rebuilt).sum()
    return cost


def alternate(y, start, mean, bases, starts, weight, scale, prior_weight, iterations):
    """The plain alternation of section 2.2.4: closed-form coefficients, then one re-weighted motion update."""
    seen = np.isfinite(y)
    known = np.where(seen, y, 0.0)
    z = start.copy()
    window = len(mean)
    for _ in range(iterations):
        total, count = np.zeros_like(z), np.zeros(len(z))
        for s in starts:
            piece = z[s : s + window] - mean
            rebuilt = mean + sum((piece * basis).sum() * basis for basis in bases)
            total[s : s + window] += rebuilt
            count[s : s + window] += 1
        w = seen * weight(z - known, scale)
        z = (w * known + 2 * prior_weight * total) / (w + 2 * prior_weight * count[:, None])
    return z


# ---- numerics/smoother.py, numerics/walk.py ---------------------------------------


def kalman_smooth(model, observed, noise_var):
    """The textbook's filter and Rauch-Tung-Striebel smoother with inverses: means (T, N), covariances (T, N, N)."""
    A, Q, H = model.transition, model.process_cov, model.observation
    predicted, filtered = [], []
    mean, cov = model.start_mean, model.start_cov
    for y, r in zip(observed, np.broadcast_to(noise_var, observed.shape), strict=True):
        predicted.append((mean, cov))
        seen = np.isfinite(y)
        if seen.any():
            innovation_cov = H[seen] @ cov @ H[seen].T + np.diag(r[seen])
            gain = cov @ H[seen].T @ np.linalg.inv(innovation_cov)
            mean = mean + gain @ (y[seen] - H[seen] @ mean)
            cov = cov - gain @ H[seen] @ cov
        filtered.append((mean, cov))
        mean, cov = A @ mean, A @ cov @ A.T + Q
    smoothed = [filtered[-1]]
    for (mean, cov), (ahead, ahead_cov) in zip(filtered[-2::-1], predicted[:0:-1], strict=True):
        gain = cov @ A.T @ np.linalg.inv(ahead_cov)
        later, later_cov = smoothed[-1]
        smoothed.append((mean + gain @ (later - ahead), cov + gain @ (later_cov - ahead_cov) @ gain.T))
    means, covariances = zip(*smoothed[::-1], strict=True)
    return np.array(means), np.array(covariances)


def batch_smooth(model, observed, noise_var):
    """All states at once from their joint Gaussian: means (T, N), covariances (T, N, N), log-likelihood."""
    A, Q, H = model.transition, model.process_cov, model.observation
    frames, n = len(observed), len(A)
    spread = np.broadcast_to(noise_var, observed.shape)
    joint, means = np.zeros((frames, n, frames, n)), np.empty((frames, n))
    mean, cov = model.start_mean, model.start_cov
    for t in range(frames):
        means[t], crossing = mean, cov
        for s in range(t, frames):
            joint[s, :, t, :], joint[t, :, s, :] = crossing, crossing.T
            crossing = A @ crossing
        mean, cov = A @ mean, A @ cov @ A.T + Q
    joint, prior = joint.reshape(frames * n, frames * n), means.ravel()
    seen = np.isfinite(observed).ravel()
    rows = np.kron(np.eye(frames), H)[seen]
    data_cov = rows @ joint @ rows.T + np.diag(spread.ravel()[seen])
    surprise = observed.ravel()[seen] - rows @ prior
    gain = joint @ rows.T @ np.linalg.inv(data_cov)
    posterior = (joint - gain @ rows @ joint).reshape(frames, n, frames, n)
    log_likelihood = -0.5 * (
        surprise @ np.linalg.solve(data_cov, surprise)
        + np.linalg.slogdet(data_cov)[1]
        + len(surprise) * np.log(2 * np.pi)
    )
    each = np.arange(frames)
    return (prior + gain @ surprise).reshape(frames, n), posterior[each, :, each, :], log_likelihood


def smooth_walk(observed, step_var, noise_var):
    """One random walk with an unknown start by weighted least squares over all its states: mean (T,), variance (T,)."""
    seen = np.isfinite(observed)
    steps = np.diff(np.eye(len(observed)), axis=0)
    information = np.diag(np.where(seen, 1.0 / noise_var, 0.0)) + steps.T @ steps / step_var
    cov = np.linalg.inv(information)
    return cov @ np.where(seen, observed / noise_var, 0.0), np.diag(cov)


# ---- kernels/banded.py -------------------------------------------------------------


def walk_system(weight, stiffness):
    """diag(weight) + D₂ᵀ diag(stiffness) D₂ of one walk, dense: (T,), (T,) to (T, T)."""
    bends = np.diff(np.eye(len(weight)), n=2, axis=0)
    return np.diag(weight) + bends.T @ np.diag(stiffness[2:]) @ bends


def walk_certainty(weight, step_var, place_var, speed_var):
    """One walk written out as a sum of its start, its speed and its steps, given all samples at once.

    z(t) = z(0) + t v(0) + sum over s of (t - s + 1) e(s); variance (T,) of z and (T,) of e as a share of step_var.
    """
    t = np.arange(len(weight))
    build = np.hstack([np.ones((len(t), 1)), t[:, None], np.maximum(t[:, None] - t[1:] + 1, 0)])
    cov = np.diag(np.concatenate([[place_var, speed_var], step_var[1:]]))
    seen = weight > 0
    rows = build[seen]
    gain = cov @ rows.T @ np.linalg.inv(rows @ cov @ rows.T + np.diag(1.0 / weight[seen]))
    cov = cov - gain @ rows @ cov
    doubt = np.concatenate([[1.0], np.diag(cov)[2:] / step_var[1:]])
    return np.diag(build @ cov @ build.T), doubt


# ---- kernels/search.py -------------------------------------------------------------


def _normal(surprise, var):
    return -0.5 * (np.log(2 * np.pi * var) + surprise**2 / var)


def _told(state, row, value, var):
    """One coordinate's (mean, covariance) once `row` times its state is told, and the log-likelihood of that."""
    mean, cov = state
    row = np.array(row)
    across = cov @ row
    spread, off = across @ row + var, value - mean @ row
    gain = across / spread[..., None]
    told = mean + gain * off[..., None], cov - gain[..., :, None] * across[..., None, :]
    return told, _normal(off, spread)


def history_turns(case, t, last, after_outlier):
    """What may happen at frame t after mode `last`: pairs of mode and what the sample is.

    "in": a measurement, "anywhere": an outlier, "held": one that is off by as much as the one before.
    """
    if not np.isfinite(case["observed"][t]).all():
        return [(0, "in")]
    modes = range(1 if t == 0 else len(case["factors"]))
    turns = [(k, "in") for k in modes]
    if not case["vouched"][t]:
        turns.append((0 if t == 0 else last, "anywhere"))
        turns += [(k, "held") for k in modes if after_outlier]
    return turns


def history_step(case, states, t, last, mode, kind, after_outlier):
    """The states of all coordinates after frame t, by the textbook's Kalman filter, and what the frame adds.

    A state is the mean and covariance of place, speed and how far off the latest outlier was; of many histories that
    take the same turn their states may be given one behind the other.
    """
    score = 0.0 if t == 0 or case["at_pole"][t] else case["log_modes"][last, mode]
    seen = np.isfinite(case["observed"][t]).all()
    after = []
    for g, state in enumerate(states):
        if t > 0:
            moves, step = np.array([[1.0, 1, 0], [0, 1, 0], [0, 0, 1]]), case["step_var"][t, g] * case["factors"][mode]
            pull, shaken = case["pull"][t, g] * np.array([1.0, 1, 0]), np.outer([1.0, 1, 0], [1.0, 1, 0])
            state = state[0] @ moves.T + pull, moves @ state[1] @ moves.T + step * shaken
        if np.isfinite(case["hint_var"][t, g]):
            state, gained = _told(state, [1.0, 0, 0], case["hint"][t, g], case["hint_var"][t, g])
            score += gained
        if seen and kind != "anywhere":
            row = [1.0, 0, 1] if kind == "held" else [1.0, 0, 0]
            state, gained = _told(state, row, case["observed"][t, g], case["noise_var"][t, g])
            score += gained
        elif seen:  # nothing was known of how far off it is
            mean, cov = state
            less = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
            noise = np.diag([0.0, 0.0, case["noise_var"][t, g]])
            state = mean @ less.T + [0.0, 0.0, case["observed"][t, g]], less @ cov @ less.T + noise
        after.append(state)
    if seen:
        rate, held = case["outlier_rate"], 0.0
        if after_outlier is not None:  # enters as often as it leaves
            follow = case["outlier_follow"]
            rate = follow if after_outlier else rate * (1 - follow) / (1 - rate)
            held = case["outlier_held"] if after_outlier else 0.0
        chance = {"in": 1 - rate, "anywhere": rate * (1 - held) * case["outlier_density"], "held": rate * held}
        score += np.log(chance[kind])
    return after, score


def history_start(case):
    """The states before frame 0."""
    return [
        (np.array([place, 0.0, 0.0]), np.diag([place_var, speed_var, 0.0]))
        for place, place_var, speed_var in zip(case["start"], case["start_var"], case["speed_var"], strict=True)
    ]


def all_histories(case):
    """(score, modes, rejected) of every history there is."""
    begun = [tuple(one[None] for one in state) for state in history_start(case)]
    groups = [(np.zeros(1), [()], [()], begun)]  # of histories that may take the same turns
    for t in range(len(case["observed"])):
        seen = [n for n in range(t) if np.isfinite(case["observed"][n]).all()]
        longer = {}
        for scores, modes, rejects, states in groups:
            last = modes[0][-1] if t else 0
            after_outlier = rejects[0][seen[-1]] if seen else None
            for mode, kind in history_turns(case, t, last, after_outlier):
                after, gained = history_step(case, states, t, last, mode, kind, after_outlier)
                out = kind != "in"
                latest = (mode, out if np.isfinite(case["observed"][t]).all() else after_outlier)
                turned = scores + gained, [(*one, mode) for one in modes], [(*one, out) for one in rejects], after
                longer.setdefault(latest, []).append(turned)
        groups = [
            (
                np.concatenate([one[0] for one in same]),
                [history for one in same for history in one[1]],
                [history for one in same for history in one[2]],
                [
                    tuple(map(np.concatenate, zip(*of, strict=True)))
                    for of in zip(*(one[3] for one in same), strict=True)
                ],
            )
            for same in longer.values()
        ]
    return [one for scores, modes, rejects, _ in groups for one in zip(scores.tolist(), modes, rejects, strict=True)]


def beam_of_histories(case, width, recent):
    """(score, modes, rejected) of the best history when only `width` that differ in `recent` turns are kept."""
    kept = [(0.0, (), (), (), history_start(case))]
    for t in range(len(case["observed"])):
        seen = np.isfinite(case["observed"][t]).all()
        best = {}
        for score, modes, rejects, turns, states in kept:
            last = modes[-1] if modes else 0
            after_outlier = turns[-1] == "out" if turns else None
            for mode, kind in history_turns(case, t, last, after_outlier):
                after, gained = history_step(case, states, t, last, mode, kind, after_outlier)
                # either kind of outlier is one turn
                turn = "out" if kind != "in" else "calm" if mode == 0 else "lively"
                latest = (*turns, turn)[-recent:] if seen else turns
                if latest not in best or score + gained > best[latest][0]:
                    best[latest] = (score + gained, (*modes, mode), (*rejects, kind != "in"), latest, after)
        kept = sorted(best.values(), key=lambda history: -history[0])[:width]
    return kept[0][:3]


# ---- denoise/rivals/classic.py -----------------------------------------------------------


def gaussian(values, fps):
    """Weighted mean of the samples within half a window of 11/30 s, weights of a Gaussian a sixth as wide."""
    half = round((11 / 30 * fps - 1) / 2)
    smooth = np.empty(values.shape)
    for t in range(len(values)):
        near = np.arange(max(0, t - half), min(len(values), t + half + 1))
        weights = np.exp(-0.5 * ((near - t) / fps / (11 / 180)) ** 2)
        smooth[t] = weights @ values[near] / weights.sum()
    return smooth
