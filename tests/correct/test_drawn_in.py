"""Bones tell of limbs drawn in slowly: what is usual does not go along, and most bones tell of restlessness."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from sensed_people import pair

from motionmend.correct import Corrector
from motionmend.correct.sight import fresh, unsteadiness
from motionmend.kernels import proportions


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
