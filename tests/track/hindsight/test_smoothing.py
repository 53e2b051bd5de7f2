"""Poses made steady."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.anatomy import average
from motionmend.bodies.performer import Poses, rotation, standing
from motionmend.track.hindsight.smoothing import smoothed
from motionmend.track.limbs.other_poses import LIMBS

BODY = average()


def moving(frames: int, fps: float = 30.0, bend: float = 1.0) -> tuple[Poses, np.ndarray]:
    """Poses that turn, walk and swing with constant acceleration."""
    times = np.arange(frames) / fps
    base = standing()
    joints = base.joints + 0.3 * bend * (times[:, None] - 0.4) ** 2 * np.sin(np.arange(28.0))
    root = rotation(np.outer(times, (0.0, 0.8, 0.0))) @ base.root
    way = np.array([0.1, 0.0, 3.0]) + np.outer(times, (0.5, 0.1, -0.3)) + np.outer(times**2, (0.4, 0.0, 0.2))
    return Poses(way, root, joints), times


@settings(max_examples=10)
@given(st.integers(4, 40), st.sampled_from([30.0, 60.0, 100.0]))
def test_constant_accelerations_stay_as_they_are(frames: int, fps: float) -> None:
    poses, times = moving(frames, fps)
    steady, places = smoothed(poses, BODY, times, np.ones(frames, bool), np.zeros((frames, 16), bool))
    np.testing.assert_allclose(steady.translation, poses.translation, atol=1e-9)
    np.testing.assert_allclose(steady.joints, poses.joints, atol=1e-9)
    np.testing.assert_allclose(steady.root, poses.root, atol=1e-9)
    assert np.isfinite(places).all()


def test_noise_is_less_afterwards_and_bones_keep_their_lengths() -> None:
    poses, times = moving(60)
    rng = np.random.default_rng(0)
    noisy = Poses(
        poses.translation + 0.005 * rng.normal(size=(60, 3)),
        rotation(0.02 * rng.normal(size=(60, 3))) @ poses.root,
        poses.joints + 0.02 * rng.normal(size=(60, 28)),
    )
    steady, places = smoothed(noisy, BODY, times, np.ones(60, bool), np.zeros((60, 16), bool))
    for name in ("translation", "joints", "root"):
        before, after = (np.std(getattr(one, name) - getattr(poses, name)) for one in (noisy, steady))
        assert after < 0.75 * before
    shank = np.linalg.norm(places[:, 12] - places[:, 11], axis=1)
    assert np.ptp(shank) < 1e-9


def test_nothing_is_smoothed_across_a_gap_or_a_jump() -> None:
    poses, times = moving(30)
    way = poses.translation.copy()
    way[12:] += (2.0, 0.0, 0.0)  # somewhere else from here on
    way[20:23] = np.nan
    joints = poses.joints.copy()
    joints[20:23] = np.nan
    whole = np.ones(30, bool)
    whole[20:23] = False
    steady, places = smoothed(Poses(way, poses.root, joints), BODY, times, whole, np.zeros((30, 16), bool))
    np.testing.assert_allclose(steady.translation, way, atol=1e-9)
    assert np.isnan(places[20:23]).all()
    assert np.isfinite(places[[19, 23]]).all()


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_few_frames_are_left_alone(frames: int) -> None:
    poses, times = moving(frames)
    steady, _ = smoothed(poses, BODY, times, np.ones(frames, bool), np.zeros((frames, 16), bool))
    np.testing.assert_array_equal(steady.joints, poses.joints)


@given(st.integers(0, 3), st.integers(3, 15), st.integers(16, 27))
@settings(max_examples=10)
def test_a_limb_out_of_sight_is_led_to_where_it_is_seen_again(number: int, first: int, after: int) -> None:
    limb, times = LIMBS[number], np.arange(30) / 30.0
    base = standing()
    true = np.tile(base.joints, (30, 1))
    true[:, limb.columns] += 0.4 * times[:, None]
    said, held = true.copy(), np.zeros((30, 16), bool)
    said[first:after, limb.columns] = true[first - 1, limb.columns]  # as it was when it was last seen
    held[first:after, limb.landmarks] = True
    way, root = np.tile((0.0, 0.0, 3.0), (30, 1)), np.tile(base.root, (30, 1, 1))
    steady, _ = smoothed(Poses(way, root, said), BODY, times, np.ones(30, bool), held)
    step = 0.4 / 30
    assert np.abs(steady.joints - true).max() < 1.5 * step
    said[first:, limb.columns] = true[first - 1, limb.columns]
    held[first:, limb.landmarks] = True  # never seen again: nothing is known of where it led
    steady, _ = smoothed(Poses(way, root, said), BODY, times, np.ones(30, bool), held)
    assert np.abs(steady.joints[first:] - said[first:]).max() < 1.5 * step
