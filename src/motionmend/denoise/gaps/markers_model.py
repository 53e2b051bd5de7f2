"""How the place of one marker depends on the markers about it, on time and on whose example it is."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ...arrays import Bools, Floats, Ints, frozen
from ...numerics.kriging import Prediction, krige, likeliest_amplitudes, matern32, matern52, squared_distances
from ...numerics.quantiles import median

GROUPS = (4, 6, 14)  # markers, nearest first; each group's say is found from the data
OWN = 2  # of the groups may say something else in this recording than in the library
UNIT = 0.05  # m; features in this unit are of the order of 1
TIMES = (0.1, 0.4, 1.6)  # s; what the markers about do not tell lasts this long
TIME_PARTS = len(TIMES)
UNKNOWN_MEAN = 100.0  # variances of a mean of which nothing is known
STRANGER = 0.01  # m; another person's marker may sit elsewhere by this much, and by UNKNOWN_MEAN variances
LEAST_SPREAD = 1e-4  # m
WOBBLE = 1e-3  # m; markers on skin and clothes hold to each other no better, however well a recording's frames agree
ENOUGH = 20  # frames of the recording, to see how far a marker moves


@dataclass(frozen=True, eq=False)
class Points:
    """Moments at which a marker is known or sought.

    Attributes
    ----------
    features : (N, F) places of the markers about it, in units; groups one after another.
    frame : (N,) of the recording; of an example 0.
    clip : (N,) 0 for the recording itself, others for examples of a library.
    """

    features: Floats
    frame: Ints
    clip: Ints


@dataclass(frozen=True, eq=False)
class Relation:
    """Groups of features and how far the features reach.

    Attributes
    ----------
    groups : slices of the features.
    reach : one per group, in units.
    taught : True where examples of a library are among the points.
    fps : Hz of the recording.
    """

    groups: tuple[slice, ...]
    reach: tuple[float, ...]
    taught: bool
    fps: float

    @property
    def own(self) -> tuple[int, ...]:
        """Groups that may differ from clip to clip."""
        return tuple(range(min(OWN, len(self.groups)))) if self.taught else ()


def relation(points: Points, markers: int, taught: bool, fps: float) -> Relation:
    """The relation of points with the features of this many markers, in a recording at `fps` Hz."""
    edges = np.minimum(np.cumsum((0, *GROUPS)), markers)
    groups = tuple(slice(3 * int(a), 3 * int(b)) for a, b in pairwise(edges) if b > a)
    own: Bools = points.clip == 0
    some = points.features[own if own.sum() >= ENOUGH else slice(None)][::2]
    reach = [float(np.sqrt(median(squared_distances(some[:, g], some[:, g]).ravel()))) for g in groups]
    return Relation(groups, tuple(max(r, 1e-3) for r in reach), taught, fps)


def _parts(points: Points, how: Relation) -> list[Floats]:
    """Covariance components of amplitude 1 between the points, noise last."""
    linear, near = [], []
    for group, reach in zip(how.groups, how.reach, strict=True):
        x = points.features[:, group]
        linear.append(x @ x.T / x.shape[1])
        near.append(np.exp(-0.5 * squared_distances(x, x) / reach**2))
    same = (points.clip[:, None] == points.clip).astype(float)
    found = [*linear, *near, *(linear[g] * same for g in how.own), *(near[g] * same for g in how.own)]
    # Of an example only one moment is known: what lasts in time is noise to it.
    here = ((points.clip[:, None] == 0) & (points.clip == 0)).astype(float)
    strange = np.diag((points.clip > 0).astype(float))
    away = np.abs(points.frame[:, None] - points.frame) / how.fps
    found += [_lasting(away, scale) * here + strange for scale in TIMES]
    return [*found, np.eye(len(same))]


def _lasting(away: Floats, scale: float) -> Floats:
    return matern32(away, scale) if scale > 1.0 else matern52(away, scale)


@lru_cache(maxsize=4)
def _lasting_so_long(frames: int, fps: float) -> Floats:
    """(TIME_PARTS, N) lasting components of amplitude 1, of moments 0, 1, ... N - 1 frames from each other.

    Of a long recording they take longer than all else, and each gap asks for other amplitudes of the same.
    """
    away = np.arange(frames) / fps
    return frozen(np.array([_lasting(away, scale) for scale in TIMES]))


def covariance(amplitudes: Floats, one: Points, other: Points, how: Relation) -> Floats:
    """(N, N') covariance of points: the sum of all components but noise and mean, and of examples' lasting ones.

    Of a point of the recording with itself the lasting ones are in it.
    """
    from ...kernels.kriged import moments_alike

    count, own = len(how.groups), how.own
    width = np.array([group.stop - group.start for group in how.groups], dtype=np.int64)
    shared, shared_near = np.zeros((2, count))
    shared[list(own)] = amplitudes[2 * count : 2 * count + len(own)] / width[list(own)]
    shared_near[list(own)] = amplitudes[2 * count + len(own) : 2 * count + 2 * len(own)]
    frames = np.concatenate([one.frame, other.frame])
    longest = int(np.ptp(frames)) + 1
    parts = _lasting_so_long(1 << longest.bit_length(), how.fps)[:, :longest]  # of few lengths: most are there
    lasting = sum(a * part for a, part in zip(amplitudes[-1 - TIME_PARTS : -1], parts, strict=True))
    return np.asarray(
        moments_alike(
            np.ascontiguousarray(one.features),
            np.ascontiguousarray(other.features.T),
            one.clip,
            other.clip,
            one.frame,
            other.frame,
            np.cumsum(np.append(0, width)),
            np.array(how.reach),
            amplitudes[:count] / width,
            amplitudes[count : 2 * count],
            shared,
            shared_near,
            lasting,
            one is other,
        )
    )


def prior_variance(amplitudes: Floats, points: Points, how: Relation) -> Floats:
    """(N,) variance of each point, noise included, mean not."""
    count, own = len(how.groups), how.own
    squares = np.array([np.square(points.features[:, g]).mean(axis=1) for g in how.groups]).reshape(
        count, len(points.frame)
    )
    total = amplitudes[:count] @ squares + amplitudes[count : 2 * count].sum() + amplitudes[-1 - TIME_PARTS :].sum()
    total = total + amplitudes[2 * count : 2 * count + len(own)] @ squares[list(own)]
    return np.asarray(total + amplitudes[2 * count + len(own) : 2 * count + 2 * len(own)].sum())


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a marker.

    Attributes
    ----------
    points : N.
    places : (N, 3) m, there.
    doubt : (N,) m² beyond the noise.
    wobble : m; by so much the relation to the markers about it differs from moment to moment.
    """

    points: Points
    places: Floats
    doubt: Floats
    wobble: float

    def centre(self) -> Floats:
        """(3,) mean place in the recording, of the examples if the recording has none."""
        own: Bools = self.points.clip == 0
        return np.asarray(self.places[own if own.any() else slice(None)].mean(axis=0))

    def spread(self) -> float:
        """Mean variance of a coordinate in the recording, in all examples if it has few frames."""
        own: Bools = self.points.clip == 0
        chosen = self.places[own if own.sum() >= ENOUGH else slice(None)]
        return max(float(chosen.var(axis=0).mean()), LEAST_SPREAD**2)

    def base(self) -> float:
        """Variance of a clip's own unknown mean."""
        return UNKNOWN_MEAN * (self.spread() + (STRANGER**2 if (self.points.clip > 0).any() else 0.0))


def learn(known: Known, how: Relation, rows: Ints, start: Floats | None, iterations: int) -> Floats:
    """Amplitudes of the components from some rows of what is known; `start` (P,) in variances of the marker."""
    points = known.points
    some = Points(points.features[rows], points.frame[rows], points.clip[rows])
    spread = known.spread()
    parts = np.array(_parts(some, how))
    share = np.maximum(np.trace(parts, axis1=1, axis2=2) / len(rows), 1e-6)
    guess = 0.3 * spread / share
    guess[-1] = 1e-3 * spread
    if start is not None and len(start) == len(guess):
        guess = np.maximum(0.5 * guess + 0.5 * start * spread, 1e-12)
    base = known.base() * (some.clip[:, None] == some.clip) + WOBBLE**2 * np.eye(len(rows))
    return likeliest_amplitudes(parts, base, known.places[rows] - known.centre(), guess, iterations)


def _noisy(amplitudes: Floats, known: Known, how: Relation) -> Floats:
    clip = known.points.clip
    cov = covariance(amplitudes, known.points, known.points, how) + known.base() * (clip[:, None] == clip)
    lasting = amplitudes[-1 - TIME_PARTS : -1].sum()
    cov[np.diag_indices(len(cov))] += amplitudes[-1] + np.where(clip > 0, lasting, 0.0) + known.doubt
    cov[np.diag_indices(len(cov))] += known.wobble**2 + 1e-9 * known.spread()
    return np.asarray(cov)


def predict(amplitudes: Floats, known: Known, how: Relation, sought: Points) -> Prediction:
    """Places (N', 3) at the points sought, and their variance (N',) of a coordinate, m²."""
    cross = covariance(amplitudes, sought, known.points, how)
    cross += known.base() * (sought.clip[:, None] == known.points.clip)
    prior = prior_variance(amplitudes, sought, how) + known.base() + known.wobble**2
    found = krige(_noisy(amplitudes, known, how), cross, prior, known.places - known.centre())
    return Prediction(found.mean + known.centre(), found.variance)
