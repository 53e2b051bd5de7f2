"""The rate of a recording whose times are its own."""

import numpy as np
import pytest

from motionmend.bodies.postures import Postures


def at(times: np.ndarray) -> Postures:
    return Postures(("head",), np.zeros((len(times), 1, 3)), times)


@pytest.mark.parametrize(("rate", "digits"), [(15.0, 3), (30.0, 3), (60.0, 3), (120.0, 3), (30.0, 2), (15.0, 2)])
@pytest.mark.parametrize("start", [0.0, 7.1234])
@pytest.mark.parametrize("dropped", [[], [20, 21, 150]])
def test_times_in_few_decimals_are_at_the_clock_s_rate(
    rate: float, digits: int, start: float, dropped: list[int]
) -> None:
    times = np.delete(start + np.arange(301) / rate, dropped)
    assert at(np.round(times, digits)).fps == pytest.approx(rate, rel=3e-3)  # by the median step up to 11 % off
    assert at(times).fps == pytest.approx(rate, rel=1e-9)


def test_a_clock_that_ticks_slowly_is_read_by_its_median_step() -> None:
    ticks = np.array([31, 47, 31, 31, 47, 62, 16, 31, 47, 31, 31]) / 1000
    assert at(np.append(0.0, np.cumsum(ticks))).fps == pytest.approx(1 / 0.031)


def test_frames_that_were_dropped_do_not_lower_the_rate() -> None:
    times = np.delete(np.arange(100) / 30, [20, 21, 50])
    assert at(times).fps == pytest.approx(30.0)


def test_one_frame_and_times_that_stand_have_no_rate() -> None:
    assert np.isnan(at(np.zeros(1)).fps)
    assert np.isnan(at(np.zeros(5)).fps)
    assert np.isnan(at(np.arange(5.0)[::-1]).fps)
    assert np.isnan(at(np.array([0.0, np.nan, 2.0])).fps)
