"""Laws of noise that comes and goes, and what a repair makes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.noise.level import first_noise
from motionmend.denoise.noise.passing import loudness
from performers import FPS, channels_of, mend, rms, truth

SEEDS = st.integers(0, 10**6)


def _walk(rng, frames=240, channels=30):
    """As smooth as a body: second differences of a tenth of a degree."""
    return np.cumsum(np.cumsum(rng.normal(0, 0.1, (frames, channels)), axis=0), axis=0)


def _outliers(rng, shape, share):
    return (rng.random(shape) < share) * rng.choice([-1.0, 1.0], shape) * rng.uniform(15.0, 55.0, shape)


def _passage(frames, first=0.4, last=0.7, times=4.0):
    """(T, 1) 1, and so many times that for a passage."""
    t = np.arange(frames)[:, None] / frames
    return np.where((t >= first) & (t < last), times, 1.0)


def _middles(frames, first=0.4, last=0.7):
    """Frames well inside the passage, and well outside."""
    t, away = np.arange(frames) / frames, 0.06
    return (t > first + away) & (t < last - away), (t < first - away) | (t > last + away)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.5, 1.0, 5.0])
@pytest.mark.parametrize("frames", [60, 240])
@pytest.mark.parametrize(("share", "least"), [(0.0, 0.9), (0.1, 0.75), (0.2, 0.6)])
def test_noise_that_stays_is_found_to_stay_whatever_the_outliers(share, least, frames, noise):
    calm = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        walk = _walk(rng, frames)
        found = loudness(walk + noise * rng.normal(size=walk.shape) + _outliers(rng, walk.shape, share), FPS)
        calm.append(np.mean(np.abs(np.log(found)) < 0.1))
        assert np.abs(np.log(found)).max() < np.log(2.0)
    assert np.mean(calm) > (0.95 if share else 0.99)
    assert np.min(calm) > least


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_a_passage_in_which_all_channels_are_noisier_is_found(share, fps):
    frames, louder = round(8 * fps), []
    inside, outside = _middles(frames)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        walk = _walk(rng, frames)
        noisy = walk + _passage(frames) * rng.normal(size=walk.shape) + _outliers(rng, walk.shape, share)
        found = loudness(noisy, fps)
        louder.append(np.median(np.median(found[inside], axis=0) / np.median(found[outside], axis=0)))
        level = first_noise(noisy, found) * np.median(found[outside], axis=0)
        np.testing.assert_allclose(np.median(level), 1.0, atol=0.35)
    assert np.min(louder) > 1.8
    assert np.mean(np.greater(louder, 2.0)) > 0.95
    assert np.max(louder) < 4.0


@given(SEEDS)
@settings(max_examples=20)
def test_channels_that_are_noisier_for_a_while_on_their_own_are_told_from_the_others(seed):
    rng = np.random.default_rng(seed)
    walk = _walk(rng)
    hit = np.arange(30) % 3 == 0
    found = loudness(walk + np.where(hit, _passage(240), 1.0) * rng.normal(size=walk.shape), FPS)
    inside, _ = _middles(240)
    assert np.median(found[inside][:, hit]) > 1.15 * np.median(found[inside][:, ~hit])
    assert np.mean(found[inside][:, hit] > 1.4) > 0.4
    assert np.median(found[inside][:, ~hit]) < 1.4


@given(SEEDS, st.floats(-5, 5))
@settings(max_examples=20)
def test_steady_motion_is_no_noise(seed, speed):
    rng = np.random.default_rng(seed)
    t = np.arange(200.0)[:, None]
    white = _passage(200) * rng.normal(0, 2.0, (200, 8))
    np.testing.assert_allclose(loudness(white + speed * t, FPS), loudness(white, FPS), rtol=1e-6)


@pytest.mark.parametrize("action", ["walk", "run", "jump"])
def test_the_liveliness_of_a_clean_motion_is_no_noise(action):
    found = loudness(channels_of(truth(action)), FPS)
    assert np.abs(np.log(found)).max() < np.log(1.5)


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=20)
def test_short_passages_of_one_marker_are_found_where_many_frames_a_second_tell_of_them(seed):
    rng, fps, frames = np.random.default_rng(seed), 120.0, 480
    walk = 0.02 * _walk(rng, frames)
    louder = np.ones((frames, 10))
    for marker in range(10):
        for start in (rng.integers(0, 150), rng.integers(250, 380)):
            louder[start : start + 96, marker] = 4.0
    louder = louder.repeat(3, axis=1)
    found = loudness(walk + 0.4 * louder * rng.normal(size=walk.shape), fps, together=3)
    assert np.median(found[louder > 1]) > 1.7 * np.median(found[louder == 1])


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=20)
def test_a_burst_of_outliers_is_no_passage_of_noise(seed):
    rng, fps, frames = np.random.default_rng(seed), 120.0, 480
    walk = 0.05 * _walk(rng, frames)
    burst = np.zeros((frames, 10), dtype=bool)
    for marker in range(10):
        start = rng.integers(0, frames - 30)
        burst[start : start + rng.integers(12, 30), marker] = True
    burst = burst.repeat(3, axis=1)
    found = loudness(
        walk + 0.4 * rng.normal(size=walk.shape) + burst * rng.normal(0, 20.0, walk.shape), fps, together=3
    )
    assert np.median(found[burst]) < 1.5 * np.median(found[~burst])


def test_how_much_louder_passages_of_single_markers_are_is_told_for_the_most_part():
    """Four times as loud for 0.8 s at a time, in logarithms."""
    told = []
    for seed in range(8):
        rng, frames = np.random.default_rng(seed), 480
        louder = np.zeros((frames, 12))
        for marker in range(12):
            for start in (rng.integers(0, 130), rng.integers(240, 380)):
                louder[start : start + 96, marker] = np.log(4.0)
        louder = louder.repeat(3, axis=1)
        noisy = 0.02 * _walk(rng, frames, 36) + 0.4 * np.exp(louder) * rng.normal(size=louder.shape)
        told.append(np.polyfit(louder.ravel(), np.log(loudness(noisy, 120.0, together=3)).ravel(), 1)[0])
    assert 0.6 < np.mean(told) < 1.1


def test_coordinates_of_a_marker_are_as_noisy_as_each_other(rng):
    walk = _walk(rng)
    noisy = walk + np.where(np.arange(30) < 15, _passage(240), 1.0) * rng.normal(size=walk.shape)
    found = loudness(noisy, FPS, together=3).reshape(240, 10, 3)
    np.testing.assert_array_equal(found, found[:, :, :1].repeat(3, axis=2))
    assert np.ptp(found) > 0.5


@pytest.mark.parametrize("frames", [1, 2, 4, 20])
def test_what_is_short_or_was_not_seen_is_as_noisy_as_ever(rng, frames):
    np.testing.assert_array_equal(loudness(rng.normal(size=(frames, 3)), FPS), np.ones((frames, 3)))
    gappy = rng.normal(size=(200, 4))
    gappy[:, 1], gappy[50:150] = np.nan, np.nan
    found = loudness(gappy, FPS)
    assert np.isfinite(found).all()
    assert (found > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("action", ["walk", "reach"])
def test_a_noisy_half_is_smoothed_and_a_calm_one_left(action, library):
    """4 degrees in the second half and half a degree in the first: neither decides for the other."""
    clean = channels_of(truth(action, seconds=8.0))
    half = len(clean) // 2
    noise = np.where(np.arange(len(clean)) < half, 0.5, 4.0)[:, None]
    found = mend(clean + noise * np.random.default_rng(3).normal(size=clean.shape), library=library).found
    away = found.values - clean
    calm, loud = slice(0, half - 8), slice(half + 8, None)
    assert rms(away[loud]) < 1.7
    assert rms(away[calm]) < 0.3
    for part, most in ((calm, 0.9), (loud, 0.78)):
        assert 0.5 < np.mean(np.abs(away[part]) < found.std[part]) < most


def test_a_passage_of_one_channel_among_many_is_mostly_found_and_not_in_the_others():
    """Fifteen times as loud for a second of five."""
    told = []
    for seed in range(10):
        rng, fps, frames = np.random.default_rng(seed), 120.0, 600
        hit, start = np.arange(60) == 7, rng.integers(40, 440)
        louder = np.ones((frames, 60))
        louder[start : start + 120, hit] = 15.0
        found = loudness(0.02 * _walk(rng, frames, 60) + 0.7 * louder * rng.normal(size=louder.shape), fps)
        told.append(np.median(found[louder > 1]))
        assert np.quantile(found[:, ~hit], 0.99) < 1.5
    assert np.mean(np.array(told) > 2.0) > 0.6


@pytest.mark.parametrize("fps", [1e-6, 1e-3, 0.1])
def test_what_has_hardly_a_frame_a_second_is_repaired_at_least(fps, rng):
    found = loudness(rng.normal(size=(60, 5)), fps)
    assert np.isfinite(found).all()
