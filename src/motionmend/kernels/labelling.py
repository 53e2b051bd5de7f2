"""Two tracks and two labels: the likeliest path of who bears which, by beam search."""

from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled


@compiled
def likeliest_path(
    frame: Ints,
    place: Floats,
    velocity: Floats,
    moving: Bools,
    odds: Floats,
    price: Floats,
    ends: float,
    forbidden: Bools,
    horizons: Floats,
    rest: Floats,
    share: Floats,
    fastest: float,
    law: tuple[float, float, float],
    kept: int,
    hopeless: float,
) -> Any:
    """Log posterior of the likeliest path that is not swapped where that is forbidden, and where it is swapped.

    The state remembers where each track was last seen, so that a track is followed from stretch to stretch across its
    gaps under every hypothesis.

    Parameters
    ----------
    frame : (2, K, 2) frames in which each of K stretches first (0) and last (1) shows either label, -1 = never.
    place : (2, K, 2, 3) m there.
    velocity : (2, K, 2, 3) m a frame.
    moving : (2, K, 2) whether that is known.
    odds : (K,) log odds of a stretch being swapped.
    price : (K,) log prior of a change of labels as the stretch begins; the first one's is that of the start.
    ends : log prior of labels that are swapped to the end.
    forbidden : (K,) True where they may not be.
    horizons, rest, share, fastest : how well a track can be followed, as `Continuity` has them.
    law : of a step's error: degrees of freedom of Student's t, the log of its constant and that of the density of steps
        that are neither motion nor swap.
    kept : paths followed at a time.
    hopeless : log odds behind the best at which one is given up.

    Returns
    -------
    score : float.
    swapped : (K,) bool.

    Source
    ------
    Viterbi, Error bounds for convolutional codes, IEEE Transactions on Information Theory 13(2), 1967, with the
    hopeless states left out.
    """
    count = len(odds)
    lines, followed = (frame, place, velocity, moving), (np.log(horizons), np.log(rest), share, fastest, law)
    parent, sides = np.zeros((count, kept), dtype=np.int64), np.zeros((count, kept), dtype=np.bool_)
    # a state: swapped or not, and the stretch and label, 2 k + label, under which either track was last seen
    swapped, last, score = np.zeros(kept, dtype=np.bool_), np.full((kept, 2), -1), np.zeros(kept)
    there, seen, total = np.zeros(2 * kept, dtype=np.bool_), np.full((2 * kept, 2), -1), np.zeros(2 * kept)
    came, node = np.zeros(2 * kept, dtype=np.int64), np.zeros(2, dtype=np.int64)
    front = 1
    for k in range(count):
        reached = 0
        for state in range(front):
            for side in range(1 if forbidden[k] else 2):
                steps = 0.0
                for track in range(2):
                    label = 1 - track if side else track
                    node[track] = last[state, track]
                    if frame[0, k, label] >= 0:
                        if node[track] >= 0:
                            steps += _goes_on(node[track], 2 * k + label, lines, followed)
                        node[track] = 2 * k + label
                gain = (odds[k] if side else 0.0) + (price[k] if (side == 1) != swapped[state] else 0.0)
                here = score[state] + gain + steps
                at = 0
                while at < reached and not (
                    there[at] == (side == 1) and seen[at, 0] == node[0] and seen[at, 1] == node[1]
                ):
                    at += 1
                if at == reached:
                    there[at], total[at] = side == 1, -np.inf
                    seen[at, 0], seen[at, 1] = node[0], node[1]
                    reached += 1
                if here > total[at]:
                    total[at], came[at] = here, state
        front, most = 0, total[:reached].max()
        while front < min(kept, reached):
            at = int(np.argmax(total[:reached]))
            if total[at] < most - hopeless:
                break
            swapped[front], score[front] = there[at], total[at]
            last[front, 0], last[front, 1] = seen[at, 0], seen[at, 1]
            parent[k, front], sides[k, front] = came[at], there[at]
            total[at] = -np.inf
            front += 1
    best = 0
    for state in range(front):
        # A swap has two ends: one that lasts to the last frame is as rare as one from the first.
        score[state] += ends if swapped[state] else 0.0
        if score[state] > score[best]:
            best = state
    path, state = np.zeros(count, dtype=np.bool_), best
    for k in range(count - 1, -1, -1):
        path[k] = sides[k, state]
        state = parent[k, state]
    return score[best], path


@compiled
def log_densities(
    error: Floats,
    way: Floats,
    sides: Ints,
    frames: Ints,
    horizons: Floats,
    rest: Floats,
    share: Floats,
    fastest: float,
    law: tuple[float, float, float],
) -> Any:
    """Log density (per m³) of N steps of a track, and how much of it is lost to the error, <= 0.

    Parameters
    ----------
    error : (N,) m, between what both sides say of the middle. way : (N,) m, gone meanwhile.
    sides : (N,) how many of them have a velocity. frames : (N,) of the steps.
    horizons, rest, share, fastest, law : as in `likeliest_path`.

    Returns
    -------
    density, lost : (N,).
    """
    followed = np.log(horizons), np.log(rest), share, fastest, law
    density, lost = np.empty(len(error)), np.empty(len(error))
    for n in range(len(error)):
        density[n], lost[n] = _density(error[n] * error[n], way[n], sides[n], frames[n], followed)
    return density, lost


@compiled
def _goes_on(
    node: int,
    after: int,
    lines: tuple[Ints, Floats, Floats, Bools],
    followed: tuple[Floats, Floats, Floats, float, tuple[float, float, float]],
) -> float:
    """Log density (per m³) of a track that ends in one stretch under one label and goes on in another."""
    frame, place, velocity, moving = lines
    k, label, then, other = node // 2, node % 2, after // 2, after % 2
    frames = frame[0, then, other] - frame[1, k, label]
    sides = int(moving[1, k, label]) + int(moving[0, then, other])
    error, left, gone = 0.0, 0.0, 0.0
    for i in range(3):
        one, two = velocity[1, k, label, i], velocity[0, then, other, i]
        off = place[1, k, label, i] + (one + two) / max(sides, 1) * frames - place[0, then, other, i]
        error += off * off
        left += one * one
        gone += two * two
    way = (np.sqrt(left) + np.sqrt(gone)) / max(sides, 1) * frames
    return float(_density(error, way, sides, frames, followed)[0])


@compiled
def _density(
    square: float,
    way: float,
    sides: int,
    frames: int,
    followed: tuple[Floats, Floats, Floats, float, tuple[float, float, float]],
) -> tuple[float, float]:
    """Log density of a step with a squared error in m², and how much of it is lost to that."""
    horizons, rest, share, fastest, (tail, constant, strange) = followed  # of horizons and rest the logarithms
    at, right = np.log(frames), 0
    while right < len(horizons) and horizons[right] < at:
        right += 1
    if right == 0 or right == len(horizons):
        edge = min(right, len(horizons) - 1)
        still, part = np.exp(rest[sides, edge]), share[sides, edge]
    else:
        t = (at - horizons[right - 1]) / (horizons[right] - horizons[right - 1])
        still = np.exp((1.0 - t) * rest[sides, right - 1] + t * rest[sides, right])
        part = (1.0 - t) * share[sides, right - 1] + t * share[sides, right]
    moved = part * min(way, fastest * frames)
    scale = (still * still + moved * moved) * np.exp(2.0 * max(at - horizons[-1], 0.0))
    lost = -0.5 * (tail + 3.0) * np.log1p(square / (tail * scale))
    usual = constant - 1.5 * np.log(scale) + lost
    return max(usual, strange) + np.log1p(np.exp(-abs(usual - strange))), lost
