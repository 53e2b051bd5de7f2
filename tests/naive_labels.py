"""Who bears which of two labels, in plain NumPy: every path is tried."""

from itertools import pairwise, product

import numpy as np


def likeliest_path(
    frame, place, velocity, moving, odds, price, ends, forbidden, horizons, rest, share, fastest, law, kept, hopeless
):
    """The best of all paths, and where it is swapped; of those given up on the way none is the best."""
    paths = [path for path in product((False, True), repeat=len(odds)) if not (np.array(path) & forbidden).any()]
    scores = [0.0] * len(paths)
    for number, path in enumerate(paths):
        score = float(odds[list(path)].sum())
        score += sum(price[k] for k, (was, now) in enumerate(zip((False, *path), path, strict=False)) if was != now)
        score += ends if path[-1] else 0.0
        for track in range(2):
            labels = [(k, track ^ swapped) for k, swapped in enumerate(path)]
            seen = [(k, label) for k, label in labels if frame[0, k, label] >= 0]
            for before, after in pairwise(seen):
                left, right = (
                    (frame[end][at], place[end][at], velocity[end][at], bool(moving[end][at]))
                    for end, at in ((1, before), (0, after))
                )
                score += _goes_on(left, right, horizons, rest, share, fastest, law)
        scores[number] = score
    best = int(np.argmax(scores))
    return scores[best], np.array(paths[best])


def _goes_on(left, right, horizons, rest, share, fastest, law):
    frames = right[0] - left[0]
    sides = left[3] + right[3]
    velocity = (left[2] + right[2]) / max(sides, 1)
    error = np.linalg.norm(left[1] + velocity * frames - right[1])
    speed = (np.linalg.norm(left[2]) + np.linalg.norm(right[2])) / max(sides, 1)
    return log_density(error, speed * frames, sides, frames, horizons, rest, share, fastest, law)


def log_density(error, way, sides, frames, horizons, rest, share, fastest, law):
    """Of one step, with a scale that grows with the way and beyond the longest horizon."""
    still = np.exp(np.interp(np.log(frames), np.log(horizons), np.log(rest[sides])))
    part = np.interp(np.log(frames), np.log(horizons), share[sides])
    scale = np.hypot(still, part * min(way, fastest * frames)) * max(frames / horizons[-1], 1.0)
    tail, constant, strange = law
    usual = constant - 3.0 * np.log(scale) - 0.5 * (tail + 3.0) * np.log1p((error / scale) ** 2 / tail)
    return np.logaddexp(usual, strange)
