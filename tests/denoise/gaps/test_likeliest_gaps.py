"""Laws of gaps filled as poses follow each other, and of their shares beside other fillings."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import cholesky_banded

import naive_denoise
from motionmend.denoise.adaptive.recording import Knowledge, mend_recording
from motionmend.denoise.gaps.likeliest import Process, fill_likeliest, process_of
from motionmend.denoise.gaps.moved import gaps_of, hidden_by, laid_elsewhere
from motionmend.denoise.gaps.shares import fillings, mixed, shares, unsure
from motionmend.evaluate import corrupt
from motionmend.kernels.gap_bands import gap_spread, gap_system
from performers import FPS, joints_model, truth


def _swinging(rng, channels, surprise=1e-6):
    """Channels that swing, each at a pace of its own, as a process knows them."""
    pace = rng.uniform(0.1, 0.4, channels)
    return Process(
        FPS,
        np.ones(channels, dtype=bool),
        rng.normal(0.0, 10.0, channels),
        np.diag(2.0 * np.cos(pace)),
        -np.eye(channels),
        surprise * np.eye(channels),
    ), pace


def _lost(rng, shape, share=0.3):
    """Bursts of missing samples in some channels."""
    gone = np.zeros(shape, dtype=bool)
    while gone.mean() < share:
        start = rng.integers(shape[0])
        gone[start : start + rng.integers(1, 15), rng.random(shape[1]) < 0.4] = True
    return gone


@given(seed=st.integers(0, 10**6), frames=st.integers(5, 30), channels=st.integers(1, 4))
@settings(deadline=None, max_examples=30)
def test_the_system_of_the_gaps_is_that_of_all_samples_without_the_others(seed, frames, channels):
    rng = np.random.default_rng(seed)
    rules = rng.normal(size=(3, channels + 1, channels))
    products = np.einsum("kea,leb->klab", rules, rules)
    frame, channel = np.nonzero(_lost(rng, (frames, channels)))
    first = np.searchsorted(frame, np.arange(frames + 3))
    band = int((first[3:] - first[:-3]).max())
    np.testing.assert_allclose(
        gap_system(products, frame, channel, frames, band),
        naive_denoise.gap_system(products, frame, channel, frames, band),
        atol=1e-12,
    )


@given(seed=st.integers(0, 10**6), frames=st.integers(5, 30), channels=st.integers(1, 4))
@settings(deadline=None, max_examples=30)
def test_how_far_gaps_may_be_off_is_the_inverse_of_their_system(seed, frames, channels):
    rng = np.random.default_rng(seed)
    rules = rng.normal(size=(3, channels + 1, channels))
    products = np.einsum("kea,leb->klab", rules, rules)
    frame, channel = np.nonzero(_lost(rng, (frames, channels)))
    first = np.searchsorted(frame, np.arange(frames + 3))
    lower = gap_system(products, frame, channel, frames, int((first[3:] - first[:-3]).max()))
    lower[0] += 0.1
    factor = np.ascontiguousarray(cholesky_banded(lower, lower=True).T)
    found = gap_spread(factor, frame, channel, frames, channels)
    for one, other in zip(found, naive_denoise.gap_spread(lower, frame, channel, frames, channels), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_gaps_of_what_follows_the_process_are_off_as_far_as_it_says():
    """Swings that the process knows and two of which are shaken alike: squares of errors are as large as is said."""
    cov = np.array([[1.0, 0.8, 0.0, 0.0], [0.8, 1.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0], [0.0, 0.0, 0.0, 0.25]])
    beyond = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        process, _ = _swinging(rng, 4)
        process = replace(process, surprise=cov, first=0.95 * process.first, second=0.95**2 * process.second)
        shaken, away = rng.multivariate_normal(np.zeros(4), cov, 600), np.zeros((600, 4))
        for t in range(2, len(away)):
            away[t] = process.first @ away[t - 1] + process.second @ away[t - 2] + shaken[t]
        values, gone = away + process.mean, _lost(rng, away.shape)
        gone[[0, 1, -2, -1]] = False
        filled, variance = fill_likeliest(process, fillings(values, gone, None, FPS)[0][1], gone, FPS)
        assert (variance[gone] > 0.0).all()
        square = np.square(filled - values)
        beyond.append([(square[gone[:, c], c] / variance[gone[:, c], c]).mean() for c in range(4)])
    assert ((np.mean(beyond, axis=0) > 0.5) & (np.mean(beyond, axis=0) < 2.0)).all()


@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=30)
def test_a_mixture_is_less_sure_the_more_the_fillings_differ(seed):
    rng = np.random.default_rng(seed)
    tried, smoother = rng.normal(size=(3, 20, 4)), rng.uniform(0.5, 2.0, (20, 4))
    counts = rng.dirichlet(np.ones(3), (20, 4)).transpose(2, 0, 1)
    process = np.where(rng.random((20, 4)) < 0.5, 0.0, rng.uniform(0.5, 2.0, (20, 4)))
    alike = unsure(np.stack([tried[0]] * 3), counts, smoother, process)
    np.testing.assert_allclose(alike[process == 0.0], smoother[process == 0.0])
    assert (alike >= np.where(process > 0.0, np.minimum(smoother, process), smoother) - 1e-12).all()
    assert (unsure(tried, counts, smoother, process) >= alike).all()


@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=20)
def test_what_follows_the_process_is_found_again_whatever_the_guess(seed):
    rng = np.random.default_rng(seed)
    process, pace = _swinging(rng, 5)
    swing = rng.uniform(5.0, 30.0, 5) * np.sin(np.arange(80)[:, None] * pace + rng.uniform(0.0, 6.0, 5)) + process.mean
    gone = _lost(rng, swing.shape)
    gone[[0, 1, -2, -1]] = False
    filled, _ = fill_likeliest(process, np.where(gone, swing + rng.normal(0.0, 5.0, swing.shape), swing), gone, FPS)
    assert np.abs(filled - swing).max() < 0.05


@given(seed=st.integers(0, 10**6), times=st.sampled_from([1, 2, 4]))
@settings(deadline=None, max_examples=20)
def test_only_gaps_of_known_channels_change(seed, times):
    rng = np.random.default_rng(seed)
    process, _ = _swinging(rng, 4, surprise=1.0)
    process = Process(FPS, np.array([True, True, False, True, True]), *list(vars(process).values())[2:])
    values = np.cumsum(rng.normal(size=(60 * times, 5)), axis=0)
    gone = _lost(rng, values.shape)
    gone[:, 4] = True  # never seen: stays as it was guessed
    filled, variance = fill_likeliest(process, values, gone, FPS * times)
    assert np.isfinite(filled).all()
    np.testing.assert_array_equal(filled[~gone], values[~gone])
    np.testing.assert_array_equal(filled[:, [2, 4]], values[:, [2, 4]])
    assert (variance >= 0.0).all()
    assert not variance[~gone].any()
    assert not variance[:, [2, 4]].any()


def test_what_channels_have_in_common_in_this_recording_is_carried_into_its_gaps():
    """Two channels move as one, which the library does not know."""
    rng = np.random.default_rng(0)
    process = Process(FPS, np.ones(2, dtype=bool), np.zeros(2), 2.0 * np.eye(2), -np.eye(2), np.eye(2))
    for way in (1.0, -1.0):
        walk = np.cumsum(np.cumsum(rng.normal(size=200)))
        both = np.stack([walk, way * walk], axis=1)
        gone = np.zeros(both.shape, dtype=bool)
        gone[90:120, 1] = True
        guess = fillings(both, gone, None, FPS)[0][1]  # a line
        filled, _ = fill_likeliest(process, guess, gone, FPS)
        assert np.abs(filled - both).max() < 0.3 * np.abs(guess - both).max()


@given(seed=st.integers(0, 10**6), count=st.sampled_from([2, 3]))
@settings(deadline=None, max_examples=30)
def test_shares_make_one_and_go_to_the_filling_that_errs_less_elsewhere(seed, count):
    rng = np.random.default_rng(seed)
    present = ~_lost(rng, (300, 6), 0.05)
    gaps = gaps_of(present)
    moved = laid_elsewhere(gaps, present)
    best = int(rng.integers(count))
    away = rng.normal(size=(count, *present.shape)) * np.where(np.arange(count) == best, 0.05, 5.0)[:, None, None]
    found = shares(gaps, moved, away, present)
    inside = hidden_by(gaps, present.shape)
    np.testing.assert_allclose(found.sum(axis=0), 1.0)
    assert (found >= 0.0).all()
    np.testing.assert_array_equal(found[0][~inside], 1.0)
    usual = shares(gaps, [], away, present)
    assert (found[best][inside] >= np.minimum(usual[best][inside], 0.9)).all()
    tried = rng.normal(size=away.shape)
    np.testing.assert_array_equal(mixed(tried, found)[~inside], tried[0][~inside])


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "turn"])
def test_gaps_are_filled_better_with_learned_dynamics(action):
    model = joints_model()
    parts = (model.layout, model.library, model.bases, None, FPS)
    error = {None: 0.0, "dynamics": 0.0}
    for seed in (0, 1):
        clean = truth(action, seconds=4.0)
        cut = corrupt(clean, gaps=0.1, seed=seed).recording
        for name in error:
            known = Knowledge(*parts, None if name is None else process_of(model.dynamics))
            away = (mend_recording(cut, known).recording.q - clean.q)[~cut.present]
            error[name] += float(np.square(np.nan_to_num(away)).sum())
    assert error["dynamics"] < 0.9 * error[None]
