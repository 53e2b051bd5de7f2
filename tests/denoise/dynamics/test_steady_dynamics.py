"""Laws of learned dynamics in their steady state, and of their share in a repair."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Origin
from motionmend.denoise.adaptive.recording import Knowledge, mend_recording
from motionmend.denoise.channels.recording import to_channels
from motionmend.denoise.dynamics.model import Trust, state_space
from motionmend.denoise.dynamics.steady import mixed_in, smooth_steadily
from motionmend.denoise.gaps.likeliest import process_of
from motionmend.evaluate import body_channels, corrupt, rms_angle
from motionmend.numerics.smoother import kalman_smoother
from performers import FPS, joints_model, rms, truth

SEEDS = st.integers(0, 10**6)


def _drawn(seed, frames=240):
    """A recording that the model's own dynamics make, and with noise of one size in all channels."""
    rng = np.random.default_rng(seed)
    dynamics = joints_model().dynamics
    model = state_space(dynamics, Trust())
    state, states = rng.multivariate_normal(model.start_mean, model.start_cov), []
    steps = rng.multivariate_normal(np.zeros(len(state)), model.process_cov, frames)
    for step in steps:
        state = model.transition @ state + step
        states.append(state)
    clean = np.tile(dynamics.mean, (frames, 1))
    clean[:, dynamics.known] += np.array(states) @ model.observation.T
    return dynamics, model, clean, clean + 2.0 * rng.standard_normal(clean.shape)


@pytest.mark.slow
def test_of_recordings_that_the_dynamics_make_it_is_the_smoother_that_knows_all():
    for seed in range(2):
        dynamics, model, clean, measured = _drawn(seed)
        known, noise = dynamics.known, np.full(clean.shape[1], 2.0)
        found, variance = smooth_steadily(dynamics, measured, noise, clean[:2])
        best = kalman_smoother(model, (measured - dynamics.mean)[:, known], np.square(noise[known]))
        smooth = dynamics.mean[known] + best.mean @ model.observation.T
        middle = slice(60, 180)
        assert rms((found[:, known] - smooth)[middle]) < 0.1 * rms((smooth - clean[:, known])[middle])
        spread = best.variance(model.observation)[120]
        np.testing.assert_allclose(variance[known].mean(), spread.mean(), rtol=0.2)
        np.testing.assert_array_equal(found[:, ~known], measured[:, ~known])
        assert np.isinf(variance[~known]).all()


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_a_mixture_lies_between_and_is_no_less_sure(seed):
    rng = np.random.default_rng(seed)
    shape = (30, 4)
    values, steady = rng.normal(0, 5, shape), rng.normal(0, 5, shape)
    variance, steady_var = rng.uniform(0.5, 60, shape), rng.uniform(0.5, 60, 4)
    steady_var[0] = np.inf
    found, spread = mixed_in(steady, steady_var, values, variance, np.ones(shape, dtype=bool))
    share = (found - values) / (steady - values)
    assert share.min() > -1e-9
    assert share.max() < 1 + 1e-9
    np.testing.assert_allclose(share, share[:1].repeat(30, axis=0), atol=1e-9)
    assert (spread <= variance + 1e-12).all()
    assert (spread > 0).all()
    np.testing.assert_array_equal(found[:, 0], values[:, 0])


def test_dynamics_that_claim_much_and_lie_far_off_count_for_little():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(50, 2))
    far = values + np.array([4.0, 0.2])
    found, _ = mixed_in(far, np.full(2, 1e-4), values, np.full(values.shape, 0.04), np.ones(values.shape, dtype=bool))
    assert np.abs(found - values)[:, 0].max() < 0.05
    assert np.abs(found - far)[:, 1].max() < 0.12


def test_gaps_are_shifted_with_their_edges():
    values, seen = np.zeros((10, 1)), np.ones((10, 1), dtype=bool)
    seen[4:7] = False
    steady = np.where(np.arange(10)[:, None] < 5, 1.0, 3.0)
    found, spread = mixed_in(steady, np.array([0.1]), values, np.full((10, 1), 4.0), seen)
    assert (spread[seen] < 4.0).all()
    np.testing.assert_array_equal(spread[~seen], 4.0)  # what the samples won says nothing of gaps
    share = found[0, 0]
    assert 0 < share <= 1
    np.testing.assert_allclose(found[:, 0], share * np.array([1, 1, 1, 1, 1.5, 2, 2.5, 3, 3, 3]))


@pytest.mark.slow
def test_it_takes_error_away_where_the_library_knows_the_motion():
    model, better = joints_model(), []
    known = Knowledge(model.layout, model.library, model.bases, None, FPS, process_of(model.dynamics))
    alone = Knowledge(model.layout, model.library, model.bases, None, FPS)
    for seed in range(2):
        clean = truth("walk", seed=20 + seed, seconds=3.0)
        spoiled = corrupt(clean, noise=np.radians(5.0), seed=seed).recording
        counted = body_channels(clean.channels)
        one, other = (
            rms_angle(clean.q[:, counted], mend_recording(spoiled, what).recording.q[:, counted])
            for what in (known, alone)
        )
        better.append(one / other)
    assert np.mean(better) < 0.97, better


@pytest.mark.slow
def test_clean_motions_stay_as_they_are():
    model, clean = joints_model(), truth("walk")
    found = model.repair(clean, "adaptive")
    away = to_channels(found.recording, model.layout).values - to_channels(clean, model.layout).values
    assert rms(away) < 0.3
    assert (found.origin == Origin.REPAIRED).mean() < 0.005
