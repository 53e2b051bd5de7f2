"""Markers that are elsewhere for a frame or two beside a gap."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.leapt_back import leapt_back
from motionmend.samples import markers
from performers import truth

FPS = 120.0


def _recorded(seed=9, noise=0.001):
    clean = markers(truth("walk", seed, 4.0, FPS))
    shaken = clean.positions + noise * np.random.default_rng(seed).standard_normal(clean.positions.shape)
    return clean, clean.with_positions(shaken)


def _with_gaps(recording, seed, away, frames=1, left=20, length=90, many=6):
    """The recording with a gap of some markers, `left` frames before its end, after which each is off by `away` m."""
    rng = np.random.default_rng(seed)
    positions, off = recording.positions.copy(), np.zeros(recording.present.shape, dtype=bool)
    stop = recording.frames - left
    for marker in rng.choice(len(recording.names), many, replace=False):
        along = rng.standard_normal((frames, 3))
        positions[stop - length : stop, marker] = np.nan
        positions[stop : stop + frames, marker] += away * along / np.linalg.norm(along, axis=1, keepdims=True)
        off[stop : stop + frames, marker] = away > 0.0
    return recording.with_positions(positions), off


@pytest.mark.parametrize("seed", [1, 2])
def test_a_gap_is_not_filled_from_a_lone_sample_that_is_elsewhere(seed):
    clean, shaken = _recorded(seed)
    bad, off = _with_gaps(shaken, seed, 0.2)
    repaired = repair_without_model(bad)
    errors = np.linalg.norm(repaired.recording.positions - clean.positions, axis=2)
    assert errors[~bad.present].max() < 0.02  # as it was 0.2
    assert (repaired.origin[off] == Origin.REPAIRED).all()
    assert (repaired.origin[bad.present & ~off] == Origin.MEASURED).mean() > 0.999
    assert any("leapt away" in warning for warning in repaired.warnings)


@pytest.mark.parametrize("frames", [1, 2])
@pytest.mark.parametrize("backward", [False, True])
def test_one_or_two_samples_are_found_on_either_side_and_no_others(frames, backward):
    _, shaken = _recorded()
    bad, off = _with_gaps(shaken, 3, 0.2, frames)
    if backward:
        bad, off = bad.with_positions(bad.positions[::-1].copy()), off[::-1]
    assert (leapt_back(bad) == off).all()


@pytest.mark.parametrize("seed", range(4))
def test_who_comes_back_where_it_is_to_be_is_left(seed):
    _, shaken = _recorded(seed, 0.004)
    bad, _ = _with_gaps(shaken, seed, 0.0)
    assert not leapt_back(bad).any()


def test_what_goes_on_as_wildly_or_is_seen_too_briefly_is_left():
    _, shaken = _recorded()
    wild, _ = _with_gaps(shaken, 3, 0.2, 8)
    assert not leapt_back(wild).any()
    brief, _ = _with_gaps(shaken, 3, 0.2, 1, left=4)
    assert not leapt_back(brief).any()


def test_a_marker_that_is_never_or_always_seen_says_nothing():
    _, shaken = _recorded()
    positions = shaken.positions.copy()
    positions[:, 0] = np.nan
    assert not leapt_back(shaken.with_positions(positions)).any()
