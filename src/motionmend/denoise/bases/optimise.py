"""The robust fit of filter bases to a recording's channels: eq. 2.8-2.16 of the dissertation."""

from dataclasses import dataclass

import numpy as np

from ...arrays import Floats, Ints
from ...numerics.robust import ESTIMATORS
from ...numerics.ssa import Eigenbases

SCALE = 3.0  # p of eq. 2.9, in channel units: degrees and centimetres
PRIOR_WEIGHT = 0.1  # lambda of eq. 2.10
TOLERANCE = 1e-3  # relative change of the cost at which the iteration ends
MOST_ITERATIONS = 200


@dataclass(frozen=True, eq=False)
class Fit:
    """A minimum of eq. 2.16 and how it was found.

    Attributes
    ----------
    values : (T, C) z, the filtered channels.
    weights : (T, C) robust weight of each sample, 0 where missing.
    cost : (iterations + 1,) the objective at the start and after each iteration; never increases.
    iterations, converged : of the alternation.
    """

    values: Floats
    weights: Floats
    cost: Floats
    iterations: int
    converged: bool


def window_starts(frames: int, window: int, stride: int) -> Ints:
    """(S,) first frames of the sliding windows; the last window always ends with the recording."""
    starts = np.arange(0, frames - window + 1, stride)
    if starts[-1] != frames - window:
        starts = np.append(starts, frames - window)
    return starts.astype(np.int64)


def fit_windows(
    measured: Floats,
    start: Floats,
    bases: Eigenbases,
    stride: int = 1,
    *,
    robust: str = "welsch",
    scale: float = SCALE,
    prior_weight: float = PRIOR_WEIGHT,
    tolerance: float = TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
) -> Fit:
    """Minimise eq. 2.16 over the filtered motion z and the coefficients c of all sliding windows.

    Each iteration makes the two updates of section 2.2.4: the closed-form coefficients (eq. 2.13) and one step of
    iteratively re-weighted least squares for the motion (eq. 2.15). Their joint effect on z is a step down the
    gradient, scaled by the curvature of each sample; consecutive steps are made conjugate and their length is
    exact, which reaches the same minimum in fewer iterations, above all where samples are missing. Since the
    weighted squares lie above rho and touch it at the present residual, the cost cannot rise.

    The dissertation writes the data term of eq. 2.15 as w r²; with rho of eq. 2.9 the squares that touch eq. 2.14
    are w r² / 2, and these are used: with them the cost of eq. 2.11 falls at every step.

    Parameters
    ----------
    measured : (T, C) y in degrees and centimetres, NaN = missing (alpha = 0).
    start : (T, C) finite start for z; the dissertation takes y.
    bases : patterns at the rate of `measured`; at most T frames long.
    stride : frames between neighbouring windows.
    robust : a name of `ESTIMATORS`.
    scale : p, in channel units.
    prior_weight : lambda.
    tolerance : relative change of cost that ends the iteration.
    most_iterations : at most so many.

    Returns
    -------
    The minimum found and its cost trace.

    Source
    ------
    Section 2.2.3-2.2.5, eq. 2.8-2.16.
    """
    from ...kernels.lagged import coverage, overlap_add, project

    rho, weight = ESTIMATORS[robust].rho, ESTIMATORS[robust].weight
    frames = len(measured)
    starts = window_starts(frames, bases.window, stride)
    alpha = np.isfinite(measured).astype(float)  # eq. 2.16
    centre = bases.mean.mean(axis=0)
    y = np.where(alpha > 0, measured - centre, 0.0)
    z = np.ascontiguousarray(start - centre)
    vectors = np.ascontiguousarray(bases.vectors)
    covered = coverage(starts, bases.window, frames)[:, None]
    mean = (bases.mean - centre)[None]
    ones = np.ones((len(starts), 1))
    mean_sum = overlap_add(ones, mean, starts, frames)  # what the mean window adds to each frame
    mean_square = len(starts) * float(np.square(mean).sum())
    mean_coefficients = np.tensordot(vectors, mean[0], axes=2)

    def prior_cost(z: Floats, c: Floats) -> float:
        # sum over s of |z_s - mean - E c_s|², the bases being orthonormal (eq. 2.12)
        away = (covered * z * z).sum() - 2.0 * (mean_sum * z).sum() + mean_square
        return max(float(away - np.square(c).sum()), 0.0)

    c = project(z, vectors, starts) - mean_coefficients  # eq. 2.13
    rebuilt = overlap_add(c, vectors, starts, frames) + mean_sum
    residual = z - y
    cost = [float((alpha * rho(residual, scale)).sum()) + prior_weight * prior_cost(z, c)]
    direction = np.zeros_like(z)
    descent_before = 0.0
    step_before = np.zeros_like(z)
    converged = False
    while len(cost) <= most_iterations and not converged:
        w = alpha * weight(residual, scale)  # eq. 2.15
        curvature = w + 2.0 * prior_weight * covered
        slope = w * residual + 2.0 * prior_weight * (covered * z - rebuilt)
        step = -slope / curvature  # eq. 2.15: the minimum over z with the coefficients kept
        descent = float(-(slope * step).sum())
        turn = max(0.0, float(-(slope * (step - step_before)).sum()) / descent_before) if descent_before else 0.0
        direction = step + turn * direction
        if float((slope * direction).sum()) >= 0.0:
            direction = step
        c_step = project(np.ascontiguousarray(direction), vectors, starts)
        # the second derivative of the touching squares along the direction
        bend = (curvature * direction * direction).sum() - 2.0 * prior_weight * np.square(c_step).sum()
        if not bend > 0.0:
            converged = True
            break
        length = float(-(slope * direction).sum() / bend)
        z = z + length * direction
        c = c + length * c_step
        rebuilt = rebuilt + length * overlap_add(c_step, vectors, starts, frames)
        residual = z - y
        descent_before, step_before = descent, step
        cost.append(float((alpha * rho(residual, scale)).sum()) + prior_weight * prior_cost(z, c))
        converged = cost[-2] - cost[-1] <= tolerance * max(cost[-2], 1e-12)
    weights = alpha * weight(residual, scale)
    return Fit(z + centre, weights, np.array(cost), len(cost) - 1, converged)
