"""Noise that was smoothed before is told from motion and from other noise."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

import motionmend as mm
from motionmend.denoise.noise.band_limited import band_limited_by_distances, band_limited_noise
from motionmend.denoise.noise.trembling import trembling
from performers import lessened

FRAMES, CHANNELS = 600, 20


def smoothed(rng, shape, fps, edge=10.0):
    """Noise of variance one, smoothed down to `edge` Hz as motion usually is (Butterworth, forward and back)."""
    noise = sosfiltfilt(butter(2, edge / (0.5 * fps), output="sos"), rng.standard_normal(shape), axis=0)
    return noise / noise.std()


def motion(rng, fps):
    """(T, C) degrees: swings of up to one a second."""
    time = np.arange(FRAMES)[:, None] / fps
    pace, phase = rng.uniform(0.3, 1.0, CHANNELS), rng.uniform(0.0, 6.0, CHANNELS)
    return 20.0 * np.sin(2.0 * np.pi * pace * time + phase)


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_how_loud_it_is_and_how_smooth_is_told(fps):
    rng = np.random.default_rng(2)
    measured = motion(rng, fps) + 3.0 * smoothed(rng, (FRAMES, CHANNELS), fps)
    measured[100:200, 4], measured[:, 5], measured[:, 3] = np.nan, np.nan, 5.0
    found = band_limited_noise(measured, fps)
    assert found is not None
    assert found.variance[3] == found.variance[5] == 0.0
    assert np.sqrt(np.median(np.delete(found.variance, [3, 5]))) == pytest.approx(3.0, rel=0.2)
    assert found.edge * fps / (2.0 * np.pi) == pytest.approx(10.0, rel=0.4)
    of_bends = np.square(np.diff(3.0 * smoothed(rng, (FRAMES, 1), fps), n=2, axis=0)).mean()
    assert np.median(found.of_bends(1)) == pytest.approx(of_bends, rel=0.8)  # which goes with the fourth power of it
    assert np.median(found.in_band) > 9.0


@pytest.mark.parametrize("times", [2, 4])
def test_noise_that_a_spline_carried_to_more_frames_is_as_loud_as_it_was(times):
    # cubics have next to no fourth differences over short lags: it was taken for 20 degrees and more below 10 Hz
    rng, fps = np.random.default_rng(2), 120.0
    few = motion(rng, fps)[::times] + rng.standard_normal((FRAMES // times, CHANNELS))
    measured = CubicSpline(np.arange(len(few)), few)(np.arange(times * (len(few) - 1) + 1) / times)
    found = band_limited_noise(measured, fps)
    assert found is not None
    assert np.sqrt(np.median(found.variance)) == pytest.approx(1.0, rel=0.2)
    assert found.edge == pytest.approx(np.pi / times, rel=0.25)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_motion_noise_that_is_new_in_every_frame_and_what_is_too_faint_or_short_are_none(fps):
    rng = np.random.default_rng(2)
    clean, faint = motion(rng, fps), 0.3 * smoothed(rng, (FRAMES, CHANNELS), fps)
    for measured in (clean, clean + 2.0 * rng.standard_normal(clean.shape), clean + faint, clean[:30] + faint[:30]):
        assert band_limited_noise(measured, fps) is None
    assert band_limited_noise(np.full((FRAMES, CHANNELS), np.nan), fps) is None


def tremble(rng, fps, channels=CHANNELS):
    """(T, C) degrees: a tremor of about 5 Hz that comes and goes, as Parkinson's does."""
    pace = 5.0 + 0.3 * np.cumsum(rng.standard_normal((FRAMES, 1)), axis=0) / np.sqrt(FRAMES)
    size = 1.0 + 0.4 * np.sin(2.0 * np.pi * np.arange(FRAMES)[:, None] / fps / 3.0)
    return 3.0 * size * np.sin(2.0 * np.pi * np.cumsum(pace, axis=0) / fps + rng.uniform(0.0, 6.0, channels))


def test_who_trembles_is_seen_among_samples_that_are_far_off():
    rng, fps = np.random.default_rng(3), 30.0
    spoilt = motion(rng, fps) + tremble(rng, fps) + rng.standard_normal((FRAMES, CHANNELS))
    spoilt[rng.random(spoilt.shape) < 0.1] += 35.0  # louder than all else together
    assert band_limited_noise(spoilt, fps) is None
    assert trembling(spoilt, 0.7 * np.pi, fps)[0]


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_who_trembles_is_no_noise(fps):
    rng = np.random.default_rng(2)
    body = motion(rng, fps)
    everybody = body + tremble(rng, fps)
    for measured in (everybody, everybody + smoothed(rng, body.shape, fps)):
        assert band_limited_noise(measured, fps) is None
    body[:, 4:] = 0.0  # as where only an arm is measured
    body[:, :4] += tremble(rng, fps, 4)
    assert band_limited_noise(body, fps) is None


@pytest.mark.parametrize(("fps", "frames"), [(60.0, 158), (120.0, 316)])
@pytest.mark.parametrize("loud", [0.0, 1.0])
def test_who_trembles_is_no_noise_where_there_are_too_few_frames_for_a_band_below(fps, frames, loud):
    """It was taken for noise below 13 to 15 Hz, and with it went the tremor: 2.4 degrees off, clean recordings too."""
    rng = np.random.default_rng(2)
    time = np.arange(FRAMES)[:, None] / fps
    swing = 3.0 * np.sin(2.0 * np.pi * 5.0 * time + rng.uniform(0.0, 6.0, CHANNELS))
    measured = motion(rng, fps) + swing + loud * rng.standard_normal((FRAMES, CHANNELS))
    assert band_limited_noise(measured[:frames], fps) is None


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_a_limb_that_trembles_in_noise_is_as_noisy_as_the_others(fps):
    rng = np.random.default_rng(2)
    measured = motion(rng, fps) + 2.0 * smoothed(rng, (FRAMES, CHANNELS), fps)
    measured[:, :4] += 1.5 * tremble(rng, fps, 4)
    measured[200:230, 1] = np.nan
    found = band_limited_noise(measured, fps)
    assert found is not None
    assert (np.sqrt(found.variance[:4]) < 2.5).all()  # with the tremble it looks like 3 to 5
    assert np.sqrt(np.median(found.variance[4:])) == pytest.approx(2.0, rel=0.2)


@pytest.mark.slow
def test_noise_that_was_smoothed_is_lessened_and_deviations_reach_it():
    clean = mm.samples.clip("walk", seconds=3, fps=120.0, seed=3)
    left, off = lessened(clean, np.radians(3.0) * smoothed(np.random.default_rng(0), clean.q.shape, 120.0))
    assert left < 0.75  # before: 1.0
    assert (off < 1.96).mean() > 0.85  # before: 0.05


def test_of_markers_it_is_told_by_their_distances_however_they_move():
    rng, fps = np.random.default_rng(2), 120.0
    motion_only = 100.0 * mm.samples.markers(mm.samples.clip("walk", seconds=4.0, fps=fps, seed=3)).positions
    clean = motion_only.reshape(len(motion_only), -1)
    for measured in (clean, clean + 0.2 * rng.standard_normal(clean.shape), clean[:, :3], clean[:30]):
        assert band_limited_by_distances(measured, fps) is None
    for noise in (0.3 * smoothed(rng, clean.shape, fps), 0.3 * smoothed(rng, clean.shape, fps, edge=20.0)):
        found = band_limited_by_distances(clean + noise, fps)
        assert found is not None
        assert np.sqrt(np.median(found.variance)) == pytest.approx(0.3, rel=0.2)


def test_noise_of_markers_that_a_spline_carried_to_more_frames_is_lessened_and_deviations_reach_it():
    rng = np.random.default_rng(2)
    walk = mm.samples.markers(mm.samples.clip("walk", seconds=3.0, fps=60.0, seed=3))

    def carried(places):
        return CubicSpline(np.arange(len(places)), places)(np.arange(2 * len(places) - 1) / 2.0)

    truth = carried(walk.positions)
    measured = carried(walk.positions + rng.normal(0.0, 0.002, walk.positions.shape))
    repaired = mm.repair_without_model(mm.Markers(names=walk.names, positions=measured, fps=120.0, up=walk.up))
    errors = repaired.recording.positions - truth
    assert np.square(errors).mean() < 0.6**2 * np.square(measured - truth).mean()  # was as good as unchanged
    assert (np.abs(errors) < 2.0 * repaired.std[..., None]).mean() > 0.85  # 0.09
