"""Laws of the filters that look at one channel only."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import naive
from motionmend.denoise.rivals import filtered
from motionmend.denoise.rivals.classic import FILTERS, GAP_FILLERS, butterworth, gaussian, kalman, savgol
from motionmend.denoise.rivals.filtered import Filtered
from motionmend.errors import MismatchError, UsageError

SEEDS = st.integers(0, 10**6)
LINEAR = ("gaussian", "savgol", "butterworth")


def _case(seed, frames=None):
    """Channels of motion and noise with gaps inside and at the ends, and a rate."""
    rng = np.random.default_rng(seed)
    frames = int(rng.integers(1, 90)) if frames is None else frames
    values = 5 * np.sin(np.arange(frames)[:, None] / rng.uniform(4, 20, 5) + rng.uniform(0, 6, 5))
    values += rng.normal(0, 0.5, values.shape)
    values[rng.random(values.shape) < rng.choice([0.0, 0.2, 0.9])] = np.nan
    values[:, 4] = np.nan if rng.random() < 0.3 else values[:, 4]
    return rng, values, float(rng.choice([25.0, 30.0, 60.0, 120.0]))


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FILTERS, *GAP_FILLERS])
@given(seed=SEEDS)
@settings(max_examples=15)
def test_no_measured_sample_is_lost_and_only_inner_gaps_are_filled(name, seed):
    _, values, fps = _case(seed)
    found = {**FILTERS, **GAP_FILLERS}[name](values, fps)
    measured = np.isfinite(values)
    assert found.values.shape == found.std.shape == found.filled.shape == values.shape
    assert np.isfinite(found.values[measured]).all()
    np.testing.assert_array_equal(found.filled, np.isfinite(found.values) & ~measured)
    inner = np.logical_or.accumulate(measured) & np.logical_or.accumulate(measured[::-1])[::-1]
    assert not (found.filled & ~inner).any()
    assert np.isnan(found.std[~np.isfinite(found.values)]).all()
    assert not (found.std < 0).any()


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FILTERS, *GAP_FILLERS])
@given(seed=SEEDS, exponent=st.integers(-20, 20))
@example(seed=1443, exponent=13)  # a channel of which too little is measured to tell its noise
@settings(max_examples=10)
def test_unit_and_origin_of_a_channel_do_not_matter(name, seed, exponent):
    rng, values, fps = _case(seed)
    unit, origin = 2.0**exponent, rng.normal(0, 5, 5)
    method = {**FILTERS, **GAP_FILLERS}[name]
    here, there = method(values, fps), method(unit * (values + origin), fps)
    np.testing.assert_allclose(there.values, unit * (here.values + origin), atol=1e-6 * unit)
    np.testing.assert_allclose(there.std, unit * here.std, rtol=1e-4, atol=1e-6 * unit)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FILTERS, *GAP_FILLERS])
@given(seed=SEEDS)
@settings(max_examples=10)
def test_channels_do_not_see_each_other(name, seed):
    _, values, fps = _case(seed)
    method = {**FILTERS, **GAP_FILLERS}[name]
    together = method(values, fps)
    for c in range(values.shape[1]):
        alone = method(values[:, [c]], fps)
        np.testing.assert_allclose(together.values[:, [c]], alone.values, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(together.std[:, [c]], alone.std, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("together", [1, 150, 10**6])
def test_a_long_recording_is_gone_through_a_few_channels_at_a_time(monkeypatch, together):
    _, values, fps = _case(3, frames=70)
    whole = savgol(values, fps)
    monkeypatch.setattr(filtered, "TOGETHER", together)
    parts = filtered.channelwise(savgol, values, fps)
    np.testing.assert_allclose(parts.values, whole.values, rtol=1e-9)
    np.testing.assert_allclose(parts.std, whole.std, rtol=1e-6)
    np.testing.assert_array_equal(parts.filled, whole.filled)


@pytest.mark.slow
@pytest.mark.parametrize("name", LINEAR)
@given(seed=SEEDS)
@settings(max_examples=10)
def test_linear_filters_are_linear(name, seed):
    rng, one, fps = _case(seed)
    other = np.where(np.isfinite(one), rng.normal(size=one.shape), np.nan)
    apply = FILTERS[name]
    both = apply(2.0 * one - 3.0 * other, fps).values
    np.testing.assert_allclose(both, 2.0 * apply(one, fps).values - 3.0 * apply(other, fps).values, atol=1e-9)


@pytest.mark.parametrize("name", [*FILTERS, *GAP_FILLERS])
def test_constants_and_straight_lines_stay(name):
    time = np.arange(90.0)
    values = np.stack([np.full(90, 7.0), 0.3 * time - 5.0], axis=1)
    gappy = values.copy()
    gappy[20:31, 1] = gappy[40:43, 0] = np.nan
    found = {**FILTERS, **GAP_FILLERS}[name](gappy, 30.0)
    np.testing.assert_allclose(found.values[:, 0], 7.0, rtol=1e-12)
    # The renormalised Gaussian leans inward where its kernel is cut.
    inside = slice(5, -5) if name == "gaussian" else slice(None)
    np.testing.assert_allclose(found.values[inside, 1], values[inside, 1], atol=1e-5)


def test_cubics_stay_with_savgol():
    time = np.linspace(-1, 1, 60)[:, None]
    np.testing.assert_allclose(savgol(time**3 - time, 30.0).values, time**3 - time, atol=1e-12)


@given(SEEDS)
@settings(max_examples=15)
def test_gaussian_is_its_plain_twin(seed):
    rng = np.random.default_rng(seed)
    values, fps = rng.normal(size=(int(rng.integers(1, 60)), 2)), float(rng.choice([10.0, 30.0, 100.0]))
    np.testing.assert_allclose(gaussian(values, fps).values, naive.gaussian(values, fps), atol=1e-12)


@pytest.mark.parametrize("name", LINEAR)
def test_a_filter_is_the_same_in_seconds_at_every_rate(name):
    def respond(fps):
        time = np.arange(round(4 * fps)) / fps
        return FILTERS[name](np.sin(2 * np.pi * 2.0 * time)[:, None], fps).values[:: round(fps / 30.0), 0]

    np.testing.assert_allclose(respond(120.0)[20:-20], respond(30.0)[20:-20], atol=0.03)


def test_butterworth_passes_half_the_power_at_its_cut_off_and_lags_nothing():
    fps = 120.0
    time = np.arange(1200) / fps
    for frequency, share in ((6.0, np.sqrt(0.5)), (1.0, 1.0), (20.0, 0.0)):
        wave = np.sin(2 * np.pi * frequency * time)
        found = butterworth(wave[:, None], fps).values[200:-200, 0]
        np.testing.assert_allclose(found, share * wave[200:-200], atol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", LINEAR)
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_noise_falls_by_the_gain_that_std_foretells(name, fps, rng):
    operator = FILTERS[name](np.eye(301), fps).values
    gain = np.sqrt(np.square(operator).sum(axis=1))
    noise = rng.normal(size=(301, 400))
    found = FILTERS[name](noise, fps)
    np.testing.assert_allclose(np.sqrt(np.square(found.values).mean(axis=1)), gain, rtol=0.2)
    np.testing.assert_allclose(np.sqrt(np.square(found.values).mean()), np.sqrt(np.square(gain).mean()), rtol=0.02)
    # What looks like motion lost adds to some channels' deviations; the others' are the gain alone, at the ends too.
    np.testing.assert_allclose(np.quantile(found.std, 0.25, axis=1), gain, rtol=0.12)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("period", [200.0, 14.0])
def test_std_counts_noise_and_what_the_filter_takes_from_the_motion(name, period, rng):
    truth = 10.0 * np.sin(2 * np.pi * np.arange(1500)[:, None] / period + rng.uniform(0, 6, 8))
    found = FILTERS[name](truth + rng.normal(size=truth.shape), 30.0)
    z = (found.values - truth) / found.std
    assert 0.7 < np.sqrt(np.square(z).mean()) < 1.3


@pytest.mark.parametrize("name", FILTERS)
def test_std_grows_inside_gaps(name, rng):
    truth = np.cumsum(rng.normal(size=(600, 4)), axis=0)
    values = truth + rng.normal(0, 0.3, truth.shape)
    values[200:240] = np.nan
    found = FILTERS[name](values, 30.0)
    assert (found.std[220] > 3 * found.std[100]).all()
    z = ((found.values - truth) / found.std)[200:240]
    assert np.sqrt(np.square(z).mean()) < 2.5


def test_kalman_is_calibrated_on_true_walks_and_knows_the_noise_it_is_told(rng):
    truth = np.cumsum(rng.normal(0, 0.5, (600, 12)), axis=0)
    values = truth + rng.normal(size=truth.shape)
    values[rng.random(values.shape) < 0.1] = np.nan
    values[[0, -1]] = truth[[0, -1]]
    for found in (kalman(values, 30.0), kalman(values, 30.0, 1.0), kalman(values, 30.0, np.full(values.shape, 1.0))):
        z = (found.values - truth) / found.std
        assert 0.85 < np.sqrt(np.square(z).mean()) < 1.15
        assert np.sqrt(np.square(found.values - truth).mean()) < 0.65


def test_kalman_weighs_samples_by_their_own_noise(rng):
    truth = np.cumsum(rng.normal(0, 0.3, (400, 6)), axis=0)
    noise = np.where(rng.random(truth.shape) < 0.3, 10.0, 0.5)
    values = truth + noise * rng.normal(size=truth.shape)
    told, guessed = kalman(values, 30.0, noise), kalman(values, 30.0)
    assert np.abs(told.values - truth).mean() < 0.6 * np.abs(guessed.values - truth).mean()


def test_a_channel_of_few_samples_stays_as_it_is():
    values = np.full((30, 2), np.nan)
    values[[3, 9, 20], 0] = [1.0, 5.0, 2.0]
    values[7, 1] = 4.0
    for name in ("kalman", "linear", "spline"):
        found = {**FILTERS, **GAP_FILLERS}[name](values, 30.0)
        np.testing.assert_array_equal(found.values[np.isfinite(values)], values[np.isfinite(values)])
    assert not kalman(values, 30.0).filled.any()


def test_refuses_what_makes_no_sense():
    with pytest.raises(UsageError, match=r"6 Hz needs a recording above 12 Hz, came 12 Hz"):
        butterworth(np.zeros((50, 1)), 12.0)
    with pytest.raises(MismatchError, match="frame rate"):
        gaussian(np.zeros((50, 1)), 0.0)
    with pytest.raises(MismatchError, match="channels"):
        kalman(np.zeros(50), 30.0)
    with pytest.raises(UsageError, match="noise"):
        kalman(np.zeros((50, 2)), 30.0, np.ones(3))
    with pytest.raises(MismatchError, match="std and filled"):
        Filtered(np.zeros((5, 2)), np.zeros((5, 3)), np.zeros((5, 2), dtype=bool))


@pytest.mark.parametrize("name", [*FILTERS, *GAP_FILLERS])
@pytest.mark.parametrize("shape", [(0, 3), (30, 0), (1, 3), (2, 3)])
def test_recordings_of_hardly_anything(name, shape):
    found = {**FILTERS, **GAP_FILLERS}[name](np.ones(shape), 30.0)
    np.testing.assert_allclose(found.values, np.ones(shape))
