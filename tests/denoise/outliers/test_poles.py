"""Ball joints whose angles jump at the pole, and outliers that only look like it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.skeleton import Skeleton
from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.adaptive.traits import Traits
from motionmend.denoise.channels.joints import root_angles
from motionmend.denoise.library.local_prior import Prior
from motionmend.denoise.outliers.poles import bends_of, pole_crossings
from performers import FPS

SEEDS = st.integers(0, 10**6)
FRAMES = 60


def _ball(rng):
    """A root that stands, a ball joint about any three axes at right angles, and a hinge."""
    axes = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix() * rng.choice([-1.0, 1.0])
    return Skeleton(
        names=("root", "ball", "hinge"),
        parents=np.array([-1, 0, 1]),
        offsets=np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0]], dtype=float),
        dof_names=("root.x", "ball.a", "ball.b", "ball.c", "hinge.a"),
        dof_joint=np.array([0, 1, 1, 1, 2]),
        dof_axis=np.vstack([np.eye(3)[:1], axes, np.eye(3)[:1]]),
        dof_kind=np.zeros(5, dtype=np.int64),
        limits=np.tile([-np.inf, np.inf], (5, 1)),
    )


def _through_the_pole(skeleton, rng, nearest=0.4):
    """(T, 5) degrees: a joint that turns steadily and passes within half a degree of its pole."""
    axes = skeleton.dof_axis[1:4]
    middle = np.linspace(55.0, 125.0, FRAMES) + rng.uniform(-5, 5)
    rotation = (
        Rotation.from_rotvec(rng.uniform(-20, 20) * axes[0], degrees=True)
        * Rotation.from_rotvec(rng.choice([-1, 1]) * nearest * axes[2], degrees=True)
        * Rotation.from_rotvec(middle[:, None] * axes[1], degrees=True)
    )
    angles = np.zeros((FRAMES, 5))
    three = root_angles(skeleton, np.array([1, 2, 3]), rotation.as_matrix())
    angles[:, 1:4] = np.degrees(np.unwrap(np.radians(three), axis=0))
    return angles


def _bend(angles):
    return np.abs(np.diff(angles, n=2, axis=0))


COLUMNS = np.arange(5)


@given(SEEDS)
@settings(max_examples=30)
def test_a_joint_that_passes_its_pole_is_vouched_for(seed):
    rng = np.random.default_rng(seed)
    skeleton = _ball(rng)
    angles = _through_the_pole(skeleton, rng)
    vouched = pole_crossings(angles, skeleton, COLUMNS)
    at_pole = bends_of(vouched)
    jumps = np.flatnonzero(_bend(angles[:, 1:4]).max(axis=1) > 40.0) + 1  # the middle frame of each sharp bend
    assert len(jumps) > 0
    assert at_pole[jumps + 1, 1:4].all()
    assert vouched[jumps - 1, 1].any() or vouched[jumps, 1].any()
    assert not vouched[:, [0, 4]].any()
    assert not at_pole[:, [0, 4]].any()
    away = np.abs(np.arange(FRAMES) - np.median(jumps)) > 15
    assert not at_pole[away].any()


@given(SEEDS, st.sampled_from([1, 2, 3]), st.floats(25.0, 55.0), st.booleans())
@settings(max_examples=40)
def test_an_outlier_in_one_angle_is_not(seed, column, off, down):
    rng = np.random.default_rng(seed)
    skeleton = _ball(rng)
    t = np.arange(FRAMES) / FPS
    angles = 30.0 * np.sin(2 * np.pi * t[:, None] * [0, 0.6, 0.4, 0.5, 1.0] + rng.uniform(0, 6, 5))
    angles += rng.normal(0, 1.0, angles.shape)
    angles[25, column] += -off if down else off
    vouched = pole_crossings(angles, skeleton, COLUMNS)
    assert not vouched[25].any()


@given(SEEDS)
@settings(max_examples=20)
def test_an_outlier_of_the_middle_angle_near_the_pole_is_not(seed):
    rng = np.random.default_rng(seed)
    skeleton = _ball(rng)
    angles = _through_the_pole(skeleton, rng, nearest=15.0)
    frame = int(np.argmax(_bend(angles[:, 1:4]).max(axis=1))) + 1
    angles[frame, 2] += 40.0
    assert not pole_crossings(angles, skeleton, COLUMNS)[frame].any()


def test_smooth_angles_and_short_recordings_have_no_crossing(rng):
    skeleton = _ball(rng)
    smooth = 20.0 * np.sin(np.arange(FRAMES)[:, None] / 9.0 + np.arange(5))
    for angles in (smooth, smooth[:2], smooth[:1], smooth[:0], np.full((FRAMES, 5), np.nan)):
        vouched = pole_crossings(angles, skeleton, COLUMNS)
        at_pole = bends_of(vouched)
        assert vouched.shape == at_pole.shape == angles.shape
        assert not vouched.any()
        assert not at_pole.any()


@given(SEEDS)
@settings(max_examples=10)
def test_the_order_of_the_channels_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    skeleton = _ball(rng)
    angles, order = _through_the_pole(skeleton, rng), rng.permutation(5)
    one = pole_crossings(angles, skeleton, COLUMNS)
    assert one.any()
    np.testing.assert_array_equal(one[:, order], pole_crossings(angles[:, order], skeleton, order))


def test_a_joint_of_which_the_model_lacks_an_angle_is_left_to_itself(rng):
    skeleton = _ball(rng)
    angles = _through_the_pole(skeleton, rng)
    assert not pole_crossings(angles, skeleton, np.array([0, 1, 2, -1, 4])).any()


def test_missing_angles_vouch_for_nothing(rng):
    skeleton = _ball(rng)
    angles = _through_the_pole(skeleton, rng)
    crossing = np.flatnonzero(pole_crossings(angles, skeleton, COLUMNS)[:, 1])
    angles[crossing, 3] = np.nan
    assert not pole_crossings(angles, skeleton, COLUMNS)[crossing].any()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_repair_keeps_the_crossing_and_takes_the_outlier(seed):
    """Without word of the pole the jump costs dozens of degrees; with it no more than the noise."""
    rng = np.random.default_rng(seed)
    skeleton = _ball(rng)
    truth = _through_the_pole(skeleton, rng)
    measured = truth + rng.normal(0, 0.3, truth.shape)
    measured[10, 1] += 40.0
    vouched = pole_crossings(measured, skeleton, COLUMNS)
    bends = np.diag(np.full(5, 0.3**2))
    mended = mend_channels(measured, Prior(bends, None), FPS, traits=Traits(leaping=lambda _: vouched))
    rejected = mended.found.origin == 1
    assert rejected[10, 1]
    jumps = np.flatnonzero(_bend(truth[:, 1:4]).max(axis=1) > 40.0) + 1
    assert not rejected[jumps.min() - 1 : jumps.max() + 2].any()
    away = np.abs(mended.found.values - truth)
    assert np.median(away) < 0.3
    assert away[jumps.min() - 1 : jumps.max() + 2, 1:4].max() < 10.0


@given(st.integers(0, 30), st.integers(1, 3), SEEDS)
def test_a_sample_takes_part_in_the_bends_that_end_there_and_in_the_two_frames_after(frames, channels, seed):
    samples = np.random.default_rng(seed).random((frames, channels)) < 0.2
    touched = bends_of(samples)
    for t in range(frames):
        np.testing.assert_array_equal(touched[t], samples[max(0, t - 2) : t + 1].any(axis=0))
