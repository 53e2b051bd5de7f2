"""Laws of what a recording tells of its noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.noise.level import (
    alike_noise,
    first_noise,
    next_follow,
    next_held,
    next_noise,
    next_rate,
    overlooked,
)
from motionmend.numerics.walk import noise_level

SEEDS = st.integers(0, 10**6)


def _walk(rng, frames, channels):
    """As smooth as a body: second differences of a tenth of a degree."""
    return np.cumsum(np.cumsum(rng.normal(0, 0.1, (frames, channels)), axis=0), axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1.0, 3.0, 5.0])
@pytest.mark.parametrize(("outliers", "most"), [(0.0, 1.5), (0.05, 1.7), (0.1, 1.75), (0.2, 2.4)])
def test_the_first_guess_is_of_the_size_of_the_noise_and_grows_with_outliers(noise, outliers, most):
    found = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        truth = _walk(rng, 400, 6)
        spoilt = truth + rng.normal(0, noise, truth.shape)
        hit = rng.random(truth.shape) < outliers
        spoilt += hit * rng.choice([-1, 1], truth.shape) * rng.uniform(15, 55, truth.shape)
        found.append(first_noise(spoilt) / noise)
    assert np.min(found) > 0.25
    assert np.max(found) < most
    assert 0.65 < np.median(found) < 1.5


@given(SEEDS, st.floats(0.5, 50.0), st.floats(-100, 100), st.floats(-5, 5))
@settings(max_examples=25)
def test_the_first_guess_has_the_channels_unit_and_feels_no_steady_motion(seed, unit, level, speed):
    rng = np.random.default_rng(seed)
    white = rng.normal(0, 2.0, (80, 3))
    t = np.arange(80.0)[:, None]
    moving = unit * (white + level + speed * t + 0.01 * speed * t**2)
    np.testing.assert_allclose(first_noise(moving), unit * first_noise(white), rtol=1e-6)


def test_a_channel_that_says_too_little_is_taken_to_be_like_the_others(rng):
    measured = rng.normal(0, [1.0, 2.0, 3.0, 2.0], (100, 4))
    measured[4:, 3] = np.nan
    found = first_noise(measured)
    assert found[3] == pytest.approx(np.median(found[:3]))


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_nothing_seen_and_next_to_nothing_give_a_number_all_the_same(rng, frames):
    for measured in (np.full((frames, 3), np.nan), rng.normal(size=(frames, 3))):
        found = first_noise(measured)
        assert np.isfinite(found).all()
        assert (found > 0).all()


@given(SEEDS, st.sampled_from([0.5, 3.0]), st.sampled_from([60, 400]))
@settings(max_examples=25)
def test_without_outliers_the_first_guess_is_the_noise(seed, noise, frames):
    rng = np.random.default_rng(seed)
    found = first_noise(rng.normal(0, noise, (frames, 40)))
    assert 0.55 * noise < np.median(found) < 1.4 * noise


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=25)
def test_the_more_outliers_the_more_careful_the_first_guess(seed):
    rng = np.random.default_rng(seed)
    white, place = rng.normal(0, 1.0, (400, 40)), rng.random((400, 40))
    off = rng.choice([-1, 1], white.shape) * rng.uniform(15, 55, white.shape)
    none, some, many = (np.median(first_noise(white + (place < share) * off)) for share in (0.0, 0.05, 0.2))
    assert some < 1.3 * none
    assert many < 1.6 * none


@given(SEEDS, st.integers(3, 6), st.sampled_from([300, 900]))
@settings(max_examples=25)
def test_what_few_channels_are_noisy_by_does_not_hang_on_how_the_clean_ones_move(seed, few, frames):
    """Clean motion rests and starts, so that its large differences are many times its small ones, as with outliers."""
    rng = np.random.default_rng(seed)
    lively = np.where(rng.random((frames, 40)) < 0.3, 0.02, 0.0005)
    measured = np.cumsum(np.cumsum(lively * rng.standard_normal((frames, 40)), axis=0), axis=0)
    measured[:, :few] += rng.standard_normal((frames, few))
    found = first_noise(measured)[:few]
    assert 0.65 < np.median(found) < 1.5


def test_still_channels_have_a_noise_above_0():
    assert (first_noise(np.full((50, 2), 7.0)) > 0).all()


@given(SEEDS, st.sampled_from([0.0, 0.1, 0.2]), st.integers(40, 300))
@settings(max_examples=40)
def test_channels_as_noisy_as_each_other_are_found_to_be_so_whatever_the_outliers(seed, outliers, frames):
    """Differences over time alone make some channels of a short recording twenty times as noisy as others."""
    rng = np.random.default_rng(seed)
    truth = _walk(rng, frames, 40)
    spoilt = truth + rng.normal(0, 1.0, truth.shape)
    spoilt += (rng.random(truth.shape) < outliers) * rng.choice([-1, 1], truth.shape) * rng.uniform(15, 55, truth.shape)
    found = alike_noise(spoilt)
    assert found.max() < 10.0 * found.min()
    assert np.ptp(np.log(found)) < np.ptp(np.log(noise_level(spoilt)))
    assert 0.5 < np.median(found) < 5.0


def test_a_channel_that_cannot_tell_its_noise_says_so(rng):
    measured = rng.normal(size=(60, 3))
    measured[1:, 1] = np.nan
    found = alike_noise(measured)
    assert np.isnan(found[1])
    np.testing.assert_allclose(found[[0, 2]], 1.0, atol=0.3)


@given(SEEDS)
@settings(max_examples=25)
def test_many_samples_are_believed(seed):
    rng = np.random.default_rng(seed)
    truth = np.exp(rng.normal(0, 0.3, 8))
    freedom = rng.uniform(2000, 5000, 8)
    found = next_noise(np.ones(8), np.square(truth) * freedom, freedom)
    np.testing.assert_allclose(found, truth, rtol=0.05)


@given(SEEDS, st.floats(0.5, 20.0))
@settings(max_examples=25)
def test_the_next_guess_has_the_unit_of_the_residuals(seed, unit):
    rng = np.random.default_rng(seed)
    noise, freedom = np.exp(rng.normal(0, 0.3, 6)), rng.uniform(1, 300, 6)
    square = freedom * np.exp(rng.normal(0, 0.5, 6))
    one = next_noise(noise, square, freedom)
    np.testing.assert_allclose(next_noise(unit * noise, unit**2 * square, freedom), unit * one, rtol=1e-9)


@given(SEEDS)
@settings(max_examples=25)
def test_the_next_guess_lies_among_what_the_channels_say(seed):
    rng = np.random.default_rng(seed)
    noise, freedom = np.exp(rng.normal(0, 0.5, 6)), rng.uniform(0, 50, 6)
    square = freedom * np.exp(rng.normal(0, 1.0, 6))
    said = [*noise, *np.sqrt(square[freedom > 1] / freedom[freedom > 1])]
    found = next_noise(noise, square, freedom)
    assert (found >= 0.5 * min(said)).all()
    assert (found <= 2.0 * max(said)).all()


def test_a_channel_without_freedom_follows_the_others():
    freedom = np.array([500.0, 500.0, 500.0, 0.0])
    found = next_noise(np.array([3.0, 3.0, 3.0, 0.2]), 9.0 * freedom, freedom)
    np.testing.assert_allclose(found[:3], 3.0, rtol=0.02)
    assert 1.5 < found[3] < 4.0


@given(SEEDS, st.sampled_from([1, 4, 12]), st.sampled_from([100.0, 300.0, 1000.0]), st.integers(40, 400))
@settings(max_examples=40)
def test_few_noisy_channels_among_many_quiet_ones_stay_as_noisy_as_they_say(seed, few, times, frames):
    """A limb that shakes while the rest is clean: what all channels say together is nothing that holds for it."""
    rng = np.random.default_rng(seed)
    truth = np.where(np.arange(60) < few, times * 0.01, 0.01) * np.exp(0.1 * rng.standard_normal(60))
    freedom = np.full(60, 0.8 * frames)
    said = truth * np.sqrt(rng.chisquare(freedom) / freedom)
    found = truth.copy()
    for _ in range(6):  # every round begins with what the last one ended with
        found = next_noise(found, np.square(said) * freedom, freedom)
    assert np.abs(np.log(found / said))[:few].max() < 0.7


def test_channels_that_are_nearly_alike_are_drawn_together():
    rng = np.random.default_rng(0)
    freedom = np.full(60, 10.0)
    said = 2.0 * np.sqrt(rng.chisquare(freedom) / freedom)
    found = next_noise(said, np.square(said) * freedom, freedom)
    assert np.log(found).std() < 0.7 * np.log(said).std()


@given(SEEDS)
@settings(max_examples=25)
def test_rates_are_shares_and_in_between(seed):
    rng = np.random.default_rng(seed)
    present = rng.random((200, 5)) < 0.8
    outlier = present & (rng.random((200, 5)) < rng.uniform(0, 0.4, 5))
    found = next_rate(outlier, present)
    own = outlier.sum(axis=0) / present.sum(axis=0)
    assert (found > 0).all()
    assert (found < 1).all()
    assert (found > own.min() - 0.01).all()
    assert (found < own.max() + 0.01).all()
    assert (np.argsort(found) == np.argsort(own)).all() or np.diff(np.sort(own)).min() < 0.01


def test_rates_of_long_channels_are_their_own():
    outlier = np.zeros((50_000, 2), dtype=bool)
    outlier[::5, 1] = True
    found = next_rate(outlier, np.ones_like(outlier))
    assert found[0] < 0.005
    assert found[1] == pytest.approx(0.2, rel=0.05)


def test_rates_of_nothing_are_finite():
    nothing = np.zeros((10, 3), dtype=bool)
    assert np.isfinite(next_rate(nothing, nothing)).all()


@given(SEEDS, st.floats(0.001, 0.4), st.floats(0.0, 5.0))
@settings(max_examples=50)
def test_a_share_that_falls_is_taken_further_and_one_that_holds_is_not(seed, share, more):
    rng = np.random.default_rng(seed)
    outlier = rng.random((400, 5)) < share
    present = np.ones_like(outlier)
    usual, expected = next_rate(outlier, present), np.full(5, max(outlier.mean(), 1e-3) * (1.0 + more))
    found = next_rate(outlier, present, expected)
    assert (found <= usual).all()
    assert (found > 0).all()
    if more < 0.1 and outlier.mean() > 1e-3:
        np.testing.assert_allclose(found, usual, rtol=1e-12)
    if more > 2.0 and outlier.mean() > 0.01:
        assert (found < 0.7 * usual).all()


@given(SEEDS, st.floats(0.0, 0.4))
@settings(max_examples=30)
def test_outliers_that_come_one_by_one_follow_as_often_as_any_sample(seed, share):
    rng = np.random.default_rng(seed)
    present = rng.random((400, 5)) < 0.9
    outlier = present & (rng.random((400, 5)) < share)
    assert next_follow(outlier, present) == pytest.approx(outlier.sum() / present.sum(), abs=0.05)


def test_outliers_that_come_in_bursts_follow_as_often_as_they_do():
    outlier = (np.arange(20_000) % 100 < 5)[:, None].repeat(3, axis=1)
    present = np.ones_like(outlier)
    assert next_follow(outlier, present) == pytest.approx(0.8, abs=0.05)
    present[1::2] = False  # what follows across a gap is not known
    assert next_follow(outlier & present, present) < 0.1


def test_a_few_pairs_of_outliers_are_no_bursts():
    outlier = np.zeros((400, 5), dtype=bool)
    outlier[np.arange(10, 400, 40)] = True
    outlier[51:54, 0] = True
    assert next_follow(outlier, np.ones_like(outlier)) < 2.0 * outlier.mean()


@pytest.mark.parametrize("together", [1, 3])
def test_the_share_of_outliers_that_stay_where_the_one_before_was_is_told(rng, together):
    """Bursts of five, of which every second keeps its distance and the others are anywhere."""
    outlier = (np.arange(5_000) % 20 < 5)[:, None].repeat(2 * together, axis=1)
    anywhere = rng.uniform(-40.0, 40.0, outlier.shape)
    first = np.arange(5_000) // 20 * 20
    stays = (first // 20 % 2 == 0)[:, None]
    off = np.where(outlier, np.where(stays, anywhere[first], anywhere), 0.0) + rng.standard_normal(outlier.shape)
    held = 0.5
    for _ in range(5):
        held = next_held(off, outlier, np.full(off.shape, 2.0), 80.0**-together, together, held, first=0.5)
    assert held == pytest.approx(0.5, abs=0.1)


def test_without_outliers_what_is_thought_of_them_stays():
    nothing = np.zeros((50, 3))
    assert next_held(nothing, nothing > 0, nothing + 1.0, 1 / 80.0, 1, 0.2, first=0.3) == pytest.approx(0.3)


def _told_apart(rng, noise, rate, frames=4000):
    """What is said, and true, of the variance of noise with outliers 15 to 55 off, found from 3.5 deviations on."""
    hit = rng.random((frames, 6)) < rate
    off = np.where(hit, rng.choice([-1.0, 1.0], hit.shape) * rng.uniform(15.0, 55.0, hit.shape), 0.0)
    measured = off + noise * rng.standard_normal(hit.shape)
    found = np.abs(measured) > 3.5 * noise
    believed = np.mean(np.square(measured[~found])) / noise**2
    return overlooked(measured, np.zeros(hit.shape), found, np.full(6, noise)), believed


@pytest.mark.parametrize("rate", [0.0, 0.2])
def test_outliers_far_beyond_noise_are_all_seen(rng, rate):
    assert 1.0 <= _told_apart(rng, 1.0, rate)[0] < 1.01


@pytest.mark.parametrize("rate", [0.05, 0.1, 0.2])
def test_some_that_are_not_are_taken_for_noise(rng, rate):
    said, real = _told_apart(rng, 5.0, rate)
    assert 0.5 * (real - 1.0) < said - 1.0 < 2.0 * (real - 1.0)


def test_missing_samples_and_none_at_all_overlook_nothing():
    nowhere = np.full((30, 4), np.nan)
    assert overlooked(nowhere, np.zeros((30, 4)), np.zeros((30, 4), dtype=bool), np.ones(4)) == 1.0


@given(st.integers(0, 10**6), st.integers(5, 10), st.sampled_from([0.1, 1.0, 5.0]))
@settings(max_examples=30, deadline=None)
def test_a_few_frames_tell_by_all_channels_together(seed, frames, noise):
    """No channel has enough of them to tell for itself: a tenth of a degree was supposed, whatever they showed."""
    rng = np.random.default_rng(seed)
    smooth = np.arange(frames)[:, None] * rng.normal(0.0, 3.0, 60)
    found = first_noise(smooth + noise * rng.standard_normal((frames, 60)))
    assert np.ptp(found) == 0.0
    assert 0.5 * noise < found[0] < 2.0 * noise


def test_channels_that_never_move_say_nothing_of_the_noise_of_a_few_frames(rng):
    noisy = rng.standard_normal((6, 70))
    beside = np.hstack([noisy, np.zeros((6, 30))])
    np.testing.assert_allclose(first_noise(beside)[0], first_noise(noisy)[0])
    assert first_noise(beside)[0] > 0.4


def test_hardly_any_samples_tell_nothing():
    assert (first_noise(np.zeros((3, 4))) > 0.0).all()
    assert (first_noise(np.full((10, 4), np.nan)) > 0.0).all()
