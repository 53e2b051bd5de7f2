"""Plain twin of kernels/throwing.py."""

import numpy as np

from motionmend.kernels import throwing as kernel


def off_line(rows, last, earlier, seconds, before, noise):
    line = earlier + before / (before + seconds) * (rows - earlier)
    away = np.linalg.norm(last - line, axis=1)
    known = np.isfinite(away)
    limit = kernel.AWAY + 0.5 * kernel.SHARP * before * seconds + kernel.OFF * noise
    least = np.sort(away[known])
    found = least[kernel.SECOND] / kernel.SECOND_DEVIATION if len(least) > kernel.SECOND else np.nan
    return known & (away > limit), known, found


def along(rows, seconds, motion, noise):
    """Each joint's place and speed by a Kalman filter that is told the joint's place with a probability."""
    after, believed, strange = np.array(motion), np.zeros(len(rows)), np.ones(len(rows))
    step = np.array([[1.0, seconds], [0.0, 1.0]])
    push = np.array([0.5 * seconds**2, seconds]) * kernel.FORCE
    for j, row in enumerate(rows):
        there = np.isfinite(row).all()
        if not np.isfinite(motion[j, 0]):
            if there:
                after[j] = [*row, 0.0, 0.0, 0.0, noise**2, kernel.SPEED**2, 0.0]
                believed[j] = 1.0
            continue
        place, speed, both = motion[j, 6:]
        state = step @ motion[j, :6].reshape(2, 3)
        cov = step @ [[place, both], [both, speed]] @ step.T + np.outer(push, push)
        if there:
            off = row - state[0]
            near = cov[0, 0] + noise**2
            wide = near + max(kernel.TAIL, kernel.FARTHER * noise) ** 2
            likely = [np.exp(-0.5 * off @ off / one) / one**1.5 for one in (near, wide)]
            well = likely[0] * (1.0 - kernel.OFTEN)
            believed[j] = share = well / (well + likely[1] * kernel.OFTEN)
            strange[j] = off @ off / near / 3.0
            gain = cov[:, 0] / near
            state = state + share * np.outer(gain, off)
            doubt = share * (1.0 - share) * (off @ off) / 3.0
            cov = cov + np.outer(gain, gain) * (doubt - share * near)
        after[j] = [*state.ravel(), cov[0, 0], cov[1, 1], cov[0, 1]]
    return after, believed, strange
