"""Markers that stand in the room while the body goes on, and leap to it afterwards."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.stood_still import stood_still
from motionmend.samples import markers
from performers import truth

NOISE = 0.0005  # m


def _walking(fps, action="walk", seed=5):
    return markers(truth(action, seed=seed, seconds=4.0, fps=fps))


def _shaken(positions, noise=NOISE, seed=0):
    return positions + noise * np.random.default_rng(seed).standard_normal(positions.shape)


def _standing(positions, fps, marker, first, seconds):
    """A marker that stays where it is in a frame, for so long."""
    last = first + round(seconds * fps)
    result = positions.copy()
    result[first:last, marker] = result[first, marker]
    return result, last


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("marker", [0, 4, 9, 13])
def test_who_stands_while_others_go_on_is_found(fps, marker):
    walk = _walking(fps)
    first = round(1.2 * fps)
    held, last = _standing(walk.positions, fps, marker, first, 0.5)
    found = stood_still(walk.with_positions(_shaken(held)))
    assert found[first + 3 : last, marker].all()
    found[first - round(0.1 * fps) : last, marker] = False
    assert not found.any()


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump", "turn", "reach"])
@pytest.mark.parametrize("noise", [0.0, 0.0005, 0.003])
def test_feet_on_the_ground_and_people_at_rest_stand_as_they_may(action, noise):
    for fps in (30.0, 120.0):
        clean = _walking(fps, action)
        assert not stood_still(clean.with_positions(_shaken(clean.positions, noise))).any()


def test_outliers_and_who_leaps_from_a_rest_are_not_taken_for_it():
    walk = _walking(60.0)
    rng = np.random.default_rng(1)
    spoilt = _shaken(walk.positions, 0.002)
    wrong = rng.random(spoilt.shape[:2]) < 0.2
    spoilt[wrong] += 0.1 * rng.standard_normal((int(wrong.sum()), 3))
    assert not stood_still(walk.with_positions(spoilt)).any()
    rest = np.repeat(walk.positions[:1], 120, axis=0)
    rest[60:, 3] += 0.2  # knocked off, or swapped, while everybody stands
    assert not stood_still(walk.at_frames(np.arange(120)).with_positions(_shaken(rest))).any()


@pytest.mark.parametrize("frames", [0, 1, 3, 8])
def test_few_frames_tell_nothing(frames):
    assert not stood_still(_walking(60.0).at_frames(np.arange(frames))).any()


@pytest.mark.slow
def test_what_follows_is_believed_and_what_stood_is_filled():
    """All that followed the leap was taken for wrong: the error was twice that of the recording."""
    walk = _walking(60.0)
    held, last = _standing(walk.positions, 60.0, 9, 80, 0.6)
    spoilt = walk.with_positions(_shaken(held))
    outcome = repair_without_model(spoilt)
    off = np.linalg.norm(outcome.recording.positions - walk.positions, axis=2)
    assert np.linalg.norm(spoilt.positions - walk.positions, axis=2)[:, 9].max() > 0.1
    assert off[82:last, 9].max() < 0.03
    assert off[last:, 9].max() < 0.005
    assert (outcome.origin[84:last, 9] == Origin.REPAIRED).all()
    assert (outcome.origin[last + 1 :, 9] == Origin.MEASURED).all()
    assert any("stood still while those about them went on" in warning for warning in outcome.warnings)
