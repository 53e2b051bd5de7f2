"""A corrector learned from the synthetic performer, seen by a sensor that is wrong by as much in every joint."""

import numpy as np
import pytest

from motionmend import samples
from motionmend.bodies.joint_sets import KINECT20, correspondence
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import positions
from motionmend.correct import Corrector, CorrectorModel, Pair


@pytest.fixture(scope="session")
def model() -> CorrectorModel:
    rng = np.random.default_rng(5)
    return Corrector(points=60).fit([_pair(action, rng) for action in ("walk", "reach")])


def _pair(action: str, rng: np.random.Generator) -> Pair:
    clip = samples.clip(action, seconds=3.0, seed=1)
    joints = correspondence(clip.skeleton.names, KINECT20.names)
    truth = positions(clip.skeleton, clip.q)[::4, joints]
    sensor = truth + 0.03 * np.sin(np.arange(60.0)).reshape(20, 3) + rng.normal(0, 0.004, truth.shape)
    times, state = np.arange(len(truth)) / 30.0, np.full(truth.shape[:2], 2, np.uint8)
    return Pair(Postures(KINECT20.names, sensor, times, state=state), Postures(KINECT20.names, truth, times))
