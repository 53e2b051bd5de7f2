"""Laws of learned linear dynamics and the smoother that uses them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.denoise.dynamics import kalman as blocks
from motionmend.denoise.dynamics.kalman import Dynamics, Trust, fit_dynamics, judge, smooth_with
from motionmend.denoise.rivals.classic import gaussian, kalman
from motionmend.errors import MismatchError, UsageError
from motionmend.io import read

SEEDS = st.integers(0, 10**6)


class _System:
    """Three damped oscillations seen in ten channels: a true second-order autoregression."""

    def __init__(self, rng, channels=10):
        self.rng = rng
        self.mix = rng.normal(size=(channels, 3)) * 5
        self.mean = rng.normal(0, 20, channels)
        self.turn = 2 * np.pi / np.array([12.0, 25.0, 40.0])
        self.damping = 0.97

    def clip(self, frames):
        z = np.zeros((frames + 100, 3))
        push = self.rng.normal(0, 0.3, z.shape)
        for t in range(2, len(z)):
            z[t] = 2 * self.damping * np.cos(self.turn) * z[t - 1] - self.damping**2 * z[t - 2] + push[t]
        detail = self.rng.normal(0, 0.05, (frames, len(self.mix)))
        return self.mean + z[100:] @ self.mix.T + detail


@pytest.fixture
def system():
    return _System(np.random.default_rng(5))


@pytest.fixture
def dynamics(system):
    return fit_dynamics([system.clip(200) for _ in range(6)], 30.0)


def _rms(error):
    return float(np.sqrt(np.square(error).mean()))


@pytest.mark.parametrize("level", [0.5, 3.0])
def test_learned_dynamics_beat_the_random_walk_and_say_how_sure_they_are(system, dynamics, level):
    truth = system.clip(300)
    noisy = truth + system.rng.normal(0, level, truth.shape)
    told = smooth_with(dynamics, noisy, 30.0, noise=level)
    guessed = smooth_with(dynamics, noisy, 30.0)
    walk = kalman(noisy, 30.0, level)
    assert _rms(told.values - truth) < 0.75 * _rms(walk.values - truth)
    assert _rms(guessed.values - truth) < 1.15 * _rms(told.values - truth)
    for found in (told, guessed):
        assert 0.7 < _rms((found.values - truth) / found.std) < 1.2


def test_gaps_are_filled_and_whole_channels_too(system, dynamics):
    truth = system.clip(300)
    noisy = truth + system.rng.normal(0, 0.3, truth.shape)
    noisy[:, [2, 7]] = np.nan
    noisy[100:120] = np.nan
    found = smooth_with(dynamics, noisy, 30.0)
    assert np.isfinite(found.values).all()
    np.testing.assert_array_equal(found.filled, np.isnan(noisy))
    spread = truth.std(axis=0).mean()
    assert _rms((found.values - truth)[:, [2, 7]][150:]) < 0.2 * spread
    # In the middle of the gap little is known, and that is said.
    assert (found.std[110] > 3 * found.std[50]).all()
    assert 0.6 < _rms(((found.values - truth) / found.std)[found.filled]) < 1.5


def test_frames_far_from_any_measurement_stay_open(system, dynamics):
    noisy = system.clip(200)
    noisy[50:150] = np.nan
    found = smooth_with(dynamics, noisy, 30.0)
    lost = np.isnan(found.values).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(lost), np.arange(50 + 30, 150 - 30))
    np.testing.assert_array_equal(np.isnan(found.std), np.isnan(found.values))
    nothing = smooth_with(dynamics, np.full((40, 10), np.nan), 30.0)
    assert np.isnan(nothing.values).all()


def test_samples_of_their_own_noise(system, dynamics):
    truth = system.clip(200)
    noise = np.where(system.rng.random(truth.shape) < 0.2, 30.0, 0.5)
    noisy = truth + noise * system.rng.normal(size=truth.shape)
    told = smooth_with(dynamics, noisy, 30.0, noise=noise)
    assert _rms(told.values - truth) < 0.5 * _rms(smooth_with(dynamics, noisy, 30.0).values - truth)


@given(SEEDS)
@settings(max_examples=3)
def test_the_model_is_stable_and_its_covariances_are_covariances(seed):
    rng = np.random.default_rng(seed)
    system = _System(rng, channels=int(rng.integers(1, 8)))
    found = fit_dynamics([system.clip(int(n)) for n in rng.integers(20, 80, 3)], 30.0)
    count = found.poses.shape[1]
    lag = np.block([[found.first, found.second], [np.eye(count), np.zeros((count, count))]])
    assert np.abs(np.linalg.eigvals(lag)).max() < 1.0
    for cov in (found.process_cov, found.start_cov):
        assert np.linalg.eigvalsh(cov).min() > -1e-9 * np.trace(cov)
    basis = np.hstack([found.poses, found.rest])
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-10)
    assert ((found.rest_decay >= 0) & (found.rest_decay < 1)).all()
    assert (found.rest_var > 0).all()


def test_arrays_and_back(system, dynamics):
    arrays = dynamics.to_arrays()
    assert all(isinstance(a, np.ndarray) for a in arrays.values())
    again = Dynamics.from_arrays(arrays)
    noisy = system.clip(60)
    one, other = smooth_with(dynamics, noisy, 30.0), smooth_with(again, noisy, 30.0)
    assert one.values.tobytes() == other.values.tobytes()
    assert one.std.tobytes() == other.std.tobytes()


def test_place_of_the_pose_does_not_matter(system):
    clips = [system.clip(120) for _ in range(4)]
    noisy = system.clip(100)
    shift = system.rng.normal(0, 50, 10)
    here = smooth_with(fit_dynamics(clips, 30.0), noisy, 30.0)
    there = smooth_with(fit_dynamics([c + shift for c in clips], 30.0), noisy + shift, 30.0)
    np.testing.assert_allclose(there.values, here.values + shift, atol=1e-5)


def test_still_channels_are_smoothed_as_walks(system):
    clips = [np.hstack([system.clip(120), np.full((120, 1), 3.0)]) for _ in range(4)]
    found = fit_dynamics(clips, 30.0)
    np.testing.assert_array_equal(found.known, [True] * 10 + [False])
    noisy = np.hstack([system.clip(100), 8.0 + system.rng.normal(size=(100, 1))])
    smooth = smooth_with(found, noisy, 30.0)
    np.testing.assert_array_equal(smooth.values[:, 10], kalman(noisy, 30.0).values[:, 10])


def test_phases_of_one_recording_are_not_held_out_against_each_other(rng):
    # A slow wander: the next phase is all but the same, a later part of the recording is elsewhere.
    wander = np.cumsum(np.cumsum(rng.normal(0, 0.02, (2400, 6)), axis=0), axis=0)
    wander += np.cumsum(rng.normal(0, 0.3, wander.shape), axis=0)
    phases = fit_dynamics([wander[p::4] for p in range(4)], 30.0)
    alone = fit_dynamics([wander[::4]], 30.0)
    assert np.trace(phases.process_cov) > 0.7 * np.trace(alone.process_cov)


def test_frames_with_a_missing_sample_cut_a_clip(system):
    clip = system.clip(300)
    clip[100, 3] = clip[200, 5] = np.nan
    parts = fit_dynamics([clip], 30.0)
    assert np.isfinite(parts.mean).all()
    np.testing.assert_allclose(parts.mean, np.delete(clip, [100, 200], axis=0).mean(axis=0), rtol=1e-6)


def test_a_recording_unlike_the_clips_is_trusted_less(system, dynamics):
    other = _System(np.random.default_rng(77)).clip(200)
    noise = np.full(other.shape, 0.25)
    like = judge(dynamics, system.clip(200), noise, noise_known=True)
    unlike = judge(dynamics, other, noise, noise_known=True)
    assert unlike.rest > 10 * like.rest
    found = smooth_with(dynamics, other + system.rng.normal(0, 0.5, other.shape), 30.0)
    assert _rms(found.values - other) < 0.6


@pytest.mark.slow
def test_a_recording_at_a_multiple_of_the_rate_keeps_its_frames_and_gets_calmer():
    frames = np.arange(150 * 4 - 3) / 4
    error, jitter = [], []
    for seed in range(8):
        system = _System(np.random.default_rng(seed))
        dynamics = fit_dynamics([system.clip(200) for _ in range(6)], 30.0)
        slow = system.clip(150)
        truth = np.stack([np.interp(frames, np.arange(150), c) for c in slow.T], axis=1)
        noisy = truth + system.rng.normal(0, 1.0, truth.shape)
        joined = smooth_with(dynamics, noisy, 120.0).values
        assert joined.shape == noisy.shape
        apart = np.empty(noisy.shape)
        for phase in range(4):
            apart[phase::4] = smooth_with(dynamics, noisy[phase::4], 30.0).values
        error.append(_rms(joined - truth) / _rms(apart - truth))
        jitter.append(_rms(np.diff(joined - truth, axis=0)) / _rms(np.diff(apart - truth, axis=0)))
    assert max(error) < 0.95
    assert max(jitter) < 0.9
    assert np.mean(error) < 0.8
    assert np.mean(jitter) < 0.7


def test_refuses_what_makes_no_sense(system, dynamics):
    with pytest.raises(MismatchError, match="know 10 channels, the recording has 4"):
        smooth_with(dynamics, np.zeros((50, 4)), 30.0)
    with pytest.raises(UsageError, match="noise"):
        smooth_with(dynamics, np.zeros((50, 10)), 30.0, noise=np.ones(3))
    with pytest.raises(MismatchError, match="came none"):
        fit_dynamics([], 30.0)
    with pytest.raises(MismatchError, match="same channels"):
        fit_dynamics([np.zeros((50, 4)), np.zeros((50, 5))], 30.0)
    with pytest.raises(MismatchError, match="no channel moves"):
        fit_dynamics([np.zeros((50, 4))], 30.0)
    with pytest.raises(MismatchError, match="at least 12 frames"):
        fit_dynamics([system.clip(8)], 30.0)


def _angles(path):
    motion = read(path, fps=120.0)
    rotations = motion.skeleton.dof_kind == 0
    return np.unwrap(motion.q[::4, rotations], axis=0) * 180 / np.pi


@pytest.mark.slow
def test_walks_of_a_person_are_cleaned_better_than_by_any_simple_filter(data):
    folder = data / "mocap" / "amc" / "07"
    dynamics = fit_dynamics([_angles(folder / f"07_{n}.amc") for n in ("01", "02", "03", "06", "07")], 30.0)
    truth = _angles(folder / "07_08.amc")
    for level in (1.0, 3.0):
        noisy = truth + np.random.default_rng(1).normal(0, level, truth.shape)
        found = smooth_with(dynamics, noisy, 30.0)
        rivals = [gaussian(noisy, 30.0), kalman(noisy, 30.0), kalman(noisy, 30.0, level)]
        assert _rms(found.values - truth) < min(_rms(r.values - truth) for r in rivals)
        assert 0.7 < _rms((found.values - truth) / found.std) < 1.4


def test_same_input_same_bytes(system):
    clips = [system.clip(80) for _ in range(3)]
    noisy = system.clip(60)
    one = smooth_with(fit_dynamics(clips, 30.0), noisy, 30.0, trust=Trust(poses=2.0))
    other = smooth_with(fit_dynamics(clips, 30.0), noisy, 30.0, trust=Trust(poses=2.0))
    assert one.values.tobytes() == other.values.tobytes()


@pytest.mark.parametrize("frames", [0, 1, 2, 9])
def test_recordings_of_hardly_anything(system, dynamics, frames):
    values = system.clip(20)[:frames]
    for fps in (30.0, 120.0):
        found = smooth_with(dynamics, values, fps)
        assert found.values.shape == values.shape
        assert np.isfinite(found.values).all()


def test_where_blocks_meet_does_not_show(system, dynamics, monkeypatch):
    truth = system.clip(300)
    noisy = truth + system.rng.normal(0, 1.0, truth.shape)
    noisy[40:45] = np.nan
    whole = smooth_with(dynamics, noisy, 30.0, noise=1.0)
    monkeypatch.setattr(blocks, "BLOCK", 50)
    parts = smooth_with(dynamics, noisy, 30.0, noise=1.0)
    assert (np.abs(parts.values - whole.values) < 0.02 * whole.std).all()
    np.testing.assert_allclose(parts.std, whole.std, rtol=0.01)
