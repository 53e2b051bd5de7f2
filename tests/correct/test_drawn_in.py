"""Limbs that are drawn in slowly: neither a leap nor a tremble tells, but bones do, and what is usual does not follow."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.arrays import Bools, Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import Corrector, CorrectorModel
from motionmend.correct.watching import fresh, unsteadiness
from motionmend.kernels import proportions

from .sensed_people import pair
from .test_real_people import LEARNED, TESTED, paired

LIMBS = ("LForearm", "LHand"), ("RLowerLeg", "RFoot", "RToes")


@given(drawn=st.floats(0.0, 0.6), seconds=st.floats(0.3, 1.0))
@settings(max_examples=30, deadline=None)
def test_usual_lengths_do_not_go_along_with_a_bone_that_is_drawn_in(drawn: float, seconds: float) -> None:
    bones, usual = np.array([[0, 1]]), np.array([0.02])
    sums, spread, well = np.zeros((2, 1)), usual, np.zeros(2)
    frames = round(30 * seconds)
    lengths = np.concatenate([np.full(30, 0.3), 0.3 * np.linspace(1.0, drawn, frames)])
    for length in lengths:
        sums, spread = proportions.counted(sums, spread, np.array([length]), well, bones, usual, 1 / 30)
    assert 0.9 * 0.3 < sums[0, 0] / sums[1, 0] <= 0.3 + 1e-12


def test_a_sensor_is_restless_by_most_of_its_bones() -> None:
    model = Corrector(points=50).fit([pair("walk", seed) for seed in range(2)])
    usual = np.asarray(model.watcher.detector.bone_spread)
    assert np.array_equal(fresh(model.watcher).spread, usual)
    one_limb, all_bones = usual.copy(), 4.0 * usual
    one_limb[:3] *= 20.0
    np.testing.assert_allclose(unsteadiness(model.watcher, one_limb), usual)
    np.testing.assert_allclose(unsteadiness(model.watcher, 1.9 * usual), usual)
    assert (unsteadiness(model.watcher, all_bones) > 3.0 * usual).all()


@pytest.fixture(scope="module")
def folder(data: Path) -> Path:
    found = data / "kinect" / "uiprmd"
    if not found.is_dir():
        pytest.skip("no paired recordings of a sensor among the data")
    return found


@pytest.fixture(scope="module")
def model(folder: Path) -> CorrectorModel:
    return Corrector(points=150).fit(paired(folder, LEARNED))


def drawn_in(sensor: Postures, limb: tuple[str, ...], share: float = 0.9) -> tuple[Postures, Bools]:
    """A limb drawn to the trunk in the course of 0.8 s, kept there for a second, and given back; where it is 15 cm off."""
    joints = [sensor.names.index(name) for name in limb]
    middle = sensor.positions[:, [sensor.names.index(name) for name in ("Waist", "Spine", "Chest")]].mean(axis=1)
    rise = np.clip((sensor.times - sensor.times[0] - 0.8) / 0.8, 0.0, 1.0)
    fall = np.clip((sensor.times[0] + 3.4 - sensor.times) / 0.8, 0.0, 1.0)
    way = share * np.minimum(rise**2 * (3.0 - 2.0 * rise), fall**2 * (3.0 - 2.0 * fall))[:, None, None]
    positions: Floats = np.array(sensor.positions)
    positions[:, joints] += way * (middle[:, None] - positions[:, joints])
    off = np.linalg.norm(positions - sensor.positions, axis=2) > 0.15
    return replace(sensor, positions=positions, state=None), np.asarray(off)


@pytest.mark.parametrize("ahead", [None, 0])
def test_limbs_that_are_drawn_in_slowly_are_mended(model: CorrectorModel, folder: Path, ahead: int | None) -> None:
    before, after = [], []
    for one in paired(folder, TESTED):
        for limb in LIMBS:
            spoilt, off = drawn_in(one.sensor, limb)
            there = off & np.isfinite(one.truth.positions).all(axis=2)
            found = model.correct(spoilt, look_ahead=ahead).positions
            before.append(np.linalg.norm(spoilt.positions - one.truth.positions, axis=2)[there])
            after.append(np.linalg.norm(found - one.truth.positions, axis=2)[there])
    assert np.concatenate(after).mean() < 0.5 * np.concatenate(before).mean()
