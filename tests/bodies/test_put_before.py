"""A rest pose before a recording is told from the first frame of one that has none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.put_before import rest_frames
from motionmend.bodies.skeleton import ROTATION
from motionmend.io import read
from motionmend.samples import clip


def with_rest(motion, frames=1):
    """The motion with first frames whose joints' angles are zero."""
    first = motion.q[:1].repeat(frames, axis=0)
    first[:, motion.skeleton.dof_kind == ROTATION] = 0.0
    return motion.with_q(np.vstack([first, motion.q]))


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(
    action=st.sampled_from(["walk", "turn", "reach", "jump"]),
    seed=st.integers(0, 100),
    noise=st.sampled_from([0.0, 1.0, 3.0]),
    outliers=st.sampled_from([0.0, 0.1]),
    missing=st.sampled_from([0.0, 0.2]),
)
def test_no_recording_without_one_is_said_to_have_one(action, seed, noise, outliers, missing):
    motion = clip(action, seconds=4.0, fps=60.0, seed=seed)
    rng = np.random.default_rng(seed)
    spoilt = motion.q + np.radians(noise) * rng.standard_normal(motion.q.shape)
    spoilt += np.where(rng.random(spoilt.shape) < outliers, np.radians(40) * rng.standard_normal(spoilt.shape), 0.0)
    spoilt[rng.random(spoilt.shape) < missing] = np.nan
    assert not rest_frames(motion.with_q(spoilt))


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(action=st.sampled_from(["walk", "reach"]), seed=st.integers(0, 100), noise=st.sampled_from([0.0, 0.5]))
def test_one_is_found_through_noise(action, seed, noise):
    motion = with_rest(clip(action, seconds=4.0, fps=60.0, seed=seed))
    rng = np.random.default_rng(seed)
    assert rest_frames(motion.with_q(motion.q + np.radians(noise) * rng.standard_normal(motion.q.shape))) == 1


def test_one_may_stand_there_several_times():
    motion = clip("walk", seconds=4.0, fps=60.0, seed=4)
    for frames in (1, 2, 4, 30):
        assert rest_frames(with_rest(motion, frames)) == frames


def test_standing_at_rest_throughout_is_none():
    motion = clip("walk", seconds=2.0, fps=60.0, seed=1)
    assert not rest_frames(motion.with_q(np.zeros_like(motion.q)))
    assert not rest_frames(motion.with_q(np.full_like(motion.q, np.nan)))
    for frames in (1, 2, 8):
        assert not rest_frames(with_rest(motion.with_q(motion.q[:frames])))


@pytest.mark.slow
def test_real_recordings(data):
    for path in sorted((data / "mocap" / "bvh").glob("*.bvh")):
        motion = read(path)
        assert rest_frames(motion) == 1, path.name
        assert not rest_frames(motion.with_q(motion.q[1:])), path.name
    for path in sorted((data / "mocap" / "amc").glob("*/*.amc"))[::8]:
        assert not rest_frames(read(path)), path.name
