"""Noise that lasts is told from motion and from noise that does not."""

import numpy as np
import pytest

import motionmend as mm
from motionmend.denoise.noise.lasting import USUAL_OF_ANGLES, lasting_by_distances, lasting_noise
from performers import lessened
from tumblers import tumbling

FPS, FRAMES, CHANNELS = 120.0, 600, 20


def lasts(rng, shape, stays):
    """Autoregressive noise of variance one."""
    noise = rng.standard_normal(shape)
    for t in range(1, shape[0]):
        noise[t] = stays * noise[t - 1] + np.sqrt(1.0 - stays**2) * noise[t]
    return noise


def motion(rng):
    """(T, C) degrees: swings of one to three a second."""
    time = np.arange(FRAMES)[:, None] / FPS
    pace, phase = rng.uniform(1.0, 3.0, CHANNELS), rng.uniform(0.0, 6.0, CHANNELS)
    return 20.0 * np.sin(2.0 * np.pi * pace * time + phase)


@pytest.mark.parametrize("stays", [0.7, 0.9, 0.95])
def test_how_loud_it_is_is_told(stays):
    rng = np.random.default_rng(2)
    measured = motion(rng) + 2.0 * lasts(rng, (FRAMES, CHANNELS), stays)
    found = lasting_noise(measured, FPS, USUAL_OF_ANGLES)
    assert found is not None
    # what white noise would have to be to be as strong at three hertz or so
    at = found.lowest
    true = 4.0 * (1.0 - stays**2) / (1.0 - 2.0 * stays * np.cos(at) + stays**2)
    assert np.median(found.in_band) == pytest.approx(true, rel=0.35)


def test_motion_alone_and_noise_that_is_new_in_every_frame_do_not_last():
    rng = np.random.default_rng(2)
    smooth = motion(rng)
    assert lasting_noise(smooth, FPS, USUAL_OF_ANGLES) is None
    assert lasting_noise(smooth + 2.0 * rng.standard_normal(smooth.shape), FPS, USUAL_OF_ANGLES) is None


def test_who_trembles_beside_noise_that_is_new_in_every_frame_shows_none_that_lasts():
    rng = np.random.default_rng(2)
    turns = np.cumsum(5.0 + 0.2 * rng.standard_normal((FRAMES, CHANNELS)), axis=0) / 30.0 + rng.random(CHANNELS)
    trembling = 3.0 * np.sin(2.0 * np.pi * turns) + 3.0 * rng.standard_normal((FRAMES, CHANNELS))
    assert lasting_noise(trembling, 30.0, USUAL_OF_ANGLES) is None


def test_what_clean_recordings_show_as_well_is_taken_off():
    rng = np.random.default_rng(2)
    measured = motion(rng) + 0.3 * lasts(rng, (FRAMES, CHANNELS), 0.9)
    found = lasting_noise(measured, FPS, USUAL_OF_ANGLES)
    assert found is None or not found.variance.any()


def test_lively_channels_of_a_clean_recording_are_not_noise_for_how_all_others_wander():
    rng = np.random.default_rng(2)
    wanders = np.where(np.arange(CHANNELS) < 4, 2.0, 0.2)  # degrees a frame, as toes that snap do, and the others
    measured = motion(rng) + np.cumsum(wanders * rng.standard_normal((FRAMES, CHANNELS)), axis=0)
    assert lasting_noise(measured, FPS, USUAL_OF_ANGLES) is None  # before: 20 degrees of noise in the four


def test_gaps_and_channels_that_never_move_are_borne():
    rng = np.random.default_rng(2)
    measured = motion(rng) + 2.0 * lasts(rng, (FRAMES, CHANNELS), 0.9)
    measured[:, 3] = 5.0
    measured[100:200, 4], measured[:, 5] = np.nan, np.nan
    found = lasting_noise(measured, FPS, USUAL_OF_ANGLES)
    assert found is not None
    assert found.variance[3] == found.variance[5] == 0.0
    assert found.variance[4] > 0.0


@pytest.mark.slow
def test_deviations_reach_noise_that_lasts():
    clean = mm.samples.clip("walk", seconds=5, fps=120.0, seed=3)
    left, off = lessened(clean, np.radians(2.0) * lasts(np.random.default_rng(0), clean.q.shape, 0.9))
    assert left < 0.9  # before: 0.99
    assert 0.6 < (off < 1.0).mean() < 0.9  # before: 0.15
    assert (off < 1.96).mean() > 0.88  # before: 0.3


def turning(fps, rng):
    """(T, 54) cm: markers on what flies and turns as fast as people do."""
    return tumbling(6, FRAMES, fps, rng, 1.5)


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("stays", [0.7, 0.9])
@pytest.mark.parametrize("seed", range(3))
def test_distances_tell_it_of_markers_whose_motion_hides_it(fps, stays, seed):
    rng = np.random.default_rng(seed)
    clean = turning(fps, rng)
    assert lasting_by_distances(clean, fps) is None
    assert lasting_by_distances(clean + 0.3 * rng.standard_normal(clean.shape), fps) is None
    measured = clean + 0.3 * lasts(rng, clean.shape, stays)
    measured[50:80, :9], measured[:, 30:33] = np.nan, np.nan
    found = lasting_by_distances(measured, fps)
    assert found is not None
    seen = np.delete(found.variance, [30, 31, 32])
    assert np.sqrt(np.median(seen)) == pytest.approx(0.3, rel=0.2)
    assert found.variance[30] == 0.0


def test_few_markers_or_frames_tell_nothing():
    rng = np.random.default_rng(0)
    measured = 0.3 * lasts(rng, (FRAMES, 18), 0.9) + turning(120.0, rng)[:, :18]
    for columns, frames in ((0, FRAMES), (3, FRAMES), (18, 30), (18, 0)):
        assert lasting_by_distances(measured[:frames, :columns], 120.0) is None
    assert lasting_by_distances(np.full((FRAMES, 18), np.nan), 120.0) is None


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_deviations_of_markers_reach_noise_that_lasts(fps):
    every = mm.samples.markers(mm.samples.clip("run", seconds=5, fps=fps, seed=3))
    clean = mm.Markers(every.names[::2], every.positions[:, ::2], fps, up=every.up)
    noise = 0.003 * lasts(np.random.default_rng(0), clean.positions.shape, 0.9)
    repaired = mm.repair_without_model(mm.Markers(clean.names, clean.positions + noise, fps, up=clean.up))
    off = np.abs(repaired.recording.positions - clean.positions)
    within = [(off < many * repaired.std[:, :, None]).mean() for many in (1.0, 1.96)]
    assert 0.55 < within[0] < 0.85
    assert within[1] > 0.85
