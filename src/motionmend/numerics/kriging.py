"""Universal kriging: values as a sum of Gaussian processes whose shares are found by restricted likelihood.

    y ~ N(mean, sum_p theta_p K_p + theta_noise I)

The K_p are known up to their amplitudes, so that finding them is a problem of variance components. A mean that is not
known (universal kriging) is a component of its own with a variance so large that any mean is as likely as another.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dtrtrs
from scipy.optimize import minimize

from ..arrays import Floats, Ints

_JITTER = 1e-9  # of the values' variance
_PULL = 0.02  # towards the start, per squared natural logarithm: decides only what the data leave open
_LEAST_LOG, _MOST_LOG = -14.0, 9.0  # how far an amplitude may go from its start


@dataclass(frozen=True, eq=False)
class Prediction:
    """What is known of values at new points.

    Attributes
    ----------
    mean : (N', D).
    variance : (N',), the same for all D.
    """

    mean: Floats
    variance: Floats


def likeliest_amplitudes(parts: Floats, base: Floats, values: Floats, start: Floats, iterations: int) -> Floats:
    """Amplitudes of covariance components, by restricted maximum likelihood.

    Parameters
    ----------
    parts : (P, N, N) covariance components of amplitude 1; the last is the noise.
    base : (N, N) covariance that is there whatever the amplitudes: that of unknown means.
    values : (N, D), D independent draws with the same covariance.
    start : (P,) above 0.
    iterations : of L-BFGS.

    Returns
    -------
    (P,) above 0.

    Source
    ------
    Patterson and Thompson, Recovery of inter-block information when block sizes are unequal, Biometrika 58(3), 1971;
    the gradient as in Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, equation 5.9.
    """
    count, draws = values.shape
    flat = parts.reshape(len(parts), -1)
    halves = _halves(parts).reshape(len(parts), -1)
    origin = np.log(start)
    floor = _JITTER * max(float(np.square(values).mean()), 1e-30)
    diagonal = np.diag_indices(count)

    def cost(log_amplitudes: Floats) -> tuple[float, Floats]:
        amplitudes = np.exp(log_amplitudes)
        cov = (amplitudes @ flat).reshape(count, count).T  # symmetric: as LAPACK lays it out
        cov += base.T
        cov[diagonal] += floor
        root, failed = dpotrf(cov, lower=1, overwrite_a=1)
        if failed:
            return 1e12, np.zeros(len(start))
        weights, _ = dpotrs(root, values, lower=1)
        volume = float(np.log(root.diagonal()).sum())
        inverse, _ = dpotri(root, lower=1, overwrite_c=1)  # its lower half; above it stands nothing
        slope = amplitudes * (halves @ (draws * inverse.T - weights @ weights.T).ravel())
        moved = log_amplitudes - origin
        fit = 0.5 * float((values * weights).sum()) + draws * volume
        return fit + _PULL * float(moved @ moved), slope + 2.0 * _PULL * moved

    bounds = list(zip(origin + _LEAST_LOG, origin + _MOST_LOG, strict=True))
    found = minimize(cost, origin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": iterations})
    return np.asarray(np.exp(found.x))


def _halves(parts: Floats) -> Floats:
    """(P, N, N) upper halves of symmetric components, of the diagonal half: a trace of products needs no more."""
    upper = np.triu(parts)
    diagonal = np.arange(parts.shape[1])
    upper[:, diagonal, diagonal] *= 0.5
    return upper


def krige(cov: Floats, cross: Floats, prior: Floats, values: Floats) -> Prediction:
    """Values at N' new points.

    Parameters
    ----------
    cov : (N, N) covariance of the known values, noise included.
    cross : (N', N) covariance of the new values with the known ones.
    prior : (N',) variance of the new values before anything is known, their noise included.
    values : (N, D) known values.

    Source
    ------
    Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, algorithm 2.1.
    """
    root = rooted(cov)
    halves, _ = dtrtrs(root, cross.T, lower=1)
    known, _ = dtrtrs(root, values, lower=1)
    return Prediction(halves.T @ known, np.maximum(prior - np.square(halves).sum(axis=0), 0.0))


def left_out(cov: Floats, values: Floats, groups: list[Ints]) -> Prediction:
    """Each group of values predicted from all others.

    Parameters
    ----------
    cov : (N, N) covariance of the values, noise included.
    values : (N, D).
    groups : rows of each group; together all rows, each once.

    Source
    ------
    Rasmussen and Williams, 2006, section 5.4.2, for groups instead of single values.
    """
    inverse, _ = dpotri(rooted(cov), lower=1)
    inverse = np.tril(inverse) + np.tril(inverse, -1).T
    weights = inverse @ values
    mean, variance = np.empty_like(values), np.empty(len(values))
    for rows in groups:
        inner = np.linalg.inv(inverse[np.ix_(rows, rows)])
        mean[rows] = values[rows] - inner @ weights[rows]
        variance[rows] = inner.diagonal()
    return Prediction(mean, variance)


def rooted(cov: Floats) -> Floats:
    """Lower Cholesky factor (N, N); a covariance that rounding made indefinite gets as little noise as it needs."""
    extra = 0.0
    for _ in range(12):
        root, failed = dpotrf(cov + extra * np.eye(len(cov)) if extra else cov, lower=1)
        if not failed:
            return np.asarray(root)
        extra = max(10.0 * extra, 1e-12 * float(cov.diagonal().max()))
    raise np.linalg.LinAlgError("a covariance must be positive semi-definite")


def matern52(distance: Floats, scale: float) -> Floats:
    """Correlation of a process with two derivatives."""
    r = distance * (np.sqrt(5.0) / scale)
    return np.asarray((1.0 + r + r * r / 3.0) * np.exp(-r))


def matern32(distance: Floats, scale: float) -> Floats:
    """Correlation of a process with one derivative."""
    r = distance * (np.sqrt(3.0) / scale)
    return np.asarray((1.0 + r) * np.exp(-r))


def squared_distances(one: Floats, other: Floats) -> Floats:
    """(N, N') squared distances between rows (N, F) and (N', F)."""
    found = np.square(one).sum(axis=1)[:, None] + np.square(other).sum(axis=1) - 2.0 * one @ other.T
    return np.asarray(np.maximum(found, 0.0))
