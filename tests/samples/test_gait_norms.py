"""The norms pass through their sources' landmarks, and the cycles keep what they promise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.samples.body import build
from motionmend.samples.gait import GRAVITY, cycle, straightest
from motionmend.samples.norms import RUN, WALK, running_stride, walking_stride

PERCENT = np.arange(0.0, 1.0, 0.001)


@pytest.mark.parametrize(
    ("curve", "phase", "degrees"),
    [
        (WALK.thigh, 0.0, 20.0),
        (WALK.thigh, 0.5, -11.0),
        (WALK.thigh, 0.86, 22.0),
        (WALK.knee, 0.14, 19.0),
        (WALK.knee, 0.38, 7.0),
        (WALK.knee, 0.72, 64.0),
        (WALK.ankle, 0.06, -4.6),
        (WALK.ankle, 0.44, 9.6),
        (WALK.ankle, 0.64, -19.8),
        (RUN.knee, 0.15, 42.0),
        (RUN.knee, 0.70, 92.5),
        (RUN.ankle, 0.20, 25.0),
        (RUN.ankle, 0.43, -22.0),
    ],
)
def test_curves_pass_through_the_published_landmarks(curve, phase, degrees):
    assert np.degrees(curve(np.array(phase))) == pytest.approx(degrees, abs=0.8)


def test_peaks_come_when_they_should():
    assert PERCENT[np.argmax(WALK.knee(PERCENT))] == pytest.approx(0.72, abs=0.02)
    assert PERCENT[np.argmin(WALK.ankle(PERCENT))] == pytest.approx(0.64, abs=0.02)
    assert PERCENT[np.argmin(WALK.thigh(PERCENT))] == pytest.approx(0.51, abs=0.02)
    assert PERCENT[np.argmax(RUN.knee(PERCENT))] == pytest.approx(0.69, abs=0.02)


@given(st.floats(0.6, 2.2), st.floats(1.4, 2.0))
def test_walkers_take_longer_and_quicker_steps_at_speed(speed, height):
    length, time, stance = walking_stride(speed, height)
    assert length == pytest.approx(speed * time)
    longer, shorter_time, less = walking_stride(speed * 1.1, height)
    assert longer > length
    assert shorter_time < time
    assert less <= stance
    assert 0.5 < stance < 0.7


def test_natural_walking_is_as_published():
    length, time, stance = walking_stride(1.35, 1.75)
    assert 120 / time == pytest.approx(112, abs=3)  # steps a minute
    assert length == pytest.approx(1.45, abs=0.03)
    assert stance == pytest.approx(0.62, abs=0.01)


def test_runners_go_28_percent_further_at_4_percent_more_steps():
    slow, fast = running_stride(3.15, 1.75), running_stride(4.12, 1.75)
    assert fast[0] / slow[0] == pytest.approx(1.26, abs=0.03)
    assert slow[1] / fast[1] == pytest.approx(1.04, abs=0.01)
    assert fast[2] < slow[2] < 0.5


@settings(max_examples=10)
@given(st.sampled_from(["walk", "run"]), st.floats(0.7, 1.5), st.floats(1.4, 2.0))
def test_a_cycle_is_periodic_and_its_standing_leg_reaches_the_floor(gait, pace, height):
    # as brisk for who is small as for who is tall
    speed = pace * (1.35 if gait == "walk" else 3.0) * np.sqrt(height / 1.75)
    c, b = cycle(gait, round(speed, 2), round(height, 2)), build(round(height, 2))
    assert c.length == pytest.approx(round(speed, 2) * c.time)
    np.testing.assert_allclose(c(np.array([0.0, 0.3])), c(np.array([1.0, -0.7])), atol=1e-9)
    flat = np.linspace(0.3, 0.45, 5) * c.stance  # sole down: the ankle is above its place
    table = c(flat)
    level = c.ahead - c.length * flat - table[:, 4] - b.hip[2]
    hips = table[:, 5] + b.hip[1] - b.ankle_height
    straight = np.sqrt(b.thigh**2 + b.shank**2 + 2 * b.thigh * b.shank * np.cos(straightest(gait, speed, height)))
    assert np.all(np.hypot(level, hips) <= straight + 1e-3)
    least = 0.94 if gait == "walk" else 0.84  # who runs fast gives way far
    assert np.all(np.hypot(level, hips) > least * straight)


def test_a_runner_falls_freely_in_flight():
    c = cycle("run", 3.0, 1.75)
    phase = np.linspace(c.stance + 0.02, 0.48, 9)
    step = 1e-3
    curve = (c(phase + step) - 2 * c(phase) + c(phase - step))[:, 5] / (step * c.time) ** 2
    np.testing.assert_allclose(curve, -GRAVITY, rtol=0.03)


def test_a_walker_is_lowest_when_both_feet_stand():
    c = cycle("walk", 1.35, 1.75)
    height = c(PERCENT)[:, 5]
    assert np.ptp(height) == pytest.approx(0.04, abs=0.005)
    assert PERCENT[np.argmin(height[:500])] == pytest.approx(0.05, abs=0.02)
