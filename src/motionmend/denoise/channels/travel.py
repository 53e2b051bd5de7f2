"""A frame that travels and turns smoothly with the body, so that place and heading drop out of the channels."""

from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.skeleton import wrapped
from ...kernels.banded import walk_certainty
from ...numerics.quantiles import median
from ...numerics.robust import ESTIMATORS
from ...numerics.whittaker import passed, response, whittaker

CUTOFF = 1.0  # Hz; slower than a stride, so that the gait itself stays in the channels
UNWRAPPING_CUTOFF = 3.0  # Hz; follows a spin of more than a turn a second
PLACE_FLOOR = 0.01  # m; below this residual every measured place counts fully
HEADING_FLOOR = 0.05  # rad
REWEIGHTINGS = 12
ANYWHERE = 1e6  # variance of the noise: where a path begins, and how fast


@dataclass(frozen=True, eq=False)
class Travel:
    """Where the body is and which way it faces, smooth in time.

    Attributes
    ----------
    place : (T, 3) m.
    heading : (T,) rad about `up`.
    up : (3,) unit vector.
    """

    place: Floats
    heading: Floats
    up: Floats

    def rotations(self) -> Floats:
        """(T, 3, 3) turns by the heading about `up`."""
        return turn(self.heading, self.up)

    def part(self, frames: slice) -> "Travel":
        """The same of some frames."""
        return Travel(self.place[frames], self.heading[frames], self.up)


def turn(angle: Floats, axis: Floats) -> Floats:
    """(T, 3, 3) rotation matrices by `angle` (T,) rad about the unit vector `axis` (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross))


def travel(place: Floats, heading: Floats, fps: float, up: Floats) -> Travel:
    """The smooth travelling frame of a body whose place and heading were measured, with outliers and gaps.

    Equivariant: a recording moved and turned about `up` gives the same frame moved and turned.

    Parameters
    ----------
    place : (T, 3) m, NaN = missing.
    heading : (T,) rad, NaN = missing; any multiple of a full turn.
    fps : Hz.
    up : (3,) unit vector.

    Returns
    -------
    Finite everywhere; standing at the origin where nothing at all was measured.
    """
    smooth_place = _robust_smooth(place, fps, CUTOFF, PLACE_FLOOR)
    # as unit vectors headings need no unwrapping; the path they make tells which turn each heading belongs to
    pointing = _robust_smooth(
        np.stack([np.cos(heading), np.sin(heading)], axis=1), fps, UNWRAPPING_CUTOFF, HEADING_FLOOR
    )
    path = np.unwrap(np.arctan2(pointing[:, 1], pointing[:, 0]))
    unwrapped = path + np.angle(np.exp(1j * (heading - path)))
    return Travel(smooth_place, _robust_smooth(unwrapped[:, None], fps, CUTOFF, HEADING_FLOOR)[:, 0], up)


def noise_followed(frame: Travel, place: Floats, heading: Floats, fps: float) -> tuple[Floats, Floats]:
    """Of how much of the samples' noise the frame itself is made: it follows what is slow of it.

    Parameters
    ----------
    frame : of `travel`.
    place, heading, fps : what it was made of.

    Returns
    -------
    (T,) each, of place and heading: variance of the frame's error per variance of white noise in one sample.
    """
    return (
        _followed(np.linalg.norm(place - frame.place, axis=1), fps, PLACE_FLOOR),
        _followed(np.abs(wrapped(heading - frame.heading)), fps, HEADING_FLOOR),
    )


def slow_part(frames: int, fps: float) -> Floats:
    """(T - 1,) of each cosine over T frames but the constant one, slowest first, the share that the frame follows."""
    return passed(_smoothness(fps, CUTOFF), np.arange(1, frames) * np.pi / frames)


def _followed(residual: Floats, fps: float, floor: float) -> Floats:
    """(T,) of what was smoothed with residuals (T,), NaN where nothing was measured."""
    present = np.isfinite(residual)
    if present.sum() < 2:
        return np.zeros(len(residual))
    weights = _weights(np.where(present, residual, 0.0), present, floor)
    smoothness, free = _smoothness(fps, CUTOFF), np.full(1, ANYWHERE)
    sure, _ = walk_certainty(weights[:, None], np.full((len(residual), 1), 1.0 / smoothness), free, free)
    # as a posterior the curve may also be where it is not smooth; of the noise alone is so much
    share = response(smoothness)
    return np.asarray(np.square(share).mean() / share.mean() * sure[:, 0])


def _robust_smooth(values: Floats, fps: float, cutoff: float, floor: float) -> Floats:
    """Low-pass `values` (T, C) below `cutoff` Hz, re-weighted by the length of each frame's residual (Welsch)."""
    present: Bools = np.asarray(np.isfinite(values).all(axis=1))
    if present.sum() < 2:
        # nothing to draw a line through: stay at the only value there is
        return np.broadcast_to(values[present].sum(axis=0), values.shape).copy()
    smoothness = _smoothness(fps, cutoff)
    known = np.where(present[:, None], values, 0.0)
    weights = present.astype(float)
    for _ in range(REWEIGHTINGS):
        smooth = whittaker(known, weights, smoothness)
        weights = _weights(np.linalg.norm(known - smooth, axis=1), present, floor)
    return np.asarray(whittaker(known, weights, smoothness))


def _smoothness(fps: float, cutoff: float) -> float:
    """Half power of the second-difference smoother is at the cut-off."""
    return float((2.0 * np.sin(np.pi * min(cutoff, 0.49 * fps) / fps)) ** -4)


def _weights(residual: Floats, present: Bools, floor: float) -> Floats:
    scale = 3.0 * max(floor, 1.4826 * float(median(residual[present])))
    return present * ESTIMATORS["welsch"].weight(residual, scale)
