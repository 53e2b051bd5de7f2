"""Plain twins of the kernels of the coupled smoother."""

from itertools import pairwise

import numpy as np


def bend_forward(x, scale):
    """Second differences, each times the scale of the frame it leads into."""
    return np.diff(x, n=2, axis=0) * scale[2:]


def bend_back(x, weight, bend, scale):
    """The samples' share and the transpose of `bend_forward`, by a dense matrix."""
    bends = np.diff(np.eye(len(x)), n=2, axis=0)
    return weight * x + bends.T @ (bend * scale[2:])


def step_along(x, residual, direction, turned, length):
    """Both after a step."""
    return x + length * direction, residual - length * turned


def gap_system(products, frame, channel, frames, band):
    """Lower bands by the dense second derivatives over all samples."""
    channels = products.shape[2]
    dense = np.zeros((frames, channels, frames, channels))
    for t in range(2, frames):
        for k in range(3):
            for last in range(3):
                dense[t - k, :, t - last] += products[k, last]
    own = dense[frame, channel][:, frame, channel]
    lower = np.zeros((band, len(frame)))
    for below in range(min(band, len(frame))):
        lower[below, : len(frame) - below] = np.diagonal(own, -below)
    return lower


def gap_spread(lower, frame, channel, frames, channels):
    """Variances of missing samples, and covariances of what is missing 0 to 2 frames back, summed over frames."""
    below = np.zeros((len(frame), len(frame)))
    for down, band in enumerate(lower):
        below += np.diag(band[: len(frame) - down], -down) if down < len(frame) else 0.0
    inverse = np.linalg.inv(below + np.tril(below, -1).T)
    everywhere = np.zeros((frames, channels, frames, channels))
    for one, (t, c) in enumerate(zip(frame, channel, strict=True)):
        everywhere[t, c, frame, channel] = inverse[one]
    back = range(3)
    products = [[sum(everywhere[t - k, :, t - m] for t in range(2, frames)) for m in back] for k in back]
    return np.diag(inverse), np.array(products)


def steadiest(triples, turns, centre, hold):
    """Viterbi's path through the branches of all frames, one matrix of steps a frame."""
    branches = (triples[:, :, None] + turns).reshape(len(triples), -1, 3)
    away = np.abs(branches - centre).sum(axis=2)
    away = (away - away.min(axis=1, keepdims=True)) / hold
    cost, came = away[0], []
    for t in range(1, len(branches)):
        through = cost[:, None] + np.abs(branches[t - 1][:, None] - branches[t]).sum(axis=2)
        came.append(through.argmin(axis=0))
        cost = through.min(axis=0) + away[t]
    path = [int(cost.argmin())]
    for back in reversed(came):
        path.append(int(back[path[-1]]))
    return np.array(path[::-1])


def best_turn(points, weights, shape):
    """Kabsch: place (3,) and rotation (3, 3) that take weighted points (A, 3) of a shape to where they are seen."""
    place = weights @ points
    left, _, right = np.linalg.svd((points - place).T @ (weights[:, None] * (shape - weights @ shape)))
    return place, left * np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right


def running_median(values, span):
    """Median of the span frames about each of (T, C); near an end that of the outermost."""
    half = span // 2
    first = np.clip(np.arange(len(values)) - half, 0, len(values) - span)
    return np.array([np.median(values[start : start + span], axis=0) for start in first])


def geometric_median(points, rounds, least):
    """Weiszfeld's iteration over the finite of points (K, 3)."""
    known = points[np.isfinite(points).all(axis=1)]
    if not len(known):
        return np.full(3, np.nan)
    middle = known.mean(axis=0)
    for _ in range(rounds):
        worth = 1.0 / np.maximum(np.linalg.norm(known - middle, axis=1), least)
        middle = worth @ known / worth.sum()
    return middle


def moments_alike(one, other, clip, clips, frame, frames, edges, reach, linear, near, own_linear, own_near, lasting):
    """Covariance of moments, pair by pair."""
    found = np.zeros((len(one), len(other)))
    for i, j in np.ndindex(found.shape):
        same = clip[i] == clips[j]
        for g, (a, b) in enumerate(pairwise(edges)):
            bell = np.exp(-0.5 * np.square(one[i, a:b] - other[j, a:b]).sum() / reach[g] ** 2)
            found[i, j] += (linear[g] + same * own_linear[g]) * (one[i, a:b] @ other[j, a:b])
            found[i, j] += (near[g] + same * own_near[g]) * bell
        if clip[i] == 0 and clips[j] == 0:
            found[i, j] += lasting[abs(frame[i] - frames[j])]
    return found


def student_squares(square, scale, tails):
    """(C,) sums over the rows of squares (N, C), each over the degrees of freedom and what it is of its scale (C,)."""
    return [sum(one / (tails + one / own) for one in column) for column, own in zip(square.T, scale, strict=True)]
