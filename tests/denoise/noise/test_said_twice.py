"""What two joints beside each other do alike is told from noise, and noise is left as it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend as mm
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import ROTATION, Skeleton
from motionmend.denoise.noise.rattling import rattles
from motionmend.denoise.noise.said_twice import loudest, rattles_once

SEEDS = st.integers(0, 10**6)
FRAMES = 150
BESIDE = np.zeros((4, 4), dtype=bool)
BESIDE[0, 1] = BESIDE[1, 0] = True


def _jittery(rng):
    """(T, 4) degrees: 0 and 1 rattle alike, 2 as much for itself, 3 not at all."""
    sway = np.cumsum(rng.standard_normal((FRAMES, 4)), axis=0) * 0.01
    jitter = 3.0 * rng.standard_normal((FRAMES, 2))
    return sway + np.stack([jitter[:, 0], jitter[:, 0], jitter[:, 1], np.zeros(FRAMES)], axis=1)


@given(SEEDS, st.floats(0.2, 5.0), st.floats(0.2, 5.0))
@settings(max_examples=30, deadline=None)
def test_it_is_as_loud_as_the_difference_at_most_and_never_less_than_it_is(seed, one, other):
    rng = np.random.default_rng(seed)
    clean, everywhere = _jittery(rng), np.ones((FRAMES, 4))
    most = loudest(clean, everywhere > 0, everywhere, BESIDE)
    assert (most[:2] < 0.1).all()
    assert np.isinf(most[2:]).all()
    noisy = clean + rng.standard_normal(clean.shape) * [one, other, 1.0, 1.0]
    most = loudest(noisy, everywhere > 0, everywhere, BESIDE)
    assert most[:2] == pytest.approx(1.2 * np.hypot(one, other), rel=0.3)


def test_few_frames_and_few_samples_tell_nothing():
    clean = _jittery(np.random.default_rng(1))
    everywhere = np.ones(clean.shape)
    assert np.isinf(loudest(clean[:9], everywhere[:9] > 0, everywhere[:9], BESIDE)).all()
    seldom = np.zeros(clean.shape, dtype=bool)
    seldom[::2] = True
    assert np.isinf(loudest(clean, seldom, everywhere, BESIDE)).all()


@pytest.mark.parametrize("alike", [True, False])
def test_what_rattles_alike_does_not_rattle(alike):
    rng = np.random.default_rng(2)
    measured = 0.1 * rng.standard_normal((FRAMES, 4))
    shake = 10.0 * rng.standard_normal((30, 2))
    measured[60:90, :2] += shake[:, [0, 0]] if alike else shake
    found = rattles(measured, 120.0)
    assert (found[62:88, :2] > 0).mean() > 0.9
    left = rattles_once(found, measured, BESIDE)
    np.testing.assert_array_equal(left, np.where(alike, 0.0, found))
    np.testing.assert_array_equal(rattles_once(found, measured, None), found)


def _hand_and_thumb():
    """A clean walk at 30 Hz whose left hand has a thumb; hand and thumb jitter alike, and leap in two frames."""
    walk = mm.samples.clip("walk", seconds=4.0, fps=30.0, seed=3)
    body = walk.skeleton
    hand = max(j for j in range(len(body.names)) if (body.dof_joint[body.dof_kind == ROTATION] == j).any())
    rows = body.dofs_of(hand)
    thumb = Skeleton(
        names=(*body.names, "thumb"),
        parents=np.append(body.parents, body.parents[hand]),
        offsets=np.vstack([body.offsets, body.offsets[hand]]),
        dof_names=(*body.dof_names, *(f"thumb.{k}" for k in range(len(rows)))),
        dof_joint=np.append(body.dof_joint, np.full(len(rows), len(body.names))),
        dof_kind=np.append(body.dof_kind, body.dof_kind[rows]),
        dof_axis=np.vstack([body.dof_axis, body.dof_axis[rows]]),
        limits=np.vstack([body.limits, body.limits[rows]]),
    )
    rng = np.random.default_rng(4)
    own = walk.q[:, rows] + np.radians(2.0) * rng.standard_normal((walk.frames, len(rows)))
    own[[30, 71]] += np.radians([25.0, -14.0])[:, None]
    q = walk.q.copy()
    q[:, rows] = own
    return Motion(thumb, np.hstack([q, own + 0.1]), walk.fps)


@pytest.mark.slow
def test_a_clean_hand_that_jitters_with_its_thumb_stays():
    clean = _hand_and_thumb()
    repaired = mm.repair_without_model(clean).recording
    assert np.degrees(np.sqrt(np.square(repaired.q - clean.q).mean())) < 0.2
