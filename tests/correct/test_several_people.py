"""Several people one after another in a recording are corrected each on their own, one person as a whole."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import CorrectorModel
from motionmend.correct.several_people import taking_turns

CHILD = 0.65


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


@cache
def alone(of: Callable[[], Floats]) -> Floats:
    """(T, 20, 3) where somebody is found with nobody before or after."""
    return fitted().correct(recording(of())).positions


def after_each_other(first: Floats, second: Floats, gap: int) -> Postures:
    return recording(np.concatenate([first, np.full((gap, *first.shape[1:]), np.nan), second]))


def adult() -> Floats:
    return sensed(truth("reach", 5, 1.5), 5)


def child() -> Floats:
    walking = sensed(truth("walk", 6, 1.5), 6)
    return CHILD * (walking - walking[:1, :1]) + adult()[-1:, :1]


@pytest.mark.slow
@pytest.mark.parametrize("gap", [0, 20, 75])
def test_a_child_after_an_adult_keeps_the_bones_of_a_child(model: CorrectorModel, gap: int) -> None:
    left = len(adult())
    found = model.correct(after_each_other(adult(), child(), gap))
    begins = left + gap
    for part, of in ((found.positions[:left], adult), (found.positions[begins:], child)):
        np.testing.assert_allclose(part, alone(of), atol=0.003)
    assert np.isnan(found.positions[left:begins]).all()
    assert any("somebody else" in one and f"{begins / 30:.2f} s" in one for one in found.source.warnings)
    assert len(found.source.flags) == found.frames


@pytest.mark.slow
def test_who_comes_back_is_the_same_person_and_that_is_said(model: CorrectorModel) -> None:
    whole = sensed(truth("walk", 5, 2.5), 5)
    half = len(whole) // 2
    found = model.correct(after_each_other(whole[:half], whole[half:], 90))
    thigh = [NAMES.index("HipLeft"), NAMES.index("KneeLeft")]
    length = np.linalg.norm(found.positions[:, thigh[0]] - found.positions[:, thigh[1]], axis=1)
    np.testing.assert_allclose(length[np.isfinite(length)], np.nanmedian(length), rtol=1e-6)
    assert any("taken for the one before" in one for one in found.source.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "reach", "jump"])
def test_one_person_is_one_recording(model: CorrectorModel, action: str) -> None:
    found = model.correct(recording(sensed(truth(action, 9), 9, noise=0.02)))
    assert not any("somebody else" in one for one in found.source.warnings)


@pytest.mark.parametrize("order", ["turns", "by chance"])
def test_who_takes_turns_with_somebody_is_corrected_alone(model: CorrectorModel, order: str) -> None:
    """A row of one and a row of the other, and nothing says whose: what came out lay in the middle between them."""
    other = adult()[:40] + np.array([1.2, 0.0, 0.4])
    one = sensed(truth("walk", 6, 1.5), 6)[:40]
    one += other[0, 0] - one[0, 0] - [1.2, 0.0, 0.0]
    whose = np.arange(80) % 2 if order == "turns" else np.random.default_rng(3).permutation(np.arange(80) % 2)
    rows = np.empty((80, *one.shape[1:]))
    rows[whose == 0], rows[whose == 1] = one, other
    times = np.arange(80) / 60.0
    found = model.correct(Postures(NAMES, rows, times))
    for k, alone_there in enumerate((one, other)):
        mine = Postures(NAMES, alone_there, times[whose == k])
        np.testing.assert_allclose(found.positions[whose == k], model.correct(mine).positions, atol=1e-9)
    assert any("take turns" in said for said in found.source.warnings)
    assert len(found.source.flags) == found.frames


def test_who_leaps_now_and_then_takes_no_turns() -> None:
    rows = sensed(truth("walk", 6, 1.5), 6)
    rows[20:] += [3.0, 0.0, 0.0]
    assert not taking_turns(rows, np.arange(len(rows)) / 30.0).any()
    rows[::2] = np.nan
    assert not taking_turns(rows, np.arange(len(rows)) / 30.0).any()
