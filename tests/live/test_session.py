"""One client's session without a server: when its frames were taken, whatever their stamps."""

import numpy as np
import pytest

from motionmend.bodies.joint_sets import KINECT20
from motionmend.live.messages import Frame, Hello
from motionmend.live.session import answered, opened, rested
from motionmend.live.warm import standing

FRAMES = 60
EVEN = np.arange(FRAMES) / 30.0
NOISE = np.random.default_rng(3).normal(0, 0.01, (FRAMES, 20, 3))
SWAYING = standing(KINECT20) + 0.1 * np.sin(3.0 * EVEN)[:, None, None] + NOISE


def answers(model, times, look_ahead=0.0, fps=30.0):
    """(T, J, 3) m of somebody who sways, in the order in which frames are sent."""
    session, found = opened(model, Hello("kinect20", KINECT20.names, fps), look_ahead=look_ahead), []
    for seq, (t, joints) in enumerate(zip(times, SWAYING, strict=True)):
        session, some = answered(model, session, Frame(seq, float(t), joints, None, "msgpack"), 0.0)
        found += some
    found += rested(model, session)[1]
    return np.array([answer.joints for _, answer in found])


def trembling(places):
    return np.linalg.norm(np.diff(places[10:], n=3, axis=0), axis=2).mean()


@pytest.mark.parametrize(
    "times",
    [
        np.arange(FRAMES) // 5 * 5 / 30.0 + np.arange(FRAMES) % 5 * 0.001,  # five come in together
        np.arange(FRAMES) // 2 * 2 / 30.0,  # stamped alike, by twos
        np.round(EVEN, 1),
        EVEN + np.random.default_rng(4).uniform(0.0, 0.03, FRAMES),  # late by up to a step
    ],
    ids=["bursts", "twos", "tenths", "late"],
)
@pytest.mark.parametrize("look_ahead", [0.0, 0.1])
def test_frames_that_come_together_are_as_steady_as_those_that_come_evenly(model, times, look_ahead):
    even, found = (trembling(answers(model, one, look_ahead)) for one in (EVEN, times))
    assert found < even + 0.3 * (trembling(SWAYING) - even)


@pytest.mark.parametrize("fps", [1.0, 25.0, 30.0, 60.0])
def test_even_frames_are_as_they_are_stamped_whatever_rate_the_hello_promised(model, fps):
    assert answers(model, EVEN, fps=fps)[30:] == pytest.approx(answers(model, EVEN, fps=30.0)[30:], abs=0.003)


def test_times_and_answers_of_even_frames_are_not_touched(model):
    state, wanted = model.start(KINECT20.names), []
    for t, joints in zip(EVEN, SWAYING, strict=True):
        state, corrected = model.step(state, joints, None, float(t))
        wanted.append(corrected.positions)
    assert np.array_equal(answers(model, EVEN), np.array(wanted))
