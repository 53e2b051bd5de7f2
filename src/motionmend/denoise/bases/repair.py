"""From a spoiled recording to a repaired one, by the method of the dissertation's section 2."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Bytes, Floats, Singles, away_from
from ...bodies.motion import Origin
from ...numerics.ssa import Eigenbases, at_rate
from ..channels.pieces import blocks
from .certainty import TRUSTED, deviations, noise_and_misfit
from .optimise import SCALE, Fit, fit_windows
from .support import interpolated

LONG = 1 << 16  # frames repaired at once: the fit needs twenty times their memory
MARGIN = 4.0  # s of the neighbours that a block of a longer recording sees on each side
MUCH_MISSED = 1.5 * SCALE  # degrees or cm; bases of the same behaviour and person miss less


@dataclass(frozen=True, eq=False)
class ChannelRepair:
    """Repaired channels and all that is known of them; (T, C) each, channel units.

    Attributes
    ----------
    values : NaN where left open.
    std : standard deviations, NaN where left open.
    weights : robust weights, 0 where missing; or only whether a sample is believed.
    origin : of `Origin`.
    iterations, cost, converged : of the optimisation.
    warnings : one sentence each.
    """

    values: Floats
    std: Floats | Singles
    weights: Floats | Singles | Bools
    origin: Bytes
    iterations: int
    cost: Floats
    converged: bool
    warnings: tuple[str, ...] = ()

    def but_for_values(self) -> "ChannelRepair":
        """The same without the values, when they have served: those of a long recording need much memory."""
        return replace(self, values=np.empty((0, self.values.shape[1])))


def repair_channels(measured: Floats, bases: Eigenbases, model_fps: float, fps: float, robust: str) -> ChannelRepair:
    """Repair channels with filter bases.

    Parameters
    ----------
    measured : (T, C) in degrees and centimetres at `fps` Hz, NaN = missing.
    bases : learned at `model_fps` Hz; they are brought to the recording's rate, not the recording to theirs.
    robust : a name of `numerics.robust.ESTIMATORS`.

    Returns
    -------
    Every frame of the input. A missing sample stays open where no window about it holds any measurement.

    Source
    ------
    Section 2.2.3-2.2.5.
    """
    patterns, stride = at_rate(bases, model_fps, fps)
    places = blocks(len(measured), LONG, round(MARGIN * fps))
    found = (_repaired(measured[seen], patterns, stride, bases, robust) for _, seen in places)
    repair, missed = next(found) if len(places) == 1 else _together(measured.shape, places, found)
    said: tuple[str, ...] = ()
    if missed > MUCH_MISSED:
        said = (
            f"the model's bases miss this recording by {missed:.1f} degrees or cm (root mean square over channels): "
            "it may not know this motion or person; expect errors of that size",
        )
    return replace(repair, warnings=said)


def _repaired(
    measured: Floats, patterns: Eigenbases, stride: int, bases: Eigenbases, robust: str
) -> tuple[ChannelRepair, float]:
    """The repair of some frames, and the root mean square of what the bases miss of them."""
    padded, kept = _padded(measured, patterns.window)
    fit = fit_windows(padded, interpolated(padded, patterns.mean.mean(axis=0)), patterns, stride, robust=robust)
    thin = _thinned(fit, stride)
    noise, misfit = noise_and_misfit(padded[::stride], thin)
    std = deviations(padded[::stride], thin, bases, noise, misfit)
    std = std.repeat(stride, axis=0)[: len(padded)]
    fit = Fit(fit.values[kept], fit.weights[kept], fit.cost, fit.iterations, fit.converged)
    return labelled(measured, fit, std[kept], patterns.window), float(np.sqrt(np.mean(np.square(misfit))))


def _together(
    shape: tuple[int, ...], places: list[tuple[slice, slice]], found: Iterator[tuple[ChannelRepair, float]]
) -> tuple[ChannelRepair, float]:
    """Repairs of blocks as that of the whole (T, C); costs are added as if all blocks had taken all iterations."""
    values, std, weights = np.empty(shape), np.empty(shape, np.float32), np.empty(shape, np.float32)
    origin = np.empty(shape, np.uint8)
    cost, missed, converged = np.zeros(1), 0.0, True
    for (own, seen), (block, misses) in zip(places, found, strict=True):
        inside = slice(own.start - seen.start, own.stop - seen.start)
        values[own], std[own] = block.values[inside], block.std[inside]
        weights[own], origin[own] = block.weights[inside], block.origin[inside]
        longest = max(len(cost), len(block.cost))
        one, other = (np.pad(c, (0, longest - len(c)), mode="edge") for c in (cost, block.cost))
        cost, converged = one + other, converged and block.converged
        missed += misses**2 * (own.stop - own.start) / shape[0]
    return ChannelRepair(values, std, weights, origin, len(cost) - 1, cost, converged), float(np.sqrt(missed))


def labelled(measured: Floats, fit: Fit, std: Floats, window: int) -> ChannelRepair:
    """Say of every sample where it comes from, and open the gaps that no window supports."""
    present = np.isfinite(measured)
    origin = np.where(fit.weights >= TRUSTED, Origin.MEASURED, Origin.REPAIRED).astype(np.uint8)
    origin[~present] = Origin.FILLED
    blind = away_from(present.any(axis=1)) >= window
    opened = ~present & blind[:, None]
    origin[opened] = Origin.LEFT_OPEN
    return ChannelRepair(
        np.where(opened, np.nan, fit.values),
        np.where(opened, np.nan, std),
        fit.weights,
        origin,
        fit.iterations,
        fit.cost,
        fit.converged,
    )


def _padded(measured: Floats, window: int) -> tuple[Floats, Bools]:
    """A recording shorter than a window gets missing frames on both sides; and which frames are its own."""
    short = max(window - len(measured), 0)
    before = short // 2
    kept = np.zeros(len(measured) + short, dtype=bool)
    kept[before : before + len(measured)] = True
    padded = np.full((len(kept), measured.shape[1]), np.nan)
    padded[kept] = measured
    return padded, kept


def _thinned(fit: Fit, stride: int) -> Fit:
    return Fit(fit.values[::stride], fit.weights[::stride], fit.cost, fit.iterations, fit.converged)
