"""Smooth functions of time: minimum-jerk steps, quintic pieces, slow random drift."""

import numpy as np

from ..arrays import Floats


def step(x: Floats | float) -> Floats:
    """From 0 at x <= 0 to 1 at x >= 1 with no velocity and no acceleration at either end.

    Source: Flash and Hogan, J. Neurosci. 5 (1985) 1688-1703, eq. 3: the path of least jerk from rest to rest.
    """
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (6.0 * x - 15.0)))


def bump(x: Floats, start: float, rise: float, fall: float, end: float) -> Floats:
    """0 outside [start, end], 1 in [rise, fall], minimum-jerk flanks between."""
    return np.asarray(step((x - start) / (rise - start)) * (1.0 - step((x - fall) / (end - fall))))


def quintic(x: Floats, duration: float, begin: Floats, end: Floats) -> Floats:
    """The fifth-degree polynomial between two states.

    Parameters
    ----------
    x : (N,) s since the beginning, 0 to `duration`.
    duration : s.
    begin, end : (3, ...) value, velocity and acceleration at each end.

    Returns
    -------
    (N, ...) values.
    """
    u = (x / duration).reshape(-1, *([1] * (np.ndim(begin) - 1)))
    scale = np.array([1.0, duration, duration**2]).reshape(3, *([1] * (np.ndim(begin) - 1)))
    (p0, v0, a0), (p1, v1, a1) = begin * scale, end * scale
    d = p1 - p0
    return np.asarray(
        p0
        + u * v0
        + u**2 * a0 / 2
        + u**3 * (10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1)
        + u**4 * (-15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1)
        + u**5 * (6 * d - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1)
    )


def drift(rng: np.random.Generator, t: Floats, spacing: float, size: float, count: int = 1) -> Floats:
    """Slow random curves: cubic splines through independent normal knots.

    Parameters
    ----------
    rng : the source of the knots.
    t : (N,) s, increasing.
    spacing : s between knots.
    size : standard deviation of a knot, in the unit wanted.
    count : how many curves.

    Returns
    -------
    (N, count)
    """
    from scipy.interpolate import CubicSpline

    knots = np.arange(t[0] - 2 * spacing, t[-1] + 3 * spacing, spacing)
    return np.asarray(CubicSpline(knots, size * rng.standard_normal((knots.size, count)))(t))


def through(t: Floats, times: Floats, states: Floats) -> Floats:
    """Quintic pieces through given states, constant before the first and after the last.

    Parameters
    ----------
    t : (N,) s.
    times : (K,) s, increasing.
    states : (K, 3, ...) value, velocity and acceleration at each; the first and the last at rest.

    Returns
    -------
    (N, ...) values with continuous acceleration.
    """
    piece = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    values = np.empty((len(t), *states.shape[2:]))
    for k in range(len(times) - 1):
        here = piece == k
        lasts = float(times[k + 1] - times[k])
        values[here] = quintic(np.clip(t[here] - times[k], 0.0, lasts), lasts, states[k], states[k + 1])
    return values
