"""Frames given out late: never touched by what comes later still, and nearer to the truth where the sensor fails."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from sensed_people import fitted, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import CorrectorModel
from motionmend.correct.look_ahead import LONGEST, MOST, frames_in
from motionmend.errors import UsageError
from motionmend.evaluate.sensor_failures import fail


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


def until(postures: Postures, frames: int) -> Postures:
    state = None if postures.state is None else postures.state[:frames]
    return replace(postures, positions=postures.positions[:frames], times=postures.times[:frames], state=state)


def test_no_look_ahead_is_the_live_correction(model: CorrectorModel) -> None:
    failed = fail(recording(sensed(truth("reach", 4), 4), state=True), seed=1).postures
    state, found = model.start(failed.names), []
    for t in range(failed.frames):
        assert failed.state is not None
        state, one = model.step(state, failed.positions[t], failed.state[t], float(failed.times[t]))
        found.append(one.positions)
    np.testing.assert_array_equal(model.correct(failed, look_ahead=0).positions, np.stack(found))


@pytest.mark.slow
def test_what_only_the_next_frame_asks_for_is_not_kept(model: CorrectorModel) -> None:
    long = recording(sensed(truth("walk", 5, 6.0), 5))
    half = until(long, long.frames // 2)
    model.correct(until(long, 10), look_ahead=2)  # loads and compiles what it needs
    peaks = []
    for one in (half, long):
        tracemalloc.start()
        model.correct(one, look_ahead=2)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert (peaks[1] - peaks[0]) / (long.frames - half.frames) < 14_000  # of the factors alone it knows 18 kB


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [1, 4])
def test_frames_depend_on_the_frames_looked_at_and_on_none_after(model: CorrectorModel, look_ahead: int) -> None:
    failed = fail(recording(sensed(truth("reach", 4), 4), state=True), seed=2).postures
    whole = model.correct(failed, look_ahead=look_ahead)
    part = model.correct(until(failed, 30), look_ahead=look_ahead)
    np.testing.assert_allclose(part.positions[: 30 - look_ahead], whole.positions[: 30 - look_ahead], atol=1e-9)
    assert whole.frames == failed.frames
    np.testing.assert_array_equal(whole.times, failed.times)


@pytest.mark.slow
def test_joints_that_fail_are_nearer_to_the_truth(model: CorrectorModel) -> None:
    errors: dict[int, list[float]] = {0: [], 5: []}
    others: dict[int, list[float]] = {0: [], 5: []}

    def away(found: Floats, true: Floats, where: object) -> float:
        return float(np.linalg.norm(found - true, axis=2)[where].mean())

    for seed in range(4):
        true = truth("walk", 20 + seed)
        failed = fail(recording(sensed(true, seed), state=True), seed=seed)
        for look_ahead in errors:
            found = model.correct(failed.postures, look_ahead=look_ahead).positions
            errors[look_ahead].append(away(found, true, failed.affected))
            others[look_ahead].append(away(found, true, ~failed.affected))
    assert np.mean(errors[5]) < 0.97 * np.mean(errors[0])
    assert np.mean(others[5]) < 1.03 * np.mean(others[0])


def test_an_empty_look_and_breaks_are_no_harm(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 3), 3), state=True)
    gone = raw.positions.copy()
    gone[20:25] = np.nan
    times = raw.times + np.where(np.arange(raw.frames) > 40, 5.0, 0.0)
    found = model.correct(replace(raw, positions=gone, times=times), look_ahead=6)
    assert np.isnan(found.positions[20:25]).all()
    assert np.isfinite(found.positions[25:]).all()
    few = model.correct(until(raw, 3), look_ahead=6)
    assert np.isfinite(few.positions).all()


def test_what_looking_ahead_takes() -> None:
    assert [frames_in(s, 30.0) for s in (0.0, 0.001, 0.1, 1.0)] == [0, 1, 3, 30]
    assert frames_in(LONGEST, 1000.0) == MOST
    for wrong in (-0.1, 1.1, np.nan):
        with pytest.raises(UsageError):
            frames_in(wrong, 30.0)


def test_only_the_default_looks_ahead(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 3), 3))
    with pytest.raises(UsageError):
        model.correct(raw, method="ridge", look_ahead=3)
    with pytest.raises(UsageError):
        model.start(raw.names, look_ahead=-1)


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["reach", "walk"])
def test_later_frames_make_what_is_given_out_steadier_and_nearer(model: CorrectorModel, motion: str) -> None:
    true = truth(motion, 33)
    raw = recording(sensed(true, 33))
    off = {n: model.correct(raw, look_ahead=n).positions - true for n in (0, 1, 3)}
    places = [float(np.linalg.norm(off[n], axis=2).mean()) for n in off]
    steps = [float(np.linalg.norm(np.diff(off[n], axis=0), axis=2).mean()) for n in off]
    assert places[2] < 1.01 * places[0]
    assert steps[0] > 1.1 * steps[1]
    assert steps[0] > 1.3 * steps[2]
