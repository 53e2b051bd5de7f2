"""Joints that a sensor throws away for a frame: such as a model knows, and such as it lacks."""

from functools import cache

import numpy as np
import pytest
from sensed_people import NAMES, fitted, sensed, truth

from motionmend.bodies.postures import Postures

HANDS = ("HandTipLeft", "ThumbLeft", "HandTipRight")  # the model has none of them
WITH_HANDS = (*NAMES, *HANDS)
BAD = 18  # the frame


def with_hands(seed: int) -> Postures:
    positions = sensed(truth("reach", seed, 1.2), seed)
    beside = {"HandTipLeft": "HandLeft", "ThumbLeft": "HandLeft", "HandTipRight": "HandRight"}
    shakes = np.random.default_rng(seed).normal(scale=0.003, size=(len(HANDS), len(positions), 3))
    further = [
        positions[:, NAMES.index(beside[name])] + (0.02 * (k + 1), -0.07, 0.03) + shakes[k]
        for k, name in enumerate(HANDS)
    ]
    whole = np.concatenate([positions, np.stack(further, axis=1)], axis=1)
    return Postures(WITH_HANDS, whole, np.arange(len(whole)) / 30.0)


@cache
def usually(seed: int, look_ahead: int | None) -> Postures:
    """What comes of it where nothing was thrown away."""
    return fitted().correct(with_hands(seed), look_ahead=look_ahead)


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0, 4])
@pytest.mark.parametrize("away", [0.5, 5.0, np.nan])
@pytest.mark.parametrize("name", HANDS)
def test_what_the_model_lacks_stays_beside_its_neighbours(look_ahead, away, name):
    given = with_hands(3)
    joint = WITH_HANDS.index(name)
    thrown = given.positions.copy()
    thrown[BAD, joint, 0] += away
    usual = usually(3, look_ahead)
    told = fitted().correct(given.with_positions(thrown), look_ahead=look_ahead)
    off = np.linalg.norm(told.positions - usual.positions, axis=2)
    assert off.max() < 0.03
    assert told.reliability is not None
    assert usual.reliability is not None
    assert told.reliability[BAD, joint] == 0.0
    assert usual.reliability[BAD, joint] > 0.9
    assert told.std is not None
    assert told.std[BAD, joint] > off[BAD, joint]


def test_what_is_never_seen_of_them_stays_empty():
    given = with_hands(4)
    without = given.positions.copy()
    without[:, -1] = np.nan
    for look_ahead in (None, 0):
        told = fitted().correct(given.with_positions(without), look_ahead=look_ahead)
        assert np.isnan(told.positions[:, -1]).all()
        assert np.isfinite(told.positions[:, :-1]).all()


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0])
@pytest.mark.parametrize("name", ["HipCenter", "Spine", "ShoulderCenter", "HipLeft", "ShoulderRight"])
@pytest.mark.parametrize("away", [1.0, 5.0])
def test_a_joint_of_the_trunk_thrown_away_leaves_the_person_standing(look_ahead, name, away):
    given = with_hands(5)
    thrown = given.positions.copy()
    thrown[BAD, WITH_HANDS.index(name)] += away * np.array([0.6, 0.0, 0.8])
    usual = usually(5, look_ahead)
    told = fitted().correct(given.with_positions(thrown), look_ahead=look_ahead)
    assert np.linalg.norm(told.positions - usual.positions, axis=2).max() < 0.03
    assert told.reliability is not None
    assert told.reliability[BAD, WITH_HANDS.index(name)] == 0.0
