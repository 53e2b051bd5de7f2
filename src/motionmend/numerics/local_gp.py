"""Gaussian processes on small sets of samples, and many of them side by side: a local mixture.

Paper symbols live here: theta0, theta1, W, beta of eq. 5; Q local models of at most S samples, the L most similar of
which answer. Inputs and outputs come from outside in whatever units make distances comparable.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_solve
from scipy.optimize import minimize

from ..arrays import Floats, Ints, frozen
from ..kernels import mixture

LOG_BOUNDS = ((-12.0, 6.0), (-12.0, 6.0), (-9.0, 9.0), (-12.0, 4.0))  # of theta0, theta1, W, 1 / beta


class Hyper(NamedTuple):
    """The parameters of eq. 5: signal variance, bias variance, inverse squared length, noise variance."""

    signal: float
    bias: float
    width: float
    noise: float


@dataclass(frozen=True, eq=False)
class Mixture:
    """Local GPs of J outputs' groups (joints), each group with Q models of at most S samples in D inputs, P outputs.

    Attributes
    ----------
    centres : (J, Q, D) means of the models' inputs; NaN where a model is not used.
    inputs : (J, Q, S, D), unused inputs of a narrower group are zero in every sample.
    outputs : (J, Q, S, P).
    factors : (J, Q, S, S) lower Cholesky factors of the covariances of eq. 5.
    weights : (J, Q, S, P) the prediction vectors alpha of eq. 8.
    counts : (J, Q) samples in use.
    hyper : (J, Q, 4) as in `Hyper`.
    """

    centres: Floats
    inputs: Floats
    outputs: Floats
    factors: Floats
    weights: Floats
    counts: Ints
    hyper: Floats

    def __post_init__(self) -> None:
        for name in ("centres", "inputs", "outputs", "factors", "weights", "hyper"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        object.__setattr__(self, "counts", frozen(self.counts, np.int64))


def covariance(a: Floats, b: Floats, hyper: Hyper) -> Floats:
    """(N, M) covariance of the function at `a` (N, D) and `b` (M, D), without noise (eq. 5)."""
    return hyper.signal * np.exp(-0.5 * hyper.width * _squares(a, b)) + hyper.bias


def log_likelihood(inputs: Floats, outputs: Floats, log_hyper: Floats) -> tuple[float, Floats]:
    """Log marginal likelihood of eq. 6 summed over the outputs, and its gradient.

    Parameters
    ----------
    inputs : (N, D).
    outputs : (N, P), independent given the inputs, one covariance.
    log_hyper : (4,) logarithms of the parameters in the order of `Hyper`.

    Returns
    -------
    value, gradient (4,) with respect to the logarithms; minus infinity where the covariance is not positive definite.

    Source
    ------
    Rasmussen and Williams 2006, eq. 5.8 and 5.9.
    """
    return _likelihood(_squares(inputs, inputs), outputs, log_hyper)


def fit_hyper(inputs: Floats, outputs: Floats, start: Hyper | None = None, rounds: int = 40) -> Hyper:
    """The parameters that maximise the marginal likelihood (section 4.1).

    Parameters
    ----------
    inputs : (N, D), N >= 1.
    outputs : (N, P).
    start : where the search begins; a guess from the spread of the samples when None.
    rounds : at most so many iterations of L-BFGS.
    """
    squares = _squares(inputs, inputs)
    if start is None:
        spread = float(np.mean(squares)) or 1.0
        power = float(np.mean(outputs**2)) or 1e-6
        start = Hyper(0.5 * power, 0.5 * power, 2.0 / spread, 0.1 * power)
    low, high = np.array(LOG_BOUNDS).T
    power = np.log(max(float(np.mean(outputs**2)), 1e-12))  # the outputs' own unit
    shift = np.array([power, power, 0.0, power])

    def cost(free: Floats) -> tuple[float, Floats]:
        value, gradient = _likelihood(squares, outputs, free + shift)
        return (-value, -gradient) if np.isfinite(value) else (1e25, np.zeros(4))

    begin = np.clip(np.log(np.array(start)) - shift, low, high)
    found = minimize(cost, begin, jac=True, method="L-BFGS-B", bounds=list(LOG_BOUNDS), options={"maxiter": rounds})
    return Hyper(*(float(v) for v in np.exp(found.x + shift)))


def factor(inputs: Floats, hyper: Hyper) -> Floats:
    """(N, N) lower Cholesky factor of the noisy covariance of the samples (eq. 14)."""
    noisy = covariance(inputs, inputs, hyper)
    noisy[np.diag_indices(len(inputs))] += hyper.noise
    return np.asarray(np.linalg.cholesky(noisy), dtype=np.float64)


def budget(inputs: Floats, outputs: Floats, hyper: Hyper, keep: int, tolerance: float = 0.0) -> Ints:
    """Which samples are worth keeping: those whose loss would change the prediction at themselves most.

    Samples go one by one, always the one whose Kullback-Leibler divergence between the predictions with and without it
    is least (eq. 1-2, closed form for Gaussians), until `keep` are left or the least is above `tolerance`.

    Parameters
    ----------
    inputs : (N, D).
    outputs : (N, P).
    hyper : of eq. 5.
    keep : how many stay at least.
    tolerance : nats; a sample that matters more than this stays; 0 = only `keep` counts.

    Returns
    -------
    (K,) ascending indices of the samples kept.
    """
    kept = np.arange(len(inputs))
    lower = factor(inputs, hyper)
    precision = cho_solve((lower, True), np.eye(len(inputs)))
    weights = precision @ outputs
    while len(kept) > max(keep, 1):
        loss = divergences(precision, weights, hyper.noise)
        worst = int(np.argmin(loss))
        if tolerance > 0 and loss[worst] > tolerance:
            break
        column = precision[:, worst] / precision[worst, worst]
        stay = np.arange(len(kept)) != worst
        weights = (weights - np.outer(column, weights[worst]))[stay]
        precision = (precision - np.outer(column, precision[worst]))[np.ix_(stay, stay)]
        kept = kept[stay]
    return kept


def divergences(precision: Floats, weights: Floats, noise: float) -> Floats:
    """(N,) divergence of eq. 1 for each sample: the prediction at it with it, from the one without it.

    Parameters
    ----------
    precision : (N, N) inverse of the noisy covariance.
    weights : (N, P) prediction vectors.
    noise : variance.

    Source
    ------
    Leave-one-out predictions in closed form: Rasmussen and Williams 2006, eq. 5.12.
    """
    diagonal = np.diag(precision)
    without = 1.0 / diagonal
    within = np.maximum(2 * noise - noise**2 * diagonal, 1e-12 * without)  # predictive, its own sample known
    apart = weights * (noise - without[:, None])  # mean with the sample less mean without it
    ratio = within / without
    outputs = weights.shape[1]
    return np.asarray(0.5 * (outputs * (ratio - 1.0 - np.log(ratio)) + (apart**2).sum(axis=1) / without))


def fit_mixture(
    inputs: list[Floats],
    outputs: list[Floats],
    models: int = 30,
    size: int = 50,
    seed: int = 0,
    room: int = 0,
    rounds: int = 25,
) -> Mixture:
    """Local GPs for several joints (algorithm 1, offline).

    Parameters
    ----------
    inputs : one (N_j, D_j) per joint.
    outputs : one (N_j, P) per joint.
    models : Q, local models per joint; fewer where there are few samples.
    size : S, samples per model.
    seed : of the k-means start and of the thinning of large clusters.
    room : extra places per model for samples learned later.
    rounds : of the search for each model's parameters.
    """
    rng = np.random.default_rng(seed)
    joints, width = len(inputs), max(one.shape[1] for one in inputs)
    depth = outputs[0].shape[1]
    mixed = Mixture(
        np.full((joints, models, width), np.nan),
        np.zeros((joints, models, size + room, width)),
        np.zeros((joints, models, size + room, depth)),
        np.zeros((joints, models, size + room, size + room)),
        np.zeros((joints, models, size + room, depth)),
        np.zeros((joints, models), np.int64),
        np.ones((joints, models, 4)),
    )
    arrays = {name: np.array(getattr(mixed, name)) for name in mixed.__dataclass_fields__}
    for j in range(joints):
        if not len(inputs[j]):
            continue
        for q, members in enumerate(clusters(inputs[j], models, rng)):
            chosen = np.sort(rng.permutation(members)[:size])
            x = np.zeros((len(chosen), width))
            x[:, : inputs[j].shape[1]] = inputs[j][chosen]
            y = outputs[j][chosen]
            _put(arrays, j, q, x, y, fit_hyper(x, y, rounds=rounds))
    return Mixture(**arrays)


def clusters(inputs: Floats, count: int, rng: np.random.Generator, rounds: int = 15) -> list[Ints]:
    """k-means: the samples of each cluster that is not empty, by ascending index (section 4.2.1).

    Parameters
    ----------
    inputs : (N, D), N >= 1.
    count : Q, clusters wanted; never more than samples.
    rng : chooses the start (k-means++).
    rounds : at most so many of Lloyd's rounds.
    """
    count = min(count, len(inputs))
    centres = inputs[[int(rng.integers(len(inputs)))]]
    nearest = _squares(inputs, centres)[:, 0]
    while len(centres) < count and nearest.max() > 0:
        pick = inputs[rng.choice(len(inputs), p=nearest / nearest.sum())]
        centres = np.vstack([centres, pick])
        nearest = np.minimum(nearest, _squares(inputs, pick[None])[:, 0])
    owner = np.full(len(inputs), -1)
    for _ in range(rounds):
        now = np.argmin(_squares(inputs, centres), axis=1)
        if np.array_equal(now, owner):
            break
        owner = now
        for q in range(len(centres)):
            if (owner == q).any():
                centres[q] = inputs[owner == q].mean(axis=0)
    return [found for q in range(len(centres)) if len(found := np.flatnonzero(owner == q))]


def predict(mixed: Mixture, queries: Floats, nearest: int = 9) -> tuple[Floats, Floats]:
    """Mean and variance of the L most similar models, weighted by similarity (eq. 10-13), all joints in one call.

    Parameters
    ----------
    mixed : the fitted models.
    queries : (T, J, D), unused inputs zero.
    nearest : L.

    Returns
    -------
    mean (T, J, P) and variance (T, J) of the function, disagreement of the models included; a joint without models
    has mean 0 and infinite variance.
    """
    mean, variance = mixture.predict(
        mixed.centres,
        mixed.inputs,
        mixed.factors,
        mixed.weights,
        mixed.counts,
        mixed.hyper,
        np.ascontiguousarray(queries, dtype=np.float64),
        nearest,
    )
    return mean, variance


def model_of(mixed: Mixture, joint: int, q: int) -> tuple[Floats, Floats, Hyper]:
    """The samples (n, D), outputs (n, P) and parameters of one local model."""
    count = int(mixed.counts[joint, q])
    return (
        mixed.inputs[joint, q, :count],
        mixed.outputs[joint, q, :count],
        Hyper(*(float(v) for v in mixed.hyper[joint, q])),
    )


def _put(arrays: dict[str, Floats], j: int, q: int, x: Floats, y: Floats, hyper: Hyper) -> None:
    count = len(x)
    lower = factor(x, hyper)
    for name in ("inputs", "outputs", "factors", "weights"):
        arrays[name][j, q] = 0.0
    arrays["centres"][j, q] = x.mean(axis=0)
    arrays["inputs"][j, q, :count] = x
    arrays["outputs"][j, q, :count] = y
    arrays["factors"][j, q, :count, :count] = lower
    arrays["weights"][j, q, :count] = cho_solve((lower, True), y)
    arrays["counts"][j, q] = count
    arrays["hyper"][j, q] = hyper


def _squares(a: Floats, b: Floats) -> Floats:
    """(N, M) squared distances of the rows, never below zero."""
    return np.asarray(np.maximum((a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T, 0.0))


def _likelihood(squares: Floats, outputs: Floats, log_hyper: Floats) -> tuple[float, Floats]:
    signal, bias, width, noise = np.exp(log_hyper)
    count, depth = outputs.shape
    bell = signal * np.exp(-0.5 * width * squares)
    noisy = bell + bias
    noisy[np.diag_indices(count)] += noise
    try:
        lower = np.linalg.cholesky(noisy)
    except np.linalg.LinAlgError:
        return -np.inf, np.zeros(4)
    precision = cho_solve((lower, True), np.eye(count))
    weights = precision @ outputs
    value = (
        -0.5 * float(np.sum(outputs * weights))
        - depth * float(np.log(np.diag(lower)).sum())
        - 0.5 * count * depth * np.log(2 * np.pi)
    )
    inner = weights @ weights.T - depth * precision  # eq. 5.9: 1/2 tr(inner dK)
    gradient = 0.5 * np.array(
        [
            np.sum(inner * bell),
            bias * np.sum(inner),
            np.sum(inner * (-0.5 * width * squares * bell)),
            noise * np.trace(inner),
        ]
    )
    return value, gradient


def with_places(mixed: Mixture, models: int, room: int) -> Mixture:
    """The same models with `models` unused ones more per joint and `room` more places in each, for online learning."""

    def padded(values: Floats, grow: tuple[int, ...], fill: float) -> Floats:
        return np.pad(values, [(0, by) for by in grow], constant_values=fill)

    return replace(
        mixed,
        centres=padded(mixed.centres, (0, models, 0), np.nan),
        inputs=padded(mixed.inputs, (0, models, room, 0), 0.0),
        outputs=padded(mixed.outputs, (0, models, room, 0), 0.0),
        factors=padded(mixed.factors, (0, models, room, room), 0.0),
        weights=padded(mixed.weights, (0, models, room, 0), 0.0),
        counts=np.pad(mixed.counts, [(0, 0), (0, models)]),
        hyper=padded(mixed.hyper, (0, models, 0), 1.0),
    )
