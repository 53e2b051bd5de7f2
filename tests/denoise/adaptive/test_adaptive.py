"""What the adaptive repair finds in channels: noise, outliers, the motion, and how sure it is of it."""

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.adaptive.rounds import adapt
from motionmend.denoise.adaptive.traits import Traits
from motionmend.denoise.library.local_prior import Prior
from motionmend.samples import markers
from performers import FPS, channels_of, f1, joints_model, mend, prior_of, rms, spoilt, truth

ACTIONS = ("walk", "reach")


def _random_walks(rng, frames=200, channels=4):
    """Second-order walks and the covariance of their steps: second differences go together in pairs."""
    covariance = 0.1**2 * (0.6 * np.kron(np.eye(channels // 2), np.ones((2, 2))) + 0.4 * np.eye(channels))
    steps = rng.multivariate_normal(np.zeros(channels), covariance, frames)
    return np.cumsum(np.cumsum(steps, axis=0), axis=0), covariance


@pytest.mark.parametrize("noise", [1.0, 3.0, 5.0])
@pytest.mark.parametrize("outliers", [0.0, 0.1, 0.2])
def test_the_noise_of_random_walks_is_told_without_a_library(rng, noise, outliers):
    walks, covariance = _random_walks(rng)
    measured, _ = spoilt(walks, noise, outliers, seed=int(10 * noise))
    found = mend_channels(measured, Prior(covariance, None), FPS)
    np.testing.assert_allclose(found.noise, noise, rtol=0.33)
    assert rms(found.found.values - walks) < 0.75 * noise


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "outliers"), [(1.0, 0.2), (3.0, 0.1), (5.0, 0.0), (5.0, 0.2)])
def test_the_noise_of_the_performer_is_told_to_a_third(noise, outliers):
    for action in ACTIONS:
        found = mend(spoilt(channels_of(truth(action, seconds=3.0)), noise, outliers)[0])
        np.testing.assert_allclose(found.noise, noise, rtol=0.33)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("action", ACTIONS)
def test_outliers_are_found(noise, action):
    measured, hit = spoilt(channels_of(truth(action)), noise, 0.1, seed=2)
    found = mend(measured).found.origin == Origin.REPAIRED
    assert f1(found, hit) > 0.9
    assert (found & ~hit).mean() < 0.02


@pytest.mark.slow
def test_what_the_library_knows_tells_where_a_short_clip_begins_and_ends():
    """Seen from one side only, where a fifth of all samples are outliers."""
    ends, between = [], []
    for seed in range(12):
        clean = channels_of(truth("turn", seed=9 + seed, seconds=1.4))
        found = mend(spoilt(clean, 1.0, 0.2, seed)[0]).found.values - clean
        ends.append(rms(found[[0, 1, -2, -1]]))
        between.append(rms(found[2:-2]))
    assert rms(ends) < 2.2 * rms(between)


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("action", ACTIONS)
def test_bursts_of_outliers_are_found(action, library):
    """A twentieth of the samples in bursts of a sixth to half a second, with a library or without."""
    rng = np.random.default_rng(4)
    clean = channels_of(truth(action))
    measured, hit = clean + 2.0 * rng.standard_normal(clean.shape), np.zeros(clean.shape, dtype=bool)
    while hit.mean() < 0.05:
        start, channel = rng.integers(len(clean)), rng.integers(clean.shape[1])
        hit[start : start + rng.integers(5, 16), channel] = True
    measured += np.where(hit, rng.choice([-1.0, 1.0], hit.shape) * rng.uniform(15.0, 55.0, hit.shape), 0.0)
    found = mend(measured, library=library).found
    assert f1(found.origin == Origin.REPAIRED, hit) > 0.95
    assert rms(found.values - clean) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("action", ACTIONS)
def test_slips_that_last_a_moment_are_found(action, fps, library):
    """A channel off by the same 15 to 55 degrees for 70 ms: within such a slip nothing jumps."""
    rng = np.random.default_rng(6)
    clean = channels_of(truth(action, fps=fps))
    measured, hit = clean + 0.5 * rng.standard_normal(clean.shape), np.zeros(clean.shape, dtype=bool)
    length = max(2, round(0.07 * fps))
    while hit.mean() < 0.02:
        start, channel = rng.integers(2, len(clean) - length - 2), rng.integers(clean.shape[1])
        if not hit[start - 2 : start + length + 2, channel].any():
            hit[start : start + length, channel] = True
            measured[start : start + length, channel] += rng.choice([-1.0, 1.0]) * rng.uniform(15.0, 55.0)
    found = mend(measured, fps=fps, library=library).found
    assert f1(found.origin == Origin.REPAIRED, hit) > 0.95
    assert rms(found.values - clean) < 0.7


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_long_bursts_are_filled_like_gaps(library):
    """Bursts of a third to half a second in six of the channels at 60 Hz, one of them at the very beginning."""
    rng = np.random.default_rng(4)
    clean = channels_of(truth("walk", fps=60.0))
    measured, hit = clean + 2.0 * rng.standard_normal(clean.shape), np.zeros(clean.shape, dtype=bool)
    for start, channel in ((0, 8), (60, 14), (100, 20), (150, 26), (200, 40), (250, 9)):
        hit[start : start + rng.integers(20, 31), channel] = True
    off = rng.choice([-1.0, 1.0], hit.shape) * rng.uniform(15.0, 55.0, hit.shape)
    found = mend(np.where(hit, measured + off, measured), fps=60.0, library=library).found.values - clean
    gaps = mend(np.where(hit, np.nan, measured), fps=60.0, library=library).found.values - clean
    assert rms(found[hit]) < 1.5 * rms(gaps[hit])


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "reach", "turn", "jump", "run"])
def test_clean_channels_are_left_alone(action):
    """Also those of motions that the library does not know."""
    clean = channels_of(truth(action))
    found = mend(clean)
    assert rms(found.found.values - clean) < 0.3
    assert (found.found.origin == Origin.REPAIRED).mean() < 0.005


@pytest.mark.slow
@pytest.mark.parametrize("action", ACTIONS)
def test_repair_takes_most_of_the_error_away(action):
    clean = channels_of(truth(action))
    for noise, most in ((1.0, 0.65), (3.0, 0.5), (5.0, 0.45)):
        measured, _ = spoilt(clean, noise, 0.1, seed=3)
        assert rms(mend(measured).found.values - clean) < most * noise


@pytest.mark.slow
@pytest.mark.parametrize("noise", [2.0])
def test_a_library_of_other_motions_does_little_harm(noise):
    """Jumps and runs of a library of walks, turns and reaches: at worst as if there were none."""
    for action in ("jump", "run"):
        clean = channels_of(truth(action))
        measured, _ = spoilt(clean, noise, 0.05, seed=4)
        told, untold = (rms(mend(measured, **given).found.values - clean) for given in ({}, {"library": False}))
        assert told < 1.15 * untold


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1.0, 3.0, 5.0])
def test_two_of_three_errors_lie_within_a_deviation_and_nineteen_of_twenty_within_two(noise):
    """Over walks and reaches of three people, with and without outliers."""
    within = []
    for action in ACTIONS:
        for seed in (9, 10, 11):
            clean = channels_of(truth(action, seed=seed, seconds=4.0))
            found = mend(spoilt(clean, noise, (0.0, 0.1, 0.2)[seed - 9], seed)[0]).found
            ratio = np.abs(found.values - clean) / found.std
            within.append([np.mean(ratio < 1.0), np.mean(ratio < 1.96)])
    one, two = np.mean(within, axis=0)
    assert one == pytest.approx(0.683, abs=0.06)
    assert two == pytest.approx(0.95, abs=0.06)


@pytest.mark.slow
def test_gaps_of_a_channel_are_as_wrong_as_they_say():
    clean = channels_of(truth("walk", seconds=6.0))
    ratio = []
    for seed in range(3):
        measured, _ = spoilt(clean, 1.0, 0.0, seed)
        gap = np.zeros(clean.shape, dtype=bool)
        rng = np.random.default_rng(seed)
        for c in rng.permutation(clean.shape[1])[:20]:
            start = int(rng.integers(5, 130))
            gap[start : start + int(rng.choice([3, 10, 30])), c] = True
        found = mend(np.where(gap, np.nan, measured)).found
        ratio.append(((found.values - clean) / found.std)[gap])
    ratio = np.abs(np.concatenate(ratio))
    assert np.mean(ratio < 1.0) > 0.5
    assert np.mean(ratio < 1.96) > 0.85


@pytest.mark.slow
def test_a_longer_gap_is_less_sure_in_its_middle():
    clean = channels_of(truth("walk"))
    measured, _ = spoilt(clean, 1.0, 0.0)
    middle = []
    for half in (0, 5, 25):
        gappy = measured.copy()
        gappy[75 - half : 76 + half, 20] = np.nan
        middle.append(mend(gappy).found.std[75, 20])
    assert min(middle[1:]) > 0.7 * middle[0]  # how lively the motion is there is told anew each time
    assert middle[-1] > 1.2 * middle[0]


@pytest.mark.slow
@pytest.mark.parametrize("fps", [15.0, 24.0, 60.0, 120.0])
def test_noise_and_outliers_are_told_at_any_rate(fps):
    clean = channels_of(truth("walk", fps=fps))
    measured, hit = spoilt(clean, 2.0, 0.1, seed=5)
    found = mend(measured, fps=fps)
    np.testing.assert_allclose(found.noise, 2.0, rtol=0.25)
    assert f1(found.found.origin == Origin.REPAIRED, hit) > 0.9
    assert rms(found.found.values - clean) < 1.4


def test_one_channel_noisier_than_the_others_is_told_apart():
    clean = channels_of(truth("walk", seconds=6.0))
    measured, _ = spoilt(clean, 1.0, 0.0)
    measured[:, 25] += np.random.default_rng(8).normal(0, 4.0, len(clean))
    noise = mend(measured).noise
    others = np.delete(noise, 25)
    assert 2.0 < noise[25] < 5.5
    assert np.median(others) == pytest.approx(1.0, abs=0.15)
    assert ((others > 0.5) & (others < 1.5)).all()


def test_coordinates_of_one_marker_are_rejected_together(rng):
    walks, _ = _random_walks(rng, 120, 6)
    measured = walks + rng.normal(0, 0.5, walks.shape)
    measured[40, 1] += 30.0
    found = adapt(measured, Prior(np.diag(np.full(6, 0.04)), None), FPS, traits=Traits(together=3))
    assert found.outlier[40, :3].all()
    assert not found.outlier[40, 3:].any()
    assert (found.outlier.reshape(120, 2, 3).any(axis=2) == found.outlier.reshape(120, 2, 3).all(axis=2)).all()


@pytest.mark.parametrize("reach", [250.0, 400.0])
def test_a_channel_that_goes_far_begins_where_it_is_seen(rng, reach):
    """A marker without a body's frame that crosses a room: its first samples are no outliers."""
    t = np.linspace(-1.0, 1.0, 150)[:, None]
    measured = reach * np.sin(0.5 * np.pi * t) * [1.0, -1.0] + rng.normal(0, 1.0, (150, 2))
    assert not adapt(measured, Prior(np.diag([0.25, 0.25]), None), FPS).outlier[:5].any()


def test_what_is_found_is_finite_and_of_the_recordings_shape():
    measured, _ = spoilt(channels_of(truth("walk")), 1.0, 0.1)
    measured[:, 7] = np.nan
    measured[40:60] = np.nan
    found = adapt(measured, prior_of(joints_model()), FPS)
    for value in (found.values, found.variance):
        assert value.shape == measured.shape
        assert np.isfinite(value).all()
    assert (found.variance > 0).all()
    assert (found.noise > 0).all()
    assert ((found.rate > 0) & (found.rate < 1)).all()
    assert not (found.outlier & np.isnan(measured)).any()


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.5, 1.0, 2.0])
def test_one_noisy_marker_among_quiet_ones_is_as_noisy_as_its_distances_say(noise):
    """Five to twenty millimetres beside 0.3: it was drawn a fourth of the way to the others."""
    cloud = markers(truth("walk", seconds=8.0, fps=60.0))
    clean = Markers(cloud.names[1::2], cloud.positions[:, 1::2], cloud.fps, up=cloud.up)  # the other half takes as long
    rng = np.random.default_rng(3)
    positions = clean.positions + 0.0003 * rng.standard_normal(clean.positions.shape)
    marker = clean.names.index("LTHI")
    positions[:, marker] += 0.01 * noise * rng.standard_normal((clean.frames, 3))
    told = repair_without_model(clean.with_positions(positions)).noise[marker]
    assert told == pytest.approx(0.01 * noise, rel=0.2)
