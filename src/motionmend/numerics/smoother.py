"""Kalman filter and Rauch-Tung-Striebel smoother for any linear-Gaussian model.

    x(t+1) = A x(t) + w(t),  w ~ N(0, Q)        y(t) = H x(t) + v(t),  v ~ N(0, diag(r(t)))        x(0) ~ N(m, P)

A missing observation is a NaN in y. Covariances are carried as roots B with BᵀB, and never formed as
differences, so they stay symmetric and positive however unlike the units of the states are.
"""

from dataclasses import dataclass
from math import log, pi

import numpy as np
from scipy.linalg.lapack import dgeqrf, dpotrf, dtrtrs

from ..arrays import Floats, Ints, frozen
from ..errors import MismatchError, UsageError

SETTLED = 1e-12
_CERTAIN = "a state is predicted without any doubt; give the start or the process noise some variance in every state"


@dataclass(frozen=True, eq=False)
class StateSpace:
    """A linear-Gaussian state-space model with N states and P observed values a frame.

    Attributes
    ----------
    transition : (N, N), A.
    process_cov : (N, N), Q, symmetric, positive semi-definite.
    observation : (P, N), H.
    start_mean : (N,), the state at frame 0 before anything is observed.
    start_cov : (N, N), its covariance, symmetric, positive definite.
    """

    transition: Floats
    process_cov: Floats
    observation: Floats
    start_mean: Floats
    start_cov: Floats

    def __post_init__(self) -> None:
        for name in ("transition", "process_cov", "observation", "start_mean", "start_cov"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        n = self.transition.shape[0]
        for name in ("transition", "process_cov", "start_cov"):
            if getattr(self, name).shape != (n, n):
                raise MismatchError(f"{name} of {n} states must be ({n}, {n}), came {getattr(self, name).shape}")
        if self.start_mean.shape != (n,) or self.observation.ndim != 2 or self.observation.shape[1] != n:
            raise MismatchError(
                f"{n} states need a start of ({n},) and an observation of (values, {n}), "
                f"came {self.start_mean.shape} and {self.observation.shape}"
            )


@dataclass(frozen=True, eq=False)
class Estimate:
    """States over time and what is known about them. T frames, N states, U distinct covariances.

    Attributes
    ----------
    mean : (T, N).
    covariances : (U, N, N); where the pattern of observations stays the same the recursion settles, so U is
        often far below T.
    which : (T,) row of `covariances` that holds at each frame.
    log_likelihood : of all observations under the model, natural logarithm.
    """

    mean: Floats
    covariances: Floats
    which: Ints
    log_likelihood: float

    def variance(self, rows: Floats) -> Floats:
        """Variance of linear combinations of the states: `rows` (P, N) gives (T, P)."""
        spread = np.einsum("pn,unm,pm->up", rows, self.covariances, rows, optimize=True)
        return np.asarray(spread[self.which])


@dataclass(frozen=True, eq=False)
class _Step:
    """One distinct step of the forward pass: B such that BᵀB is a covariance."""

    root: Floats  # (N, N), of the filtered covariance
    gain: Floats | None  # (N, N), C of the smoother: how much of what the next frame teaches comes back
    leftover: Floats | None  # (R, N), of the covariance of this frame once the next frame is known
    log_determinant: float  # of the innovation covariance, without that of the noise


@dataclass(frozen=True, eq=False)
class _Forward:
    predicted: Floats  # (T, N)
    filtered: Floats  # (T, N)
    steps: list[_Step]
    which: Ints  # (T,)
    log_likelihood: float


def kalman_filter(model: StateSpace, observed: Floats, noise_var: Floats, tolerance: float = SETTLED) -> Estimate:
    """State at each frame given the observations up to and including that frame.

    Parameters
    ----------
    model : N states, P observed values.
    observed : (T, P), NaN = missing.
    noise_var : (P,) or (T, P), variance of the observation noise, above 0; inf counts as missing.
    tolerance : two successive covariances this close, in standard deviations, count as the same. The recursion then
        has settled and is not repeated until other values are missing or the noise changes.

    Raises
    ------
    MismatchError : shapes that do not fit the model.
    UsageError : a noise variance that is not above 0, or a state that is predicted without any doubt.

    Source
    ------
    Anderson and Moore, Optimal Filtering, 1979, section 3.1, in the square-root form of Kaminski, Bryson and Schmidt,
    IEEE Trans. Automatic Control 16(6), 1971.
    """
    forward = _forward(model, observed, noise_var, tolerance, smoothing=False)
    n = len(model.start_mean)
    covariances = np.array([step.root.T @ step.root for step in forward.steps]).reshape(-1, n, n)
    return Estimate(forward.filtered, covariances, forward.which, forward.log_likelihood)


def kalman_smoother(model: StateSpace, observed: Floats, noise_var: Floats) -> Estimate:
    """State at each frame given all observations.

    Parameters, raises: as in `kalman_filter`, with the tolerance at its default.

    Source
    ------
    Rauch, Tung and Striebel, AIAA Journal 3(8), 1965; square roots as in Park and Kailath, Int. J. Control 62(5), 1995.
    """
    forward = _forward(model, observed, noise_var, SETTLED, smoothing=True)
    frames, n = forward.filtered.shape
    mean = forward.filtered.copy()
    which = np.zeros(frames, dtype=np.int64)
    covariances: list[Floats] = []
    if frames:
        last = forward.steps[-1].root
        covariances.append(last.T @ last)
    settled = False
    for t in range(frames - 2, -1, -1):
        step = forward.steps[forward.which[t]]
        assert step.gain is not None
        assert step.leftover is not None
        mean[t] += step.gain @ (mean[t + 1] - forward.predicted[t + 1])
        if not (settled and forward.which[t] == forward.which[t + 1]):
            cov = step.leftover.T @ step.leftover + step.gain @ covariances[-1] @ step.gain.T
            cov = 0.5 * (cov + cov.T)
            settled = _close(cov, covariances[-1], SETTLED)
            covariances.append(cov)
        which[t] = len(covariances) - 1
    return Estimate(mean, np.array(covariances).reshape(-1, n, n), which, forward.log_likelihood)


def _forward(model: StateSpace, observed: Floats, noise_var: Floats, tolerance: float, smoothing: bool) -> _Forward:
    values, precision = _weigh(model, observed, noise_var)
    frames, n = len(values), len(model.start_mean)
    observation, transition = model.observation, model.transition
    process_root = _root(model.process_cov)
    repeats = np.zeros(frames + 1, dtype=bool)
    repeats[1:-1] = (precision[1:] == precision[:-1]).all(axis=1)

    predicted, filtered = np.empty((frames, n)), np.empty((frames, n))
    which = np.zeros(frames, dtype=np.int64)
    steps: list[_Step] = []
    state, ahead = model.start_mean, _root(model.start_cov)
    information, settled = np.zeros((n, n)), False
    quadratic = 0.0
    for t in range(frames):
        if not repeats[t]:
            information = (observation.T * precision[t]) @ observation  # Hᵀ R⁻¹ H
        if not (settled and repeats[t]):
            before = ahead
            step, ahead = _step(before, information, transition, process_root, smoothing)
            settled = bool(repeats[t + 1]) and _close(ahead.T @ ahead, before.T @ before, tolerance)
            steps.append(step)
        which[t] = len(steps) - 1
        predicted[t] = state
        innovation = values[t] - observation @ state
        weighted = precision[t] * innovation
        pulled = step.root @ (observation.T @ weighted)
        filtered[t] = state + step.root.T @ pulled
        quadratic += step.log_determinant + float(innovation @ weighted) - float(pulled @ pulled)
        state = transition @ filtered[t]
    seen = precision[precision > 0]
    log_likelihood = -0.5 * (quadratic + len(seen) * log(2 * pi) - float(np.log(seen).sum()))
    return _Forward(predicted, filtered, steps, which, log_likelihood)


def _step(
    ahead: Floats, information: Floats, transition: Floats, process_root: Floats, smoothing: bool
) -> tuple[_Step, Floats]:
    """Update with one frame's observations and predict the next; roots B (any, N) stand for covariances BᵀB.

    `ahead` is the root of the predicted covariance; comes back with the step: that of the frame after.
    """
    n, rank = len(transition), len(process_root)
    inner, failed = dpotrf(np.eye(len(ahead)) + ahead @ information @ ahead.T, lower=1)
    if failed:
        raise UsageError("the observations of one frame differ too much in their noise; none may be nearly exact")
    root, _ = dtrtrs(inner, ahead, lower=1)  # rootᵀ root = (P⁻¹ + Hᵀ R⁻¹ H)⁻¹
    log_determinant = 2.0 * float(np.log(inner.diagonal()).sum())
    # One orthogonal reduction of the joint root of the next and this frame's states gives the prediction, the
    # smoother's gain and what stays unknown of this frame once the next is known:
    #   rotation · [ root·Aᵀ  root ]  =  [ following  following⁻ᵀ·A·P ]
    #              [ Q^½        0  ]     [     0          leftover    ]
    joint = np.zeros((len(root) + rank, 2 * n if smoothing else n), order="F")
    joint[: len(root), :n] = root @ transition.T
    joint[len(root) :, :n] = process_root
    if smoothing:
        joint[: len(root), n:] = root
    reduced = np.triu(dgeqrf(joint, overwrite_a=1)[0])
    following = reduced[:n, :n].copy()
    if not smoothing:
        return _Step(root, None, None, log_determinant), following
    if len(reduced) < n:
        raise UsageError(_CERTAIN)
    gain, singular = dtrtrs(following, reduced[:n, n:], lower=0)
    if singular:
        raise UsageError(_CERTAIN)
    return _Step(root, gain.T.copy(), reduced[n:, n:].copy(), log_determinant), following


def _root(cov: Floats) -> Floats:
    """(R, N) B with BᵀB = `cov` (N, N), R its rank."""
    if not len(cov):
        return np.zeros((0, 0))
    scale = np.sqrt(np.maximum(cov.diagonal(), 0.0))
    units = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(cov / np.outer(units, units))
    kept = values > len(cov) * np.finfo(float).eps * max(float(values[-1]), 0.0)
    return np.asarray((vectors[:, kept] * np.sqrt(values[kept])).T * units)


def _weigh(model: StateSpace, observed: Floats, noise_var: Floats) -> tuple[Floats, Floats]:
    """Observations with 0 for NaN, and their precisions with 0 for missing; both (T, P)."""
    width = len(model.observation)
    if observed.ndim != 2 or observed.shape[1] != width:
        raise MismatchError(f"the model observes (frames, {width}) values, came {observed.shape}")
    if noise_var.shape not in ((width,), observed.shape):
        raise MismatchError(f"noise must be ({width},) or {observed.shape}, came {noise_var.shape}")
    spread = np.broadcast_to(noise_var, observed.shape)
    measured = np.isfinite(observed)
    if not (spread[measured] > 0).all():
        raise UsageError("the variance of the observation noise must be above 0 wherever something is observed")
    precision = np.zeros(observed.shape)
    np.divide(1.0, spread, out=precision, where=measured)
    return np.where(measured, observed, 0.0), precision


def _close(one: Floats, other: Floats, tolerance: float) -> bool:
    scale = np.sqrt(one.diagonal())
    return bool((np.abs(one - other) <= tolerance * np.outer(scale, scale)).all())
