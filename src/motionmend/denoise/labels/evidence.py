"""What speaks for a label: that a track goes on smoothly, and that distances between markers are its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints, frozen
from ...errors import MismatchError
from ...numerics.quantiles import median

TAIL = 3.0  # degrees of freedom of Student's t: impacts and soft tissue have heavier tails than a normal law
_T3 = -2.5510  # log of the constant of a 3-D Student t density with 3 degrees of freedom
_T1 = -1.0008  # and of a 1-D one
_STRANGE = 1e-4  # share of steps that are neither motion nor swap: spikes, ghosts
STEP_LAW = TAIL, _T3, float(np.log(_STRANGE))  # of the error of a step, as the search for paths wants it
_STRANGE_DISTANCE = 0.01  # share of distances that are off for any reason
_WINDOW = 0.03  # s, of the straight line fitted to either side of a step
_LONGEST = 1.0  # s, gap up to which the error of a prediction is measured; it grows in proportion beyond
_LEAST = 1e-4  # m, scale below which no prediction error is believed
_PARTNERS = 6  # distances by which a marker is known
_RIGID = 3  # of them are on the same segment
_WORTH = 3.0  # independent distances that these amount to: three fix a place
_APART = 0.03  # of a distance, by which people differ and markers are put on anew, at least
_SIZES = 200  # sizes of a body that are tried
_SAMPLED = 400  # frames from which distances are learned
_STEPS = 5000  # steps of each length from which their errors are


@dataclass(frozen=True, eq=False)
class Ends:
    """Straight lines through the last samples up to, or the first from, each of N instants.

    Attributes
    ----------
    place : (N, 3) m at the instant.
    velocity : (N, 3) m a frame, 0 where a single sample says nothing of it.
    moving : (N,) whether the velocity is known.
    """

    place: Floats
    velocity: Floats
    moving: Bools

    def at(self, index: Ints) -> "Ends":
        """Those of the given numbers."""
        return Ends(self.place[index], self.velocity[index], self.moving[index])

    def still(self) -> "Ends":
        """The same with the velocities forgotten."""
        return Ends(self.place, np.zeros_like(self.velocity), np.zeros_like(self.moving))


@dataclass(frozen=True, eq=False)
class Continuity:
    """How well a track can be followed over h frames, measured on the recording itself.

    Where a step leads from one straight line to another, both are followed to its middle: the error of a constant
    acceleration cancels there. Its scale is sqrt(rest² + (share * way)²), the way being speed times h.

    Attributes
    ----------
    horizons : (H,) frames.
    rest : (3, H) m, by how many sides have a velocity.
    share : (3, H).
    window : samples of a straight line.
    fastest : m a frame; a spike that seems faster makes no step less sure.
    """

    horizons: Floats
    rest: Floats
    share: Floats
    window: int
    fastest: float

    def log_density(self, left: Ends, right: Ends, frames: Ints) -> tuple[Floats, Floats]:
        """Of N steps of `frames`: their log density (per m³) and how much is lost to the error, <= 0."""
        from ...kernels.labelling import log_densities

        sides = left.moving.astype(np.int64) + right.moving
        error, way = mismatch(left, right, frames)
        density, lost = log_densities(
            error, way, sides, frames, self.horizons, self.rest, self.share, self.fastest, STEP_LAW
        )
        return np.asarray(density), np.asarray(lost)


def mismatch(left: Ends, right: Ends, frames: Ints) -> tuple[Floats, Floats]:
    """(N,) m between what both sides say of the middle, and (N,) m of way."""
    velocities = np.stack([left.velocity, right.velocity])
    sides = (left.moving.astype(np.int64) + right.moving)[:, None]
    # A side without a velocity goes by the other's.
    mean = velocities.sum(axis=0) / np.maximum(sides, 1)
    error = left.place + mean * frames[:, None] - right.place
    speed = np.sqrt(np.square(velocities).sum(axis=2)).sum(axis=0) / np.maximum(sides[:, 0], 1)
    return np.sqrt(np.square(error).sum(axis=1)), speed * frames


def line_ends(positions: Floats, window: int) -> tuple[Ends, Ends]:
    """Lines up to and from every sample of (T, M, 3): fields (T * M, ...), NaN places where missing."""
    before = _lines(positions, window)
    after = _lines(positions[::-1], window)
    frames, markers = positions.shape[:2]
    back = (np.arange(frames)[::-1, None] * markers + np.arange(markers)).ravel()
    after = after.at(back)
    return before, Ends(after.place, -after.velocity, after.moving)


def _lines(positions: Floats, window: int) -> Ends:
    """Lines through the last samples up to each."""
    place, velocity = positions.copy(), np.full_like(positions, np.nan)
    for count in sorted({2, window}):
        if count > len(positions):
            continue
        slope, level = line_weights(count)
        moved = sum(w * positions[k : len(positions) - count + 1 + k] for k, w in enumerate(slope))
        stood = sum(w * positions[k : len(positions) - count + 1 + k] for k, w in enumerate(level))
        known = np.isfinite(moved)
        velocity[count - 1 :][known] = np.asarray(moved)[known]
        place[count - 1 :][known] = np.asarray(stood)[known]
    velocity = velocity.reshape(-1, 3)
    moving = np.isfinite(velocity[:, 0])
    return Ends(place.reshape(-1, 3), np.where(moving[:, None], velocity, 0.0), moving)


def line_weights(count: int) -> tuple[Floats, Floats]:
    """(count,) weights of samples in the slope and in the last point of their least-squares line."""
    at = np.arange(count) - 0.5 * (count - 1)
    slope = at / np.square(at).sum()
    return slope, 1.0 / count + slope * at[-1]


def measure_continuity(positions: Floats, fps: float) -> Continuity:
    """The prediction errors of a recording (T, M, 3) m, by medians, so that rare swaps do not count."""
    window = int(np.clip(round(_WINDOW * fps), 2, 8))
    frames, markers = positions.shape[:2]
    longest = max(2, min(round(_LONGEST * fps), frames // 3))
    horizons = np.unique(np.geomspace(1, longest, 10).round().astype(np.int64))
    left, right = line_ends(positions, window)
    rest, share = np.full((3, len(horizons)), np.nan), np.zeros((3, len(horizons)))
    for column, horizon in enumerate(horizons):
        starts = np.arange(0, frames - horizon, max(1, (frames - horizon) * markers // _STEPS))
        first = (starts[:, None] * markers + np.arange(markers)).ravel()
        a, b = left.at(first), right.at(first + horizon * markers)
        kept = a.moving & b.moving
        a, b = a.at(np.flatnonzero(kept)), b.at(np.flatnonzero(kept))
        steps = np.full(len(a.place), horizon)
        for sides, pair in enumerate(((a.still(), b.still()), (a, b.still()), (a, b))):
            rest[sides, column], share[sides, column] = _scale(*mismatch(*pair, steps))
            if sides == 0:  # without any velocity the way is not known and the scale is all there is
                rest[0, column], share[0, column] = _usual(mismatch(*pair, steps)[0]), 0.0
    known = np.isfinite(rest).all(axis=0)
    speed = np.sqrt(np.square(left.velocity[left.moving]).sum(axis=1))
    fastest = 2.0 * float(np.quantile(speed, 0.9)) if len(speed) else np.inf
    if not known.any():
        return Continuity(np.array([1.0]), np.full((3, 1), np.inf), np.zeros((3, 1)), window, np.inf)
    # A longer step is never the surer one.
    rest, share = np.maximum.accumulate(rest.compress(known, axis=1), axis=1), share.compress(known, axis=1)
    return Continuity(horizons[known].astype(np.float64), np.maximum(rest, _LEAST), share, window, fastest)


def _usual(error: Floats) -> float:
    """m per coordinate: the median length of a 3-D error over that of unit noise."""
    return float(median(error)) / 1.538 if len(error) >= 20 else np.nan


def _scale(error: Floats, way: Floats) -> tuple[float, float]:
    """Rest and share that explain the errors of slow and of fast steps."""
    if len(error) < 20:
        return np.nan, 0.0
    fast = way > median(way)
    if not fast.any():
        return _usual(error), 0.0
    slow_scale, fast_scale = (float(median(error[some])) / 1.538 for some in (~fast, fast))
    slow_way, fast_way = (float(median(way[some])) for some in (~fast, fast))
    growth = max(0.0, float((fast_scale**2 - slow_scale**2) / (fast_way**2 - slow_way**2)))
    return float(np.sqrt(max(slow_scale**2 - growth * slow_way**2, _LEAST**2))), float(np.sqrt(growth))


@dataclass(frozen=True, eq=False)
class MarkerDistances:
    """How far apart the markers of a set are.

    Attributes
    ----------
    mean : (M, M), in body sizes when learned from several clips, NaN where never seen together.
    spread : (M, M), the same unit.
    size : m, the median distance of the first clip's markers: 1 body size.
    """

    mean: Floats
    spread: Floats
    size: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", frozen(self.mean))
        object.__setattr__(self, "spread", frozen(self.spread))
        if self.mean.ndim != 2 or self.mean.shape[0] != self.mean.shape[1] or self.mean.shape != self.spread.shape:
            raise MismatchError(
                f"distances need two (markers, markers) arrays, came {self.mean.shape} and {self.spread.shape}"
            )

    def to_arrays(self) -> dict[str, Floats]:
        """Plain arrays `mean`, `spread` and `size`."""
        return {"mean": self.mean, "spread": self.spread, "size": np.array([self.size])}

    @staticmethod
    def from_arrays(arrays: Mapping[str, Floats]) -> "MarkerDistances":
        """Back from `to_arrays`."""
        return MarkerDistances(arrays["mean"], arrays["spread"], float(np.ravel(arrays["size"])[0]))

    def fitted(self, positions: Floats) -> "MarkerDistances":
        """In metres, at the size of the body in (T, M, 3), which no swap of a few markers alters."""
        if positions.shape[1] != len(self.mean):
            raise MismatchError(f"distances of {len(self.mean)} markers cannot judge {positions.shape[1]} markers")
        scale = _body_size(measure_distances([positions]).mean, self) or self.size
        return MarkerDistances(self.mean * scale, self.spread * scale, 1.0)

    @property
    def partners(self) -> Ints:
        """(M, K) the markers whose distances are steadiest, -1 where there are fewer."""
        spread = np.where(np.isfinite(self.spread), self.spread, np.inf)
        np.fill_diagonal(spread, np.inf)
        order = np.argsort(spread, axis=1, kind="stable")[:, :_PARTNERS]
        return np.where(np.isfinite(np.take_along_axis(spread, order, axis=1)), order, -1)


def learn_distances(clips: Sequence[Floats]) -> MarkerDistances:
    """Distances between the markers of a set from clean clips.

    Parameters
    ----------
    clips : each (T, M, 3) m, NaN = missing, the same markers in the same order; any people.

    Raises
    ------
    MismatchError : no clip, or clips of different marker sets.
    """
    if not clips or any(c.ndim != 3 or c.shape[1:] != clips[0].shape[1:] for c in clips):
        raise MismatchError("distances need clips (frames, markers, 3) of one marker set")
    each = [measure_distances([c]) for c in clips]
    known = np.isfinite(each[0].mean)
    np.fill_diagonal(known, False)
    first = float(median(each[0].mean[known])) if known.any() else 1.0
    body = MarkerDistances(each[0].mean / first, np.hypot(each[0].spread, _APART * each[0].mean) / first, first)
    sizes = [first, *(_body_size(d.mean, body) or first for d in each[1:])]
    means = np.stack([d.mean / s for d, s in zip(each, sizes, strict=True)])
    spreads = np.stack([d.spread / s for d, s in zip(each, sizes, strict=True)])
    known = np.isfinite(means)
    count = np.maximum(known.sum(axis=0), 1)
    mean = np.where(known, means, 0.0).sum(axis=0) / count
    within = np.where(known, np.square(spreads), 0.0).sum(axis=0) / count
    # One clip cannot show how people differ, so something is supposed.
    between = np.where(known, np.square(means - mean), 0.0).sum(axis=0) / count
    spread = np.sqrt(within + np.maximum(between, np.square(_APART * mean)))
    never = ~known.any(axis=0)
    mean[never], spread[never] = np.nan, np.nan
    return MarkerDistances(mean, spread, first)


def _body_size(here: Floats, body: MarkerDistances) -> float:
    """The likeliest size of the body whose markers are `here` (M, M) m apart in the median; 0 = nothing in common.

    Postures differ, and with them most distances. Those to the few markers of the same segment do not, and of all sizes
    they agree on one: the mode of the likelihood, so that some swapped markers do not alter it.
    """
    one, other = np.repeat(np.arange(len(here)), _RIGID), body.partners[:, :_RIGID].ravel()
    one, other = one[other >= 0], other[other >= 0]
    distance, mean, spread = here[one, other], body.mean[one, other], body.spread[one, other]
    known = np.isfinite(distance) & np.isfinite(mean) & (mean > 0)
    if not known.any():
        return 0.0
    distance, mean, spread = distance[known], mean[known], spread[known]
    tried = np.quantile(distance / mean, np.linspace(0.02, 0.98, _SIZES))[:, None]
    likelihood = distance_density(distance, tried * mean, tried * spread).sum(axis=1)
    return float(tried[int(np.argmax(likelihood)), 0])


def measure_distances(clips: Sequence[Floats]) -> MarkerDistances:
    """Median and spread in metres, of at most 400 frames of each clip.

    The spread is twice that of a normal law with the same quartiles: a quarter of the frames may be swapped, and a
    posture held for most of a recording does not make the others strange.
    """
    sampled = np.concatenate([c[:: max(1, len(c) // _SAMPLED)] for c in clips])
    distances = pairwise(sampled)
    markers = sampled.shape[1]
    low, mean, high = np.full((3, markers, markers), np.nan)
    upper = np.triu_indices(markers, 1)
    ordered = np.sort(distances[:, upper[0], upper[1]], axis=0)  # NaN last
    seen = np.isfinite(ordered).sum(axis=0)
    enough = seen >= min(10, len(sampled))
    for share, out in ((0.25, low), (0.5, mean), (0.75, high)):
        at = np.maximum((share * (seen - 1)).round().astype(np.int64), 0)
        value = np.where(enough, np.take_along_axis(ordered, at[None], axis=0)[0], np.nan)
        out[upper], out[upper[::-1]] = value, value
    return MarkerDistances(mean, 2.0 * (high - low) / 1.349 + 1e-3, 1.0)


def pairwise(positions: Floats) -> Floats:
    """(T, M, M) m between markers of (T, M, 3)."""
    square = np.square(positions).sum(axis=2)
    product = positions @ positions.transpose(0, 2, 1)
    return np.asarray(np.sqrt(np.maximum(square[:, :, None] + square[:, None] - 2.0 * product, 0.0)))


def distance_density(distances: Floats, mean: Floats, spread: Floats) -> Floats:
    """Log density of distances, mixed with a little of what can be anything."""
    usual = _T1 - np.log(spread) - 2.0 * np.log1p(np.square((distances - mean) / spread) / TAIL)
    with np.errstate(invalid="ignore"):  # NaN where a marker is missing
        return np.asarray(np.logaddexp(usual, np.log(_STRANGE_DISTANCE)))


def pair_evidence(positions: Floats, known: MarkerDistances, pair: tuple[int, int]) -> Floats:
    """(T,) log odds that two markers of (T, M, 3) bear each other's labels, by distances to third ones; 0 = silent.

    The third markers are those whose steady distances to the two labels differ most.
    """
    mean, spread = known.mean[list(pair)], known.spread[list(pair)]
    telling = np.square(mean[0] - mean[1]) * np.square(1.0 / spread).sum(axis=0)
    telling[list(pair)] = np.nan
    third = np.argsort(np.where(np.isfinite(telling), -telling, np.inf), kind="stable")[:_PARTNERS]
    third = third[np.isfinite(telling[third])]
    odds = np.zeros(len(positions))
    for slot, other in ((0, 1), (1, 0)):
        distances = np.sqrt(np.square(positions[:, [pair[slot]]] - positions[:, third]).sum(axis=2))
        there = np.isfinite(distances)
        gain = distance_density(distances, mean[other, third], spread[other, third])
        gain -= distance_density(distances, mean[slot, third], spread[slot, third])
        odds += _WORTH * np.where(there, gain, 0.0).sum(axis=1) / np.maximum(there.sum(axis=1), 1)
    return odds


def suspicious_pairs(positions: Floats, known: MarkerDistances, least: float) -> Bools:
    """(F, M, M) where distances in F frames speak for a swap of two markers by more than `least`."""
    partners = known.partners
    markers = positions.shape[1]
    distances = pairwise(positions)  # (F, slot, partner)
    density = np.full((len(positions), markers, markers), np.nan)  # (F, label, slot)
    for label in range(markers):
        third = partners[label][partners[label] >= 0]
        if len(third) == 0:
            continue
        terms = distance_density(distances[:, :, third], known.mean[label, third], known.spread[label, third])
        terms[:, third, np.arange(len(third))] = np.nan
        usable = np.isfinite(terms)
        count = usable.sum(axis=2)
        mean = np.where(usable, terms, 0.0).sum(axis=2) / np.maximum(count, 1)
        density[:, label] = np.where(count > 0, mean, np.nan)
    own = np.einsum("fmm->fm", density)
    gain = density + density.transpose(0, 2, 1) - own[:, :, None] - own[:, None]
    return np.asarray(_WORTH * np.where(np.isfinite(gain), gain, 0.0) > least)
