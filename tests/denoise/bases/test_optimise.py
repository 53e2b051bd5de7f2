"""Laws of the robust window fit (eq. 2.8-2.16)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.denoise.bases import repair
from motionmend.denoise.bases.optimise import fit_windows, window_starts
from motionmend.numerics.robust import ESTIMATORS
from motionmend.numerics.ssa import eigenbases, lag_covariance

WINDOW = 8


def _rhythm(seed, frames=60, channels=5):
    """Smooth, correlated channels in degrees: three rhythms mixed into all channels."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None]
    rhythms = np.hstack([np.sin(0.25 * t + rng.uniform(0, 6)), np.cos(0.25 * t), np.sin(0.5 * t + rng.uniform(0, 6))])
    return 20 * rhythms @ rng.normal(size=(3, channels)) + rng.normal(scale=30, size=channels)


def _bases(clean, energy=0.99):
    return eigenbases(lag_covariance(clean, WINDOW), energy)


def _spoiled(clean, seed, noise=1.0, outliers=0.05, missing=0.1):
    rng = np.random.default_rng(seed)
    y = clean + rng.normal(scale=noise, size=clean.shape)
    hit = rng.random(clean.shape) < outliers
    y[hit] += rng.choice([-1, 1], hit.sum()) * rng.uniform(15, 55, hit.sum())
    y[rng.random(clean.shape) < missing] = np.nan
    return y


def _start(y, bases):
    return np.where(np.isfinite(y), y, bases.mean.mean(axis=0))


@given(st.integers(0, 10**6), st.sampled_from(sorted(ESTIMATORS)), st.integers(1, 4))
@settings(max_examples=40)
def test_the_cost_never_increases(seed, robust, stride):
    clean = _rhythm(seed)
    bases = _bases(clean)
    y = _spoiled(clean, seed + 1)
    fit = fit_windows(y, _start(y, bases), bases, stride, robust=robust, tolerance=1e-9)
    assert (np.diff(fit.cost) <= 1e-9 * fit.cost[0]).all()


@given(st.integers(0, 10**6))
@settings(max_examples=15)
def test_the_cost_is_that_of_the_equation(seed):
    clean = _rhythm(seed)
    bases = _bases(clean)
    y = _spoiled(clean, seed + 1)
    fit = fit_windows(y, _start(y, bases), bases)
    starts = window_starts(len(y), WINDOW, 1)
    said = naive.window_cost(fit.values, y, bases.mean, bases.vectors, starts, ESTIMATORS["welsch"].rho, 3.0, 0.1)
    assert fit.cost[-1] == pytest.approx(said, rel=1e-9)


@pytest.mark.slow
@given(st.integers(0, 10**6))
@settings(max_examples=8)
def test_it_ends_where_the_plain_alternation_ends(seed):
    """For least squares the minimum is one: both must find it."""
    clean = _rhythm(seed, frames=30)
    bases = _bases(clean)
    y = _spoiled(clean, seed + 1, outliers=0.0)
    start = _start(y, bases)
    fit = fit_windows(y, start, bases, robust="square", tolerance=1e-14, most_iterations=2000)
    plain = naive.alternate(
        y,
        start,
        bases.mean,
        bases.vectors,
        window_starts(len(y), WINDOW, 1),
        ESTIMATORS["square"].weight,
        3.0,
        0.1,
        400,
    )
    starts = window_starts(len(y), WINDOW, 1)
    cost = naive.window_cost(plain, y, bases.mean, bases.vectors, starts, ESTIMATORS["square"].rho, 3.0, 0.1)
    assert fit.cost[-1] <= cost * (1 + 1e-9)
    np.testing.assert_allclose(fit.values[np.isfinite(y)], plain[np.isfinite(y)], atol=0.05)


@pytest.mark.parametrize("seed", range(4))
def test_robust_minimum_is_no_worse_than_that_of_the_plain_alternation(seed):
    clean = _rhythm(seed, frames=40)
    bases = _bases(clean)
    y = _spoiled(clean, seed + 1, missing=0.0)
    starts = window_starts(len(y), WINDOW, 1)
    welsch = ESTIMATORS["welsch"]
    plain = naive.alternate(y, y, bases.mean, bases.vectors, starts, welsch.weight, 3.0, 0.1, 60)
    cost = naive.window_cost(plain, y, bases.mean, bases.vectors, starts, welsch.rho, 3.0, 0.1)
    assert fit_windows(y, y, bases, tolerance=1e-7).cost[-1] <= 1.02 * cost


def test_outliers_are_rejected_and_noise_is_reduced():
    clean = _rhythm(1, frames=200)
    bases = _bases(clean, 0.999)
    y = _spoiled(clean, 2, noise=1.0, outliers=0.1, missing=0.0)
    hit = np.abs(y - clean) > 10
    fit = fit_windows(y, y, bases)
    assert fit.converged
    assert fit.weights[hit].max() < 0.05
    assert np.sqrt(np.mean(np.square(fit.values - clean))) < 0.6


def test_missing_samples_are_filled_from_the_others():
    clean = _rhythm(3, frames=150)
    bases = _bases(clean, 0.999)
    y = clean.copy()
    y[40:80, 1] = np.nan  # five windows long
    fit = fit_windows(y, _start(y, bases), bases, tolerance=1e-8)
    assert np.abs(fit.values[40:80, 1] - clean[40:80, 1]).max() < 2.0
    assert (fit.weights[40:80, 1] == 0).all()


@given(st.integers(0, 10**6), st.floats(-1e3, 1e3))
@settings(max_examples=15)
def test_what_stood_at_a_missing_sample_has_no_influence(seed, value):
    clean = _rhythm(seed)
    bases = _bases(clean)
    y = _spoiled(clean, seed + 1)
    start = _start(y, bases)
    fit = fit_windows(y, start, bases)
    again = fit_windows(np.where(np.isfinite(y), y, np.nan), start, bases)
    np.testing.assert_array_equal(fit.values, again.values)
    # and a start elsewhere reaches the same place
    moved = np.where(np.isfinite(y), y, start + value / 100)
    there = fit_windows(y, moved, bases, tolerance=1e-10, most_iterations=500, robust="square")
    here = fit_windows(y, start, bases, tolerance=1e-10, most_iterations=500, robust="square")
    assert there.cost[-1] == pytest.approx(here.cost[-1], rel=1e-4)


@given(st.integers(0, 10**6))
@settings(max_examples=15)
def test_channel_order_does_not_matter(seed):
    clean = _rhythm(seed)
    order = np.random.default_rng(seed).permutation(clean.shape[1])
    y = _spoiled(clean, seed + 1, missing=0.0)
    straight = fit_windows(y, y, _bases(clean))
    mixed = fit_windows(y[:, order], y[:, order], _bases(np.ascontiguousarray(clean[:, order])))
    np.testing.assert_allclose(mixed.values, straight.values[:, order], atol=1e-6)


@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_converges_in_ten_to_twenty_iterations_on_cleanish_data(noise):
    """The dissertation: "typically converges after 10 to 20 iterations"."""
    clean = _rhythm(4, frames=300, channels=12)
    y = _spoiled(clean, 5, noise=noise, outliers=0.02, missing=0.0)
    fit = fit_windows(y, y, _bases(clean))
    assert fit.converged
    assert fit.iterations <= 20


def test_windows_cover_every_frame_whatever_the_stride():
    for frames in range(20, 40):
        for stride in range(1, 7):
            starts = window_starts(frames, 11, stride)
            covered = np.zeros(frames, dtype=bool)
            for s in starts:
                covered[s : s + 11] = True
            assert covered.all()
            assert starts[-1] == frames - 11


def test_blocks_of_a_long_recording_are_repaired_as_the_whole(monkeypatch):
    clean = _rhythm(5, frames=400)
    y, bases = _spoiled(clean, 5), _bases(clean)
    whole = repair.repair_channels(y, bases, 30.0, 30.0, "welsch")
    monkeypatch.setattr(repair, "LONG", 150)
    parts = repair.repair_channels(y, bases, 30.0, 30.0, "welsch")
    apart = np.abs(parts.values - whole.values)
    assert apart.mean() < 0.1 * np.abs(whole.values - clean).mean()
    assert np.abs(parts.std / whole.std - 1.0).mean() < 0.2
    assert (parts.origin == whole.origin).mean() > 0.99
    assert len(parts.cost) == parts.iterations + 1
    assert (np.diff(parts.cost) <= 1e-9 * parts.cost[0]).all()
    assert parts.converged
