"""Markers that leap away from their place for a while and back."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import motionmend as mm
from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.faults import displaced as room
from motionmend.denoise.faults.displaced import displaced
from motionmend.samples import markers
from performers import clips, truth

SEEDS = st.integers(0, 10**6)
FPS = 60.0
ACTIONS = ("walk", "run", "jump", "reach", "turn")


def _recorded(action="walk", seed=9, noise=0.001, seconds=5.0):
    clean = markers(truth(action, seed, seconds, FPS))
    shaken = clean.positions + noise * np.random.default_rng(seed).standard_normal(clean.positions.shape)
    return clean, clean.with_positions(shaken)


def _halved(recording):
    """Every other marker: still two and more on a segment."""
    return Markers(recording.names[::2], recording.positions[:, ::2], recording.fps, up=recording.up)


def _away(recording, stretches, shift):
    """The recording with markers off by `shift` m in stretches (marker, first, last), and where."""
    positions, off = recording.positions.copy(), np.zeros(recording.present.shape, dtype=bool)
    for marker, first, last in stretches:
        positions[first : last + 1, marker] += shift
        off[first : last + 1, marker] = True
    return recording.with_positions(positions), off


def _direction(rng):
    along = rng.standard_normal(3)
    return along / np.linalg.norm(along)


@pytest.mark.slow
@given(SEEDS, st.sampled_from(ACTIONS), st.integers(6, 60), st.floats(0.08, 0.3))
@settings(max_examples=25)
def test_a_marker_off_for_a_while_is_found_and_no_other(seed, action, length, size):
    rng = np.random.default_rng(seed)
    _, shaken = _recorded(action)
    first, marker = int(rng.integers(5, shaken.frames - length - 5)), int(rng.integers(len(shaken.names)))
    bad, off = _away(shaken, [(marker, first, first + length - 1)], size * _direction(rng))
    found = displaced(bad.positions, FPS)
    assert (found & off).sum() >= 0.9 * off.sum()
    assert (found & ~off).sum() <= 2


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=10)
def test_a_marker_that_flickers_between_two_places_is_where_it_is_at_home(seed):
    rng = np.random.default_rng(seed)
    _, shaken = _recorded()
    marker, shift = int(rng.integers(len(shaken.names))), 0.15 * _direction(rng)
    frames = 100 + np.flatnonzero(rng.random(60) < 0.5)
    bad, off = _away(shaken, [(marker, t, t) for t in frames], shift)
    found = displaced(bad.positions, FPS)
    assert (found & off).sum() >= 0.9 * off.sum()
    assert (found & ~off).sum() <= 3


@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.01])
def test_nothing_is_found_where_nothing_is_off(action, noise):
    assert displaced(_recorded(action, noise=noise)[1].positions, FPS).mean() < 1e-3


def test_who_is_elsewhere_for_half_of_the_recording_may_be_at_home_there():
    _, shaken = _recorded()
    bad, _ = _away(shaken, [(3, shaken.frames // 2, shaken.frames - 1)], np.array([0.2, 0.0, 0.0]))
    assert not displaced(bad.positions, FPS).any()


def test_the_same_is_found_elsewhere_and_facing_elsewhere():
    _, shaken = _recorded()
    bad, _ = _away(shaken, [(3, 40, 70), (12, 150, 190)], np.array([0.1, 0.1, -0.1]))
    turn = Rotation.from_rotvec([0.3, -1.2, 2.0]).as_matrix()
    found = displaced(bad.positions, FPS)
    assert found.sum() == 31 + 41
    np.testing.assert_array_equal(displaced(bad.positions @ turn.T + [3.0, -7.0, 1.0], FPS), found)


def test_a_long_recording_is_looked_through_in_parts(monkeypatch):
    _, shaken = _recorded(seconds=12.0)
    bad, off = _away(shaken, [(3, 340, 375), (12, 600, 640)], np.array([0.1, 0.1, -0.1]))
    monkeypatch.setattr(room, "PIECE", 360)
    np.testing.assert_array_equal(displaced(bad.positions, FPS), off)


@pytest.mark.parametrize("frames", [0, 1, 3, 30, 60])
def test_few_frames_and_missing_markers(frames):
    positions = np.random.default_rng(0).standard_normal((frames, 5, 3))
    positions[:, 2] = np.nan
    assert displaced(positions, FPS).shape == (frames, 5)
    assert not displaced(np.full((frames, 5, 3), np.nan), FPS).any()


@cache
def _halved_model():
    return Denoiser(window=20, fps=30.0).fit([_halved(markers(motion)) for motion in clips()])


@cache
def _said_of_the_shaken():
    return repair_without_model(_halved(_recorded()[1])).warnings


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
def test_it_is_repaired_and_said(taught):
    clean, shaken = (_halved(recording) for recording in _recorded())
    bad, off = _away(shaken, [(3, 40, 70), (12, 150, 190)], np.array([0.1, 0.1, -0.1]))
    outcome = _halved_model().repair(bad) if taught else repair_without_model(bad)
    error = np.linalg.norm(outcome.recording.positions - clean.positions, axis=2)
    assert error[off].max() < 0.03
    assert (outcome.origin[off] == Origin.REPAIRED).all()
    # per coordinate: two of three errors within one deviation, or it is too cautious
    assert (error[off] / np.sqrt(3.0) < outcome.std[off]).mean() > 0.5
    assert any("leapt away" in said and clean.names[3] in said and clean.names[12] in said for said in outcome.warnings)
    assert not any("leapt away" in said for said in _said_of_the_shaken())


def _look_among_dropouts(shaken, seed, share):
    """One marker leaps away in a recording of which a share is missing: it is found, and no other with or without."""
    rng = np.random.default_rng(seed)
    bad, off = _away(shaken, [(int(rng.integers(len(shaken.names))), 80, 110)], 0.2 * _direction(rng))
    dropped = rng.random(off.shape) < share
    for recording, wanted in ((shaken, np.zeros_like(off)), (bad, off & ~dropped)):
        found = displaced(np.where(dropped[:, :, None], np.nan, recording.positions), FPS)
        assert (found & wanted).sum() >= 0.9 * wanted.sum()
        assert (found & ~wanted).sum() <= 2


@pytest.mark.slow
@given(SEEDS, st.sampled_from(ACTIONS), st.floats(0.05, 0.3))
@settings(max_examples=15)
def test_scattered_dropouts_put_no_marker_elsewhere_and_hide_none(seed, action, share):
    _look_among_dropouts(_halved(_recorded(action)[1]), seed, share)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [256, 10])
def test_a_marker_that_drops_out_as_it_leaps_is_not_hidden_by_it(seed):
    _look_among_dropouts(_recorded("reach")[1], seed, 0.25)


@pytest.mark.slow
def test_fast_feet_and_wrists_that_drop_out_are_not_elsewhere(data):
    whole = mm.read(data / "mocap" / "c3d" / "cmu_135_02.c3d")
    assert isinstance(whole, mm.Markers)
    rng = np.random.default_rng(0)
    kick = whole.positions[1000:1400, :41] + 0.001 * rng.standard_normal((400, 41, 3))
    for share in (0.1, 0.3):
        dropped = rng.random(kick.shape[:2]) < share
        assert not displaced(np.where(dropped[:, :, None], np.nan, kick), whole.fps).any()


def test_gaps_do_not_hide_it():
    _, shaken = _recorded()
    bad, off = _away(shaken, [(3, 40, 70)], np.array([0.1, 0.1, -0.1]))
    positions = bad.positions.copy()
    positions[30:40, 3] = np.nan
    positions[50:55, 3] = np.nan
    there = np.isfinite(positions).all(axis=2)
    np.testing.assert_array_equal(displaced(positions, FPS), off & there)


@pytest.mark.slow
@given(SEEDS, st.sampled_from(("walk", "turn", "reach")), st.integers(12, 60))
@settings(max_examples=15, deadline=None)
def test_what_comes_back_elsewhere_between_two_gaps_is_found_though_no_leap_is_seen(seed, action, length):
    rng = np.random.default_rng(seed)
    _, shaken = _recorded(action)
    first, marker = int(rng.integers(20, shaken.frames - length - 20)), int(rng.integers(len(shaken.names)))
    bad, off = _away(shaken, [(marker, first, first + length - 1)], 0.2 * _direction(rng))
    positions = bad.positions.copy()
    positions[first - 8 : first, marker] = positions[first + length : first + length + 8, marker] = np.nan
    found = displaced(positions, FPS)
    assert (found & off).sum() >= 0.9 * off.sum()
    assert (found & ~off).sum() <= 2


@pytest.mark.slow
def test_what_is_as_far_from_those_about_it_as_ever_is_not_elsewhere(data):
    """A part of CMU's 135_02 in which an arm is held as nowhere else in it: 134 good samples were replaced."""
    whole = mm.read(data / "mocap" / "c3d" / "cmu_135_02.c3d")
    for first, last in ((2810, 3500), (10, 700)):
        assert not displaced(whole.positions[first:last], whole.fps).any()


@pytest.mark.slow
def test_what_is_cleared_by_its_distances_guides_no_other(data):
    """HDM05's first take at 30 Hz: 24 good samples of a finger were replaced."""
    assert not displaced(mm.read(data / "mocap" / "c3d" / "hdm05_bd_01-02_01_120.c3d").positions[:1600:4], 30.0).any()


@pytest.mark.slow
def test_gaps_of_real_markers_put_hardly_any_elsewhere(data):
    hidden = found = 0
    for name in ("cmu_02_01", "cmu_05_13", "gt_squat", "hdm05_bd_01-02_01_120"):
        positions = mm.read(data / "mocap" / "c3d" / f"{name}.c3d").positions[:1500].copy()
        rng = np.random.default_rng(4)
        for marker in np.flatnonzero(rng.random(positions.shape[1]) < 0.3):
            for start in rng.integers(0, len(positions) - 60, 4):
                positions[start : start + 60, marker] = np.nan
        found += int(displaced(positions, 120.0).sum())
        hidden += int(np.isnan(positions).any(axis=2).sum())
    assert found <= 0.01 * hidden


@pytest.mark.slow
def test_what_a_few_guides_tell_of_a_stretch_that_nobody_saw_leap_is_not_elsewhere(data):
    """A dance at 60 Hz with gaps in 30 % of its markers: 48 good samples of a heel were replaced."""
    dance = mm.read(data / "mocap" / "c3d" / "cmu_05_13.c3d").positions[400:1000:2, :41].copy()
    rng = np.random.default_rng(22)
    for marker in np.flatnonzero(rng.random(41) < 0.3):
        for start in rng.integers(0, len(dance) - 60, 4):
            dance[start : start + 60, marker] = np.nan
    assert not displaced(dance, 60.0).any()
