"""Comparing joint positions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.joint_sets import KINECT25, UIPRMD22
from motionmend.bodies.postures import Postures
from motionmend.errors import MismatchError
from motionmend.evaluate.joints import compare_joints

NAMES = ("pelvis", "head", "l_wrist", "r_wrist")


def postures(seed: int = 0, frames: int = 30, fps: float = 30.0) -> Postures:
    rng = np.random.default_rng(seed)
    times = np.arange(frames) / fps
    swing = 0.2 * np.sin(2 * np.pi * (times[:, None, None] + rng.random((1, 4, 3))))
    return Postures(NAMES, swing + rng.normal(size=(1, 4, 3)), times)


def test_a_recording_is_itself() -> None:
    found = compare_joints(postures(), postures())
    assert (found.mean_cm, found.p95_cm, found.share_above_15cm, found.missing["samples"]) == (0, 0, 0, 0)
    assert found.notes == ()


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0.001, 1.0))
def test_a_shift_is_its_length(seed: int, length: float) -> None:
    truth = postures(seed)
    way = np.random.default_rng(seed).normal(size=3)
    way *= length / np.linalg.norm(way)
    found = compare_joints(truth, truth.with_positions(truth.positions + way))
    for value in (found.mean_cm, found.median_cm, found.p95_cm, found.max_cm, *found.mean_cm_by_joint.values()):
        assert value == pytest.approx(100 * length)
    if abs(length - 0.15) > 1e-6:
        assert found.share_above_15cm == found.frames_above_15cm == float(length > 0.15)


def test_joints_are_matched_by_name_in_any_order() -> None:
    truth = postures()
    order = [2, 0, 3, 1]
    other = Postures(tuple(NAMES[k] for k in order), truth.positions[:, order], truth.times)
    assert compare_joints(truth, other).mean_cm == 0


def test_what_is_missing_never_helps() -> None:
    truth = postures()
    off = truth.positions + np.array([0.01, 0, 0])
    off[:, 2] += [0.5, 0, 0]
    whole = compare_joints(truth, truth.with_positions(off))
    off[5:15, 2] = np.nan
    gappy = compare_joints(truth, truth.with_positions(off))
    assert gappy.missing == {
        "samples": 10,
        "share": 10 / 120,
        "by_channel": dict(zip(NAMES, [0, 0, 10, 0], strict=True)),
    }
    assert gappy.mean_cm is not None
    assert whole.mean_cm is not None
    assert gappy.mean_cm < whole.mean_cm  # which is why it is not the whole story
    assert gappy.mean_cm_counting_missing is not None
    assert gappy.mean_cm_counting_missing > 1.5 * gappy.mean_cm
    assert gappy.share_above_15cm_counting_missing == whole.share_above_15cm == 0.25


@pytest.mark.parametrize("lost", [0, 2, 3])
def test_to_lose_joints_that_are_far_off_improves_no_score(lost: int) -> None:
    truth = postures()
    off = truth.positions + np.array([3.0, 0, 0])  # m, farther than the middle of the body is
    off[5:15, lost] = np.nan
    found = compare_joints(truth, truth.with_positions(off))
    assert found.mean_cm == pytest.approx(300.0)
    assert found.mean_cm_counting_missing is not None
    assert found.mean_cm_counting_missing >= found.mean_cm - 1e-6


def test_a_joint_without_a_column_counts_as_missing() -> None:
    truth = postures()
    found = compare_joints(truth, Postures(NAMES[:3], truth.positions[:, :3], truth.times))
    assert found.missing["by_channel"]["r_wrist"] == 30
    assert any("r_wrist" in note for note in found.notes)


def test_what_is_too_much_counts_unless_it_is_unsure() -> None:
    truth = postures()
    empty = truth.positions.copy()
    empty[:10] = np.nan
    sure = compare_joints(truth.with_positions(empty), truth)
    assert sure.extra == {"samples": 40, "share": 1.0}
    std = np.zeros((30, 4))
    std[:10] = 0.2
    unsure = Postures(NAMES, truth.positions, truth.times, std=std)
    assert compare_joints(truth.with_positions(empty), unsure).extra["samples"] == 0


def test_frames_without_anybody_are_lost() -> None:
    truth = postures()
    some = truth.positions.copy()
    some[:6] = np.nan
    assert compare_joints(truth, truth.with_positions(some)).frames_above_15cm == 0.2


@pytest.mark.parametrize(("ours", "theirs"), [(30.0, 120.0), (120.0, 30.0), (30.0, 29.97)])
def test_other_rates_are_compared_in_time(ours: float, theirs: float) -> None:
    truth, other = postures(frames=int(2 * ours), fps=ours), postures(frames=int(2 * theirs) - 3, fps=theirs)
    found = compare_joints(truth, other)
    assert found.mean_cm is not None
    assert found.mean_cm < 0.5  # a straight line between samples of a swing
    assert len(found.notes) == 1
    assert "on a straight line" in found.notes[0]


@pytest.mark.parametrize(("ours", "theirs", "lacking"), [(30.0, 60.0, 1 / 2), (60.0, 30.0, 0.0), (30.0, 100.0, 0.7)])
def test_as_many_rows_at_another_rate_are_compared_in_time(ours: float, theirs: float, lacking: float) -> None:
    truth, other = postures(frames=120, fps=ours), postures(frames=120, fps=theirs)
    found = compare_joints(truth, other)
    assert found.mean_cm is not None
    assert found.mean_cm < 0.5
    assert found.missing["share"] == pytest.approx(lacking, abs=0.01)
    assert f"120 rows at {theirs:g} Hz where the truth has 120 rows at {ours:g} Hz" in found.notes[0]


@pytest.mark.parametrize("other", [postures(fps=29.97).times, postures().times + 0.5, np.zeros(30)])
def test_as_many_rows_by_another_clock_are_compared_row_by_row(other: np.ndarray) -> None:
    truth = postures()
    late = Postures(NAMES, truth.positions, other + 10.0)
    found = compare_joints(truth, late)
    assert found.mean_cm == 0
    assert "row by row" in found.notes[0]


def test_a_recording_that_ends_early_lacks_the_rest() -> None:
    truth = postures(frames=60)
    other = Postures(NAMES, truth.positions[:40], truth.times[:40])
    assert compare_joints(truth, other).missing["share"] == pytest.approx(1 / 3)


def test_names_of_sensors_are_matched_by_meaning() -> None:
    truth = postures()
    other = Postures(("SpineBase", "Head", "WristLeft", "WristRight"), truth.positions, truth.times)
    found = compare_joints(truth, other)
    assert found.mean_cm == 0
    assert "mean" in found.notes[0]


def test_names_go_before_meanings_where_most_are_the_same() -> None:
    """A body's `neck` may mean another place than a sensor's; in two recordings of one body it is the same joint."""
    names = ("pelvis", "Neck", "Spine1", "Head", "l_wrist")
    rng = np.random.default_rng(1)
    truth = Postures(names, rng.normal(size=(10, 5, 3)), np.arange(10) / 30)
    other = Postures(tuple(f"him:{name.lower()}" for name in names), truth.positions, truth.times)
    assert compare_joints(truth, other).mean_cm == 0
    renamed = Postures(("pelvis", "Neck", "Spine1", "Head", "WristLeft"), truth.positions, truth.times)
    found = compare_joints(truth, renamed)
    assert (found.mean_cm, found.missing["samples"]) == (0, 0)
    assert "l_wrist" in found.notes[0]


def test_two_names_that_two_sensors_share_by_chance_do_not_go_before_what_they_mean() -> None:
    rng = np.random.default_rng(2)
    at = rng.normal(size=(5, 22, 3))
    truth = Postures(UIPRMD22.names, at, np.arange(5) / 30)
    place = {meaning: k for k, meaning in enumerate(UIPRMD22.meanings)}
    there = np.stack([at[:, place[m]] if m in place else at[:, 0] + 9.0 for m in KINECT25.meanings], axis=1)
    found = compare_joints(truth, Postures(KINECT25.names, there, truth.times))
    assert found.mean_cm == pytest.approx(0.0)


@pytest.mark.parametrize("signs", [(1, -1, 1), (-1, -1, 1)])
def test_sensors_with_y_up_are_compared_with_cameras(signs: tuple[int, int, int]) -> None:
    rng = np.random.default_rng(0)
    at = np.array([[0, 0.9, 3], [0, 1.6, 3], [0.4, 1.2, 2.8], [-0.4, 1.1, 2.9]]) + 0.05 * rng.normal(size=(20, 4, 3))
    truth = Postures(NAMES, at, np.arange(20) / 30)
    found = compare_joints(truth, truth.with_positions(at * np.array(signs)))
    assert found.mean_cm == pytest.approx(0.0)
    assert "changed sign" in found.notes[0]
    assert compare_joints(truth, truth).notes == ()


def test_other_axes_are_brought_together() -> None:
    truth = postures()
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    found = compare_joints(truth, truth.with_positions(truth.positions @ turn.T + [1, 2, 3]), align=True)
    assert found.mean_cm == pytest.approx(0.0, abs=1e-9)
    mirrored = compare_joints(truth, truth.with_positions(truth.positions * [-1, 1, 1]), align=True)
    assert mirrored.mean_cm is not None
    assert mirrored.mean_cm > 5.0


def test_nothing_in_common() -> None:
    truth = postures()
    with pytest.raises(MismatchError, match="names"):
        compare_joints(truth, Postures(("a", "b", "c", "d"), truth.positions, truth.times))
    with pytest.raises(MismatchError, match="common times"):
        compare_joints(truth, Postures(NAMES, truth.positions[:9], truth.times[:9] + 50))
