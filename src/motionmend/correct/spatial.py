"""The spatial term: the offset from a sensor's posture to the true one, from the posture's shape.

The paper predicts each joint's offset from the positions of its neighbours (section 4.1). People who were not seen in
training differ in size and stance, and positions relative to a root carry the root's own error into every joint; the
directions and lengths of all bones do not, and they say more of how a sensor sees a posture. So a committee of Gaussian
processes looks at those. Sensors err alike on both sides of the body, hence every sample counts twice, once mirrored;
and a share of the truth is wrong (a lost marker, the other leg), hence outliers weigh little (Student's t).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ..arrays import Floats, frozen
from .anatomy import Anatomy

DIRECTION = 0.25  # weight of a bone's unit direction beside its length (in standard metres)
NOISE = 0.3  # variance of an offset that posture does not tell, by that which it does
REACH = 1.5  # length of the kernel by the spread of all features together
SCOUTS = 150  # samples that tell how well known a posture is
FREEDOM = 4.0  # degrees of freedom of the offsets' Student-t distribution


@dataclass(frozen=True, eq=False)
class Committee:
    """Gaussian processes with one kernel, each on samples of its own; what they say is averaged.

    Attributes
    ----------
    centre : (D,) mean of the features.
    length : of the kernel.
    inputs : (M, N, D) features of each member's samples, less the centre.
    weights : (M, N, J*3).
    mean : (J, 3) standard metres, the offset far from all samples.
    norms : (M, N) squared lengths of the features.
    scouts : (M, S, S) inverse covariances of the first S samples, for the variance.
    spread : (J,) variance of an offset's coordinate, standard metres squared: what posture tells, far from all samples.
    floor : (J,) variance that stays however near the samples are.
    """

    centre: Floats
    length: float
    inputs: Floats
    weights: Floats
    mean: Floats
    norms: Floats
    scouts: Floats
    spread: Floats
    floor: Floats

    def __post_init__(self) -> None:
        for name in ("centre", "inputs", "weights", "mean", "norms", "scouts", "spread", "floor"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def predict(self, features: Floats) -> tuple[Floats, Floats]:
        """Offsets (T, J, 3) and the variance (T, J) of a coordinate, standard units.

        Parameters
        ----------
        features : (T, D) of `shape_features`.
        """
        queries = features - self.centre
        square = (queries**2).sum(axis=1)
        total = np.zeros((len(queries), self.weights.shape[2]))
        unknown = np.zeros(len(queries))
        for inputs, norms, weights, scouts in zip(self.inputs, self.norms, self.weights, self.scouts, strict=True):
            apart = queries @ inputs.T
            apart *= 2.0
            apart -= norms
            apart -= square[:, None]
            np.minimum(apart, 0.0, out=apart)
            apart *= 0.5 / self.length**2
            cross = np.exp(apart, out=apart)
            total += cross @ weights
            near = cross[:, : len(scouts)]
            unknown += 1.0 - ((near @ scouts) * near).sum(axis=1)
        members = len(self.inputs)
        offsets = self.mean + (total / members).reshape(len(queries), -1, 3)
        return offsets, np.maximum(unknown / members, 0.0)[:, None] * self.spread + self.floor

    def to_arrays(self) -> dict[str, Any]:
        """What `from_arrays` needs."""
        return {name: np.asarray(getattr(self, name)) for name in self.__dataclass_fields__}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "Committee":
        """The committee that `to_arrays` took apart."""
        return cls(
            **{name: arrays[name] for name in cls.__dataclass_fields__ if name != "length"},
            length=float(arrays["length"]),
        )


def shape_features(standard: Floats, body: Anatomy) -> Floats:
    """(T, 4B) directions and lengths of the bones of postures (T, J, 3) in standard form."""
    bones = standard[:, body.bones[:, 1]] - standard[:, body.bones[:, 0]]
    length = np.sqrt((bones**2).sum(axis=2))
    unit = DIRECTION * bones / np.maximum(length, 1e-9)[..., None]
    return np.hstack([unit.reshape(len(standard), -1), length])


def mirrored_postures(standard: Floats, body: Anatomy) -> Floats:
    """(T, J, 3) the postures (or offsets) of the same people seen in a mirror, still named by their own sides."""
    return np.asarray(standard[:, body.mirror] * np.array([-1.0, 1.0, 1.0]))


def fit_committee(
    standard: Floats, offsets: Floats, body: Anatomy, members: int = 1, size: int = 800, seed: int = 0, rounds: int = 3
) -> Committee:
    """Learn a committee.

    Parameters
    ----------
    standard : (N, J, 3) what the sensor said, in standard form, complete.
    offsets : (N, J, 3) truth less that, standard units; NaN where the truth is not known.
    body : the joint set.
    members : M, Gaussian processes.
    size : samples of each, half of them mirrored.
    seed : of the choice of samples.
    rounds : of reweighting against outliers.
    """
    rng = np.random.default_rng(seed)
    mean = _robust_mean(offsets, body)
    features = shape_features(standard, body), shape_features(mirrored_postures(standard, body), body)
    centre = 0.5 * (features[0].mean(axis=0) + features[1].mean(axis=0))
    length = REACH * float(np.sqrt(0.5 * (features[0].var(axis=0) + features[1].var(axis=0)).sum())) or 1.0
    half = min(size // 2, len(standard))
    known = np.asarray(np.isfinite(offsets).all(axis=2))
    targets = np.where(known[..., None], offsets, mean) - mean
    parts: dict[str, list[Floats]] = {"inputs": [], "weights": [], "norms": [], "scouts": [], "left": [], "heard": []}
    for chosen in _shares(len(standard), members, half, rng):
        inputs = np.vstack([features[0][chosen], features[1][chosen]]) - centre
        output = np.vstack([targets[chosen], mirrored_postures(targets[chosen], body)])
        have = np.vstack([known[chosen], known[chosen][:, body.mirror]])
        kernel = np.exp(-0.5 * _squares(inputs) / length**2)
        weights, left = _robust_weights(kernel, output, have, rounds)
        parts["inputs"].append(inputs)
        parts["weights"].append(weights)
        parts["norms"].append((inputs**2).sum(axis=1))
        few = min(SCOUTS, len(inputs))
        parts["scouts"].append(np.asarray(np.linalg.inv(kernel[:few, :few] + NOISE * np.eye(few)), dtype=np.float64))
        parts["left"].append(left)
        parts["heard"].append((kernel @ weights).reshape(output.shape).var(axis=(0, 2)))
    floor = np.mean(parts["left"], axis=0)
    return Committee(
        centre,
        length,
        np.stack(parts["inputs"]),
        np.stack(parts["weights"]),
        mean,
        np.stack(parts["norms"]),
        np.stack(parts["scouts"]),
        floor / NOISE,
        floor,
    )


def _robust_mean(offsets: Floats, body: Anatomy) -> Floats:
    """(J, 3) median offset, alike on both sides; 0 where no truth is known."""
    both = np.vstack([offsets, mirrored_postures(offsets, body)])
    known = np.isfinite(both).all(axis=(0, 2)) | np.isfinite(both).any(axis=(0, 2))
    mean = np.zeros(offsets.shape[1:])
    if known.any():
        mean[known] = np.nanmedian(both[:, known], axis=0)
    return mean


def _shares(count: int, members: int, half: int, rng: np.random.Generator) -> list[Any]:
    """Samples of each member: disjoint as long as there are enough of them."""
    order = rng.permutation(count)
    need = members * half
    repeated = np.concatenate([order] * (need // max(count, 1) + 1))[:need]
    return list(np.split(repeated, members)) if count >= need else [order[:half]]


def _robust_weights(kernel: Floats, output: Floats, have: Any, rounds: int) -> tuple[Floats, Floats]:
    """Prediction vectors (N, J*3) under Student-t noise, and the variance (J,) that is left."""
    count, joints, _ = output.shape
    weights = np.zeros((count, joints * 3))
    left = np.zeros(joints)
    for j in range(joints):
        if not have[:, j].any():
            continue
        trust = np.where(have[:, j], 1.0, 1e-6)
        for _ in range(rounds):
            system = kernel + np.diag(NOISE / trust)
            found = cho_solve(cho_factor(system, lower=True), output[:, j])
            rest = ((output[:, j] - kernel @ found) ** 2).sum(axis=1)
            scale = max(float(np.median(rest[have[:, j]])) / 2.37, 1e-12)  # a coordinate's variance: median of chi2(3)
            trust = np.where(have[:, j], (FREEDOM + 3.0) / (FREEDOM + rest / scale), 1e-6)
        weights[:, 3 * j : 3 * j + 3] = found
        left[j] = float(np.average(rest, weights=trust)) / 3.0
    return weights, left


def _squares(rows: Floats) -> Floats:
    norm = (rows**2).sum(axis=1)
    return np.asarray(np.maximum(norm[:, None] + norm - 2.0 * rows @ rows.T, 0.0))
