"""People of whom a sensor sees one side, facing anywhere."""

from functools import cache

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth


@cache
def model():
    return fitted()


@cache
def corrected(lost: str, heading: float, look_ahead: int | None):
    """As corrected, turned back."""
    cos, sin = np.cos(heading), np.sin(heading)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    given = sensed(truth("walk", 5), 5) @ turn
    given[:, [k for k, name in enumerate(NAMES) if lost in name]] = np.nan
    told = model().correct(recording(given), look_ahead=look_ahead)
    return told.positions @ turn.T, told.source.warnings


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0])
@pytest.mark.parametrize("lost", ["Left", "Right"])
@pytest.mark.parametrize("heading", [2.0, 3.14])
def test_who_is_seen_from_one_side_is_corrected_alike_whatever_they_face(heading, lost, look_ahead):
    told, warnings = corrected(lost, heading, look_ahead)
    np.testing.assert_allclose(told, corrected(lost, 0.0, look_ahead)[0], atol=1e-3)
    assert not any("changed back" in one for one in warnings)
