"""Recordings that show each of their frames several times: made at a lower rate than they are written at."""

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.slower import DRAWN, REPEATED, as_slower, but_for_repeats, ends_of_lines, shown_once
from motionmend.samples import markers
from performers import joints_model, truth

HOLDS = [2.0, 3.0, 2.5, 5.0 / 3.0]


def _values(recording):
    return recording.q if isinstance(recording, Motion) else recording.positions


def _with(recording, values):
    return recording.with_q(values) if isinstance(recording, Motion) else recording.with_positions(values)


def _shown_again(recording, times):
    """What is new every so many frames is held until there is more, and which frames that are."""
    new = np.unique(np.ceil(np.arange(0, recording.frames, times)).astype(int))
    new = new[new < recording.frames]
    last = new[np.searchsorted(new, np.arange(recording.frames), side="right") - 1]
    return _with(recording, _values(recording)[last]), new


def _off(recording, clean):
    return float(np.sqrt(np.mean(np.square(_values(recording) - _values(clean)))))


@pytest.fixture(params=["motion", "markers"])
def clean(request):
    motion = truth("walk", seconds=3.0, fps=120.0)
    return motion if request.param == "motion" else markers(motion)


def _thinned(recording):
    """A recording of every third marker: as many as a repair needs, whose effort grows with their number squared."""
    return Markers(recording.names[::3], recording.positions[:, ::3], recording.fps, up=recording.up)


@pytest.fixture
def light(clean):
    """As `clean`, where a repair of fewer markers is as far from what the test allows."""
    return clean if isinstance(clean, Motion) else _thinned(clean)


@pytest.mark.parametrize("times", HOLDS)
def test_frames_that_show_something_new_are_found(clean, times):
    held, new = _shown_again(clean, times)
    np.testing.assert_array_equal(shown_once(held), new)


@pytest.mark.parametrize("times", HOLDS)
def test_in_a_rest_there_are_as_many_as_in_motion(clean, times):
    values = _values(clean).copy()
    values[60:90] = values[60]
    held, new = _shown_again(_with(clean, values), times)
    found = shown_once(held)
    assert abs(len(found) - len(new)) <= 2
    assert np.diff(found).max() <= np.ceil(times) + 1


@pytest.mark.parametrize("times", HOLDS)
def test_what_is_missing_tells_nothing_else(clean, times):
    values = _values(clean).copy()
    values[40:70, 3:9] = np.nan
    held, new = _shown_again(_with(clean, values), times)
    np.testing.assert_array_equal(shown_once(held), new)


def test_other_recordings_are_as_fast_as_they_say(clean, rng):
    values, keys = _values(clean), _values(clean)[::15]
    assert shown_once(clean) is None
    tenth = values.copy()
    tenth[10::10] = tenth[9:-1:10]
    assert shown_once(_with(clean, tenth)) is None
    any_ = np.cumsum(rng.random(clean.frames) < 0.6)
    assert shown_once(_with(clean, values[np.minimum(any_, len(values) - 1)])) is None
    assert shown_once(_with(clean, keys.repeat(15, axis=0))) is None  # poses that somebody drew
    resting = values.copy()
    resting[40:] = resting[40]
    assert shown_once(_with(clean, resting)) is None
    assert shown_once(_with(clean, np.repeat(values[:1], 100, axis=0))) is None
    one = values.copy()
    one[1::2, 4] = one[:-1:2, 4]  # one channel alone
    assert shown_once(_with(clean, one)) is None


def test_a_part_cut_out_between_two_frames_is_of_the_same_rate():
    held, _ = _shown_again(truth("walk", seconds=2.0, fps=60.0), 2.0)
    part = held.with_q(held.q[11:74])
    assert as_slower(part, shown_once(part), REPEATED).startswith(
        "each frame is shown 2 times throughout: taken for a recording of 30 Hz"
    )


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5, 10])
def test_few_frames_tell_nothing(clean, frames):
    assert shown_once(_with(clean, _values(clean)[:frames].repeat(2, axis=0))) is None


@pytest.mark.slow
@pytest.mark.parametrize("times", HOLDS)
def test_what_lies_between_is_put_there_and_said(light, times):
    held, new = _shown_again(light, times)
    outcome = repair_without_model(held)
    again = np.setdiff1d(np.arange(light.frames), new)
    assert outcome.recording.frames == light.frames
    assert outcome.recording.fps == light.fps
    assert _off(outcome.recording, light) < 0.4 * _off(held, light)
    assert (outcome.origin[again] == Origin.REPAIRED).all()
    assert (outcome.origin[new] == Origin.MEASURED).mean() > 0.99
    assert sum(f"each frame is shown {times:.3g} times" in warning for warning in outcome.warnings) == 1


@pytest.mark.slow
@pytest.mark.parametrize("times", [2.0, 2.5])
def test_noise_that_is_shown_twice_is_no_motion(clean, times):
    """It was smoothed hardly at all, and said to be three times as sure as it was."""
    rng = np.random.default_rng(3)
    noise = np.radians(1.0) if isinstance(clean, Motion) else 0.002
    held, _ = _shown_again(_with(clean, _values(clean) + noise * rng.standard_normal(_values(clean).shape)), times)
    outcome = repair_without_model(held)
    off, std = _values(outcome.recording) - _values(clean), outcome.std.astype(float)
    if isinstance(clean, Markers):
        std = std[..., None]
    else:
        turns = np.ptp(clean.q, axis=0) > np.radians(2.0)
        off, std = off[:, turns & (np.arange(off.shape[1]) > 5)], std[:, turns & (np.arange(off.shape[1]) > 5)]
    assert np.sqrt(np.mean(np.square(off))) < 0.75 * noise
    assert 0.6 < (np.abs(off) < std).mean() < 0.85
    assert (np.abs(off) < 1.96 * std).mean() > 0.9


@pytest.mark.slow
def test_a_library_helps_as_it_would_at_the_lower_rate():
    clean = truth("walk", fps=60.0)
    held, _ = _shown_again(clean, 2.0)
    q = held.q.copy()
    q[60:80, 20] = np.nan
    outcome = joints_model().repair(clean.with_q(q))
    assert _off(outcome.recording, clean) < 0.4 * _off(held, clean)
    assert (outcome.origin[60:80, 20] == Origin.FILLED).all()


@pytest.mark.slow
def test_an_angle_that_leaps_to_another_way_of_saying_the_same_is_not_halved():
    clean = truth("walk", fps=120.0)
    q = clean.q.copy()
    q[100:, 10] += 2.0
    outcome = but_for_repeats(repair_without_model, _shown_again(clean.with_q(q), 2.0)[0])
    step = np.abs(np.diff(outcome.recording.q[95:105, 10]))
    assert (step > 1.0).sum() == 1


@pytest.mark.slow
def test_full_turns_are_written_as_they_were():
    """A turn past 180 degrees that goes on at -180."""
    clean = truth("turn", fps=120.0)
    heading = int(np.argmax(np.ptp(clean.q[:, :6], axis=0) * (clean.skeleton.dof_kind[:6] == ROTATION)))
    q = clean.q.copy()
    q[:, heading] = (q[:, heading] - np.median(q[:, heading])) % (2.0 * np.pi) - np.pi
    held, _ = _shown_again(clean.with_q(q), 2.0)
    assert (np.abs(np.diff(q[:, heading])) > 5.0).any()
    outcome = repair_without_model(held)
    step = np.abs(np.diff(outcome.recording.q[:, heading]))
    assert ((step < 0.2) | (step > 2.0 * np.pi - 0.2)).all()
    assert (step > 5.0).sum() == (np.abs(np.diff(q[:, heading])) > 5.0).sum()


@pytest.mark.slow
def test_what_is_left_open_stays_open():
    clean = _thinned(markers(truth("walk")))
    positions = clean.positions.copy()
    positions[:, 5] = np.nan
    held, _ = _shown_again(clean.with_positions(positions), 2.0)
    outcome = repair_without_model(held)
    assert (outcome.origin[:, 5] == Origin.LEFT_OPEN).all()
    assert np.isnan(outcome.recording.positions[:, 5]).all()
    assert np.isnan(outcome.std[:, 5]).all()


def _on_lines(recording, times, decimals=None):
    """Every so many frames are as recorded, the rest on straight lines between; the last goes on as before."""
    values = _values(recording)
    last = (len(values) - 1) // times * times
    new = np.arange(0, last + 1, times)
    flat = values[: last + 1].reshape(last + 1, -1)
    drawn = np.stack([np.interp(np.arange(last + 1), new, flat[new, c]) for c in range(flat.shape[1])], axis=1)
    scale = 180.0 / np.pi if isinstance(recording, Motion) else 1000.0
    drawn = drawn if decimals is None else np.round(drawn * scale, decimals) / scale
    return recording.at_frames(np.arange(last + 1)).with_values(drawn.reshape(last + 1, *values.shape[1:])), new


@pytest.mark.parametrize("times", [2, 3, 4, 5])
@pytest.mark.parametrize("decimals", [None, 5, 2])
def test_the_ends_of_lines_are_found(clean, times, decimals):
    drawn, new = _on_lines(clean, times, decimals)
    found = ends_of_lines(drawn)
    assert found is not None
    assert np.isin(new[1:-1], found).mean() > 0.95
    assert len(found) <= 1.1 * len(new)
    assert f"only every {times}th frame" in as_slower(drawn, found, DRAWN) or len(found) != len(new)


def test_who_moves_on_no_lines_is_as_fast_as_it_says(clean, rng):
    values = _values(clean)
    assert ends_of_lines(clean) is None
    assert ends_of_lines(_on_lines(clean, 8)[0]) is None  # 15 Hz: poses that somebody drew
    drawn, _ = _on_lines(clean, 2)
    shaken = _values(drawn) + 1e-3 * rng.standard_normal(_values(drawn).shape)
    assert ends_of_lines(drawn.with_values(shaken)) is None
    one = values.copy()
    one[1:-1:2, 4] = 0.5 * (one[:-2:2, 4] + one[2::2, 4])[: len(one[1:-1:2])]  # one channel alone
    assert ends_of_lines(clean.with_values(one)) is None
    gap = values.copy()
    gap[40:70, 4] = np.linspace(0.0, 1.0, 30).reshape(-1, *[1] * (values.ndim - 2)) * (values[69, 4] - values[40, 4])
    assert ends_of_lines(clean.with_values(gap)) is None  # somebody filled it
    assert ends_of_lines(clean.with_values(np.repeat(values[:1], clean.frames, axis=0))) is None


@pytest.mark.slow
def test_noise_between_which_lines_were_drawn_is_no_motion(light):
    """It was left as it was, and 13 % of the errors lay within one deviation."""
    rng = np.random.default_rng(3)
    noise = np.radians(1.0) if isinstance(light, Motion) else 0.002
    shaken = light.with_values(_values(light) + noise * rng.standard_normal(_values(light).shape))
    drawn, new = _on_lines(shaken, 2)
    truth_there = light.at_frames(np.arange(drawn.frames))
    outcome = repair_without_model(drawn)
    off, std = _values(outcome.recording) - _values(truth_there), outcome.std.astype(float)
    if isinstance(light, Markers):
        std = std[..., None]
    else:
        turns = (np.ptp(light.q, axis=0) > np.radians(2.0)) & (np.arange(off.shape[1]) > 5)
        off, std = off[:, turns], std[:, turns]
    assert np.sqrt(np.mean(np.square(off))) < 0.75 * noise
    assert 0.6 < (np.abs(off) < std).mean() < 0.85
    assert (np.abs(off) < 1.96 * std).mean() > 0.9
    between = np.setdiff1d(np.arange(drawn.frames - 1), new)
    assert (outcome.origin[between] == Origin.REPAIRED).all()
    assert any("frames that lie on lines were replaced" in warning for warning in outcome.warnings)
