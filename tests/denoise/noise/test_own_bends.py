"""How sharply a recording bends, told by itself: through noise much larger than the bends, and through outliers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.noise.own_bends import LONGEST_OF_MARKERS, first_bends
from motionmend.evaluate import corrupt
from motionmend.samples import clip


def walks(bend, noise, frames=1200, channels=8, seed=0):
    """(T, C) twice summed steps of deviation `bend` with noise on them."""
    rng = np.random.default_rng(seed)
    steps = bend * rng.standard_normal((frames, channels))
    return np.cumsum(np.cumsum(steps, axis=0), axis=0) + noise * rng.standard_normal((frames, channels))


@settings(max_examples=25, deadline=None)
@given(ratio=st.sampled_from([0.0, 0.1, 1.0, 10.0, 60.0]), seed=st.integers(0, 1000), unit=st.sampled_from([1e-2, 1.0]))
def test_steps_are_found_through_noise(ratio, seed, unit):
    """Noise up to 60 times the steps: what differs from frame to frame is then all noise."""
    found = np.diag(first_bends(unit * walks(1.0, ratio, seed=seed), 120.0))
    assert 0.3 < np.median(np.sqrt(found)) / unit < 2.0


@pytest.mark.parametrize("seed", range(4))
def test_who_hardly_moves_is_found_through_noise_of_hundreds_of_steps(seed):
    """Lags of an eighth of a second still show noise alone, which passed for bends twice to four times as sharp."""
    found = np.diag(first_bends(walks(1.0, 200.0, seed=seed), 120.0, LONGEST_OF_MARKERS))
    assert 0.3 < np.median(np.sqrt(found)) < 1.75


def test_outliers_and_gaps_hardly_change_it():
    rng = np.random.default_rng(3)
    measured = walks(1.0, 10.0)
    spoilt = measured + np.where(rng.random(measured.shape) < 0.1, 400.0 * rng.standard_normal(measured.shape), 0.0)
    spoilt[rng.random(measured.shape) < 0.1] = np.nan
    clean, found = (np.median(np.sqrt(np.diag(first_bends(m, 120.0)))) for m in (measured, spoilt))
    assert 0.4 < found / clean < 2.5


@pytest.mark.parametrize("frames", [3, 4, 5, 12, 40])
def test_few_frames_and_empty_channels(frames):
    measured = walks(1.0, 1.0, frames=frames)
    measured[:, 2] = np.nan
    found = first_bends(measured, 120.0)
    assert np.isfinite(found).all()
    assert (np.diag(found) > 0).all()


@pytest.mark.slow
def test_a_repair_without_a_library_leaves_little_of_the_noise():
    """At 120 Hz most noise can be told from motion: a quarter of it is left where all of it was half before."""
    walk = clip("walk", seconds=4.0, fps=120.0, seed=5)
    noisy = corrupt(walk, noise=np.radians(3), seed=1).recording
    angles = walk.skeleton.dof_kind == ROTATION
    moving = angles & (walk.q.std(axis=0) > np.radians(1))

    def error(motion):
        return np.sqrt(np.mean(np.square(motion.q - walk.q)[:, moving]))

    assert error(repair_without_model(noisy, "adaptive").recording) < 0.42 * error(noisy)
