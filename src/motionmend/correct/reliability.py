"""How far each joint of a sensor's posture is to be trusted, in [0, 1] (section 4.4).

The paper's three measures, after Shum et al. 2013, are behaviour (a joint that turns back on itself from frame to
frame), kinematics (bones that change their length) and the tracking state. The default weighs such evidence together,
as log-likelihood ratios, with one more: where the joint is expected from the joints that can be trusted and from the
past. A failure lasts, so what was believed a frame ago counts (a hidden Markov chain of two states).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, frozen
from ..bodies.postures import INFERRED, NOT_TRACKED, TRACKED
from .anatomy import Anatomy

STATE_TRUST = {TRACKED: 1.0, INFERRED: 0.5, NOT_TRACKED: 0.0}
LENGTH_TOLERANCE = 0.1  # a bone's relative change at which kinematic reliability falls to exp(-1/2)
STEADY = 0.005  # m; smaller displacements than this have no direction to speak of
FAILING_SECONDS, HONEST_SECONDS = 1.0, 8.0  # how long a failure lasts, how long a joint goes well


def behaviour(now: Floats, before: Floats, earlier: Floats) -> Floats:
    """(J,) 1 for a joint that goes on as it went, 0 for one that turns straight back.

    The cosine between two displacements, from [-1, 1] to [0, 1]; displacements too small to have a direction count as
    steady.
    """
    last, first = now - before, before - earlier
    lengths = np.sqrt((last**2).sum(axis=1) * (first**2).sum(axis=1))
    cosine = (last * first).sum(axis=1) / np.maximum(lengths, 1e-12)
    small = np.minimum(np.sqrt((last**2).sum(axis=1)), np.sqrt((first**2).sum(axis=1))) < STEADY
    return np.where(small | ~np.isfinite(cosine), 1.0, 0.5 * (1.0 + np.clip(cosine, -1.0, 1.0)))


def kinematics(lengths: Floats, usual: Floats, body: Anatomy) -> Floats:
    """(J,) 1 while the bones at a joint keep their usual lengths, toward 0 as they do not.

    Parameters
    ----------
    lengths, usual : (B,) m, NaN where not known.
    """
    off = np.log(np.maximum(lengths, 1e-6) / np.maximum(usual, 1e-6)) / LENGTH_TOLERANCE
    good = np.where(np.isfinite(off), np.exp(-0.5 * off**2), 1.0)
    total, count = np.zeros(len(body.names)), np.zeros(len(body.names))
    for end in (0, 1):
        np.add.at(total, body.bones[:, end], good)
        np.add.at(count, body.bones[:, end], 1.0)
    return np.where(count > 0, total / np.maximum(count, 1.0), 1.0)


def tracking(states: Bytes | None, present: Bools) -> Floats:
    """(J,) what the sensor says: 1 tracked, 0.5 inferred, 0 not tracked or missing; 1 when it says nothing."""
    if states is None:
        return present.astype(np.float64)
    trust = np.array([STATE_TRUST[NOT_TRACKED], STATE_TRUST[INFERRED], STATE_TRUST[TRACKED]])
    return np.where(present, trust[np.minimum(states, 2)], 0.0)


def paper_reliability(parts: tuple[Floats, Floats, Floats]) -> Floats:
    """(J,) the three measures together: the mean of the first two, times what the sensor says."""
    moving, jointed, told = parts
    return 0.5 * (moving + jointed) * told


@dataclass(frozen=True, eq=False)
class Detector:
    """Evidence of failure, weighed.

    Attributes
    ----------
    weights : (F + 1,) of the features and, last, a constant: the log-likelihood ratio of failing to going well. The
        features, in order: misplaced by what all others say, by what was forecast, own bone off, best bone off, jerky,
        inferred, not tracked, tracked.
    bone_spread : (B,) usual standard deviation of the logarithm of each bone's length in a recording.
    jerk : (J,) usual size of the second difference, standard metres.
    """

    weights: Floats
    bone_spread: Floats
    jerk: Floats

    def __post_init__(self) -> None:
        for name in ("weights", "bone_spread", "jerk"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def to_arrays(self) -> dict[str, Any]:
        """What `from_arrays` needs."""
        return {name: np.asarray(getattr(self, name)) for name in self.__dataclass_fields__}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> "Detector":
        """The detector that `to_arrays` took apart."""
        return cls(**{name: arrays[name] for name in cls.__dataclass_fields__})


def chain_backward(forecasts: Floats, filtered: Floats, seconds: Floats) -> Floats:
    """(T, J) belief that joints fail once the whole recording is known.

    Parameters
    ----------
    forecasts, filtered : (T, J) of `Followed`: `forecast` and `failing`.
    seconds : (T,) since the frame before; infinite where the two frames say nothing of each other.
    """
    smoothed = np.array(filtered)
    for t in range(len(filtered) - 2, -1, -1):
        if not np.isfinite(seconds[t + 1]):
            continue
        out = 1.0 - np.exp(-seconds[t + 1] / FAILING_SECONDS)
        into = 1.0 - np.exp(-seconds[t + 1] / HONEST_SECONDS)
        stays = filtered[t] * (
            (1.0 - out) * smoothed[t + 1] / forecasts[t + 1] + out * (1.0 - smoothed[t + 1]) / (1.0 - forecasts[t + 1])
        )
        goes = (1.0 - filtered[t]) * (
            into * smoothed[t + 1] / forecasts[t + 1]
            + (1.0 - into) * (1.0 - smoothed[t + 1]) / (1.0 - forecasts[t + 1])
        )
        smoothed[t] = stays / np.maximum(stays + goes, 1e-300)
    return smoothed
