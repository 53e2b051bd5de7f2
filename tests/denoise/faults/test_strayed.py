"""Markers that stray beside a gap, and gaps that somebody filled by straight lines."""

from dataclasses import replace

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults import strayed as straying
from motionmend.denoise.faults.drawn_lines import drawn_lines
from motionmend.denoise.faults.strayed import strayed
from motionmend.samples import markers
from performers import truth

FPS = 120.0
NOISE = 0.0003


def _recorded(seed=9, noise=NOISE):
    clean = markers(truth("walk", seed, 4.0, FPS))
    shaken = clean.positions + noise * np.random.default_rng(seed).standard_normal(clean.positions.shape)
    return clean, clean.with_positions(shaken)


def _with_gaps(recording, seed, away, frames=5, length=40, many=8):
    """The recording with gaps of single markers, off by up to `away` m beside them; where it is off."""
    rng = np.random.default_rng(seed)
    positions, off = recording.positions.copy(), np.zeros(recording.present.shape, dtype=bool)
    for marker in rng.choice(len(recording.names), many, replace=False):
        first = int(rng.integers(40, recording.frames - length - 40))
        along = rng.standard_normal(3)
        ramp = np.outer(np.arange(1, frames + 1) / frames, away * along / np.linalg.norm(along))
        before, after = slice(first - frames, first), slice(first + length, first + length + frames)
        positions[before, marker] += ramp
        positions[after, marker] += ramp[::-1]
        off[before, marker] = off[after, marker] = away > 0.0
        positions[first : first + length, marker] = np.nan
    return recording.with_positions(positions), off


def _with_lines(recording, seed, length=40, many=6):
    rng = np.random.default_rng(seed)
    positions, drawn = recording.positions.copy(), np.zeros(recording.present.shape, dtype=bool)
    for marker in rng.choice(len(recording.names), many, replace=False):
        first = int(rng.integers(5, recording.frames - length - 5))
        part = np.linspace(0.0, 1.0, length + 2)[1:-1, None]
        positions[first : first + length, marker] = (1.0 - part) * positions[first - 1, marker] + part * positions[
            first + length, marker
        ]
        drawn[first : first + length, marker] = True
    return recording.with_positions(positions.astype(np.float32).astype(np.float64)), drawn


def _errors(clean, repaired):
    return np.linalg.norm(repaired.recording.positions - clean.positions, axis=2)


@pytest.mark.parametrize("seed", [1, 2])
def test_what_strays_beside_gaps_is_repaired_and_said(seed):
    clean, shaken = _recorded(seed)
    bad, off = _with_gaps(shaken, seed, 0.03)
    repaired = repair_without_model(bad)
    gone = ~bad.present
    assert np.sqrt(np.square(_errors(clean, repaired)[gone]).mean()) < 0.006  # as it was 0.02
    assert (repaired.origin[off] == Origin.REPAIRED).mean() > 0.7
    assert (repaired.origin[~off & ~gone] == Origin.MEASURED).mean() > 0.999
    assert any("stray beside a gap" in warning for warning in repaired.warnings)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_honest_samples_beside_gaps_are_left(seed):
    _, shaken = _recorded(seed, 0.001)
    bad, _ = _with_gaps(shaken, seed, 0.0)
    std = np.full(bad.present.shape, 0.001)
    assert not strayed(bad.positions, std, ~bad.present, FPS).any()


@pytest.mark.parametrize(("home", "strays"), [(0.001, True), (0.006, False)])
def test_who_strayed_is_back_and_who_moves_as_nowhere_else_stays_away(monkeypatch, home, strays):
    """A finger was 6 to 15 mm from where the hand had it all along, and lost its samples next to the gap."""
    away = np.full((200, 3), np.nan)
    away[110:120, 1] = np.r_[0.015, 0.012, 0.010, np.full(7, home)]
    monkeypatch.setattr(straying, "away_and_doubt", lambda *_: (away, np.full(away.shape, 0.0035)))
    positions = np.zeros((200, 3, 3))
    positions[80:110, 1] = np.nan
    missing = np.isnan(positions[..., 0])
    found = strayed(positions, np.full(missing.shape, 0.001), missing, FPS)
    assert found[110:113, 1].all() == strays
    assert found.sum() == 3 * strays


def test_where_nothing_is_missing_nothing_strays():
    _, shaken = _recorded()
    std = np.full(shaken.present.shape, NOISE)
    assert not strayed(shaken.positions, std, ~shaken.present, FPS).any()


@pytest.mark.parametrize("seed", [1, 2])
def test_lines_drawn_across_gaps_are_taken_for_gaps_and_said(seed):
    clean, shaken = _recorded(seed)
    bad, drawn = _with_lines(shaken, seed)
    off = drawn & (np.linalg.norm(bad.positions - clean.positions, axis=2) > 0.01)
    repaired = repair_without_model(bad)
    assert off.sum() > 50
    assert _errors(clean, repaired)[off].max() < 0.01
    assert any("straight lines" in warning for warning in repaired.warnings)


@pytest.mark.parametrize("step", [0.0001, 0.001])
def test_rounded_recordings_lie_on_no_lines(step):
    clean, _ = _recorded()
    rounded = clean.with_positions(np.round(clean.positions / step) * step)
    std = np.full(rounded.present.shape, NOISE)
    assert not drawn_lines(rounded, rounded.positions, std).any()


def test_who_stands_is_on_no_line():
    clean, _ = _recorded()
    still = clean.with_positions(np.broadcast_to(clean.positions[:1], clean.positions.shape).copy())
    assert not drawn_lines(still, still.positions, np.full(still.present.shape, NOISE)).any()


def test_a_few_frames_are_too_few_to_tell():
    _, shaken = _recorded()
    few = replace(shaken, positions=shaken.positions[:12], residuals=None)
    bad = few.with_positions(np.where(np.arange(12)[:, None, None] == 5, np.nan, few.positions))
    std = np.full(bad.present.shape, NOISE)
    assert not strayed(bad.positions, std, ~bad.present, FPS).any()
    assert not drawn_lines(few, few.positions, std).any()
