"""Plain NumPy twins of correction's kernels: slow, short, and plainly right."""

import numpy as np

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
