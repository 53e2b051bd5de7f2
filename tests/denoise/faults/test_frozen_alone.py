"""A marker that froze by itself and leaps after the others."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.frozen_alone import frozen_alone
from motionmend.evaluate import corrupt
from motionmend.io import read
from motionmend.samples import markers
from performers import markers_model, truth


def _nothing(recording):
    return np.zeros((recording.frames, len(recording.names)), dtype=bool)


def _holding(recording, marker, first, last):
    """The recording with a marker held in frames `first` to `last` where it was before, and where that is."""
    positions, still = recording.positions.copy(), _nothing(recording)
    positions[first : last + 1, marker] = positions[first - 1, marker]
    still[first : last + 1, marker] = True
    return recording.with_positions(positions), still


def _fastest(recording, frame):
    """The marker that goes farthest in the next 0.3 s."""
    ahead = frame + round(0.3 * recording.fps)
    return int(np.linalg.norm(recording.positions[ahead] - recording.positions[frame], axis=1).argmax())


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.sampled_from(["walk", "turn", "reach"]), st.integers(20, 100), st.integers(8, 30), st.integers(0, 2))
def test_what_is_left_behind_is_found_and_nothing_else(action, first, length, seed):
    clean = markers(truth(action, seed=seed))
    marker = _fastest(clean, first)
    spoilt, still = _holding(clean, marker, first, first + length)
    found = frozen_alone(spoilt, _nothing(clean))
    assert not found[~still].any()
    behind = np.linalg.norm(spoilt.positions[first + length, marker] - clean.positions[first + length, marker])
    assert found[still].all() or behind < 0.1


@pytest.mark.parametrize("noise", [0.0, 0.0003, 0.002])
def test_it_is_found_beside_noise_and_others_that_froze_elsewhere(noise):
    clean = markers(truth("walk"))
    one, other = _fastest(clean, 40), _fastest(clean, 90)
    spoilt = corrupt(clean, noise=noise, seed=3).recording if noise else clean
    spoilt, still = _holding(spoilt, one, 41, 55)
    spoilt, also = _holding(spoilt, other, 91, 102)
    np.testing.assert_array_equal(frozen_alone(spoilt, _nothing(clean)), still | also)


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_it_is_repaired_from_those_about_it_and_said(library):
    clean = markers(truth("walk"))
    marker = _fastest(clean, 60)
    spoilt, still = _holding(clean, marker, 60, 75)
    outcome = (markers_model().repair if library else repair_without_model)(spoilt)
    off = np.linalg.norm(outcome.recording.positions - clean.positions, axis=2)
    before = np.linalg.norm(spoilt.positions - clean.positions, axis=2)
    assert off[still].max() < 0.1 * before[still].max()
    assert (outcome.origin[still] == Origin.REPAIRED).all()
    (said,) = [warning for warning in outcome.warnings if "frozen" in warning]
    assert "frames 60 to 75" in said
    assert clean.names[marker] in said


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_a_foot_that_stands_is_left(step):
    clean = markers(truth("walk"))
    rounded = clean.with_positions(np.round(clean.positions / step) * step)
    assert (np.diff(rounded.positions, axis=0) == 0).all(axis=2).any()
    assert not frozen_alone(rounded, _nothing(clean)).any()


def test_a_marker_at_rest_that_all_others_pass_is_left():
    """It stays where its guides have it at the end: they come back to it."""
    clean = markers(truth("reach"))
    still = clean.positions.copy()
    still[:, 0] = still[:1, 0]
    assert not frozen_alone(clean.with_positions(still), _nothing(clean)).any()


def test_a_marker_that_is_hardly_seen_else_tells_nothing():
    clean = markers(truth("walk"))
    spoilt, _ = _holding(clean, 3, 60, 75)
    positions = spoilt.positions.copy()
    positions[:57, 3] = positions[79:, 3] = np.nan
    assert not frozen_alone(spoilt.with_positions(positions), _nothing(clean)).any()


def test_what_is_known_to_be_wrong_is_not_asked():
    clean = markers(truth("walk"))
    spoilt, still = _holding(clean, _fastest(clean, 60), 60, 75)
    assert not frozen_alone(spoilt, still).any()


@pytest.mark.parametrize(("first", "last"), [(420, 435), (330, 410), (320, 480)])
def test_a_long_recording_is_looked_through_in_parts(monkeypatch, first, last):
    """Whatever edge of a part the hold lies across."""
    clean = markers(truth("walk", seconds=20.0))
    spoilt, still = _holding(clean, _fastest(clean, last), first, last)
    monkeypatch.setattr("motionmend.denoise.faults.frozen_alone.PIECE", 200)
    found = frozen_alone(spoilt, _nothing(clean))
    np.testing.assert_array_equal(found, still)


@pytest.mark.slow
def test_clean_recordings_hold_none(data):
    for file in sorted((data / "mocap").rglob("*.c3d")):
        recording = read(file)
        assert not frozen_alone(recording, _nothing(recording)).any(), file.name


@pytest.mark.slow
def test_real_markers_that_freeze_are_found(data):
    """Five of each recording for 0.3 s, one at a time: four in five and more of those that are left 5 cm behind."""
    told, seen = 0, 0
    for name in ("cmu_02_01", "gt_squat", "sfu_0018_Moonwalk001"):
        clean = read(data / "mocap" / "c3d" / f"{name}.c3d")
        whole = np.flatnonzero(np.isfinite(clean.positions).all(axis=(0, 2)))
        length = round(0.3 * clean.fps)
        for k, marker in enumerate(np.random.default_rng(7).choice(whole, 5, replace=False)):
            first = clean.frames // 3 + 10 * k
            spoilt, still = _holding(clean, marker, first, first + length)
            behind = np.linalg.norm((spoilt.positions - clean.positions)[first + length, marker])
            if behind > 0.05:
                found = frozen_alone(spoilt, _nothing(clean))
                assert not found[~still].any()
                seen, told = seen + 1, told + bool(found[still].all())
    assert seen >= 8
    assert told >= 0.8 * seen
