"""Second-order walks in time: the pentadiagonal systems they make, and what their smoother is sure of."""

import numpy as np

from ..arrays import Floats
from .compile import compiled

LEAST_PIVOT = 1e-11  # of a diagonal element: closer to nothing it is rounding, and turns what it divides away
PRECISION = 1e-15  # of a variance that another is taken from; no smaller difference is one


@compiled
def walk_factors(weight: Floats, stiffness: Floats) -> tuple[Floats, Floats, Floats]:
    """L and D of L D Lᵀ = diag(weight) + D₂ᵀ diag(stiffness) D₂ for N walks, D₂ the second differences of T frames.

    Parameters
    ----------
    weight : (T, N) above 0, or not below 0 where two samples of each walk are above.
    stiffness : (T, N) above 0, of the second difference into each frame; rows 0 and 1 are not used.

    Returns
    -------
    diagonal, first, second : (T, N) of D, and of the two diagonals below that of L.
    """
    frames, walks = weight.shape
    diagonal, first, second = np.empty((frames, walks)), np.zeros((frames, walks)), np.zeros((frames, walks))
    for t in range(frames):
        for n in range(walks):
            into = stiffness[t, n] if t >= 2 else 0.0
            over = stiffness[t + 1, n] if 1 <= t < frames - 1 else 0.0
            out = stiffness[t + 2, n] if t < frames - 2 else 0.0
            d = weight[t, n] + into + 4.0 * over + out
            least = LEAST_PIVOT * d  # rounding may leave nothing of a walk that hardly any sample holds
            one, two = -2.0 * over - 2.0 * into, 0.0
            if t >= 2:
                two = into / diagonal[t - 2, n]
                one -= two * diagonal[t - 2, n] * first[t - 1, n]
                d -= two * two * diagonal[t - 2, n]
            if t >= 1:
                one /= diagonal[t - 1, n]
                d -= one * one * diagonal[t - 1, n]
            d = max(d, least)
            diagonal[t, n], first[t, n], second[t, n] = d, one, two
    return diagonal, first, second


@compiled
def solve_walks(diagonal: Floats, first: Floats, second: Floats, right: Floats) -> Floats:
    """(T, N) x with L D Lᵀ x = right, of the factors of `walk_factors`."""
    frames, walks = right.shape
    x = right.copy()
    for t in range(1, frames):
        if t == 1:
            for n in range(walks):
                x[t, n] -= first[t, n] * x[t - 1, n]
        else:
            for n in range(walks):
                x[t, n] -= first[t, n] * x[t - 1, n] + second[t, n] * x[t - 2, n]
    for t in range(frames - 1, -1, -1):
        if t + 2 < frames:
            for n in range(walks):
                x[t, n] = x[t, n] / diagonal[t, n] - first[t + 1, n] * x[t + 1, n] - second[t + 2, n] * x[t + 2, n]
        elif t + 1 < frames:
            for n in range(walks):
                x[t, n] = x[t, n] / diagonal[t, n] - first[t + 1, n] * x[t + 1, n]
        else:
            for n in range(walks):
                x[t, n] /= diagonal[t, n]
    return x


@compiled
def walk_certainty(weight: Floats, step_var: Floats, place_var: Floats, speed_var: Floats) -> tuple[Floats, Floats]:
    """How sure a smoother of second-order walks is; nothing but the weights of the samples is needed.

    Parameters
    ----------
    weight : (T, C) inverse variance of each sample, 0 = missing.
    step_var : (T, C) variance of the step e into each frame (those of frame 0 are not used).
    place_var, speed_var : (C,) of the state at frame 0 before anything is seen.

    Returns
    -------
    variance : (T, C) of the smoothed walk.
    doubt : (T, C) variance of e given all samples, as a share of `step_var`; 1 = the samples tell nothing of it.

    Source
    ------
    de Jong, Smoothing and interpolation with the state-space model, J. American Statistical Association 84, 1989.
    """
    frames, channels = weight.shape
    # of each frame, before its sample is seen, the variance of the place and its covariance with the speed; then what
    # is asked for
    variance, doubt = np.empty((frames, channels)), np.empty((frames, channels))
    place, both, pace = place_var.copy(), np.zeros(channels), speed_var.copy()
    for t in range(frames):
        for ch in range(channels):  # walks side by side: each waits for its own divisions only
            a, b, c, w = place[ch], both[ch], pace[ch], weight[t, ch]
            if t > 0:
                e = step_var[t, ch]
                a, b, c = max(a + 2.0 * b + c, 0.0) + e, b + c + e, c + e
            variance[t, ch], doubt[t, ch] = a, b
            # a divided, not a less what is known: beside a free step and a sure sample the difference would be lost
            one = 1.0 / (1.0 + a * w)
            a, b, c = a * one, b * one, max(c - w * one * b * b, 0.0)
            place[ch], both[ch], pace[ch] = a, b, c
    n00, n01, n11 = np.zeros(channels), np.zeros(channels), np.zeros(channels)  # what later samples know of the state
    for t in range(frames - 1, -1, -1):
        for ch in range(channels):
            a, b, w = variance[t, ch], doubt[t, ch], weight[t, ch]
            m00, m01, m11 = n00[ch], n00[ch] + n01[ch], n00[ch] + 2.0 * n01[ch] + n11[ch]
            one = 1.0 / (1.0 + a * w)
            gain, other = w * one, -b * w * one
            a, b = a * one, b * one
            left = a - (a * a * m00 + 2.0 * a * b * m01 + b * b * m11)
            variance[t, ch] = max(left, PRECISION * a)
            k00 = one * one * m00 + 2.0 * one * other * m01 + other * other * m11 + gain
            k01 = one * m01 + other * m11
            n00[ch], n01[ch], n11[ch] = k00, k01, m11
            told = 1.0 - step_var[t, ch] * (k00 + 2.0 * k01 + m11)
            doubt[t, ch] = min(1.0, max(1e-3, told)) if t > 0 else 1.0
    return variance, doubt


@compiled
def bend_forward(x: Floats, scale: Floats) -> Floats:
    """(T - 2, N) second differences of x (T, N), each times the `scale` (T, N) of the frame it leads into."""
    frames, walks = x.shape
    bend = np.empty((frames - 2, walks))
    for t in range(2, frames):
        for n in range(walks):
            bend[t - 2, n] = (x[t - 2, n] - 2.0 * x[t - 1, n] + x[t, n]) * scale[t, n]
    return bend


@compiled
def bend_back(x: Floats, weight: Floats, bend: Floats, scale: Floats) -> Floats:
    """(T, N) weight x + D₂ᵀ (scale bend): what is left of `bend_forward`, transposed, and the samples' share."""
    frames, walks = x.shape
    back = np.empty((frames, walks))
    for t in range(frames):
        for n in range(walks):
            back[t, n] = weight[t, n] * x[t, n]
        if t < frames - 2:
            for n in range(walks):
                back[t, n] += bend[t, n] * scale[t + 2, n]
        if 1 <= t < frames - 1:
            for n in range(walks):
                back[t, n] -= 2.0 * (bend[t - 1, n] * scale[t + 1, n])
        if t >= 2:
            for n in range(walks):
                back[t, n] += bend[t - 2, n] * scale[t, n]
    return back


@compiled
def step_along(x: Floats, residual: Floats, direction: Floats, turned: Floats, length: float) -> None:
    """One step of conjugate gradients in place: x along the direction, the residual along what it is turned into."""
    for t in range(x.shape[0]):
        for n in range(x.shape[1]):
            x[t, n] += length * direction[t, n]
            residual[t, n] -= length * turned[t, n]
