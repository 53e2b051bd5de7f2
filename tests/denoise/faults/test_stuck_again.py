"""Markers that leap once and stay are named; intact takes and what comes back are not."""

import numpy as np
import pytest

import motionmend as mm
from motionmend.denoise.faults.stuck_again import stuck_again
from motionmend.samples import markers

FPS = 120.0


def take(seed):
    """A walk of 2.5 s, with a little noise."""
    clean = markers(mm.samples.clip("walk", seconds=2.5, fps=FPS, seed=seed))
    shaken = clean.positions + 3e-4 * np.random.default_rng(seed).standard_normal(clean.positions.shape)
    return clean.with_positions(shaken)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_nothing_in_intact_takes_nor_in_what_comes_back(seed):
    positions = take(seed).positions.copy()
    assert not stuck_again(positions, FPS)
    positions[100:180, 3] += [0.0, 0.03, 0.0]
    assert not stuck_again(positions, FPS)


@pytest.mark.slow
def test_most_are_found_to_the_frame_and_no_other_marker_is_named():
    found = tried = 0
    for seed in range(3):
        whole = take(seed)
        for marker in range(0, len(whole.names), 3):
            positions = whole.positions.copy()
            positions[140:, marker] += [0.02, -0.02, 0.02]
            said = [(leap.marker, leap.first) for leap in stuck_again(positions, FPS)]
            assert said in ([], [(marker, 140)])
            found, tried = found + len(said), tried + 1
    assert found > 0.5 * tried


@pytest.mark.slow
def test_it_is_said_with_the_frame():
    whole = take(1)
    for marker in range(len(whole.names)):
        positions = whole.positions.copy()
        positions[140:, marker] += [0.02, -0.02, 0.02]
        if stuck_again(positions, FPS):
            break
    outcome = mm.repair_without_model(whole.with_positions(positions))
    touched = (outcome.origin[150:, marker] != mm.Origin.MEASURED).mean() > 0.5
    said = [warning for warning in outcome.warnings if whole.names[marker] in warning]
    assert touched or any("from frame 140 on" in one and "stuck on again" in one for one in said)
    assert said
