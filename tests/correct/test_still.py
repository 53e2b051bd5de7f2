"""A body that stands still to the last digit: nobody is measured there, and what comes out says so."""

from dataclasses import replace

import numpy as np
import pytest
from sensed_people import fitted, recording, sensed, truth

from motionmend.correct.still import repeated

TIMES = np.arange(90) / 30.0


def held(positions, first, last):
    """The posture of the first frame said until the last one."""
    positions = positions.copy()
    positions[first + 1 : last + 1] = positions[first]
    return positions


def test_frames_on_end_that_are_alike_for_long_are_found_from_the_second_on(rng):
    positions = rng.normal(size=(90, 20, 3))
    again, since = repeated(held(positions, 40, 60), TIMES)
    np.testing.assert_array_equal(np.flatnonzero(again), np.arange(41, 61))
    np.testing.assert_allclose(since[again], np.arange(1, 21) / 30.0)


def test_slow_sensors_postures_that_never_change_and_who_is_away_are_none(rng):
    positions = rng.normal(size=(90, 20, 3))
    for one in (
        positions,
        np.repeat(positions[::6], 6, axis=0),
        np.repeat(positions[:1], 90, axis=0),
        np.where((np.arange(90) // 30 == 1)[:, None, None], np.nan, positions),
        positions[:1],
        positions[:0],
    ):
        assert not repeated(one, TIMES[: len(one)])[0].any()


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0])
def test_a_walker_whom_the_sensor_holds_is_as_unsure_as_it_is_wrong(look_ahead) -> None:
    true = truth("walk", 7, 3.0)
    given = recording(sensed(true, 7))
    found = fitted().correct(replace(given, positions=held(given.positions, 45, 75)), look_ahead=look_ahead)
    late = slice(46 + 16, 76)
    off = np.linalg.norm(found.positions - true, axis=2)
    assert (found.reliability[late] == 0.0).all()
    assert (found.reliability[:46] > 0.5).mean() > 0.8
    assert np.mean(off[late] < 3.0 * found.std[late]) > 0.9
    assert found.std[:46].max() < found.std[late].min()
    assert sum("to the last digit" in said for said in found.source.warnings) == 1
