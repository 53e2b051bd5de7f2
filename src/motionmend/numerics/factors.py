"""A vector of many coordinates that a few factors explain, followed over time while some of it is hidden.

    y_j(t) = mean_j + B_j z(t) + noise_j,    each z_k a Matern-3/2 process

Groups j of P coordinates (joints) are seen or not, with any weight between. The process is exact for any step of time.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats, frozen
from ..kernels import factors as kernel


@dataclass(frozen=True, eq=False)
class Factors:
    """A linear model of a posture.

    Attributes
    ----------
    mean : (J, P).
    loadings : (J, P, K).
    rates : (K,) 1/s, how fast each factor (of variance 1) changes.
    noise : (J,) variance of each coordinate that the factors leave open.
    """

    mean: Floats
    loadings: Floats
    rates: Floats
    noise: Floats

    def __post_init__(self) -> None:
        for name in ("mean", "loadings", "rates", "noise"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def count(self) -> int:
        """K, the number of factors."""
        return len(self.rates)


@dataclass(frozen=True, eq=False)
class Belief:
    """What is believed of the factors and their speeds: mean (2K,), covariance (2K, 2K)."""

    mean: Floats
    cov: Floats


def fit_factors(samples: Floats, steps: Floats, seconds: Floats, share: float = 0.995, most: int = 24) -> Factors:
    """Factors by principal components; their rates by how far they go in a step.

    Parameters
    ----------
    samples : (N, J, P) complete.
    steps : (M, J, P) differences between samples that follow each other.
    seconds : (M,) s, the time between them.
    share : of the variance that the factors explain.
    most : factors at most.
    """
    flat = samples.reshape(len(samples), -1)
    mean = flat.mean(axis=0)
    cov = np.cov(flat - mean, rowvar=False) if len(flat) > 1 else np.eye(flat.shape[1])
    values, vectors = np.linalg.eigh(np.atleast_2d(cov))
    values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    total = max(float(values.sum()), 1e-12)
    count = int(np.clip(np.searchsorted(np.cumsum(values) / total, share) + 1, 1, min(most, len(values))))
    values, vectors = np.maximum(values[:count], 1e-9 * total), vectors[:, :count]
    left = np.maximum(np.diag(cov) - (vectors**2 @ values), 0.0).reshape(samples.shape[1:]).mean(axis=1)
    rates = np.full(count, 3.0)
    if len(steps):
        speed = (steps.reshape(len(steps), -1) @ vectors) / seconds[:, None]
        rates = np.sqrt(np.maximum((speed**2).mean(axis=0) / values, 0.05))
    return Factors(
        mean.reshape(samples.shape[1:]),
        (vectors * np.sqrt(values)).reshape(*samples.shape[1:], count),
        rates,
        left + 1e-6 * total / len(mean),
    )


def start(factors: Factors) -> Belief:
    """What is believed before anything is seen."""
    return Belief(np.zeros(2 * factors.count), np.diag(np.concatenate([np.ones(factors.count), factors.rates**2])))


def transition(factors: Factors, seconds: float) -> Floats:
    """(2K, 2K) matrix of the Matern-3/2 process over a time.

    Source
    ------
    Hartikainen and Sarkka, Kalman filtering and smoothing solutions to temporal Gaussian process regression, 2010.
    """
    rate, count = factors.rates, factors.count
    decay = np.exp(-rate * seconds)
    matrix = np.zeros((2 * count, 2 * count))
    k = np.arange(count)
    matrix[k, k] = decay * (1.0 + rate * seconds)
    matrix[k, k + count] = decay * seconds
    matrix[k + count, k] = -decay * rate**2 * seconds
    matrix[k + count, k + count] = decay * (1.0 - rate * seconds)
    return matrix


def ahead(factors: Factors, belief: Belief, seconds: float) -> Belief:
    """The belief after a time without looking."""
    return Belief(*kernel.ahead(belief.mean, belief.cov, factors.rates, seconds))


def seen(factors: Factors, belief: Belief, values: Floats, precision: Floats) -> Belief:
    """The belief after looking at some groups.

    Parameters
    ----------
    values : (J, P) deviations from the mean; where `precision` is 0 anything finite.
    precision : (J,) one over the variance of what is seen; 0 = not seen.
    """
    return Belief(*kernel.seen(factors.loadings, belief.mean, belief.cov, values, precision))


def expected(factors: Factors, belief: Belief) -> tuple[Floats, Floats]:
    """Deviations from the mean (J, P) that the factors make, and the covariance (J, P, P) of each group's."""
    values, covs = kernel.expected(factors.loadings, belief.mean, belief.cov)
    return values, covs


def forecast(factors: Factors, belief: Belief, seconds: float) -> tuple[Belief, tuple[Floats, Floats]]:
    """The belief after a time without looking, and what is then `expected`."""
    mean, cov, values, covs = kernel.forecast(factors.loadings, belief.mean, belief.cov, factors.rates, seconds)
    return Belief(mean, cov), (values, covs)


def left_out(rest: Floats, cov: Floats, noise: Floats, precision: Floats) -> tuple[Floats, Floats]:
    """How far each group is from where all the others and the past expect it.

    Parameters
    ----------
    rest, cov : values less what is expected (J, 3) and the covariance (J, 3, 3), as `expected` gives them.
    noise : (J,) variance of a coordinate that the factors leave open.
    precision : (J,) with which each group was seen.

    Returns
    -------
    distance (J,) by Mahalanobis, and volume (J,), the logarithm of the determinant of the covariance.
    """
    far, volume = kernel.left_out(rest, cov, noise.copy(), precision)  # as who follows a person hands it on
    return far, volume


def backward(factors: Factors, later: Belief, here: Belief, seconds: float) -> Belief:
    """The belief at a frame once the whole recording is known, from that of the next frame (Rauch-Tung-Striebel)."""
    forecast = ahead(factors, here, seconds)
    matrix = transition(factors, seconds)
    gain = np.linalg.solve(forecast.cov, matrix @ here.cov).T
    cov = here.cov + gain @ (later.cov - forecast.cov) @ gain.T
    return Belief(here.mean + gain @ (later.mean - forecast.mean), 0.5 * (cov + cov.T))
