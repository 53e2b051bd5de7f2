"""What a model keeps of its clips beside the bases: how sharply they bend at each rate, and windows as they were."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Floats, Ints, Singles, frozen
from ...errors import MismatchError
from ..channels.pieces import pieces

_SMOOTHEST, _ROUGHEST = -2.0, 0.0  # slopes of log bend over log rate: constant acceleration, and white noise
_TAILS = 3.0  # degrees of freedom of the Student distribution: heavy tails
_SCALE_ROUNDS, _SCALE_TOLERANCE = 20, 1e-3
_SCALE_SAMPLES = 4096  # second differences that tell a scale well enough
_HELD = 6.0  # scales; few second differences of clean motion lie beyond
_LEAST_SCALE = 1e-3  # degrees or cm
_TOGETHER = 1 << 16  # second differences of a window that are looked at together
_STILL = 1e-12  # degrees or cm a step: a channel that bends less is at rest


@dataclass(frozen=True, eq=False)
class Library:
    """Second differences of the clips at several rates, and some of their windows. C channels, degrees and cm.

    Attributes
    ----------
    rates : (R,) Hz, rising; those that clips reach.
    counts : (R,) second differences seen at each rate.
    bends : (R, C, C) mean outer product of z(t) - 2 z(t+1) + z(t+2), t in frames of the rate.
    exemplars : (N, M, C) float32 windows at the model's rate, spread evenly over all clips.
    typical : (C, C) covariance of the second differences at the model's rate without the few large ones of glitches,
        poles and impacts, which `bends` counts in full.
    rate : Hz, the model's.
    """

    rates: Floats
    counts: Ints
    bends: Floats
    exemplars: Singles
    typical: Floats
    rate: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rates", frozen(self.rates))
        object.__setattr__(self, "counts", frozen(self.counts, np.int64))
        object.__setattr__(self, "bends", frozen(self.bends))
        object.__setattr__(self, "exemplars", frozen(self.exemplars, np.float32))
        object.__setattr__(self, "typical", frozen(self.typical))
        rates = len(self.rates)
        if self.exemplars.ndim != 3 or self.bends.shape != (rates, *(self.exemplars.shape[2:] * 2)):
            raise MismatchError(
                f"{rates} rates and exemplars {self.exemplars.shape} need bends (rates, channels, channels), "
                f"came {self.bends.shape}"
            )
        if self.counts.shape != self.rates.shape or (np.diff(self.rates) <= 0).any():
            raise MismatchError("a library needs rising rates and a count for each")

    def curvature(self, fps: float) -> Floats:
        """Covariance of the second differences of clean motion from frame to frame at a rate.

        Between the stored rates the logarithm of each standard deviation is linear in that of the rate, and the
        correlations are too. Beyond them the deviations go on by the slope of the last two rates, held between that
        of a constant acceleration (-2) and that of white noise (0), and the correlations stay.

        Parameters
        ----------
        fps : Hz.

        Returns
        -------
        (C, C) symmetric and, to rounding, positive semidefinite; 0 for channels at rest.

        Raises
        ------
        MismatchError : the clips had no three frames on end without a missing sample.
        """
        if len(self.rates) == 0:
            raise MismatchError(
                "how sharply clean motion bends is not known: the clips have no three whole frames on end at half "
                "of the model's rate or more; fit again with a lower --model-fps, or clips with fewer gaps"
            )
        spread = np.sqrt(np.diagonal(self.bends, axis1=1, axis2=2))
        at, rates = np.log(fps), np.log(self.rates)
        if len(rates) == 1:
            bend = _scaled(spread[0], np.full(spread.shape[1], _SMOOTHEST) * (at - rates[0]))
            return _covariance(bend, _correlation(self.bends[0], spread[0]))
        below = int(np.clip(np.searchsorted(rates, at) - 1, 0, len(rates) - 2))
        left, right = slice(below, below + 1), slice(below + 1, below + 2)
        logs = np.log(np.maximum(spread, _STILL))
        slope = ((logs[right] - logs[left]) / (rates[right] - rates[left])[:, None])[0]
        share = float((at - rates[below]) / (rates[below + 1] - rates[below]))
        if not 0.0 <= share <= 1.0:
            slope = np.clip(slope, _SMOOTHEST, _ROUGHEST)
        near = below + (share > 0.5)  # from the nearer rate, so that a stored rate gives what is stored
        bend = _scaled(spread[near], slope * (at - rates[near]))
        share = min(max(share, 0.0), 1.0)
        one, other = (_correlation(self.bends[k], spread[k]) for k in (below, below + 1))
        return _covariance(bend, (1.0 - share) * one + share * other)

    def usual_bends(self, fps: float) -> Floats:
        """(C, C) `typical` brought to another rate: each channel by the ratio of its `curvature` there and here."""
        here, there = np.diag(self.curvature(self.rate)), np.diag(self.curvature(fps))
        ratio = np.sqrt(there / np.where(here > 0, here, np.inf))
        return np.asarray(self.typical * np.multiply.outer(ratio, ratio))

    def to_arrays(self) -> dict[str, Any]:
        """Arrays from which `from_arrays` makes the library again."""
        return {
            "rates": self.rates,
            "counts": self.counts,
            "bends": self.bends,
            "exemplars": self.exemplars,
            "typical": self.typical,
            "rate": np.array([self.rate]),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "Library":
        """The library that `to_arrays` took apart."""
        return cls(
            arrays["rates"],
            arrays["counts"],
            arrays["bends"],
            arrays["exemplars"],
            arrays["typical"],
            float(arrays["rate"][0]),
        )


def typical_bends(windows: Floats | Singles) -> Floats:
    """(C, C) covariance of the second differences in windows (N, M, C), the few large ones held back.

    Each channel's second differences are taken for Student-distributed; what lies beyond a few of their scales is cut
    to that. Windows of fewer than three frames, or none, give 0.
    """
    channels = windows.shape[2]
    if windows.shape[0] == 0 or windows.shape[1] < 3:
        return np.zeros((channels, channels))
    from ...kernels.medians import student_squares

    bends = windows.shape[1] - 2
    count = windows.shape[0] * bends
    which, at = np.divmod(np.arange(0, count, max(1, count // _SCALE_SAMPLES)), bends)
    some = _bends(np.stack([windows[which, at + k] for k in range(3)], axis=1))
    scale, square = 1.4826 * np.median(np.abs(np.ascontiguousarray(some.T)), axis=1) + _LEAST_SCALE, np.square(some)
    for _ in range(_SCALE_ROUNDS):
        before = scale
        scale = np.sqrt((_TAILS + 1.0) * student_squares(square, np.square(scale), _TAILS) / len(square)) + _LEAST_SCALE
        if np.abs(scale - before).max() <= _SCALE_TOLERANCE * before.min():
            break
    products = np.zeros((channels, channels))
    for part in pieces(bends, _TOGETHER):
        held = np.clip(_bends(windows[:, part.start : part.stop + 2]), -_HELD * scale, _HELD * scale)
        products += held.T @ held
    return np.asarray(products / count)


def mean_bends(windows: Floats | Singles) -> Floats:
    """(C, C) mean outer product of the second differences in windows (N, M, C), as they are; of none 0."""
    bends = _bends(windows)
    return np.asarray(bends.T @ bends / max(len(bends), 1))


def _bends(windows: Floats | Singles) -> Floats:
    """(N (M - 2), C) second differences in windows (N, M, C); a missing sample counts as 0."""
    whole: Any = windows if np.isfinite(windows).all() else np.nan_to_num(windows)
    bend = whole[:, :-2] - 2.0 * whole[:, 1:-1] + whole[:, 2:]
    return np.asarray(bend.reshape(-1, windows.shape[2]), dtype=np.float64)


def _scaled(spread: Floats, exponent: Floats) -> Floats:
    return np.where(spread > _STILL, spread * np.exp(exponent), 0.0)


def _correlation(second: Floats, spread: Floats) -> Floats:
    scale = 1.0 / np.where(spread > _STILL, spread, np.inf)
    return np.asarray(second * np.multiply.outer(scale, scale))


def _covariance(spread: Floats, correlation: Floats) -> Floats:
    covariance = correlation * np.multiply.outer(spread, spread)
    return np.asarray(0.5 * (covariance + covariance.T))
