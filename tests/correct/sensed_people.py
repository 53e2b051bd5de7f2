"""Synthetic people as a sensor sees them: the samples' performer, 20 joints, a bias that posture tells, some noise."""

from functools import cache

import numpy as np

from motionmend import samples
from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT20, correspondence
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import positions as joint_positions
from motionmend.correct import Corrector, CorrectorModel, Pair

NAMES = KINECT20.names
_NAMED = {"thorax": "neck_base"}


def truth(action: str, seed: int, seconds: float = 2.0) -> Floats:
    """(T, 20, 3) m at 30 Hz, y up."""
    return _truth(action, seed, seconds).copy()  # some spoil what they are given


@cache
def _truth(action: str, seed: int, seconds: float) -> Floats:
    clip = samples.clip(action, seconds=seconds, seed=seed)
    where = joint_positions(clip.skeleton, clip.q[:: round(clip.fps / 30)])
    found = correspondence(clip.skeleton.names, NAMES)
    found[NAMES.index("ShoulderCenter")] = clip.skeleton.names.index("thorax")
    assert (found >= 0).all()
    return np.asarray(where[:, found])


def sensed(positions: Floats, seed: int, noise: float = 0.002) -> Floats:
    """(T, 20, 3) what the sensor makes of it: joints drawn toward the pelvis, each with a shift of its own."""
    own = 0.03 * np.random.default_rng(99).normal(size=(20, 3)) * [0.0, 1.0, 0.0]
    pelvis = positions[:, :1]
    drawn = pelvis + (positions - pelvis) * (1.0 - 0.08 * np.tanh(np.abs(positions - pelvis)))
    return np.asarray(drawn + own + noise * np.random.default_rng(seed).normal(size=positions.shape))


def recording(positions: Floats, state: bool = False) -> Postures:
    """At 30 Hz."""
    told = np.full(positions.shape[:2], 2, dtype=np.uint8) if state else None
    return Postures(NAMES, positions, np.arange(len(positions)) / 30.0, told)


def pair(action: str, seed: int, seconds: float = 2.0) -> Pair:
    """A sensor's recording and the truth."""
    true = truth(action, seed, seconds)
    return Pair(recording(sensed(true, seed)), recording(true))


@cache
def fitted() -> CorrectorModel:
    """A corrector that has seen six people walk, reach and jump; one for all files that a process runs."""
    actions = ("walk", "reach", "jump") if {"walk", "reach", "jump"} <= set(samples.ACTIONS) else samples.ACTIONS[:3]
    return Corrector(points=150).fit([pair(action, seed) for seed in range(3) for action in actions])


def error(postures: Postures, true: Floats) -> float:
    """Mean distance, m."""
    return float(np.linalg.norm(postures.positions - true, axis=2).mean())
