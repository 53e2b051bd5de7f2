"""Frames in which no marker is seen at all, before the first, after the last or between."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.gaps.unseen_frames import between, farther_each_frame
from motionmend.io import read
from motionmend.samples import markers
from performers import truth

FPS = 60.0


def thinned(recording):
    """Every fourth marker: still some on every limb, and where none is seen it does not matter how many there are."""
    return Markers(recording.names[::4], recording.positions[:, ::4], recording.fps, up=recording.up)


@cache
def performed(action, seconds):
    """A performance and the same with noise of a millimetre."""
    clean = thinned(markers(truth(action, 4, seconds, FPS)))
    shaken = clean.positions + 0.001 * np.random.default_rng(4).standard_normal(clean.positions.shape)
    return clean, clean.with_positions(shaken)


@cache
def said_of_the_whole(action, seconds):
    return repair_without_model(performed(action, seconds)[1]).warnings


@given(st.integers(0, 10**6), st.integers(1, 20))
@settings(max_examples=30)
def test_how_far_points_get_is_that_of_a_line_or_of_staying(seed, count):
    rng = np.random.default_rng(seed)
    start, speed = rng.normal(size=(2, 4, 3))
    steady = start + speed * np.arange(40)[:, None, None]
    np.testing.assert_allclose(farther_each_frame(steady, count), 0.0, atol=1e-12)
    shaken = 0.1 * rng.normal(size=(400, 4, 3))  # of what stays, two draws differ by the root of two
    np.testing.assert_allclose(farther_each_frame(shaken, count), 0.1 * np.sqrt(2.0), rtol=0.15)
    walk = np.cumsum(rng.normal(size=(60, 4, 3)), axis=0)
    off = farther_each_frame(walk, count)
    assert (np.diff(off, axis=0) >= 0.0).all()
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    np.testing.assert_allclose(farther_each_frame(walk @ turn.T + 3.0, count), off, rtol=1e-9)


def test_a_recording_too_short_goes_on_in_proportion_and_what_is_missing_stays_unknown():
    walk = np.cumsum(np.random.default_rng(0).normal(size=(6, 2, 3)), axis=0)
    walk[:, 1] = np.nan
    off = farther_each_frame(walk, 20)
    assert off.shape == (20, 2)
    assert off[19, 0] == pytest.approx(off[4, 0] * 20 / 5)
    assert np.isnan(off[:, 1]).all()
    assert np.isnan(farther_each_frame(walk[:1], 3)).all()


@given(st.integers(0, 10**6), st.integers(1, 20))
@settings(max_examples=30)
def test_how_far_points_are_from_the_way_across_is_that_of_a_line_or_a_cubic(seed, count):
    rng = np.random.default_rng(seed)
    start, speed, turn = rng.normal(size=(3, 2, 3))
    time = np.arange(60)[:, None, None] / 30.0
    np.testing.assert_allclose(between(start + speed * time, count), 0.0, atol=1e-12)
    bent = start + speed * time + turn * time**2
    straight = np.arange(1, count + 1) * np.arange(count, 0, -1) / 900.0  # how far a parabola is from its chord
    assert (between(bent, count) <= straight[:, None] * np.sqrt(np.square(turn).mean(axis=1)) + 1e-12).all()
    walk = np.cumsum(rng.normal(size=(60, 2, 3)), axis=0)
    assert between(walk, count) == pytest.approx(between(walk[::-1], count)[::-1])
    other = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    np.testing.assert_allclose(between(walk @ other.T + 3.0, count), between(walk, count), rtol=1e-9)


def test_what_is_seen_nowhere_for_so_long_is_off_as_it_moves_ahead_of_the_nearer_end():
    walk = np.cumsum(np.random.default_rng(0).normal(size=(12, 2, 3)), axis=0)
    off, ahead = between(walk, 9), farther_each_frame(walk, 5)
    np.testing.assert_allclose(off, ahead[[0, 1, 2, 3, 4, 3, 2, 1, 0]])


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump", "reach", "turn"])
@pytest.mark.parametrize("frames", [10, 20, 40])
def test_what_is_filled_where_no_marker_is_seen_is_as_unsure_as_it_is_wrong(action, frames):
    clean, noisy = performed(action, 6.0)
    shaken = noisy.positions.copy()
    gone = (np.array([[50], [150], [250]]) + np.arange(frames)).ravel()
    shaken[gone] = np.nan
    told = repair_without_model(clean.with_positions(shaken))
    filled = told.origin[gone] == Origin.FILLED
    assert filled.mean() > 0.9
    off = np.abs(told.recording.positions - clean.positions)[gone]
    assert (off < 1.96 * told.std[gone][:, :, None])[filled].mean() > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump", "reach", "turn"])
@pytest.mark.parametrize("end", ["first", "last"])
def test_what_is_filled_there_is_as_unsure_as_it_is_wrong_and_that_is_said(action, end):
    clean, noisy = performed(action, 5.0)
    shaken = noisy.positions.copy()
    gone = slice(0, 15) if end == "first" else slice(-15, None)
    shaken[gone] = np.nan
    told = repair_without_model(clean.with_positions(shaken))
    filled = told.origin[gone] == Origin.FILLED
    assert filled.mean() > 0.9
    off = np.abs(told.recording.positions - clean.positions)[gone]
    assert (off < 1.96 * told.std[gone][:, :, None])[filled].mean() > 0.8
    assert any(f"no marker is seen in the {end} 15 frames" in said for said in told.warnings)
    assert not any("no marker is seen" in said for said in said_of_the_whole(action, 5.0))


@cache
def whole_walk(file):
    return repair_without_model(thinned(read(file))).recording


def walks_through(data, name, share):
    """A real walk, whole, and the same seen only in the middle of its way, so much of it left out at either end."""
    walk = whole_walk(data / "mocap" / "c3d" / f"{name}.c3d")
    along = np.ptp(np.nanmedian(walk.positions, axis=1), axis=0)[:2].argmax()
    low, high = np.quantile(np.nanmedian(walk.positions, axis=1)[:, along], [share, 1.0 - share])
    gone = (walk.positions[..., along] < low) | (walk.positions[..., along] > high)
    return walk, walk.with_positions(np.where(gone[..., None], np.nan, walk.positions)), gone


@pytest.mark.slow
@pytest.mark.parametrize(("name", "share"), [("cmu_02_01", 0.1), ("cmu_02_01", 0.22)])
def test_who_walks_into_view_is_as_unsure_before_as_what_is_made_up_is_wrong(data, name, share):
    walk, part, gone = walks_through(data, name, share)
    found = repair_without_model(part)
    assert any("come into view late or leave it early" in said for said in found.warnings)
    away = np.abs(found.recording.positions - walk.positions)[gone] / found.std[gone][:, None]
    away = away[np.isfinite(away)]
    assert (away < 1.0).mean() > 0.6
    assert (away < 1.96).mean() > 0.78


@pytest.mark.slow
def test_nothing_is_said_where_everybody_is_in_view(data):
    walk, _, _ = walks_through(data, "cmu_02_01", 0.1)
    assert not any("into view" in said for said in repair_without_model(walk).warnings)
