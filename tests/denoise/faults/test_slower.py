"""Recordings that show each of their frames several times: made at a lower rate than they are written at."""

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.slower import as_slower, but_for_repeats, shown_once
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
    assert as_slower(part, shown_once(part)).startswith(
        "each frame is shown 2 times throughout: taken for a recording of 30 Hz"
    )


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5, 10])
def test_few_frames_tell_nothing(clean, frames):
    assert shown_once(_with(clean, _values(clean)[:frames].repeat(2, axis=0))) is None


@pytest.mark.parametrize("times", HOLDS)
def test_what_lies_between_is_put_there_and_said(clean, times):
    held, new = _shown_again(clean, times)
    outcome = repair_without_model(held)
    again = np.setdiff1d(np.arange(clean.frames), new)
    assert outcome.recording.frames == clean.frames
    assert outcome.recording.fps == clean.fps
    assert _off(outcome.recording, clean) < 0.4 * _off(held, clean)
    assert (outcome.origin[again] == Origin.REPAIRED).all()
    assert (outcome.origin[new] == Origin.MEASURED).mean() > 0.99
    assert sum(f"each frame is shown {times:.3g} times" in warning for warning in outcome.warnings) == 1


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


def test_a_library_helps_as_it_would_at_the_lower_rate():
    clean = truth("walk", fps=60.0)
    held, _ = _shown_again(clean, 2.0)
    q = held.q.copy()
    q[60:80, 20] = np.nan
    outcome = joints_model().repair(clean.with_q(q))
    assert _off(outcome.recording, clean) < 0.4 * _off(held, clean)
    assert (outcome.origin[60:80, 20] == Origin.FILLED).all()


def test_an_angle_that_leaps_to_another_way_of_saying_the_same_is_not_halved():
    clean = truth("walk", fps=120.0)
    q = clean.q.copy()
    q[100:, 10] += 2.0
    outcome = but_for_repeats(repair_without_model, _shown_again(clean.with_q(q), 2.0)[0])
    step = np.abs(np.diff(outcome.recording.q[95:105, 10]))
    assert (step > 1.0).sum() == 1


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


def test_what_is_left_open_stays_open():
    clean = markers(truth("walk"))
    positions = clean.positions.copy()
    positions[:, 5] = np.nan
    held, _ = _shown_again(clean.with_positions(positions), 2.0)
    outcome = repair_without_model(held)
    assert (outcome.origin[:, 5] == Origin.LEFT_OPEN).all()
    assert np.isnan(outcome.recording.positions[:, 5]).all()
    assert np.isnan(outcome.std[:, 5]).all()
