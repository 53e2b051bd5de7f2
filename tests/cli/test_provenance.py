"""What stands in a .mend.json is what the repair did."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motionmend.bodies.motion import Markers, Motion, Origin, Repaired
from motionmend.bodies.skeleton import Skeleton
from motionmend.cli.provenance import mask_runs, provenance, repaired_from

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


@given(arrays(np.uint8, st.tuples(st.integers(1, 20), st.just(2)), elements=st.integers(0, 3)), st.booleans())
def test_what_was_written_of_a_repair_is_read_again(origin: np.ndarray, angles: bool) -> None:
    """Every sample's origin, and the deviation of each that was not measured, to the digits written."""
    rng = np.random.default_rng(len(origin))
    std = np.where(origin == OPEN, np.nan, rng.uniform(0.001, 0.1, origin.shape))
    if angles:
        skeleton = Skeleton(
            ("hips",),
            [-1],
            np.zeros((1, 3)),
            ("hips.tx", "hips.rx"),
            [0, 0],
            np.eye(3)[:2],
            [1, 0],
            [[-np.inf, np.inf]] * 2,
        )
        recording: Motion | Markers = Motion(skeleton, np.zeros(origin.shape), 30.0)
    else:
        recording = Markers(("LFHD", "RFHD"), np.zeros((*origin.shape, 3)), 30.0)
    done = Repaired(recording, origin, std, np.ones(origin.shape), "adaptive", 2, np.array([2.0, 1.0]))
    said = {**provenance(done), "method": done.method, "warnings": ["a word"]}
    said["runs"] = dict(said["runs"])
    again = repaired_from(json.loads(json.dumps(said)), recording)
    assert again is not None
    np.testing.assert_array_equal(again.origin, origin)
    touched = origin != MEASURED
    np.testing.assert_allclose(again.std[touched], std[touched], rtol=6e-3)
    assert np.isnan(again.std[~touched]).all()
    assert (again.method, again.iterations, again.warnings) == ("adaptive", 2, ("a word",))


def test_runs_beyond_a_recording_are_of_another_one() -> None:
    markers = Markers(("LFHD",), np.zeros((3, 1, 3)), 30.0)
    done = Repaired(markers, np.array([[0], [2], [2]]), np.ones((3, 1)), np.ones((3, 1)), "adaptive")
    said = {**provenance(done), "method": "adaptive", "warnings": []}
    said["runs"] = dict(said["runs"])
    shorter = Markers(("LFHD",), np.zeros((2, 1, 3)), 30.0)
    with pytest.raises(ValueError, match="LFHD: frames 1 to 2 of 2"):
        repaired_from(said, shorter)


def test_a_file_that_tells_of_no_single_sample_is_no_repair() -> None:
    markers = Markers(("LFHD",), np.zeros((2, 1, 3)), 30.0)
    assert repaired_from({"method": "default", "warnings": []}, markers) is None
