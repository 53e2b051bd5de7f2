"""What learned linear dynamics are: arrays, and the state-space model they make.

pose(t) = mean + poses · z(t) + rest · u(t)
z(t+1)  = first · z(t) + second · z(t-1) + N(0, process_cov)
u(t+1)  = rest_decay · u(t) + N(0, (1 - rest_decay²) rest_var)
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...arrays import Bools, Floats, frozen
from ...numerics.smoother import StateSpace

_SLACK = 2.0  # a new recording may start this much further from the mean than the clips do, in variance


@dataclass(frozen=True, eq=False)
class Dynamics:
    """C channels in comparable units (degrees, centimetres), K principal poses, R further directions.

    Attributes
    ----------
    fps : rate of the dynamics, Hz.
    known : (C,) True where the clips move; the model says nothing of the other channels.
    mean : (C,) pose.
    poses : (C, K) orthonormal, by falling variance; 0 in unknown channels.
    first, second : (K, K).
    process_cov : (K, K).
    start_cov : (2 K, 2 K) covariance of (z(t), z(t-1)).
    rest : (C, R) orthonormal, the directions the poses leave out.
    rest_decay : (R,) in [0, 1).
    rest_var : (R,) variance of u.
    """

    fps: float
    known: Bools
    mean: Floats
    poses: Floats
    first: Floats
    second: Floats
    process_cov: Floats
    start_cov: Floats
    rest: Floats
    rest_decay: Floats
    rest_var: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "known", frozen(self.known, np.bool_))
        for field in fields(self):
            if field.name not in ("fps", "known"):
                object.__setattr__(self, field.name, frozen(getattr(self, field.name)))

    def to_arrays(self) -> dict[str, Any]:
        """Arrays from which `from_arrays` makes the dynamics again."""
        arrays: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        return arrays | {"fps": np.array([self.fps]), "known": self.known.astype(np.uint8)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "Dynamics":
        """The dynamics that `to_arrays` took apart."""
        return cls(**{**{f.name: arrays[f.name] for f in fields(cls)}, "fps": float(arrays["fps"][0])})


@dataclass(frozen=True)
class Trust:
    """How far a recording bears the model out: factors on the variances of its poses' steps, its rest and the noise."""

    poses: float = 1.0
    rest: float = 1.0
    noise: float = 1.0


def state_space(dynamics: Dynamics, trust: Trust) -> StateSpace:
    """States (z(t), z(t-1), u(t)) of the known channels, with the variances that this trust gives them."""
    known = dynamics.known
    count, others = dynamics.poses.shape[1], dynamics.rest.shape[1]
    size = 2 * count + others
    z, before, u = slice(0, count), slice(count, 2 * count), slice(2 * count, size)
    transition, process_cov, start_cov = (np.zeros((size, size)) for _ in range(3))
    transition[z, z], transition[z, before] = dynamics.first, dynamics.second
    transition[before, z] = np.eye(count)
    transition[u, u] = np.diag(dynamics.rest_decay)
    process_cov[z, z] = trust.poses * dynamics.process_cov
    process_cov[u, u] = np.diag(trust.rest * (1.0 - dynamics.rest_decay**2) * dynamics.rest_var)
    start_cov[: 2 * count, : 2 * count] = _SLACK * max(trust.poses, 1.0) * dynamics.start_cov
    start_cov[u, u] = np.diag(_SLACK * max(trust.rest, 1.0) * dynamics.rest_var)
    observation = np.zeros((int(known.sum()), size))
    observation[:, z], observation[:, u] = dynamics.poses[known], dynamics.rest[known]
    return StateSpace(transition, process_cov, observation, np.zeros(size), start_cov)
