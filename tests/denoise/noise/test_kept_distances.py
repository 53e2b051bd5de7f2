"""The noise of markers, told by the distances that skin keeps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.noise.kept_distances import noise_by_distances
from tumblers import tumbling

FRAMES = 200


def _tumbling(markers, fps, rng):
    return tumbling(markers, FRAMES, fps, rng, 9.0)


@given(st.integers(4, 8), st.sampled_from([30.0, 120.0]), st.floats(0.05, 1.0), st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_it_is_found_however_fast_bodies_tumble(markers, fps, noise, seed):
    rng = np.random.default_rng(seed)
    clean = _tumbling(markers, fps, rng)
    measured = clean + noise * rng.standard_normal(clean.shape)
    everywhere = np.ones(clean.shape)
    variance, weight = noise_by_distances(measured, np.isfinite(measured), everywhere)
    assert np.sqrt(variance.mean()) == pytest.approx(noise, rel=0.15)
    assert (weight > 0.3 * FRAMES).all()


def test_one_that_shakes_is_told_from_those_that_do_not():
    rng = np.random.default_rng(1)
    clean = _tumbling(5, 60.0, rng)
    noise = np.full(15, 0.2)
    noise[6] = 1.0
    measured = clean + np.repeat(noise, 3) * rng.standard_normal(clean.shape)
    variance, _ = noise_by_distances(measured, np.isfinite(measured), np.ones(clean.shape))
    found = np.sqrt(variance[::3])
    assert found[6] == pytest.approx(1.0, rel=0.25)
    assert np.delete(found, 6).max() < 0.35


def test_gaps_and_rejected_samples_tell_nothing_and_spoil_nothing():
    rng = np.random.default_rng(2)
    clean = _tumbling(5, 60.0, rng)
    measured = clean + 0.3 * rng.standard_normal(clean.shape)
    bad = np.repeat(rng.random((FRAMES, 15)) < 0.05, 3, axis=1)
    spoilt = np.where(bad, measured + 50.0, measured)
    spoilt[60:80, :9] = np.nan
    variance, weight = noise_by_distances(spoilt, np.isfinite(spoilt) & ~bad, np.ones(clean.shape))
    assert np.sqrt(variance.mean()) == pytest.approx(0.3, rel=0.15)
    assert weight[:9].mean() < weight[9:].mean()


def test_louder_moments_are_taken_for_what_they_are():
    rng = np.random.default_rng(3)
    clean = _tumbling(5, 60.0, rng)
    loud = np.where((np.arange(FRAMES) // 50 % 2 == 0)[:, None], 1.0, 3.0) * np.ones(clean.shape)
    measured = clean + 0.2 * loud * rng.standard_normal(clean.shape)
    variance, _ = noise_by_distances(measured, np.isfinite(measured), loud)
    assert np.sqrt(variance.mean()) == pytest.approx(0.2, rel=0.15)


def test_distances_that_change_are_believed_little():
    rng = np.random.default_rng(4)
    time = np.arange(FRAMES)[:, None] / 30.0
    apart = 30.0 * np.sin(2.0 * np.pi * rng.uniform(0.5, 2.0, 24) * time + rng.uniform(0.0, 6.0, 24))
    _, weight = noise_by_distances(apart, np.isfinite(apart), np.ones(apart.shape))
    assert weight.max() < 0.05 * FRAMES


@pytest.mark.parametrize(("frames", "columns"), [(0, 9), (10, 9), (200, 3), (200, 0)])
def test_too_little_tells_nothing(frames, columns):
    variance, weight = noise_by_distances(
        np.zeros((frames, columns)), np.ones((frames, columns), bool), np.ones((frames, columns))
    )
    assert variance.shape == weight.shape == (columns,)
    assert not weight.any()


def test_markers_that_are_never_seen_together_tell_nothing():
    measured = np.random.default_rng(5).standard_normal((FRAMES, 6))
    measured[: FRAMES // 2, :3] = np.nan
    measured[FRAMES // 2 :, 3:] = np.nan
    _, weight = noise_by_distances(measured, np.isfinite(measured), np.ones(measured.shape))
    assert not weight.any()
