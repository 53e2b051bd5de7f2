"""Joints are made as steady as their noise asks for: quick moves stay quick, and who shakes goes on to shake."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sensed_people import truth

from motionmend.arrays import Floats
from motionmend.correct.steadying import steadied

NOISE = 0.005


def times_of(values: Floats, fps: float = 30.0) -> Floats:
    return np.arange(len(values)) / fps


def noisy(true: Floats, seed: int, size: float = NOISE) -> Floats:
    return true + size * np.random.default_rng(seed).standard_normal(true.shape)


def off(found: Floats, true: Floats) -> tuple[float, float]:
    """RMS of places and of steps from frame to frame."""
    apart = found - true
    return float(np.sqrt(np.square(apart).mean())), float(np.sqrt(np.square(np.diff(apart, axis=0)).mean()))


@pytest.mark.parametrize(("action", "share"), [("reach", 0.7), ("walk", 0.95), ("jump", 1.0), ("run", 1.0)])
def test_places_and_steps_are_nearer_to_the_truth(action: str, share: float) -> None:
    """Most where little is quick; who runs is left as they were seen."""
    true = truth(action, 3)
    seen = noisy(true, 0)
    found = off(steadied(seen, times_of(true), np.ones(true.shape[:2])), true)
    assert found[0] < share * off(seen, true)[0]
    assert found[1] < share * off(seen, true)[1]


def test_who_is_thrown_away_for_a_frame_pulls_nobody_along() -> None:
    true = truth("reach", 3)
    seen, times, trust = noisy(true, 1), times_of(true), np.ones(true.shape[:2])
    thrown = seen.copy()
    thrown[40, 7] += [0.1, -0.1, 0.1]
    before, after = steadied(seen, times, trust), steadied(thrown, times, trust)
    assert np.linalg.norm(after - before, axis=2).max() < 0.2 * np.linalg.norm(thrown - seen, axis=2).max()
    untouched = np.arange(true.shape[1]) != 7
    np.testing.assert_array_equal(after[:, untouched], before[:, untouched])


@pytest.mark.parametrize("fps", [15.0, 30.0, 60.0, 120.0])
def test_a_quick_move_stays_and_who_rests_is_calmed(fps: float) -> None:
    times = np.arange(round(4 * fps)) / fps
    true = np.zeros((len(times), 2, 3))
    true[:, 1, 1] = 0.6 / (1.0 + np.exp(-(times - 2.0) / 0.04))  # 3.75 m/s
    seen = noisy(true, 2, 0.003)
    found = steadied(seen, times, np.ones(true.shape[:2]))
    speeds = [np.linalg.norm(np.diff(one, axis=0), axis=2).max(axis=0) * fps for one in (seen, found, true)]
    assert speeds[1][1] > 0.95 * speeds[0][1]
    assert speeds[1][0] < (0.4 if fps > 15.0 else 0.6) * speeds[0][0]
    assert abs(found[-1, 1, 1] - found[0, 1, 1] - 0.6) < 0.01


@pytest.mark.slow
@given(st.integers(0, 10**6), st.floats(0.0, 360.0))
@settings(max_examples=20, deadline=None)
def test_turned_moved_and_backward_it_is_the_same(seed: int, degrees: float) -> None:
    true = truth("walk", 3)[:60, :8]
    seen, times, trust = noisy(true, seed), times_of(true)[:60], np.random.default_rng(seed).random((60, 8))
    turn, shift = Rotation.from_euler("y", degrees, degrees=True).as_matrix(), np.array([3.0, -1.0, 2.0])
    found = steadied(seen, times, trust)
    np.testing.assert_allclose(steadied(seen @ turn.T + shift, times, trust), found @ turn.T + shift, atol=1e-7)
    np.testing.assert_allclose(steadied(seen[::-1], times, trust[::-1])[::-1], found, atol=1e-7)
    order = np.random.default_rng(seed).permutation(8)
    np.testing.assert_allclose(steadied(seen[:, order], times, trust[:, order]), found[:, order], atol=1e-12)


@pytest.mark.slow
@given(st.data())
@settings(max_examples=30, deadline=None)
def test_what_is_missing_stays_missing_and_the_rest_is_finite(data: st.DataObject) -> None:
    true = truth("reach", 3)[:50, :4]
    seen, trust = noisy(true, 5), np.full((50, 4), data.draw(st.sampled_from([0.0, 0.5, 1.0])))
    steps = np.array(data.draw(st.lists(st.sampled_from([0.0, 0.01, 1 / 30, 0.07, 2.0]), min_size=49, max_size=49)))
    gone = np.array(data.draw(st.lists(st.booleans(), min_size=200, max_size=200))).reshape(50, 4)
    seen[gone] = np.nan
    found = steadied(seen, np.append(0.0, np.cumsum(steps)), trust)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(seen))


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5, 9, 12])
def test_few_frames_are_no_error(frames: int) -> None:
    seen = truth("walk", 3)[:frames]
    found = steadied(seen, times_of(seen), np.ones(seen.shape[:2]))
    np.testing.assert_allclose(found, seen, atol=0.015)


def test_what_does_not_move_stays_where_it_is() -> None:
    still = np.repeat(truth("walk", 3)[:1], 60, axis=0)
    np.testing.assert_allclose(steadied(still, times_of(still), np.ones(still.shape[:2])), still, atol=1e-12)


@pytest.mark.parametrize("fps", [25.0, 30.0, 60.0, 120.0])
@pytest.mark.parametrize(("hertz", "far"), [(2.0, 0.03), (3.0, 0.03), (4.0, 0.06), (5.0, 0.015)])
def test_who_waves_or_shakes_goes_on_to(hertz: float, far: float, fps: float) -> None:
    times = np.arange(round(8 * fps)) / fps
    true = np.zeros((len(times), 1, 3))
    true[:, 0, 0] = far * np.sin(2.0 * np.pi * hertz * times)
    found = steadied(noisy(true, 3, 0.002), times, np.ones((len(times), 1)))
    inner = slice(round(fps), -round(fps))
    kept = (found[inner] * true[inner]).sum() / np.square(true[inner]).sum()
    assert 0.75 < kept < 1.02


def test_a_slow_sensor_s_waves_are_not_taken_for_noise() -> None:
    """Four a second, seen fifteen times a second: even differences of a high order are motion's."""
    times = np.arange(120) / 15.0
    true = np.zeros((120, 1, 3))
    true[:, 0, 0] = 0.06 * np.sin(2.0 * np.pi * 4.0 * times)
    found = steadied(noisy(true, 3, 0.002), times, np.ones((120, 1)))
    assert np.sqrt(np.square(found - true).mean()) < 0.005


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_who_moves_off_in_the_last_frames_is_not_held_back(frames: int) -> None:
    true = np.zeros((60, 1, 3))
    true[-frames:, 0, 0] = 0.06 * np.arange(1, frames + 1)  # 1.8 m/s
    seen = noisy(true, 4, 0.002)
    times, trust = times_of(true), np.ones((60, 1))
    assert np.abs(steadied(seen, times, trust) - true).max() < 0.015
    assert np.abs(steadied(seen[::-1], times, trust)[::-1] - true).max() < 0.015
