"""Clips that are spoiled themselves are repaired before a model learns from them; clean ones are not touched."""

from dataclasses import replace

import numpy as np
import pytest

import motionmend as mm
from motionmend import samples
from motionmend.bodies.motion import Markers, Motion
from motionmend.denoise.spoiled_clips import Spoiled, looks_spoiled, told, unspoiled
from motionmend.io import read
from performers import every_other, truth


def _off(one: Motion | Markers, other: Motion | Markers) -> float:
    """Root mean square, degrees or cm, where both are there."""
    apart = one.values[..., 6:] - other.values[..., 6:] if isinstance(one, Motion) else one.values - other.values
    scale = np.degrees(1.0) if isinstance(one, Motion) else 100.0
    return float(scale * np.sqrt(np.nanmean(np.square(apart))))


@pytest.mark.slow
@pytest.mark.parametrize("action", samples.ACTIONS)
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_clean_clip_is_not_touched(action, fps):
    motion = samples.clip(action, seconds=4.0, fps=fps, seed=3)
    for clip in (motion, samples.markers(motion)):
        cleaned, found = unspoiled(clip)
        assert cleaned is clip
        assert found is None


@pytest.mark.slow
def test_no_real_clip_looks_spoiled(data):
    for path in sorted((data / "mocap").rglob("*.*")):
        if path.suffix not in {".amc", ".bvh", ".c3d"}:
            continue
        clip = read(path)
        for every in (1, 2, 4, 8):
            fps = clip.fps / every
            assert fps < 14.0 or not looks_spoiled(replace(clip.at_frames(slice(None, None, every)), fps=fps)), path


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "outliers"), [(1.0, 0.0), (0.0, 0.01), (3.0, 0.05)])
def test_noise_and_outliers_of_a_clip_go_and_are_told(noise, outliers):
    motion = truth("walk")
    units = {Motion: np.radians(noise), Markers: 0.005 * noise}
    for clip in (motion, samples.markers(motion)):
        bad = mm.corrupt(clip, noise=units[type(clip)], outliers=outliers, seed=5).recording
        cleaned, found = unspoiled(bad)
        assert found is not None
        assert found.outliers == pytest.approx(outliers, abs=0.2 * outliers + 0.002)
        assert found.noise == pytest.approx(noise * (1.0 if clip is motion else 0.5), rel=0.15, abs=0.06)
        assert _off(cleaned, clip) < 0.6 * _off(bad, clip)


@pytest.mark.slow
def test_what_is_missing_in_a_clip_is_not_made_up():
    motion = truth("walk", seconds=3.0)
    for clip in (motion, every_other(samples.markers(motion))):
        bad = mm.corrupt(clip, noise=np.radians(2.0) if clip is motion else 0.006, gaps=0.2, seed=7).recording
        cleaned, found = unspoiled(bad)
        assert found is not None
        assert not (cleaned.present & ~bad.present).any()
        assert cleaned.present.sum() > 0.99 * bad.present.sum()


@pytest.mark.slow
def test_a_model_of_spoiled_clips_is_about_as_good_as_one_of_clean_ones():
    clips = [samples.clip("walk", seconds=3.0, fps=30.0, seed=seed) for seed in range(2)]
    bad = [mm.corrupt(clip, noise=np.radians(2.0), outliers=0.05, seed=k).recording for k, clip in enumerate(clips)]
    seen = samples.clip("walk", seconds=3.0, fps=30.0, seed=9)
    recording = mm.corrupt(seen, noise=np.radians(1.0), outliers=0.1, seed=11).recording
    clean, spoiled, repaired = (
        _off(mm.Denoiser().fit(some).repair(recording).recording, seen)
        for some in (clips, bad, [unspoiled(clip)[0] for clip in bad])
    )
    assert clean < repaired < clean + 0.4 * (spoiled - clean)


def test_how_badly_is_one_sentence():
    assert told([Spoiled(1.234, 0.05)], "degrees").startswith("noise of 1.2 degrees and 5 % outliers: repaired")
    assert "0.3 cm and 1 % outliers at most" in told([Spoiled(0.3, 0.0), Spoiled(0.1, 0.01)], "cm")
    assert told([Spoiled(float("nan"), 0.05)], "cm").startswith("5 % outliers: repaired")
