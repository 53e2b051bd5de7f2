"""Channels that never move are found under noise, and those that do are not taken for them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.adaptive.blocks import Mended
from motionmend.denoise.adaptive.unmoving import FEWEST, kept_still, nothing_still, unmoving
from motionmend.denoise.bases.repair import ChannelRepair
from motionmend.evaluate import corrupt
from motionmend.samples import clip

SEEDS = st.integers(0, 10**6)


def repaired(values, noise, origin=None):
    """A repair that changed nothing and found this noise."""
    origin = np.full(values.shape, Origin.MEASURED, np.uint8) if origin is None else origin
    found = ChannelRepair(
        values.copy(), np.ones(values.shape), origin == Origin.MEASURED, origin, 1, np.empty(0), converged=True
    )
    count = values.shape[1]
    unseen = np.ones(count)
    return Mended(found, np.full(count, noise), unseen, 0.0, np.zeros(count, np.int64), np.zeros(count), values[:0])


def still_in(values, noise, origin=None):
    return unmoving(
        values, repaired(values, noise, origin), np.ones(values.shape[1], bool), np.zeros(values.shape[1], bool), 30.0
    )


@given(SEEDS, st.sampled_from([0.01, 1.0, 30.0]), st.sampled_from([FEWEST, 100, 3000]))
@settings(max_examples=25, deadline=None)
def test_constants_under_white_noise_are_found_wherever_they_are(seed, noise, frames):
    rng = np.random.default_rng(seed)
    place = rng.uniform(-180.0, 180.0, 40)
    rest = still_in(place + noise * rng.standard_normal((frames, 40)), noise)
    assert rest.still.mean() > 0.5
    off = (rest.place - place)[rest.still] / rest.std[rest.still]
    assert np.abs(off).max() < 6.0
    assert np.isnan(rest.place[~rest.still]).all()


@given(SEEDS, st.sampled_from([0.5, 1.0, 3.0, 12.0]), st.sampled_from([180, 600]))
@settings(max_examples=25, deadline=None)
def test_who_sways_half_as_far_as_the_noise_moves(seed, times, frames):
    rng = np.random.default_rng(seed)
    sway = np.sqrt(0.5) * np.sin(2.0 * np.pi * (times * np.linspace(0.0, 1.0, frames)[:, None] + rng.random(20)))
    assert still_in(sway + rng.standard_normal((frames, 20)), 1.0).still.mean() < 0.15


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_who_moves_by_more_than_the_noise_moves_however_fast(seed):
    """Two seconds of a run seen at 30 Hz turn over from frame to frame: as white as noise, but no noise."""
    rng = np.random.default_rng(seed)
    assert not still_in(4.0 * rng.standard_normal((60, 20)), 1.0).still.any()


def test_the_few_samples_that_were_believed_of_what_swings_are_no_constant(rng):
    """A library that knows a joint as still rejects most of a tremble, and the rest looks like a constant in noise."""
    values = rng.standard_normal((200, 4))
    origin = np.full(values.shape, Origin.MEASURED, np.uint8)
    origin[:100, 0] = Origin.REPAIRED
    assert not still_in(values, 1.5, origin).still[0]
    origin[:100, 0] = Origin.MEASURED
    assert still_in(values, 1.5, origin).still[0] == still_in(values, 1.5).still[0]


def test_what_says_nothing_is_left(rng):
    few = rng.standard_normal((200, 4))
    few[FEWEST - 1 :, 0] = np.nan
    origin = np.where(np.isfinite(few), Origin.MEASURED, Origin.FILLED).astype(np.uint8)
    few[:, 1] = 3.0  # to the last digit
    found = repaired(few, 1.0, origin)
    asked = np.array([True, True, True, False])
    rest = unmoving(few, found, asked, np.zeros(len(asked), bool), 30.0)
    assert not rest.still[[0, 1, 3]].any()
    assert not nothing_still(4).still.any()


def test_only_what_the_repair_believed_is_asked_and_gaps_stay_as_unsure_as_they_were(rng):
    values = 7.0 + rng.standard_normal((300, 1))
    origin = np.full(values.shape, Origin.MEASURED, np.uint8)
    origin[::10], origin[5::10], origin[7] = Origin.REPAIRED, Origin.FILLED, Origin.LEFT_OPEN
    values[::10] += 50.0
    values[5::10] = np.nan
    rest = still_in(values, 1.0, origin)
    assert rest.still[0]
    seen = values[origin == Origin.MEASURED]
    after = kept_still(repaired(values, 1.0, origin), rest)
    assert after.unseen_bends[0] == 0.0
    known = origin != Origin.LEFT_OPEN
    np.testing.assert_allclose(after.found.values[known], seen.mean())
    assert after.found.values[7, 0] == values[7, 0]
    np.testing.assert_allclose(after.found.std[origin <= Origin.REPAIRED], seen.std(ddof=1) / np.sqrt(len(seen)))
    assert (after.found.std[origin == Origin.FILLED] == 1.0).all()


@pytest.mark.slow
def test_joints_that_never_move_are_brought_back_to_their_place():
    """To what a mean is sure of, not to what a smoother is."""
    walk = clip("walk", seconds=6.0, fps=30.0, seed=4)
    never = np.isin(walk.skeleton.dof_names, ("lradius.rx", "rhand.rx", "rhand.rz", "ltoes.rx", "head.ry", "lfoot.rz"))
    walk = walk.with_q(np.where(never, walk.q[0], walk.q))
    noisy = corrupt(walk, noise=np.radians(2), outliers=0.02, seed=3).recording
    ours = repair_without_model(noisy, "adaptive")
    off = np.sqrt(np.square(np.degrees(ours.recording.q - walk.q)[:, never]).mean(axis=0))
    assert np.median(off) < 0.3
    assert off.max() < 0.8
    assert (off < 4.0 * np.degrees(ours.std[:, never]).max(axis=0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_one_limb_that_shakes_is_mended_as_if_all_did_and_the_rest_left_alone(seed):
    walk = clip("walk", seconds=2.0, fps=60.0, seed=6)
    skeleton = walk.skeleton
    angle = skeleton.dof_kind == ROTATION
    arm = np.isin([skeleton.names[j] for j in skeleton.dof_joint], ("lhumerus", "lradius", "lwrist", "lhand")) & angle
    assert arm.sum() > 4
    noise = np.radians(8) * np.random.default_rng(seed).standard_normal(walk.q.shape)
    noisy = walk.with_q(walk.q + np.where(arm, noise, 0.0))

    def off(motion, channels):
        return float(np.degrees(np.sqrt(np.square(motion.q - walk.q)[:, channels].mean())))

    ours = repair_without_model(noisy, "adaptive")
    filters = ("butterworth", "savgol", "gaussian", "kalman")
    best = min(off(repair_without_model(noisy, one).recording, arm) for one in filters)
    assert off(ours.recording, arm) < 1.1 * best
    assert off(ours.recording, ~arm & angle) < 0.1
