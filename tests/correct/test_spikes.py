"""Joints that were away for a frame or two, known by what comes after."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensed_people import NAMES, fitted, sensed, truth

from motionmend.bodies.joint_sets import mirrored
from motionmend.bodies.postures import Postures
from motionmend.correct import corrector
from motionmend.correct.spikes import thrown_and_back
from motionmend.correct.watching import look

SEEDS = st.integers(0, 10**6)
MIRROR = mirrored(NAMES)


def _moving(rng, fps, frames=60):
    """Joints that swing as briskly as limbs do: up to 60 m/s^2."""
    t = np.arange(frames)[:, None, None] / fps
    pace = rng.uniform(1.0, 12.0, (1, len(NAMES), 3))
    size = np.minimum(0.4, 60.0 / np.sqrt(3.0) / pace**2)
    return rng.uniform(-1.0, 1.0, (1, len(NAMES), 3)) + size * np.sin(pace * t + rng.uniform(0.0, 6.0, size.shape))


@given(SEEDS, st.sampled_from([15.0, 30.0, 60.0]))
@settings(max_examples=40)
def test_what_limbs_do_is_no_spike(seed, fps):
    positions = _moving(np.random.default_rng(seed), fps)
    assert not thrown_and_back(positions, np.arange(len(positions)) / fps, MIRROR).any()


@given(SEEDS, st.sampled_from([1, 2]), st.floats(0.5, 5.0))
@settings(max_examples=40)
def test_a_joint_away_for_a_frame_or_two_is_found_and_no_other(seed, count, far):
    rng = np.random.default_rng(seed)
    positions = _moving(rng, 30.0)
    joint, frame = rng.integers(len(NAMES)), rng.integers(1, len(positions) - count)
    way = rng.standard_normal(3)
    positions[frame : frame + count, joint] += far * way / np.linalg.norm(way)
    found = thrown_and_back(positions, np.arange(len(positions)) / 30.0, MIRROR)
    other = positions[frame - 1 : frame + count + 1, MIRROR[joint]]
    if np.linalg.norm(positions[frame, joint] - other, axis=1).min() > 0.7 * far:  # else it looks like its other side
        assert found[frame : frame + count, joint].all()
    found[frame : frame + count, joint] = False
    assert not found.any()


@given(SEEDS)
@settings(max_examples=30)
def test_it_is_found_wherever_the_sensor_stands_and_whenever_it_began(seed):
    rng = np.random.default_rng(seed)
    positions = _moving(rng, 30.0) + 0.6 * (rng.random((60, len(NAMES), 1)) < 0.05)
    times = np.cumsum(rng.uniform(0.02, 0.05, 60))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    found = thrown_and_back(positions, times, MIRROR)
    assert found.any()
    np.testing.assert_array_equal(thrown_and_back(positions @ turn + 2.0, times + 7.0, MIRROR), found)
    np.testing.assert_array_equal(thrown_and_back(positions[::-1], -times[::-1], MIRROR)[::-1], found)


def test_what_goes_on_or_was_taken_for_its_other_side_or_has_nothing_beside_it_is_none():
    positions = np.zeros((20, len(NAMES), 3)) + np.random.default_rng(0).uniform(-1.0, 1.0, (1, len(NAMES), 3))
    times = np.arange(20) / 30.0
    hand, other, head = (NAMES.index(name) for name in ("WristLeft", "WristRight", "Head"))
    goes_on, exchanged, alone = positions.copy(), positions.copy(), positions.copy()
    goes_on[10:, hand] += 0.8
    exchanged[10, [hand, other]] = exchanged[10, [other, hand]]
    alone[10, head] += 0.8
    alone[[9, 12], head] = np.nan
    for one in (goes_on, exchanged, alone):
        assert not thrown_and_back(one, times, MIRROR).any()
    stopped = times.copy()
    stopped[8:13] = stopped[8]
    alone[[9, 12], head] = positions[0, head]
    assert thrown_and_back(alone, times, MIRROR)[10, head]
    assert not thrown_and_back(alone, stopped, MIRROR)[10, head]


@pytest.mark.parametrize("frames", [0, 1, 2, 3])
def test_few_frames(frames):
    assert thrown_and_back(np.zeros((frames, 4, 3)), np.arange(frames) / 30.0, np.arange(4)).shape == (frames, 4)


def _seen():
    """(T, 20, 3) somebody for little longer than before and after the frame in which a joint is away is known of."""
    return sensed(truth("reach", 5, 1.2), 5)


@cache
def _given_out(look_ahead):
    """What comes of them where no joint was away."""
    positions = _seen()
    return fitted().correct(Postures(NAMES, positions, np.arange(len(positions)) / 30.0), look_ahead=look_ahead)


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0, 2, 6])
@pytest.mark.parametrize("away", [0.3, 0.8])
@pytest.mark.parametrize("name", ["Head", "ElbowRight", "WristRight", "KneeLeft", "AnkleLeft"])
def test_what_is_given_out_hardly_changes_by_it(name, away, look_ahead):
    thrown = _seen()
    thrown[18, NAMES.index(name), 1] += away
    usual = _given_out(look_ahead)
    told = fitted().correct(Postures(NAMES, thrown, usual.times), look_ahead=look_ahead)
    assert np.linalg.norm(told.positions - usual.positions, axis=2).max() < (0.04 if look_ahead == 0 else 0.03)
    assert told.reliability is not None
    assert told.reliability[18, NAMES.index(name)] < 0.1


def test_live_who_hops_and_stays_is_believed_a_frame_later_as_if_at_once(monkeypatch):
    """Only that frame is given out as if the joint had not been seen."""
    positions = sensed(truth("reach", 7, 2.0), 7)
    positions[30:, NAMES.index("AnkleLeft")] += (0.3, 0.0, 0.1)
    recording = Postures(NAMES, positions, np.arange(len(positions)) / 30.0)
    told = fitted().correct(recording, look_ahead=0)
    monkeypatch.setattr(corrector, "look_twice", lambda watcher, sight, _, *frame: (look(watcher, sight, *frame), None))
    at_once = fitted().correct(recording, look_ahead=0)
    assert told.reliability is not None
    assert at_once.reliability is not None
    np.testing.assert_array_equal(told.positions[:30], at_once.positions[:30])
    np.testing.assert_allclose(told.reliability[31:], at_once.reliability[31:], atol=1e-12)
    assert told.reliability[30, NAMES.index("AnkleLeft")] < 0.1


def test_who_is_thrown_about_again_and_again_shakes_and_is_left():
    positions = np.zeros((90, len(NAMES), 3)) + np.random.default_rng(0).uniform(-1.0, 1.0, (1, len(NAMES), 3))
    times, hand = np.arange(90) / 30.0, NAMES.index("WristLeft")
    positions[20:40:3, hand] += 0.8
    positions[70, hand] += 0.8
    found = thrown_and_back(positions, times, MIRROR)
    assert np.argwhere(found).tolist() == [[70, hand]]
