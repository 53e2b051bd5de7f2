"""What stands in a .mend.json is what the repair did."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motionmend.bodies.motion import Markers, Origin, Repaired
from motionmend.cli.provenance import mask_runs, provenance

MEASURED, REPAIRED, FILLED, OPEN = (int(origin) for origin in Origin)


@given(arrays(np.bool_, st.integers(0, 30)))
def test_runs_give_the_mask_back(mask: np.ndarray) -> None:
    again = np.zeros_like(mask)
    for first, frames in mask_runs(mask):
        assert frames > 0
        assert not again[first : first + frames].any()
        again[first : first + frames] = True
    assert (again == mask).all()
    assert len(mask_runs(mask)) == int((np.diff(mask.astype(int), prepend=0) == 1).sum())


def test_entries_of_a_repair_that_can_be_reckoned() -> None:
    origin = np.array([[MEASURED, FILLED], [REPAIRED, FILLED], [MEASURED, OPEN], [FILLED, MEASURED]])
    std = np.array([[0.001, 0.02], [0.004, 0.03], [0.001, np.nan], [0.0123456, 0.001]])
    weights = np.array([[1, 0], [0, 0], [1, 0], [0, 1]])
    positions = np.zeros((4, 2, 3))
    positions[2, 1] = np.nan
    markers = Markers(("LFHD", "RFHD"), positions, 120.0)
    found = provenance(
        Repaired(markers, origin, std, weights, "paper", iterations=2, cost=np.array([3.0, 2.0, 1.5]), converged=False)
    )
    assert found["counts"] == {"measured": 3, "repaired": 1, "filled": 3, "left_open": 1}
    assert found["channels"]["RFHD"] == {"measured": 1, "repaired": 0, "filled": 2, "left_open": 1}
    assert found["std"]["LFHD"] == {"unit": "m", "mean": pytest.approx(0.00459), "max": 0.0123}
    assert found["runs"] == {
        "LFHD": {"repaired": [[1, 1, 0.004]], "filled": [[3, 1, 0.0123]]},
        "RFHD": {"filled": [[0, 2, [0.02, 0.03]]], "left_open": [[2, 1]]},
    }
    assert (found["iterations"], found["cost"], found["converged"]) == (2, [3.0, 2.0, 1.5], False)
