"""Samples that repeat themselves to the last digit while their channel is noisy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Motion, Origin, Repaired
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.faults.held import LEAST_REPEATS, LONG, held, in_noise
from motionmend.evaluate import compare, corrupt
from motionmend.samples import markers
from performers import FPS, clips, joints_model, truth

SEEDS = st.integers(0, 10**6)


def _noise(rng, frames=200, names=4, size=0.005):
    return Markers(tuple(f"M{n}" for n in range(names)), size * rng.standard_normal((frames, names, 3)), 60.0)


def _holding(recording, runs):
    """The recording with runs (channel, first, last) of the sample before each."""
    values = (recording.q if isinstance(recording, Motion) else recording.positions).copy()
    still = np.zeros((recording.frames, len(recording.channels)), dtype=bool)
    for channel, first, last in runs:
        values[first : last + 1, channel] = values[first - 1, channel]
        still[first : last + 1, channel] = True
    return (recording.with_q if isinstance(recording, Motion) else recording.with_positions)(values), still


def _as_it_is(recording):
    """A repair that takes everything for measured."""
    nothing = np.zeros(recording.present.shape)
    return Repaired(recording, nothing, nothing, nothing + 1.0, "adaptive")


@given(SEEDS, st.integers(LEAST_REPEATS, int(LONG * 60)))
@settings(max_examples=30)
def test_runs_in_noise_are_found_and_nothing_else(seed, length):
    rng = np.random.default_rng(seed)
    recording, still = _holding(_noise(rng, 500), [(2, 100, 99 + length), (0, 250, 249 + length)])
    np.testing.assert_array_equal(held(recording), still)


@given(SEEDS, st.sampled_from([1e-4, 5e-4, 2e-3]))
@settings(max_examples=30)
def test_what_is_written_in_coarse_steps_repeats_by_chance(seed, step):
    noise = _noise(np.random.default_rng(seed), 400, size=0.002)
    assert not held(noise.with_positions(step * np.round(noise.positions / step))).any()


def test_a_channel_at_rest_a_long_stand_at_an_end_or_a_limit_and_frames_shown_twice_are_left():
    noise = _noise(np.random.default_rng(0), 600)
    positions = noise.positions.copy()
    positions[:, 0] = positions[0, 0]
    positions[500:, 1] = positions[500, 1]
    positions[100:200, 2] = positions[100, 2]
    positions[300, 2] = positions[100, 2]
    positions[100:200, 3] = positions.max(axis=0)[3]
    assert not held(noise.with_positions(positions)).any()
    assert not held(noise.with_positions(np.repeat(noise.positions[:200], 3, axis=0))).any()


@given(SEEDS, st.integers(int(LONG * 60) + 1, 290))
@settings(max_examples=20)
def test_long_runs_that_come_from_elsewhere_and_go_elsewhere_are_found(seed, length):
    noise = _noise(np.random.default_rng(seed), 600)
    recording, still = _holding(noise, [(2, 100, 99 + length)])
    np.testing.assert_array_equal(held(recording), still)


@given(SEEDS, st.integers(61, int(LONG * 60)))
@settings(max_examples=20)
def test_a_run_that_is_much_of_a_channel_is_found_where_it_hardly_repeats_itself_else(seed, length):
    """A take of three seconds: a third of it and more is held, to its end or not."""
    noise = _noise(np.random.default_rng(seed), 180)
    recording, still = _holding(noise, [(2, 60, 59 + length), (0, 181 - length, 179)])
    np.testing.assert_array_equal(held(recording), still)


def test_a_run_that_is_much_of_a_channel_is_repaired_in_noise_alone():
    """Its equal samples are so many that the repair finds no noise in the channel; in a clean take there is none."""
    clean = truth("walk", seconds=3.0)
    row, length = clean.skeleton.dof_names.index("ltibia.rx"), round(1.2 * FPS)
    for noise in (0.0, 1.0):
        noisy = corrupt(clean, noise=np.radians(noise), seed=1).recording
        bad, still = _holding(noisy, [(row, 30, 29 + length)])
        assert (held(bad) == still).all()
        outcome = replace(_as_it_is(bad), noise=np.where(still.any(axis=0), 0.0, np.radians(noise)))
        assert (in_noise(still, outcome, bad) == (still if noise else np.zeros_like(still))).all()


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("start", [60, 70, 80])
def test_what_is_held_for_long_is_filled_or_kept_and_never_said_to_be_sure(library, start):
    clean = truth("walk", seconds=6.0)
    noisy = corrupt(clean, noise=np.radians(2.0), seed=1).recording
    row = clean.skeleton.dof_names.index("ltibia.rx")
    bad, still = _holding(noisy, [(row, start, start + round(1.6 * FPS))])
    found = joints_model().repair(bad) if library else repair_without_model(bad, "adaptive")
    assert np.isfinite(found.recording.q).all()
    off, recorded = (np.abs(q - clean.q)[still] for q in (found.recording.q, bad.q))
    assert np.sqrt(np.mean(np.square(off))) < (0.4 if library else 1.1) * np.sqrt(np.mean(np.square(recorded)))
    assert (off < 2.0 * found.std[still]).mean() > 0.7  # of one gap, whose errors go together
    assert (found.origin[still] == Origin.REPAIRED).mean() > (0.99 if library else 0.5)
    assert any("taken as missing" in warning for warning in found.warnings)


@pytest.mark.parametrize("frames", [0, 1, 2, 5])
def test_few_frames(frames):
    assert held(_noise(np.random.default_rng(0), frames)).shape == (frames, 4)


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("dropped", [True, False])
def test_what_a_sensor_holds_is_filled_and_said(library, dropped):
    """The last value, or zero, for a third of a second: nearly as good as if it were missing."""
    clean = truth("walk")
    noisy = corrupt(clean, noise=np.radians(2.0), seed=1).recording
    runs = [(channel, 20 + 7 * turn, 29 + 7 * turn) for turn, channel in enumerate(range(8, 40, 3))]
    bad, still = _holding(noisy, runs)
    if dropped:
        bad = bad.with_q(np.where(still, 0.0, bad.q))

    def repaired(recording):
        return joints_model().repair(recording) if library else repair_without_model(recording, "adaptive")

    found, gaps = repaired(bad), repaired(noisy.with_q(np.where(still, np.nan, noisy.q)))
    inside = still.copy()
    if dropped:  # the first zero may be true for all that is known
        inside[20:][np.diff(still.astype(int), axis=0)[19:] > 0] = False
    assert (found.origin[inside] == Origin.REPAIRED).mean() > 0.9
    assert compare(clean, found.recording).rms_deg < 1.15 * compare(clean, gaps.recording).rms_deg
    assert any("repeat the one before" in warning for warning in found.warnings)
    assert not (found.origin == Origin.LEFT_OPEN).any()


@pytest.mark.slow
def test_markers_that_are_held_are_filled_from_the_others():
    def halved(motion):  # two and more are left on every segment
        every = markers(motion)
        return Markers(every.names[::2], every.positions[:, ::2], every.fps, up=every.up)

    clean = halved(truth("walk"))
    noisy = corrupt(clean, noise=0.002, seed=1).recording
    bad, still = _holding(noisy, [(5, 30, 50), (12, 60, 80)])
    found = Denoiser(window=20, fps=FPS).fit([halved(motion) for motion in clips()]).repair(bad)
    off = np.linalg.norm(found.recording.positions - clean.positions, axis=2)
    assert (found.origin[still] == Origin.REPAIRED).all()
    assert np.sqrt(np.mean(np.square(off[still]))) < 0.02


@pytest.mark.slow
def test_what_is_held_where_nothing_tells_of_it_is_left_open_and_not_said_to_be_replaced():
    """A second lost, then one held: its middle is as far from anything seen as that of a gap of two."""
    clean = truth("walk")
    noisy = corrupt(clean, noise=np.radians(2.0), seed=1).recording
    bad, still = _holding(noisy, [(10, 121, 149)])
    q = bad.q.copy()
    q[60:120, 10] = np.nan
    found = repair_without_model(bad.with_q(q), "adaptive")
    assert (found.origin[still] == Origin.LEFT_OPEN).any()
    assert np.isnan(found.recording.q[found.origin == Origin.LEFT_OPEN]).all()
    (said,) = [warning for warning in found.warnings if "repeat the one before" in warning]
    assert "taken as missing" in said


@pytest.mark.slow
def test_a_clean_recording_may_stand_still():
    """Without noise nobody can tell: what is at rest stays."""
    clean, _ = _holding(truth("reach"), [(20, 40, 60), (21, 40, 60), (33, 80, 95)])
    for found in (joints_model().repair(clean), repair_without_model(clean, "adaptive")):
        assert not any("repeat the one before" in warning for warning in found.warnings)
        assert found.recording.fps == FPS


@pytest.mark.slow
def test_rests_in_a_calm_half_are_left_where_the_other_is_noisy():
    """A joint rests for a while before the noise begins, and is held after: only the second is repaired."""
    clean = truth("walk", seconds=8.0)
    half, joint = clean.frames // 2, 20
    noise = np.where(np.arange(clean.frames)[:, None] < half, 0.0, np.radians(3.0))
    noisy = clean.with_q(clean.q + noise * np.random.default_rng(1).normal(size=clean.q.shape))
    recorded, still = _holding(noisy, [(joint, 40, 52), (joint, half + 40, half + 52)])
    found = repair_without_model(recorded, "adaptive").origin == Origin.REPAIRED
    assert not (found & still)[:half].any()
    assert (found & still)[half:].sum() > 8
