"""A single channel that rattles for a moment is told from motion, from lone outliers and from common noise."""

import numpy as np
import pytest

import motionmend as mm
from motionmend.denoise.noise.rattling import rattles

FPS, FRAMES, CHANNELS = 120.0, 400, 30


@pytest.fixture
def measured():
    """(T, C) degrees: swings with a little noise."""
    rng = np.random.default_rng(4)
    time = np.arange(FRAMES)[:, None] / FPS
    swing = 30.0 * np.sin(2.0 * np.pi * rng.uniform(1.0, 4.0, CHANNELS) * time + rng.uniform(0.0, 6.0, CHANNELS))
    return swing + 0.3 * rng.standard_normal(swing.shape)


def test_where_and_how_loud(measured):
    measured[100:130, 7] += 15.0 * np.random.default_rng(1).standard_normal(30)
    found = rattles(measured, FPS)
    assert (found[102:128, 7] > 0).all()
    assert np.median(found[102:128, 7]) == pytest.approx(15.0, rel=0.4)
    assert not np.delete(found, 7, axis=1).any()
    assert not found[:94, 7].any()
    assert not found[135:, 7].any()


def test_a_marker_rattles_as_a_whole(measured):
    measured[100:130, 7] += 15.0 * np.random.default_rng(1).standard_normal(30)
    found = rattles(measured, FPS, 3)
    assert (found[102:128, 6:9] > 0).all()
    assert not np.delete(found, [6, 7, 8], axis=1).any()


def test_none_in_motion_lone_outliers_slips_and_common_noise(measured):
    assert not rattles(measured, FPS).any()
    rng = np.random.default_rng(5)
    lone = measured + 40.0 * (rng.random(measured.shape) < 0.02)
    assert (rattles(lone, FPS) > 0).mean() < 0.002
    slipped = measured.copy()
    slipped[100:130, 7] += 40.0
    assert not rattles(slipped, FPS).any()
    assert not rattles(measured + 5.0 * rng.standard_normal(measured.shape), FPS).any()


def test_a_joint_that_rattles_is_repaired():
    clean = mm.samples.clip("walk", seconds=4, fps=120.0, seed=3)
    rng = np.random.default_rng(0)
    bad = clean.q + np.radians(0.3) * rng.standard_normal(clean.q.shape) * (np.ptp(clean.q, axis=0) > 1e-3)
    knee = next(c for c, name in enumerate(clean.channels) if "tibia" in name or "knee" in name.lower())
    bad[200:236, knee] += np.radians(18.0) * rng.standard_normal(36)
    repaired = mm.repair_without_model(clean.with_q(bad), "adaptive")
    off = np.degrees(repaired.recording.q - clean.q)[202:234, knee]
    assert np.sqrt(np.square(off).mean()) < 4.0  # before: as it was, 17
    assert (repaired.origin[202:234, knee] == mm.Origin.REPAIRED).all()
    assert (np.abs(off) < 2.5 * np.degrees(repaired.std[202:234, knee])).mean() > 0.8
