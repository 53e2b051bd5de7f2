"""The data-driven Kalman filter: recordings smoothed by dynamics that were learned from clean clips."""

import numpy as np
from threadpoolctl import threadpool_limits

from ...arrays import Bools, Floats, away_from
from ...errors import MismatchError
from ...numerics.risk import excess, stein_risk
from ...numerics.smoother import kalman_filter, kalman_smoother
from ..channels.pieces import blocks
from ..noise.level import alike_noise
from ..rivals.classic import kalman, variance_of
from ..rivals.filtered import Filtered, check_channels
from .fit import fit_dynamics
from .model import Dynamics, Trust, state_space

__all__ = ["Dynamics", "Trust", "fit_dynamics", "judge", "smooth_with"]

SUPPORT = 1.0  # s; a frame further than this from any measured sample is left open
BLOCK, MARGIN = 2048, 4.0  # steps smoothed at once, and s of the neighbours seen beside them: states are large
_TRIED = 150  # frames of a recording on which its trust in the model is judged
_ROUGHLY = 1e-3  # half decades differ by far more than covariances settled to this
_FURTHEST = 12  # half decades that a factor of trust may be from 1


def smooth_with(
    dynamics: Dynamics,
    values: Floats,
    fps: float,
    stride: int | None = None,
    *,
    noise: float | Floats | None = None,
    trust: Trust | None = None,
) -> Filtered:
    """Kalman filter and Rauch-Tung-Striebel smoother with learned dynamics.

    A recording at a multiple of the dynamics' rate is smoothed phase by phase; cubics over two steps join the phases.

    Parameters
    ----------
    dynamics : of the same C channels.
    values : (T, C), NaN = missing.
    fps : of `values`, Hz.
    stride : frames of `values` per step of the dynamics; None = the nearest to its rate.
    noise : standard deviation of the noise, one number, (C,) or (T, C); None = estimated from the recording.
    trust : in the dynamics; None = judged by the recording's likelihood.

    Returns
    -------
    Every channel filled, except further than `SUPPORT` from any measured sample. Channels unknown to the dynamics are
    smoothed as random walks. std : of the pose given the whole recording.

    Raises
    ------
    MismatchError : other channels than the dynamics'.
    """
    check_channels(values, fps)
    if values.shape[1] != len(dynamics.mean):
        raise MismatchError(
            f"the dynamics know {len(dynamics.mean)} channels, the recording has {values.shape[1]}: "
            "use a model fitted on this skeleton or marker set"
        )
    steps = max(1, round(fps / dynamics.fps)) if stride is None else stride
    known, measured = dynamics.known, np.isfinite(values)
    noise_var = _noise_var(dynamics, values, noise)
    with threadpool_limits(1, user_api="blas"):  # many small products: threads would wait for each other
        if trust is None:
            trust = judge(dynamics, values[::steps], noise_var[::steps], noise_known=noise is not None)
        result, variance = _by_phases(dynamics, values, trust.noise * noise_var, trust, steps)
    result[:, known], variance[:, known] = _joined(
        values[:, known], result[:, known], variance[:, known], noise_var[:, known], trust, steps
    )
    far = away_from(measured.any(axis=1)) > round(SUPPORT * fps)
    result[far], variance[far] = np.nan, np.nan
    std = np.sqrt(variance)
    if not known.all():
        walk = kalman(values[:, ~known], fps, None if noise is None else np.sqrt(noise_var[:, ~known]))
        result[:, ~known], std[:, ~known] = walk.values, walk.std
    return Filtered(result, std, np.isfinite(result) & ~measured)


def judge(dynamics: Dynamics, values: Floats, noise_var: Floats, *, noise_known: bool) -> Trust:
    """The trust under which a recording is likeliest, to half a decade; judged on its fullest five seconds at 30 Hz.

    Parameters
    ----------
    values : (T, C) at the dynamics' rate, NaN = missing.
    noise_var : (T, C), variance of the noise.
    noise_known : False = the noise is judged too.
    """
    here = _fullest(np.isfinite(values), _TRIED)
    known = dynamics.known
    observed, noise = values[here][:, known] - dynamics.mean[known], noise_var[here][:, known]
    if not np.isfinite(observed).any():
        return Trust()
    tried: dict[tuple[int, int, int], float] = {}
    limits = (_FURTHEST, _FURTHEST, 0 if noise_known else _loudest(observed, noise))

    def likelihood(steps: tuple[int, int, int]) -> float:
        if steps not in tried:
            trust = _trust(steps)
            model = state_space(dynamics, trust)
            tried[steps] = kalman_filter(model, observed, trust.noise * noise, _ROUGHLY).log_likelihood
        return tried[steps]

    best = (0, 1, 0)  # clips of new people usually stray somewhat more from the poses than held-out clips did
    moved = True
    while moved:
        moved = False
        for axis in range(3):
            for way in (1, -1):
                step = tuple(way * (a == axis) for a in range(3))
                while True:
                    there = (best[0] + step[0], best[1] + step[1], best[2] + step[2])
                    if abs(there[axis]) > limits[axis] or likelihood(there) <= likelihood(best):
                        break
                    best, moved = there, True
    return _trust(best)


def _loudest(observed: Floats, noise_var: Floats) -> int:
    """Half decades by which the noise may be louder: steps between frames hold twice its variance, and motion."""
    steps = np.square(np.diff(observed, axis=0))
    seen = np.isfinite(steps)
    counted = seen.any(axis=0)
    if not counted.any():
        return 0
    mean = np.where(seen, steps, 0.0).sum(axis=0)[counted] / seen.sum(axis=0)[counted]
    ratio = float(np.median(0.5 * mean / noise_var.mean(axis=0)[counted]))
    return min(_FURTHEST, max(0, int(np.ceil(2 * np.log10(max(ratio, 1.0))))))


def _trust(steps: tuple[int, int, int]) -> Trust:
    return Trust(*(10.0 ** (0.5 * s) for s in steps))


def _by_phases(
    dynamics: Dynamics, values: Floats, noise_var: Floats, trust: Trust, steps: int
) -> tuple[Floats, Floats]:
    """Mean and variance (T, C) of the known channels, every `steps`-th frame on its own; NaN in the others."""
    known = dynamics.known
    model = state_space(dynamics, trust)
    mean, variance = np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    for phase in range(min(steps, len(values))):
        frames = np.arange(phase, len(values), steps)
        for own, around in blocks(len(frames), BLOCK, round(MARGIN * dynamics.fps)):
            seen, inside = frames[around], slice(own.start - around.start, own.stop - around.start)
            found = kalman_smoother(
                model, values[np.ix_(seen, known)] - dynamics.mean[known], noise_var[seen][:, known]
            )
            here = np.ix_(frames[own], known)
            mean[here] = dynamics.mean[known] + found.mean[inside] @ model.observation.T
            variance[here] = found.variance(model.observation)[inside]
    return mean, variance


def _joined(
    values: Floats, smooth: Floats, variance: Floats, noise_var: Floats, trust: Trust, steps: int
) -> tuple[Floats, Floats]:
    """Mean and variance (T, C) once phases that were smoothed apart are joined where that makes them less wrong.

    The cubic nearest to two steps about each frame joins them; a channel too fast for it is left as it is. The phases'
    noise is independent, so that of recorded samples falls by the cubic's gain; in a gap they err together. What a
    channel is more wrong than the dynamics say is added to its variance.
    """
    from scipy.signal import savgol_coeffs, savgol_filter

    recorded = np.isfinite(values)
    noise = np.sqrt(noise_var)
    own = variance / (trust.noise * noise_var)
    risk = stein_risk(values - smooth, own, noise)
    window = 2 * steps + 1
    if steps > 1 and len(values) >= window:
        cubic = savgol_coeffs(window, 3)
        inside = np.zeros(len(values), dtype=bool)
        inside[steps:-steps] = True
        joined = savgol_filter(smooth, window, 3, axis=0, mode="interp")
        calmer = variance * np.where(recorded & inside[:, None], np.square(cubic).sum(), 1.0)
        joined_risk = stein_risk(values - joined, own * cubic[steps], noise)
        better = joined_risk < risk
        smooth, variance = np.where(better, joined, smooth), np.where(better, calmer, variance)
        risk = np.where(better, joined_risk, risk)
    return smooth, variance + excess(risk, variance, values)


def _noise_var(dynamics: Dynamics, values: Floats, noise: float | Floats | None) -> Floats:
    """(T, C), not below a thousandth of the channel's own standard deviation, which keeps it from being exact."""
    own = np.square(dynamics.poses) @ dynamics.start_cov.diagonal()[: dynamics.poses.shape[1]]
    own = own + np.square(dynamics.rest) @ dynamics.rest_var
    if noise is None:
        # Too few samples to tell: a twentieth of how much the channel moves.
        level = alike_noise(values)
        spread = np.square(np.where(np.isfinite(level), level, 0.05 * np.sqrt(own)))
    else:
        spread = variance_of(noise, values.shape)
    return np.broadcast_to(np.maximum(spread, 1e-6 * own), values.shape)


def _fullest(measured: Bools, frames: int) -> slice:
    """The first stretch of at most `frames` frames with the most measured samples."""
    if len(measured) <= frames:
        return slice(0, len(measured))
    total = np.concatenate([[0], np.cumsum(measured.sum(axis=1))])
    start = int((total[frames:] - total[:-frames]).argmax())
    return slice(start, start + frames)
