"""Angles of a chain that jump against each other, and outliers that move what hangs on them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend as mm
from motionmend.bodies.skeleton import ROTATION, TRANSLATION, Skeleton, positions
from motionmend.denoise.outliers.as_pose import smoother_as_pose
from performers import FPS

SEEDS = st.integers(0, 10**6)
FRAMES = 60
X, Y, Z = np.eye(3)
UPPER, ELBOW, WRIST = 8, 9, 10  # the twists of the upper arm and the wrist, and the hinge between them
ARM = Skeleton(
    names=("root", "upper", "elbow", "wrist", "hand_end"),
    parents=np.array([-1, 0, 1, 2, 3]),
    offsets=np.array([[0.0, 1.0, 0.0], [0.2, 0.4, 0.0], [0.3, 0.0, 0.0], [0.25, 0.0, 0.0], [0.1, 0.05, 0.0]]),
    dof_names=(
        *("root.tx", "root.ty", "root.tz", "root.rx", "root.ry", "root.rz"),
        *("upper.z", "upper.y", "upper.x", "elbow.z", "wrist.x"),
    ),
    dof_joint=np.array([0] * 6 + [1, 1, 1, 2, 3]),
    dof_axis=np.array([X, Y, Z, X, Y, Z, Z, Y, X, Z, X]),
    dof_kind=np.array([TRANSLATION] * 3 + [ROTATION] * 8, np.uint8),
    limits=np.tile([-np.inf, np.inf], (11, 1)),
)
COLUMNS = np.arange(11)


def _swinging(rng):
    """(T, 11) degrees and cm: an arm that is held almost straight and swings."""
    t = np.arange(FRAMES)[:, None] / FPS
    channels = 15.0 * np.sin(2.0 * np.pi * t * rng.uniform(0.3, 0.6, 11) + rng.uniform(0.0, 6.0, 11))
    channels[:, ELBOW] = 0.5
    return channels


def _twisted(channels, frame, by, columns=(UPPER, WRIST)):
    """Measured channels in which twists jump, and where they are rejected; the second twist undoes the first."""
    measured, outlier = channels.copy(), np.zeros(channels.shape, dtype=bool)
    for column, sign in zip(columns, (1.0, -1.0), strict=False):
        measured[frame, column] += sign * by
        outlier[frame, column] = True
    return measured, outlier


def _turned_over(seed, first, length, by, column):
    """A bent arm as it is, and with an angle of the upper arm and the wrist turned for some frames; where it is."""
    rng = np.random.default_rng(seed)
    channels = _swinging(rng)
    channels[:, ELBOW] += 60.0
    measured, outlier = channels.copy(), np.zeros(channels.shape, dtype=bool)
    hit = np.ix_(range(first, first + length), [column, WRIST])
    measured[hit] += by
    outlier[hit] = True
    return channels, measured, outlier


@given(SEEDS, st.integers(3, FRAMES - 15), st.integers(2, 12), st.floats(168.0, 192.0), st.floats(100.0, 180.0))
@settings(max_examples=40)
def test_a_limb_that_its_solver_turns_over_is_taken_as_measured_though_it_leaps(seed, first, length, half, back):
    channels, measured, outlier = _turned_over(seed, first, length, (half, -back), UPPER)
    kept = smoother_as_pose(measured, outlier, channels, ARM, COLUMNS)
    assert kept[outlier].all()
    assert not kept[:, [*range(6), ELBOW]].any()
    assert not np.delete(kept, range(first, first + length), axis=0).any()


@given(SEEDS, st.integers(3, FRAMES - 15), st.integers(4, 12), st.floats(100.0, 140.0), st.floats(100.0, 140.0))
@settings(max_examples=40)
def test_a_limb_that_is_elsewhere_for_a_while_is_not(seed, first, length, off, back):
    """By less than half a turn, or turned to where none of its joints is in place."""
    for column, by in ((UPPER, (off, -back)), (UPPER - 1, (180.0, -back))):
        channels, measured, outlier = _turned_over(seed, first, length, by, column)
        assert not smoother_as_pose(measured, outlier, channels, ARM, COLUMNS).any()


@given(SEEDS, st.integers(2, FRAMES - 3), st.floats(20.0, 120.0), st.booleans())
@settings(max_examples=40)
def test_twists_that_undo_each_other_are_taken_as_measured(seed, frame, by, down):
    channels = _swinging(np.random.default_rng(seed))
    channels[frame, WRIST] += 25.0  # what the repair puts there is not the truth itself
    measured, outlier = _twisted(_swinging(np.random.default_rng(seed)), frame, -by if down else by)
    kept = smoother_as_pose(measured, outlier, channels, ARM, COLUMNS)
    assert kept[outlier].all()
    assert not kept[:, [*range(6), ELBOW]].any()
    assert not np.delete(kept, frame, axis=0).any()


@given(SEEDS, st.integers(2, FRAMES - 3), st.floats(20.0, 120.0), st.sampled_from([6, 7, UPPER, ELBOW, WRIST]))
@settings(max_examples=40)
def test_an_angle_that_jumps_alone_is_not(seed, frame, by, column):
    channels = _swinging(np.random.default_rng(seed))
    measured, outlier = _twisted(channels, frame, by, (column,))
    assert not smoother_as_pose(measured, outlier, channels, ARM, COLUMNS).any()


@given(SEEDS, st.sampled_from([0, 1, FRAMES - 2, FRAMES - 1]))
@settings(max_examples=20)
def test_nothing_is_said_of_the_first_and_last_frames(seed, frame):
    channels = _swinging(np.random.default_rng(seed))
    measured, outlier = _twisted(channels, frame, 60.0)
    channels[frame, WRIST] += 25.0
    assert not smoother_as_pose(measured, outlier, channels, ARM, COLUMNS).any()


@given(SEEDS, st.permutations(range(11)))
@settings(max_examples=20)
def test_the_order_of_channels_does_not_matter(seed, order):
    order = np.array(order)
    rng = np.random.default_rng(seed)
    channels = _swinging(rng)
    measured, outlier = _twisted(channels, 30, 80.0)
    measured[12, 6] += 40.0
    outlier[12, 6] = True
    channels[30, WRIST] += 25.0
    one = smoother_as_pose(measured, outlier, channels, ARM, COLUMNS)
    other = smoother_as_pose(measured[:, order], outlier[:, order], channels[:, order], ARM, order)
    assert one.any()
    assert np.array_equal(one[:, order], other)


def test_a_limb_elsewhere_is_judged_for_itself():
    channels = _swinging(np.random.default_rng(3))
    measured, outlier = _twisted(channels, 30, 80.0)
    channels[30, WRIST] += 25.0
    measured[30, ELBOW] += 50.0
    outlier[30, ELBOW] = True  # in the same limb: what hangs on both is thrown about
    assert not smoother_as_pose(measured, outlier, channels, ARM, COLUMNS).any()
    outlier[30, ELBOW] = False
    outlier[50, 6], measured[50, 6] = True, measured[50, 6] + 50.0
    kept = smoother_as_pose(measured, outlier, channels, ARM, COLUMNS)
    assert kept[30, UPPER]
    assert not kept[50].any()


@given(SEEDS, st.floats(20.0, 40.0))
@settings(max_examples=20)
def test_an_outlier_beside_what_is_put_back_stays_rejected(seed, by):
    """A repair that throws the arm about is worse than both together, and none the better for the outlier."""
    measured = _swinging(np.random.default_rng(seed))
    values, outlier = measured.copy(), np.zeros(measured.shape, dtype=bool)
    outlier[30, [6, ELBOW]] = True
    values[30, 6] += 90.0
    measured[30, ELBOW] += by
    kept = smoother_as_pose(measured, outlier, values, ARM, COLUMNS)
    assert kept[30, 6]
    assert not kept[30, ELBOW]


@pytest.mark.slow
@pytest.mark.parametrize(("clip", "every", "most"), [("05_08", 4, 0.02), ("05_03", 4, 0.02)])
def test_a_dance_is_not_thrown_about_by_its_repair(data, clip, every, most):
    whole = mm.read(data / "mocap" / "amc" / clip[:2] / f"{clip}.amc")
    clean = mm.Motion(whole.skeleton, whole.q[::every], whole.fps / every)
    found = mm.repair_without_model(clean, "adaptive").recording
    away = positions(clean.skeleton, clean.q) - positions(clean.skeleton, found.q)
    assert np.linalg.norm(away, axis=2).max() < most


@pytest.mark.slow
@pytest.mark.parametrize(("name", "first", "keep"), [("05_10", 0, 1), ("05_16", 150, 1), ("05_16", 150, 2)])
def test_pirouettes_in_which_a_leg_is_turned_over_come_back_as_recorded(data, name, first, keep):
    clean = mm.read(data / "mocap" / "amc" / "05" / f"{name}.amc").at_frames(slice(first, 360, keep))
    clean = replace(clean, fps=120.0 / keep)
    away = np.degrees(mm.repair_without_model(clean).recording.q - clean.q)
    assert np.sqrt(np.square(away[:, 6:]).mean()) < 0.3  # 2 to 9 before
