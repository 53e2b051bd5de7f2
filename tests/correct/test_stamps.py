"""When frames were taken whose times are rounded, or those of when they came in."""

from dataclasses import replace

import numpy as np
import pytest
from sensed_people import fitted, recording, sensed, truth

from motionmend.correct.stamps import taken

EVEN = np.arange(150) / 30.0
TOGETHER = {
    "twos": np.arange(150) // 2 * 2 / 30.0,
    "tenths": np.round(EVEN, 1),
    "seconds": np.floor(EVEN),
    "bursts": np.arange(150) // 5 * 5 / 30.0 + np.arange(150) % 5 * 0.001,
}


@pytest.mark.parametrize("times", TOGETHER.values(), ids=TOGETHER)
def test_frames_that_were_stamped_together_are_spread_to_the_next_stamp(times):
    found = taken(times)
    assert np.abs(np.diff(found) * 30.0 - 1.0).max() < 1.6
    assert np.median(np.diff(found)) == pytest.approx(1 / 30.0, rel=0.05)
    assert np.ptp(found - EVEN) < 0.15


@pytest.mark.parametrize(
    "times",
    [
        EVEN,
        EVEN[:1],
        EVEN[:0],
        np.zeros(150),
        EVEN + np.where(np.arange(150) > 70, 60.0, 0.0),  # a break
        np.sort(EVEN + np.random.default_rng(0).normal(0, 0.008, 150)),
        np.delete(EVEN, np.s_[::4]),  # frames that were dropped
        np.where(np.arange(150) % 10 == 9, EVEN - 1 / 30.0, EVEN),  # one in ten is said twice
    ],
    ids=["even", "one", "none", "no clock", "break", "jitter", "dropped", "some twice"],
)
def test_times_that_tell_are_believed(times):
    assert np.array_equal(taken(times), times)


def test_a_break_stays_one():
    times = TOGETHER["tenths"] + np.where(np.arange(150) > 70, 60.0, 0.0)
    assert np.diff(taken(times)).max() > 59.5


def test_a_recording_stamped_to_seconds_is_as_steady_as_one_with_a_clock() -> None:
    true = truth("walk", 7, 3.0)
    one = recording(sensed(true, 7))
    found = [fitted().correct(replace(one, times=times)) for times in (one.times, np.floor(one.times))]
    np.testing.assert_array_equal(found[1].times, np.floor(one.times))
    even, spread, given = (np.linalg.norm(np.diff(p.positions, n=3, axis=0), axis=2).mean() for p in (*found, one))
    assert spread < even + 0.25 * (given - even)
