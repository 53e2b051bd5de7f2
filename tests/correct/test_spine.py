"""Joints along the spine: who has them elsewhere is another sensor, and is not put out of joint for it."""

from functools import cache

import numpy as np
import pytest
from sensed_people import NAMES, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import Corrector, CorrectorModel, Pair
from motionmend.correct.anatomy import anatomy
from motionmend.correct.spine import heights

WITH_CHEST = (*NAMES, "Chest")
PELVIS, BASE = NAMES.index("HipCenter"), NAMES.index("ShoulderCenter")


def with_chest(positions: Floats, along: float) -> Postures:
    """A recording with a chest so far on the way from the pelvis to the neck's base, and 2 mm before that line."""
    low, high = positions[:, PELVIS], positions[:, BASE]
    chest = low + along * (high - low) + [0.0, 0.0, 0.002]
    one = recording(positions)
    return Postures(WITH_CHEST, np.concatenate([positions, chest[:, None]], axis=1), one.times)


@cache
def model() -> CorrectorModel:
    """Of a sensor that has the chest at the neck's base, as UI-PRMD does."""
    trues = [(truth(action, 3), sensed(truth(action, 3), 3)) for action in ("walk", "reach")]
    return Corrector(points=40).fit([Pair(with_chest(raw, 0.985), with_chest(true, 0.985)) for true, raw in trues])


@pytest.mark.parametrize("ahead", [None, 0, 3])
def test_a_chest_in_the_middle_of_the_trunk_is_another_sensors(ahead: int | None) -> None:
    """A bone of a centimetre that has a span's length is no sign of a joint that fails."""
    given = with_chest(sensed(truth("reach", 41), 41), 0.57)
    corrected = model().correct(given, look_ahead=ahead)
    assert np.linalg.norm(corrected.positions - given.positions, axis=2).mean() < 0.015
    assert corrected.reliability is not None
    assert corrected.reliability.mean() > 0.9
    (said,) = corrected.source.warnings  # type: ignore[attr-defined]
    assert "Chest" in said
    assert "another sensor" in said


def test_one_frame_in_which_the_chest_is_thrown_off_is_not_another_sensor() -> None:
    given = with_chest(sensed(truth("reach", 42), 42), 0.985)
    frames = given.positions.copy()
    frames[0, -1] += 0.5 * (frames[0, PELVIS] - frames[0, BASE])
    state = model().start(given.names)
    for k, frame in enumerate(frames):
        state, one = model().step(state, frame, None, k / 30.0)
    assert not state.joining.elsewhere.any()
    assert "foreign" not in one.flags


def test_heights_do_not_ask_for_axes_or_size() -> None:
    body, rows = anatomy(WITH_CHEST), with_chest(truth("walk", 5), 0.6).positions.copy()
    found = heights(rows, body)
    np.testing.assert_allclose(found[:, -1], 0.6, atol=1e-3)
    np.testing.assert_allclose(heights(1.3 * rows[..., [2, 0, 1]] + [5.0, 0.0, 1.0], body), found, atol=1e-9)
    rows[:, PELVIS] = np.nan
    assert np.isnan(heights(rows, body)).all()
