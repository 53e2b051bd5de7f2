"""The spatial term: the offset from a sensor's posture to the true one, from the posture's shape.

The paper predicts each joint's offset from the positions of its neighbours (section 4.1). People who were not seen in
training differ in size and stance, and positions relative to a root carry the root's own error into every joint; the
directions and lengths of bones do not, and they say more of how a sensor sees a posture. A joint's Gaussian process
looks at all bones, the less the further they are from the joint: a leg's offset hardly depends on the arms, and who
compares whole postures finds none alike among a few people. Sensors err alike on both sides of the body, hence every
sample counts twice, once mirrored; and a share of the truth is wrong (a lost marker, the other leg), hence outliers
weigh little (Student's t). A frame says little that the frame before did not say: thousands of them are brought down to
some hundred points (subset of regressors; Quinonero-Candela and Rasmussen, JMLR 6, 2005, section 3).

Kernels long enough to carry over to other people carry too far in postures that nobody showed: there single bones still
resemble learned ones, and what they tell is wrong. How far a posture as a whole is known decides how much of it counts;
in one that is like none the mean offset is left.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.csgraph import shortest_path

from ..arrays import Floats, Ints, Singles, frozen
from ..kernels import shapes as kernel
from .anatomy import Anatomy

DIRECTION = 0.15  # weight of a bone's unit direction beside its length (in standard metres)
NEAR = 2.0  # bones from a joint within which the weight of a bone falls to 1 / e
NOISE = 1.0  # variance of a frame's offset that posture does not tell, by that which it does
REACH = 1.5  # length of the kernel by the spread of the weighted features together
SCOUTS = 150  # points that tell how well known a posture is, half of them mirrored
FAMILIAR = 0.75  # of how well the points are known: strangers' postures in movements that were learned nearly all are
FREEDOM = 4.0  # degrees of freedom of the offsets' Student-t distribution
SCOUTED = 0.3  # variance of what a point tells
ROUNDS = 3  # of reweighting against outliers
SHARES = 3  # parts of the samples, each judged by what the others teach
AT_ONCE = 64  # frames


@dataclass(frozen=True, eq=False)
class Processes:
    """A Gaussian process for each joint whose truth was known, all on the same points.

    Attributes
    ----------
    told : (K,) those joints.
    centre : (B, 4) mean of the bones' features.
    points : (M, B, 4) features less the centre.
    share : (K, B) inverse squared length of each joint's kernel along each bone's features.
    weights : (K, M, 3).
    mean : (J, 3) standard metres, the offset far from all points.
    whole : (1, B) inverse squared length of a kernel of the whole posture, for the variance.
    scouts : (S, S) inverse covariance of the first S points under it.
    spread : (J,) variance of an offset's coordinate, standard metres squared: what posture tells, far from all points.
    floor : (J,) variance that stays however near the points are, as samples left out tell it.
    """

    told: Ints
    centre: Floats
    points: Floats
    share: Floats
    weights: Floats
    mean: Floats
    whole: Floats
    scouts: Floats
    spread: Floats
    floor: Floats

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            object.__setattr__(self, name, frozen(getattr(self, name), np.int64 if name == "told" else np.float64))

    @cached_property
    def single(self) -> tuple[Singles, Singles, Singles]:
        """Points (4, B, M) as columns, exponents (K + 1, B) of all kernels, that of the whole posture last, and scouts.

        Single precision leaves 1e-7 of a kernel's value, and takes a third of the time.
        """
        exponents = -0.5 * np.concatenate([self.share, self.whole])
        return frozen(self.points.T, np.float32), frozen(exponents, np.float32), frozen(self.scouts, np.float32)

    @cached_property
    def familiar(self) -> float:
        """Share of the variance that is taken away from a posture in which all that the points tell is believed."""
        scouts = self.points[: len(self.scouts)]
        near = covariances(self.whole, self.points, scouts, squares(self.whole, scouts))[0]
        return FAMILIAR * float(np.median(((near @ self.scouts) * near).sum(axis=1)))

    def predict(self, features: Floats) -> tuple[Floats, Floats]:
        """Offsets (T, J, 3) and the variance (T, J) of a coordinate, standard units.

        Parameters
        ----------
        features : (T, B, 4) of `shape_features`.
        """
        columns, exponents, scouts = self.single
        offsets = np.empty((len(features), *self.mean.shape))
        variance = np.empty(offsets.shape[:2])
        for first in range(0, len(features), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            like = exponents @ kernel.apart(features[some], self.centre, columns)  # one distance for all kernels
            np.exp(like, out=like)
            kernel.told(
                like,
                self.weights,
                self.told,
                self.mean,
                scouts,
                self.spread,
                self.floor,
                self.familiar,
                offsets[some],
                variance[some],
            )
        return offsets, variance

    def to_arrays(self) -> dict[str, Any]:
        """What `from_arrays` needs."""
        return {name: np.asarray(getattr(self, name)) for name in self.__dataclass_fields__}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "Processes":
        """The processes that `to_arrays` took apart."""
        return cls(**{name: arrays[name] for name in cls.__dataclass_fields__})


def shape_features(standard: Floats, body: Anatomy) -> Floats:
    """(T, B, 4) directions and lengths of the bones of postures (T, J, 3) in standard form."""
    return np.asarray(kernel.directions(np.ascontiguousarray(standard), body.bones, DIRECTION))


def mirrored_postures(standard: Floats, body: Anatomy) -> Floats:
    """(T, J, 3) the postures (or offsets) of the same people seen in a mirror, still named by their own sides."""
    return np.asarray(standard[:, body.mirror] * np.array([-1.0, 1.0, 1.0]))


def fit_processes(
    standard: Floats, offsets: Floats, body: Anatomy, points: int = 400, frames: int = 4000, seed: int = 0
) -> Processes:
    """Learn the offsets.

    Parameters
    ----------
    standard : (N, J, 3) what the sensor said, in standard form, complete; recordings of one person stand together.
    offsets : (N, J, 3) truth less that, standard units; NaN where the truth is not known.
    body : the joint set.
    points : M, half of them mirrored.
    frames : to learn from at most.
    seed : of the choice of points and frames.
    """
    rng = np.random.default_rng(seed)
    chosen = rng.permutation(len(standard))[:frames]
    mean = _robust_mean(offsets, body)
    mirrored = mirrored_postures(standard[chosen], body)
    features = np.concatenate([shape_features(standard[chosen], body), shape_features(mirrored, body)])
    centre = features.mean(axis=0)
    features -= centre
    known = np.asarray(np.isfinite(offsets[chosen]).all(axis=2))
    less = np.where(known[..., None], offsets[chosen] - mean, 0.0)
    targets = np.concatenate([less, mirrored_postures(less, body)])
    have = np.concatenate([known, known[:, body.mirror]])
    half = min(points // 2, len(chosen))
    beside = np.stack([np.arange(half), np.arange(half) + len(chosen)], axis=1)  # each and its mirrored: scouts are too
    at = features[beside.ravel()]
    varied = (features**2).mean(axis=0).sum(axis=1)
    share = _share(body, varied)
    whole = np.full((1, len(varied)), 1.0 / (REACH**2 * max(float(varied.sum()), 1e-12)))
    parts = np.tile(chosen * SHARES // len(standard), 2)
    told = np.flatnonzero(have.any(axis=0))
    weights = np.zeros((len(told), len(at), 3))
    spread, floor = np.zeros(len(mean)), np.zeros(len(mean))
    for k, j in enumerate(told):
        rows, own = have[:, j], share[j : j + 1]
        norms = squares(own, at)
        prior = covariances(own, at, at, norms)[0] + 1e-6 * np.eye(len(at))
        cross = covariances(own, features[rows], at, norms)[0]
        weights[k], floor[j] = _robust_weights(prior, cross, targets[rows, j], parts[rows])
        spread[j] = float((cross @ weights[k]).var(axis=0).mean())
    few = at[: min(SCOUTS, len(at))]
    like = covariances(whole, few, few, squares(whole, few))[0]
    scouts = np.asarray(np.linalg.inv(like + SCOUTED * np.eye(len(few))), dtype=np.float64)
    return Processes(told, centre, at, share[told], weights, mean, whole, scouts, spread, floor)


def squares(share: Floats, points: Floats) -> Floats:
    """(K, M) squared lengths of features (M, B, 4) under kernels (K, B)."""
    return np.asarray(share @ (points**2).sum(axis=2).T)


def covariances(share: Floats, queries: Floats, points: Floats, norms: Floats) -> Floats:
    """(K, T, M) of offsets under kernels (K, B), at features (T, B, 4) and (M, B, 4), `norms` of `squares`."""
    return np.asarray(np.exp(_logarithms(share, queries, points, norms)))


def _logarithms(share: Floats, queries: Floats, points: Floats, norms: Floats) -> Floats:
    weighted = share[:, None, :, None] * queries
    found = weighted.reshape(-1, queries[0].size) @ points.reshape(len(points), -1).T
    found = found.reshape(len(share), len(queries), len(points))
    found -= 0.5 * ((weighted * queries).sum(axis=(2, 3))[..., None] + norms[:, None])
    return np.asarray(found)


def _share(body: Anatomy, varied: Floats) -> Floats:
    """(J, B) inverse squared lengths of the kernels: bones count the less the further they are from the joint."""
    weight = np.exp(-_bones_away(body) / NEAR)
    return np.asarray(weight / (REACH**2 * np.maximum(weight @ varied, 1e-12)[:, None]))


def _bones_away(body: Anatomy) -> Floats:
    """(J, B) bones between a joint and the nearer end of each bone; as many as there are joints where none lead."""
    count = len(body.names)
    bones = np.zeros((count, count))
    bones[body.bones[:, 0], body.bones[:, 1]] = 1.0
    away = np.minimum(shortest_path(bones, directed=False, unweighted=True), float(count))
    return np.asarray(np.minimum(away[:, body.bones[:, 0]], away[:, body.bones[:, 1]]))


def _robust_mean(offsets: Floats, body: Anatomy) -> Floats:
    """(J, 3) median offset, alike on both sides; 0 where no truth is known."""
    both = np.vstack([offsets, mirrored_postures(offsets, body)])
    known = np.isfinite(both).any(axis=(0, 2))
    mean = np.zeros(offsets.shape[1:])
    if known.any():
        mean[known] = np.nanmedian(both[:, known], axis=0)
    return mean


def _robust_weights(prior: Floats, cross: Floats, output: Floats, parts: Ints) -> tuple[Floats, float]:
    """Weights (M, 3) of the points by samples (N, M) under Student-t noise, and the variance of a coordinate in samples
    of one part as the other parts teach it."""
    trust = np.ones(len(output))
    rows = [np.flatnonzero(parts == part) for part in range(SHARES)]
    shares = [(cross[own], output[own]) for own in rows]
    for _ in range(ROUNDS):
        normal = [_normal(*share, trust[own]) for share, own in zip(shares, rows, strict=True)]
        gram, right = np.sum([one for one, _ in normal], axis=0), np.sum([one for _, one in normal], axis=0)
        found = cho_solve(cho_factor(prior + gram, lower=True), right)
        trust = _trust(output - cross @ found)
    rest = np.empty(output.shape)
    for (known, told), own, (own_gram, own_right) in zip(shares, rows, normal, strict=True):
        taught = cho_solve(cho_factor(prior + gram - own_gram, lower=True), right - own_right)
        rest[own] = told - known @ taught
    return np.asarray(found), float(np.average((rest**2).sum(axis=1), weights=trust)) / 3.0


def _normal(cross: Floats, output: Floats, trust: Floats) -> tuple[Floats, Floats]:
    """(M, M) and (M, 3): what samples say of the points' weights."""
    scale = np.sqrt(trust / NOISE)[:, None]
    cross, output = cross * scale, output * scale
    return np.asarray(cross.T @ cross), np.asarray(cross.T @ output)


def _trust(rest: Floats) -> Floats:
    """(N,) weights of residuals (N, 3) under Student's t, their scale from the median."""
    square = (rest**2).sum(axis=1)
    scale = max(float(np.median(square)) / 2.37, 1e-12)  # a coordinate's variance: median of chi2(3)
    return np.asarray((FREEDOM + 3.0) / (FREEDOM + square / scale))
