"""Frames and recordings that cannot be corrected: one clear line, and the state stays as it was."""

from dataclasses import replace

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.bodies.postures import Postures
from motionmend.correct import METHODS, CorrectorModel
from motionmend.errors import MismatchError


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


@pytest.mark.slow
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("at", [0, 7])
def test_a_time_that_is_no_number_is_named(model: CorrectorModel, bad: float, at: int) -> None:
    raw = recording(sensed(truth("walk", 7), 7)[:12])
    timeless = replace(raw, times=np.where(np.arange(12) == at, bad, raw.times))
    for method in METHODS:
        with pytest.raises(MismatchError, match=f"frame {at} has {bad}"):
            model.correct(timeless, method=method)
    with pytest.raises(MismatchError, match=f"frame {at} has {bad}"):
        model.correct(timeless, look_ahead=2)


def test_no_joints_are_too_few(model: CorrectorModel) -> None:
    for frames in (0, 5):
        with pytest.raises(MismatchError, match="came no joints at all"):
            model.correct(Postures((), np.zeros((frames, 0, 3)), np.arange(frames) / 30.0))


@pytest.mark.parametrize("look_ahead", [0, 3])
def test_a_live_frame_of_another_shape_or_without_a_time_is_refused(model: CorrectorModel, look_ahead: int) -> None:
    posture = recording(sensed(truth("walk", 7), 7)).positions[0]
    state = model.start(NAMES, look_ahead=look_ahead)
    for bad in (posture[:5], np.vstack((posture, posture)), posture[:0], posture[:, :2], posture.ravel()):
        with pytest.raises(MismatchError, match=r"a frame of 20 joints is \(20, 3\)"):
            model.feed(state, bad, None, 0.0)
    with pytest.raises(MismatchError, match=r"came \(20, 3\) and \(3,\)"):
        model.feed(state, posture, np.full(3, 2, np.uint8), 0.0)
    for time in (np.nan, np.inf):
        with pytest.raises(MismatchError, match="the time of a frame in s was wanted"):
            model.feed(state, posture, None, time)
    model.feed(state, posture, None, 0.0)


@pytest.mark.parametrize("look_ahead", [None, 0])
def test_a_pelvis_from_which_all_else_is_given_is_not_missing(model: CorrectorModel, look_ahead: int | None) -> None:
    raw = recording(sensed(truth("walk", 7), 7)[:40])
    rooted = raw.with_positions(raw.positions - raw.positions[:, :1])
    away = np.array([0.0, 0.0, 2.0])
    aside = raw.with_positions(rooted.positions + away)
    found, wanted = (model.correct(one, look_ahead=look_ahead) for one in (rooted, aside))
    np.testing.assert_allclose(found.positions + away, wanted.positions, atol=0.002)
    np.testing.assert_allclose(found.std, wanted.std, rtol=0.05)
