"""Which samples of a channel are outliers: the likeliest of many histories, kept side by side.

A channel, or the three coordinates of a marker, moves as a second-order walk: z(t) = z(t-1) + v(t-1) + e(t),
v(t) = v(t-1) + e(t), e ~ N(pull(t), q(t) f(k)), with a factor f of the mode k: calm, burst or jump. Each sample is
either a measurement or an outlier: it lies anywhere and tells nothing, or it is off by as much as the outlier before it
and tells how the channel moves. Every history of modes and outliers is a Kalman filter of its own; after each frame the
best few of them that differ in their latest turns are kept.
"""

from math import log, pi
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bools, Bytes, Floats, Ints
from .compile import compiled

# Of a coordinate in a history: place, speed, and their covariance (place, place with speed, speed); and after an
# outlier how far off it was, its covariance with place and speed, and its variance
State: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]

RECENT = 4  # frames in which two histories have to differ to be kept side by side


@compiled
def likeliest_history(
    observed: Floats,
    hint: Floats,
    hint_var: Floats,
    pull: Floats,
    step_var: Floats,
    noise_var: Floats,
    outlier_rate: float,
    outlier_follow: float,
    outlier_density: float,
    outlier_held: float,
    factors: Floats,
    log_modes: Floats,
    width: int,
    start: Floats,
    start_var: Floats,
    speed_var: Floats,
    vouched: Bools,
    at_pole: Bools,
) -> tuple[Bytes, Bytes]:
    """Labels of the likeliest history of G coordinates that are outliers together. T frames, K modes.

    Parameters
    ----------
    observed : (T, G), NaN = missing.
    hint, hint_var : (T, G) what else is known of each value, and its variance; inf = nothing.
    pull, step_var : (T, G) mean and variance of e in the calm mode.
    noise_var : (T, G) of a measurement.
    outlier_rate : in (0, 1), of all samples.
    outlier_follow : in (0, 1), of the samples after an outlier; the rate itself where outliers come one by one.
    outlier_density : of an outlier, per unit to the power G.
    outlier_held : in (0, 1), of the outliers after an outlier, those off by as much as the one before.
    factors : (K,) f, of the variance of e in each mode; the first is 1.
    log_modes : (K, K) logarithm of the probability of the mode (column) after a mode (row).
    width : H, histories kept.
    start, start_var, speed_var : (G,) the state before the first frame, and the speed about 0.
    vouched : (T,) True where a sample is known to be no outlier.
    at_pole : (T,) True where every mode is as likely as any.

    Returns
    -------
    outlier : (T,) 1 where the likeliest history rejects the sample.
    mode : (T,) its modes.
    """
    frames, coordinates = observed.shape
    modes = len(factors)
    most = width * (2 * modes + 1) + 1
    state, after = np.zeros((width, coordinates, 9)), np.zeros((width, coordinates, 9))
    score, turns, mode_of = np.zeros(width), np.zeros(width, np.int64), np.zeros(width, np.int64)
    new_score, new_turns, new_mode = np.zeros(most), np.zeros(most, np.int64), np.zeros(most, np.int64)
    came_from, rejects = np.zeros(most, np.int64), np.zeros(most, np.int64)
    parent, event = np.zeros((frames, width), np.int16), np.zeros((frames, width), np.uint8)
    # A turn is 0 calm, 1 an outlier, 2 livelier; kinds of outliers, were they told apart, crowd out jumps that stay
    mask = (1 << (2 * RECENT)) - 1
    order, best_of = np.zeros(width, np.int64), np.full(mask + 1, -1)
    # outliers are a Markov chain: it enters as often as its share and how long it stays let it
    enters = min(outlier_rate * (1.0 - outlier_follow) / (1.0 - outlier_rate), 0.5)
    next_in, next_out = log(1.0 - enters), log(enters * outlier_density)
    first_in, first_out = log(1.0 - outlier_rate), log(outlier_rate * outlier_density)
    then_in = log(1.0 - outlier_follow)
    then_out = log(outlier_follow * (1.0 - outlier_held) * outlier_density)
    then_held = log(outlier_follow * outlier_held)
    kept, begun = 1, False
    for g in range(coordinates):
        state[0, g, 0], state[0, g, 2], state[0, g, 4] = start[g], start_var[g], speed_var[g]
    for t in range(frames):
        seen = True
        for g in range(coordinates):
            if np.isnan(observed[t, g]):
                seen = False
        # what each history can become, and how likely that is
        count = 0
        for h in range(kept):
            last = mode_of[h]
            log_in, log_out, off = next_in, next_out, False
            if not begun:
                log_in, log_out = first_in, first_out
            elif turns[h] & 3 == 1:  # the sample before was rejected
                log_in, log_out, off = then_in, then_out, True
            for k in range(modes if seen and t > 0 else 1):
                total = score[h]
                if t > 0 and not at_pole[t]:
                    total += log_modes[last, k]
                told_square, told_spread, seen_square, seen_spread, held_square, held_spread = _against(
                    state, h, t, factors[k], pull, step_var, hint, hint_var, observed, noise_var, seen, off
                )
                if not seen:
                    new_score[count] = total - 0.5 * (log(told_spread) + told_square)
                    new_turns[count], new_mode[count], came_from[count], rejects[count] = turns[h], k, h, 0
                    count += 1
                    continue
                if not vouched[t] and (k == last or t == 0):
                    # a sample that lies anywhere tells nothing of the mode: it stays
                    new_score[count] = total + log_out - 0.5 * (log(told_spread) + told_square)
                    new_turns[count], new_mode[count] = ((turns[h] << 2) | 1) & mask, k
                    came_from[count], rejects[count] = h, 1
                    count += 1
                if not vouched[t] and off:
                    new_score[count] = (
                        total + then_held - 0.5 * (log(told_spread * held_spread) + told_square + held_square)
                    )
                    new_turns[count], new_mode[count] = ((turns[h] << 2) | 1) & mask, k
                    came_from[count], rejects[count] = h, 2
                    count += 1
                new_score[count] = total + log_in - 0.5 * (log(told_spread * seen_spread) + told_square + seen_square)
                new_turns[count], new_mode[count] = ((turns[h] << 2) | (2 if k > 0 else 0)) & mask, k
                came_from[count], rejects[count] = h, 0
                count += 1
        begun = begun or seen
        kept = _best_that_differ(new_score, new_turns, count, width, order, best_of)
        # only their states are worked out
        best = new_score[order[0]]
        for i in range(kept):
            n = order[i]
            h = came_from[n]
            for g in range(coordinates):
                now = _of(state, h, g)
                if t > 0:
                    now = _moved(now, pull[t, g], step_var[t, g] * factors[new_mode[n]])
                if hint_var[t, g] < np.inf:
                    now = _told(now, hint[t, g], hint_var[t, g])
                if seen and rejects[n] == 0:
                    now = _measured(now, observed[t, g], noise_var[t, g])
                elif rejects[n] == 1:
                    now = _thrown(now, observed[t, g], noise_var[t, g])
                elif rejects[n] == 2:
                    now = _held(now, observed[t, g], noise_var[t, g])
                for m in range(9):
                    after[i, g, m] = now[m]
            parent[t, i], event[t, i] = h, 2 * new_mode[n] + min(rejects[n], 1)
        for i in range(kept):
            n = order[i]
            score[i], turns[i], mode_of[i] = new_score[n] - best, new_turns[n], new_mode[n]
        state, after = after, state
    return _traced(parent, event)


@compiled
def _against(
    states: Floats,
    h: int,
    t: int,
    factor: float,
    pull: Floats,
    step_var: Floats,
    hint: Floats,
    hint_var: Floats,
    observed: Floats,
    noise_var: Floats,
    seen: bool,
    off: bool,
) -> tuple[float, float, float, float, float, float]:
    """How far frame t is from what a history expects of it, should its steps be `factor` times as wide.

    Parameters
    ----------
    states : (H, G, 9) of the histories, after the frame before; h is the number of one.
    seen : whether the frame has samples. off : whether the one before was rejected.

    Returns
    -------
    The squared distance over its variance, and the product of 2 pi times the variances, of each of three: what the
    channels were told, what is measured, and what is if it is off by as much as before; 0 and 1 of what there is not.
    """
    told_square, told_spread, seen_square, seen_spread = 0.0, 1.0, 0.0, 1.0
    held_square, held_spread = 0.0, 1.0
    for g in range(states.shape[1]):
        x, a, o, d, f = states[h, g, 0], states[h, g, 2], states[h, g, 5], states[h, g, 6], states[h, g, 8]
        if t > 0:
            x += states[h, g, 1] + pull[t, g]
            a += 2.0 * states[h, g, 3] + states[h, g, 4] + step_var[t, g] * factor
            d += states[h, g, 7]
        if hint_var[t, g] < np.inf:
            s, r = a + hint_var[t, g], hint[t, g] - x
            told_spread *= 2.0 * pi * s
            s = 1.0 / s
            told_square += r * r * s
            x, a, o, d, f = x + a * s * r, a - a * a * s, o + d * s * r, d - a * d * s, f - d * d * s
        if seen:
            s, r = a + noise_var[t, g], observed[t, g] - x
            seen_square += r * r / s
            seen_spread *= 2.0 * pi * s
            if off:
                s, r = a + 2.0 * d + f + noise_var[t, g], r - o
                held_square += r * r / s
                held_spread *= 2.0 * pi * s
    return told_square, told_spread, seen_square, seen_spread, held_square, held_spread


@compiled
def _best_that_differ(score: Floats, turns: Ints, count: int, width: int, order: Ints, best: Ints) -> int:
    """How many of `count` histories are kept: the best `width` that differ in their latest turns, in `order`.

    `best` (4**RECENT,) has room for the best history of each turns, and is -1 throughout before and after.
    """
    for n in range(count):
        other = best[turns[n]]
        if other < 0 or score[n] > score[other]:
            best[turns[n]] = n
    kept = 0
    for n in range(count):
        if best[turns[n]] != n:
            continue
        best[turns[n]] = -1
        if kept < width:
            kept += 1
        elif score[n] <= score[order[width - 1]]:
            continue
        place = kept - 1
        while place > 0 and score[order[place - 1]] < score[n]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = n
    return kept


@compiled
def _of(state: Floats, h: int, g: int) -> State:
    """A coordinate's state in a history."""
    return (
        state[h, g, 0], state[h, g, 1], state[h, g, 2], state[h, g, 3], state[h, g, 4],
        state[h, g, 5], state[h, g, 6], state[h, g, 7], state[h, g, 8],
    )  # fmt: skip


@compiled
def _moved(state: State, pull: float, bend: float) -> State:
    """A state one frame on."""
    x, v, a, b, c, o, d, j, f = state
    return x + v + pull, v + pull, a + 2.0 * b + c + bend, b + c + bend, c + bend, o, d + j, j, f


@compiled
def _told(state: State, hint: float, hint_var: float) -> State:
    """A state that was told where the channel is."""
    x, v, a, b, c, o, d, j, f = state
    s, r = 1.0 / (a + hint_var), hint - x
    x, v, o = x + a * s * r, v + b * s * r, o + d * s * r
    d, j, f = d - a * d * s, j - b * d * s, f - d * d * s
    return x, v, a - a * a * s, b - a * b * s, c - b * b * s, o, d, j, f


@compiled
def _measured(state: State, observed: float, noise_var: float) -> State:
    """A state after a measurement; how far off outliers were no longer matters."""
    x, v, a, b, c, o, d, j, f = state
    s, r = 1.0 / (a + noise_var), observed - x
    return x + a * s * r, v + b * s * r, a - a * a * s, b - a * b * s, c - b * b * s, o, d, j, f


@compiled
def _thrown(state: State, observed: float, noise_var: float) -> State:
    """A state after an outlier that lies anywhere: it tells no more than how far off it is."""
    x, v, a, b, c, _, _, _, _ = state
    return x, v, a, b, c, observed - x, -a, -b, a + noise_var


@compiled
def _held(state: State, observed: float, noise_var: float) -> State:
    """A state after an outlier off by as much as the one before: place and distance together are measured."""
    x, v, a, b, c, o, d, j, f = state
    p, q, u = a + d, b + j, d + f
    s, r = 1.0 / (p + u + noise_var), observed - x - o
    x, v, o = x + p * s * r, v + q * s * r, o + u * s * r
    d, j, f = d - p * u * s, j - q * u * s, f - u * u * s
    return x, v, a - p * p * s, b - p * q * s, c - q * q * s, o, d, j, f


@compiled
def _traced(parent: NDArray[np.int16], event: Bytes) -> tuple[Bytes, Bytes]:
    """(T,) outliers and modes of the history that ends best, from its end back."""
    frames = len(parent)
    outlier, mode = np.zeros(frames, np.uint8), np.zeros(frames, np.uint8)
    history = 0
    for t in range(frames - 1, -1, -1):
        outlier[t], mode[t] = event[t, history] & 1, event[t, history] >> 1
        history = parent[t, history]
    return outlier, mode
