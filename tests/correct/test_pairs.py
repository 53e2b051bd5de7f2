"""Pairs: a known offset of time and a known rigid motion are found again; what does not belong together is told."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT25, TRACKER16, UIPRMD22, correspondence, mirrored
from motionmend.bodies.postures import Postures
from motionmend.bodies.rigid import rigid_fit
from motionmend.correct.pairs import at_times, match, strange
from motionmend.errors import MismatchError

NAMES = KINECT25.names


def moving(times: Floats, seed: int = 0, names: tuple[str, ...] = NAMES) -> Floats:
    """(T, J, 3) m: joints about a body, each on a smooth path of its own that is not periodic."""
    rng = np.random.default_rng(seed)
    rest = rng.normal(size=(len(names), 3)) * [0.3, 0.5, 0.1]
    wave = rng.uniform(0.5, 4.0, (len(names), 3, 3))
    phase = rng.uniform(0, 7, (len(names), 3, 3))
    path = np.sin(times[:, None, None, None] * wave + phase).sum(axis=3)
    return np.asarray(rest + 0.08 * path)


def pair(
    offset: float,
    turn: Floats,
    shift: Floats,
    noise: float = 0.01,
    bias: float = 0.03,
    seed: int = 0,
    start: float = 0.0,
    sensor_names: tuple[str, ...] = NAMES,
) -> tuple[Postures, Postures]:
    """A sensor at 30 Hz and the truth at 100 Hz in axes of its own; sensor's time + offset = truth's time."""
    rng = np.random.default_rng(seed + 1)
    times, fine = np.arange(0, 4, 1 / 30), np.arange(-0.8, 4.9, 0.01)
    sensed = moving(times, seed, sensor_names)
    sensed = sensed + rng.normal(scale=bias, size=sensed.shape[1:]) + rng.normal(scale=noise, size=sensed.shape)
    truth = (moving(fine, seed, sensor_names) - shift) @ turn
    return Postures(sensor_names, sensed, times + start), Postures(sensor_names, truth, fine + offset + start)


turns = st.tuples(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3)).map(
    lambda angles: Rotation.from_euler("zyx", angles).as_matrix()
)
shifts = st.tuples(*[st.floats(-5, 5)] * 3).map(np.array)


@pytest.mark.slow
@settings(max_examples=5)
@given(st.floats(-0.5, 0.5), turns, shifts, st.integers(0, 1000), st.sampled_from([0.0, 63134.9]))
def test_offset_and_rigid_motion_are_found_again(
    offset: float, turn: Floats, shift: Floats, seed: int, start: float
) -> None:
    sensor, truth = pair(offset, turn, shift, seed=seed, start=start)
    found = match(sensor, truth)
    assert abs(found.offset - offset) < 0.025
    wanted = moving(sensor.times - start, seed)
    apart = np.linalg.norm(found.truth.positions - wanted, axis=2)
    assert np.isfinite(apart).all()
    assert apart.mean() < 0.03  # the bias of 25 joints turns and moves the fit a little
    assert found.truth.names == sensor.names
    np.testing.assert_array_equal(found.truth.times, sensor.times)


@pytest.mark.slow
@settings(max_examples=3)
@given(turns, shifts)
def test_moving_and_turning_the_truth_changes_nothing(turn: Floats, shift: Floats) -> None:
    sensor, truth = pair(0.2, np.eye(3), np.zeros(3))
    moved = truth.with_positions(truth.positions @ turn.T + shift)
    one, other = match(sensor, truth), match(sensor, moved)
    assert one.offset == pytest.approx(other.offset, abs=0.005)
    np.testing.assert_allclose(match(sensor, moved, one.offset).truth.positions, one.truth.positions, atol=1e-9)


@pytest.mark.slow
@given(turns, shifts, st.integers(0, 99))
def test_a_rigid_fit_gives_back_the_motion_and_never_a_mirroring(turn: Floats, shift: Floats, seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(9, 3))
    holed = points.copy()
    holed[0, 1] = np.nan
    rotation, translation = rigid_fit(holed, points @ turn.T + shift)
    np.testing.assert_allclose(rotation, turn, atol=1e-9)
    np.testing.assert_allclose(translation, shift, atol=1e-8)
    mirrored_points = points * [-1, 1, 1]
    assert np.linalg.det(rigid_fit(points, mirrored_points)[0]) == pytest.approx(1.0)


def test_a_given_offset_is_used_and_questioned_when_it_is_wrong() -> None:
    sensor, truth = pair(0.3, np.eye(3), np.zeros(3))
    right, wrong = match(sensor, truth, 0.3), match(sensor, truth, -0.2)
    assert right.offset == 0.3
    assert right.warnings == ()
    assert wrong.offset == -0.2
    assert any("took the one given" in warning for warning in wrong.warnings)
    assert wrong.mean_error > 1.3 * right.mean_error


def test_a_person_who_stands_still_tells_no_offset() -> None:
    sensor, truth = pair(0.0, np.eye(3), np.zeros(3))
    rng = np.random.default_rng(0)
    still = replace(sensor, positions=sensor.positions[:1] + rng.normal(scale=0.005, size=sensor.positions.shape))
    frozen = replace(truth, positions=np.repeat(truth.positions[:1], truth.frames, axis=0))
    assert any("hardly tells" in warning for warning in match(still, frozen).warnings)


def test_missing_truth_stays_missing_and_spoils_nothing_else() -> None:
    sensor, truth = pair(0.1, np.eye(3), np.zeros(3))
    holed = truth.positions.copy()
    holed[200:300, 5] = np.nan
    whole, found = match(sensor, truth, 0.1), match(sensor, truth.with_positions(holed), 0.1)
    gap = ~np.isfinite(found.truth.positions[:, 5, 0])
    assert 25 < gap.sum() < 35
    assert np.isfinite(np.delete(found.truth.positions, 5, axis=1)).all()
    np.testing.assert_allclose(found.truth.positions[:, 6], whole.truth.positions[:, 6], atol=5e-3)


def test_joints_without_a_counterpart_are_missing_and_the_others_go_by_meaning() -> None:
    sensor, truth = pair(0.0, np.eye(3), np.zeros(3))
    rows = correspondence(NAMES, TRACKER16.names)
    few = Postures(TRACKER16.names, truth.positions[:, rows], truth.times)
    found = match(sensor, few, 0.0)
    there = np.asarray(np.isfinite(found.truth.positions[:, :, 0]).all(axis=0))
    assert there.sum() == 16
    assert not there[NAMES.index("HandLeft")]
    assert np.isfinite(found.error[there]).all()
    assert np.isnan(found.error[~there]).all()


def test_a_heads_middle_is_given_to_both_ends_of_the_sensors_head() -> None:
    names = UIPRMD22.names
    sensor, truth = pair(0.0, np.eye(3), np.zeros(3), noise=0.0, bias=0.0, sensor_names=names)
    head, top = names.index("Head"), names.index("HeadTip")
    others = [k for k in range(22) if k != top]
    positions = truth.positions.copy()
    positions[:, head] = truth.positions[:, [head, top]].mean(axis=1) + np.array([0, 0.05, 0])
    found = match(sensor, Postures(tuple(names[k] for k in others), positions[:, others], truth.times), 0.0)
    moved = found.truth.positions - sensor.positions
    np.testing.assert_allclose(moved[:, head], moved[:, top], atol=1e-12)
    np.testing.assert_allclose(moved[:, head], np.tile([0, 0.05, 0], (sensor.frames, 1)), atol=0.01)


@pytest.mark.slow
def test_confused_sides_other_movements_and_other_limbs_are_strange() -> None:
    pairs = [pair(0.0, np.eye(3), np.zeros(3), seed=seed) for seed in range(10)]
    matched = [match(sensor, truth, 0.0) for sensor, truth in pairs]
    assert strange(matched) == ("",) * 10
    sensor, truth = pairs[0]
    other = mirrored(NAMES)
    sides = match(sensor, truth.with_positions(truth.positions[:, other]), 0.0)
    movement = match(sensor, replace(truth, positions=pairs[1][1].positions), 0.0)
    limb = truth.positions.copy()
    limb[:, NAMES.index("WristLeft")] += [0.6, 0, 0]
    one_off = match(sensor, truth.with_positions(limb), 0.0)
    said = strange([*matched, sides, movement, one_off])
    assert said[:10] == ("",) * 10
    assert "left and right" in said[10]
    assert "another movement" in said[11]
    assert "WristLeft" in said[12]


def test_a_few_pairs_are_judged_without_others() -> None:
    matched = [match(*pair(0.0, np.eye(3), np.zeros(3), seed=seed), 0.0) for seed in range(2)]
    assert strange(matched) == ("", "")


def test_too_few_joints_or_no_common_time_is_a_mismatch() -> None:
    sensor, truth = pair(0.0, np.eye(3), np.zeros(3))
    with pytest.raises(MismatchError, match="in common"):
        match(sensor, Postures(("a", "b", "c"), truth.positions[:, :3], truth.times))
    with pytest.raises(MismatchError, match="offset"):
        match(sensor, truth, 100.0)
    with pytest.raises(MismatchError):
        rigid_fit(np.zeros((2, 3)), np.zeros((2, 3)))


@given(st.lists(st.floats(0.001, 0.2), min_size=2, max_size=9), st.integers(0, 99))
def test_at_times_agrees_with_interpolation_coordinate_by_coordinate(steps: list[float], seed: int) -> None:
    times = np.concatenate([[0.0], np.cumsum(steps)])
    rng = np.random.default_rng(seed)
    positions, wanted = rng.normal(size=(len(times), 2, 3)), rng.uniform(0, times[-1], 7)
    plain = np.stack(
        [[np.interp(wanted, times, positions[:, k, c]) for c in range(3)] for k in range(2)], axis=0
    ).transpose(2, 0, 1)
    np.testing.assert_allclose(at_times(positions, times, wanted), plain, atol=1e-9)
    assert np.isnan(at_times(positions, times, np.array([-0.1, times[-1] + 0.1]))).all()
