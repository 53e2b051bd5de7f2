"""A sensor of which all joints shake: told from motion and from joints that fail, and calmed."""

from dataclasses import replace

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.correct import CorrectorModel
from motionmend.correct.shaking import calm, shaken
from motionmend.evaluate.sensor_failures import fail
from motionmend.kernels.bones import ACQUAINTED_SECONDS


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


def said(positions: np.ndarray, times: np.ndarray) -> np.ndarray:
    """(T,) m, the deviation that is told after each frame."""
    shaking, found = calm(positions.shape[1]), []
    nobody = np.full(positions.shape[1:], np.nan)
    for t, now in enumerate(times):
        last, earlier = (positions[t - back] if t >= back else nobody for back in (1, 2))
        shaking = shaken(shaking, positions[t], last, earlier, now - times[t - 1] if t else 0.0)
        found.append(shaking.deviation)
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump"])
@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_noise_of_all_joints_is_told_and_motion_is_none(action: str, noise: float) -> None:
    clean = truth(action, 5, 4.0)
    times = np.arange(len(clean)) / 30.0
    assert said(clean, times).max() < 0.002
    shaky = clean + noise * np.random.default_rng(1).normal(size=clean.shape)
    assert np.median(said(shaky, times)) == pytest.approx(noise, rel=0.25)


def test_who_shakes_alone_or_is_shown_twice_is_no_shaking_sensor() -> None:
    clean = truth("walk", 6, 4.0)
    shaky, times = np.array(clean), np.arange(len(clean)) / 30.0
    shaky[:, :4] += 0.05 * np.random.default_rng(2).normal(size=shaky[:, :4].shape)
    assert said(shaky, times).max() < 0.005
    uneven = np.delete(np.arange(len(clean)), slice(2, None, 3))  # of three frames the third is lost
    assert said(clean[uneven], times[uneven]).max() < 0.002


@pytest.mark.slow
@pytest.mark.parametrize(("look_ahead", "left"), [(0, 0.71), (3, 0.55)])
def test_a_sensor_of_which_all_joints_shake_is_not_given_up_live(
    model: CorrectorModel, look_ahead: int, left: float
) -> None:
    off: dict[str, list[float]] = {"given": [], "found": [], "believed": []}
    for seed, action in enumerate(("walk", "reach", "jump", "walk")):
        true = truth(action, 60 + seed, 3.0)
        raw = recording(sensed(true, 60 + seed, 0.03))
        found = model.correct(raw, look_ahead=look_ahead)
        assert found.reliability is not None
        for name, postures in (("given", raw), ("found", found)):
            off[name].append(float(np.linalg.norm(postures.positions - true, axis=2).mean()))
        off["believed"].append(float(found.reliability.mean()))
    assert max(np.array(off["found"]) / np.array(off["given"])) < left
    assert min(off["believed"]) > 0.9


@pytest.mark.slow
def test_limbs_that_fail_are_found_where_all_joints_shake(model: CorrectorModel) -> None:
    given, found = [], []
    for seed, action in enumerate(("walk", "reach", "jump", "walk")):
        true = truth(action, 70 + seed, 4.0)
        failed = fail(recording(sensed(true, 70 + seed, 0.01)), seed=seed, swaps=0.0, states=False)
        for kept, postures in ((given, failed.postures), (found, model.correct(failed.postures, look_ahead=0))):
            kept.append(np.linalg.norm(postures.positions - true, axis=2)[failed.affected].mean())
    assert np.mean(found) < 0.6 * np.mean(given)


def test_a_first_frame_does_not_say_for_long_whether_the_sensor_is_the_learned_one(model: CorrectorModel) -> None:
    """The mean of half a second does; from then on it changes slowly, and not at all while the clock stands."""
    state = model.start(NAMES)
    state = replace(state, kin=state.kin_after(0.1, 0.0))
    assert state.kin == 0.1
    for k in range(1, 18):
        lengths = np.full_like(state.shown.lengths, k / 30.0)
        state = replace(state, shown=replace(state.shown, time=(k - 1) / 30.0, lengths=lengths))
        state = replace(state, kin=state.kin_after(1.0, k / 30.0))
    assert state.kin == pytest.approx(1.0 - 0.9 / 18)
    known = replace(state.shown, time=1.0, lengths=np.full_like(state.shown.lengths, ACQUAINTED_SECONDS))
    later = replace(state, shown=known)
    assert later.kin_after(0.0, 1.0) == state.kin
    assert 0.99 * state.kin < later.kin_after(0.0, 1.0 + 1 / 30) < state.kin
