"""Laws of what the library says, and of how far it is believed."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.bases.support import CARRIED, Support, ends_alone, missed_by, support, supported
from motionmend.numerics.ssa import eigenbases, lag_covariance

FPS = 30.0
SEEDS = st.integers(0, 10**6)
FRAMES = 90


def _swings(seed, frames=FRAMES):
    """Six channels that swing together in two ways: what the library knows, begun at any moment."""
    ways = np.random.default_rng(7).normal(0, 8, (2, 2, 6))
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 2)
    t = np.arange(frames)[:, None] / FPS
    turned = [2 * np.pi * rate * t + p for rate, p in zip((0.8, 1.5), phase, strict=True)]
    return sum(np.cos(a) @ way[:1] + np.sin(a) @ way[1:] for a, way in zip(turned, ways, strict=True)) + 20.0


@lru_cache(maxsize=1)
def _bases():
    return eigenbases(lag_covariance([_swings(s, 300) for s in range(20)], 12), 1.0 - 1e-9)


def _judged(measured, values, smooth=None, believed=None, noise=0.5):
    believed = np.isfinite(measured) if believed is None else believed
    return support(measured, believed, smooth, values, _bases(), np.full(6, noise), FPS).variance


@given(SEEDS)
@settings(max_examples=10)
def test_what_the_library_knows_it_says_again(seed):
    truth = _swings(seed)
    np.testing.assert_allclose(supported(truth, truth, _bases(), 1), truth, atol=1e-3)


@given(SEEDS)
@settings(max_examples=10)
def test_noise_is_mostly_left_out_and_a_missing_stretch_is_said_all_the_same(seed):
    rng, truth = np.random.default_rng(seed), _swings(seed)
    measured = truth + rng.normal(0, 1.0, truth.shape)
    measured[30:50, 2] = np.nan
    start = np.where(np.isfinite(measured), measured, truth.mean(axis=0))
    away = supported(measured, start, _bases(), 1) - truth
    assert np.sqrt(np.mean(np.square(away))) < 0.7
    assert np.abs(away[30:50, 2]).max() < 4.0


@given(SEEDS, st.floats(3.0, 20.0))
@settings(max_examples=20)
def test_where_the_library_misses_it_is_believed_less(seed, off):
    rng, truth = np.random.default_rng(seed), _swings(seed)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    right, wrong = truth, truth.copy()
    wrong[40:60, 3] += off
    before, after = _judged(measured, right), _judged(measured, wrong)
    assert (after[45:55, 3] > before[45:55, 3]).all()
    assert (after[45:55, 3] > off**2).all()
    others = [0, 1, 2, 4, 5]
    np.testing.assert_allclose(after[:, others], before[:, others])


@given(SEEDS)
@settings(max_examples=20)
def test_variances_are_above_0_and_finite_however_much_is_missing(seed):
    rng, truth = np.random.default_rng(seed), _swings(seed)
    measured = np.where(rng.random(truth.shape) < rng.uniform(0, 1), np.nan, truth)
    measured[:, 0] = np.nan
    for smooth in (None, truth):
        found = _judged(measured, truth + rng.normal(0, 2, truth.shape), smooth)
        assert np.isfinite(found).all()
        assert (found > 0.05**2).all()


def test_single_outliers_are_no_word_against_the_library(rng):
    truth = _swings(3)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    before = _judged(measured, truth)
    measured[6::12] += 50.0
    assert (_judged(measured, truth) < 5.0 * before + 1.0).all()


@pytest.mark.parametrize("frame", [0, -1])
def test_neither_is_an_outlier_in_the_first_or_last_frame(rng, frame):
    truth = _swings(3)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    before = _judged(measured, truth)
    measured[frame] += 50.0
    assert (_judged(measured, truth) < 5.0 * before + 1.0).all()


@pytest.mark.parametrize("frames", [(0, 2, 3), (-1, -3, -4)])
def test_nor_are_three_of_the_first_or_last_four(rng, frames):
    truth = _swings(3)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    before = _judged(measured, truth)
    measured[list(frames)] += np.array([-50.0, -25.0, 30.0])[:, None]
    assert (_judged(measured, truth) < 5.0 * before + 1.0).all()


@given(SEEDS, st.sampled_from([0, 1, 40, -2, -1]))
@settings(max_examples=20)
def test_an_outlier_believed_by_mistake_is_no_word_against_the_library(seed, frame):
    rng, truth = np.random.default_rng(seed), _swings(seed)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    measured[frame, 2] += 40.0
    believing = truth.copy()
    believing[frame, 2] += 40.0
    present, noise = np.isfinite(measured), np.full(6, 0.5)
    one, other = (support(measured, present, s, truth, _bases(), noise, FPS) for s in (believing, truth))
    assert (one.verdict < 5.0 * other.verdict + 1.0).all()
    assert (one.variance[frame, 2] > 40.0**2).all()  # what becomes of the repair is as unsure as it was


@given(SEEDS)
@settings(max_examples=10)
def test_where_outliers_are_common_the_frames_at_the_ends_stand_for_those_beyond(seed):
    verdict = np.random.default_rng(seed).uniform(1.0, 9.0, (FRAMES, 6))
    found = ends_alone(verdict, np.array([0.0, 1e-4, 0.02, 0.1, 0.2, 1e9]))
    np.testing.assert_array_equal(found[1:-1], verdict[1:-1])
    factor = verdict[[0, -1]] / found[[0, -1]]
    np.testing.assert_allclose(factor[:, 0], 1.0)
    np.testing.assert_allclose(factor[:, -1], CARRIED)
    assert (np.diff(factor, axis=1) > 0).all()


def test_what_bases_of_the_recordings_own_miss_is_their_fault_however_short(rng):
    truth = _swings(3)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    swing = truth.copy()
    swing[40:42, 2] += 40.0
    present = np.isfinite(measured)
    found = [support(measured, present, swing, truth, _bases(), np.full(6, 0.5), FPS, own=own) for own in (False, True)]
    silent, heard = (one.verdict[40:42, 2] for one in found)
    assert (heard > 40.0**2).all()
    assert (silent < 0.05 * heard).all()


def test_in_a_gap_the_estimate_is_no_word_against_the_library(rng):
    truth = _swings(4)
    measured = truth + rng.normal(0, 0.5, truth.shape)
    measured[40:60, 1] = np.nan
    one, two = truth.copy(), truth.copy()
    two[40:60, 1] += 30.0
    np.testing.assert_array_equal(_judged(measured, truth, one), _judged(measured, truth, two))
    three = truth.copy()
    three[10:20, 1] += 30.0
    assert (_judged(measured, truth, three)[12:18, 1] > 30.0).all()


@pytest.mark.parametrize("first", [0, 40, FRAMES - 12])
def test_a_burst_is_no_word_against_the_library_as_a_steady_miss_is(first):
    """Twelve frames that scatter to both sides, at 30 Hz the moment and more; or that all lie to one."""
    truth, burst, away = _swings(6), slice(first, first + 12), {"burst": [], "miss": []}
    for seed in range(20):
        rng = np.random.default_rng(seed)
        clean = truth + rng.normal(0, 0.5, truth.shape)
        sizes = rng.uniform(15.0, 55.0, 12)
        for kind, side in (("burst", rng.choice([-1.0, 1.0], 12)), ("miss", 1.0)):
            measured = clean.copy()
            measured[burst, 2] += side * (sizes if kind == "burst" else 35.0)
            away[kind].append(np.sqrt(_judged(measured, truth)[burst, 2].mean()))
    assert np.median(away["burst"]) < 0.3 * np.median(away["miss"])


def test_noise_is_not_taken_for_misfit(rng):
    """Ten times the noise, told as such, makes the right library not a hundred times as doubtful."""
    truth = _swings(5, 300)
    white = rng.normal(0, 1.0, truth.shape)
    quiet, loud = (_judged(truth + s * white, truth, noise=s).mean() for s in (0.3, 3.0))
    assert loud < 10.0 * quiet


@given(SEEDS)
@settings(max_examples=20)
def test_what_is_missed_is_counted_where_samples_are_believed(seed):
    rng = np.random.default_rng(seed)
    values, smooth, believed = rng.normal(size=(20, 4)), rng.normal(size=(20, 4)), rng.random((20, 4)) < 0.5
    told = Support(values, np.ones((20, 4)), np.ones((20, 4)))
    wanted = np.sqrt(np.mean([(a - b) ** 2 for a, b in zip(values[believed], smooth[believed], strict=True)]))
    assert missed_by(told, believed, smooth) == pytest.approx(wanted)
    assert missed_by(told, np.zeros((20, 4), dtype=bool), smooth) == 0.0
