"""Medians of the frames about each, and of points in space; squares of which large ones count less."""

import numpy as np

from ..arrays import Floats
from .compile import compiled


@compiled
def running_median(values: Floats, span: int) -> Floats:
    """(C, T) median of the `span` frames, odd, about each; near an end that of the outermost `span`.

    Parameters
    ----------
    values : (C, T), finite; T >= span.
    span : frames.
    """
    channels, frames = values.shape
    half = span // 2
    found, ordered = np.empty(values.shape), np.empty(span)
    for c in range(channels):
        for t in range(frames):
            one, place = values[c, t], t
            if t >= span:  # there is room where the one that leaves was
                gone, place = values[c, t - span], 0
                after = span
                while place < after:
                    between = (place + after) // 2
                    if ordered[between] < gone:
                        place = between + 1
                    else:
                        after = between
                while place < span - 1 and ordered[place + 1] < one:
                    ordered[place] = ordered[place + 1]
                    place += 1
            while place > 0 and ordered[place - 1] > one:
                ordered[place] = ordered[place - 1]
                place -= 1
            ordered[place] = one
            if t >= span - 1:
                found[c, t - half] = ordered[half]
        for t in range(half):
            found[c, t], found[c, frames - 1 - t] = found[c, half], found[c, frames - 1 - half]
    return found


@compiled
def geometric_medians(points: Floats, rounds: int, least: float) -> Floats:
    """(N, 3), the one of least distance to all K finite of (N, K, 3) in sum; NaN if none is.

    Parameters
    ----------
    points : (N, K, 3), each finite as a whole or not at all.
    rounds : of Weiszfeld's iteration.
    least : no point counts as nearer than this.

    Source
    ------
    Weiszfeld, Sur le point pour lequel la somme des distances de n points donnes est minimum, Tohoku Mathematical
    Journal 43, 1937.
    """
    groups, count = points.shape[0], points.shape[1]
    found, some = np.full((groups, 3), np.nan), np.empty((count, 3))
    for n in range(groups):
        known = 0
        x, y, z = 0.0, 0.0, 0.0
        for k in range(count):
            if np.isfinite(points[n, k, 0] + points[n, k, 1] + points[n, k, 2]):
                for i in range(3):
                    some[known, i] = points[n, k, i]
                x, y, z, known = x + some[known, 0], y + some[known, 1], z + some[known, 2], known + 1
        if known == 0:
            continue
        x, y, z = x / known, y / known, z / known
        for _ in range(rounds):
            total, sum_x, sum_y, sum_z = 0.0, 0.0, 0.0, 0.0
            for k in range(known):
                u, v, w = some[k, 0] - x, some[k, 1] - y, some[k, 2] - z
                worth = 1.0 / max(np.sqrt(u * u + v * v + w * w), least)
                total += worth
                sum_x, sum_y, sum_z = sum_x + worth * some[k, 0], sum_y + worth * some[k, 1], sum_z + worth * some[k, 2]
            x, y, z = sum_x / total, sum_y / total, sum_z / total
        found[n, 0], found[n, 1], found[n, 2] = x, y, z
    return found


@compiled
def student_squares(square: Floats, scale: Floats, tails: float) -> Floats:
    """(C,) sum of squares (N, C), each over what it says of Student's distribution: square / (tails + square / scale).

    Parameters
    ----------
    square : (N, C).
    scale : (C,) squares of the distribution's scale.
    tails : its degrees of freedom.
    """
    total = np.zeros(square.shape[1])
    for n in range(square.shape[0]):
        for c in range(square.shape[1]):
            total[c] += square[n, c] / (tails + square[n, c] / scale[c])
    return total
