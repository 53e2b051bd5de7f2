"""Markers that slide slowly are named; those that stay, or leap, or move as bodies do are not."""

import numpy as np
import pytest

from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.slid import FEWEST, slides
from motionmend.samples import markers
from performers import markers_model, truth


def slid(positions, fps, marker, away, first, ramp=0.8, stays=1.0):
    """A marker that leaves its place within `ramp` s, stays away and comes back; first s."""
    t = np.arange(len(positions)) / fps - first
    up, down = np.clip(t / ramp, 0.0, 1.0), np.clip((t - ramp - stays) / ramp, 0.0, 1.0)
    bump = 0.5 * (np.cos(np.pi * down) - np.cos(np.pi * up))
    result = positions.copy()
    result[:, marker] += away * bump[:, None] * np.array([0.6, 0.0, 0.8])
    return result


def found_in(positions, fps, believed=None):
    believed = np.isfinite(positions).all(axis=2) if believed is None else believed
    return slides(positions, believed, fps)


def body(seed=0, noise=0.001):
    walk = markers(truth("walk", seed=5, seconds=6.0))
    return walk, walk.positions + noise * np.random.default_rng(seed).standard_normal(walk.positions.shape)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.005])
def test_nobody_is_named_who_stays(noise):
    walk, positions = body(noise=noise)
    assert found_in(positions, walk.fps) == ()


@pytest.mark.slow
@pytest.mark.parametrize("marker", [0, 7, 12])
def test_who_slides_by_five_centimetres_is_found_with_when_and_how_far(marker):
    walk, positions = body()
    found = found_in(slid(positions, walk.fps, marker, 0.06, 2.0), walk.fps)
    assert [one.marker for one in found] == [marker]
    assert abs(found[0].first / walk.fps - 2.4) < 0.5
    assert abs(found[0].last / walk.fps - 4.2) < 0.5
    assert 0.02 < found[0].away < 0.08


@pytest.mark.slow
def test_it_is_found_wherever_the_body_is_and_with_gaps(rng):
    walk, positions = body()
    there = slid(positions, walk.fps, 7, 0.06, 2.0)
    once = found_in(there, walk.fps)
    moved = found_in(there + np.array([5.0, 1.0, -3.0]), walk.fps)
    assert [one.marker for one in once] == [one.marker for one in moved] == [7]
    assert moved[0].away == pytest.approx(once[0].away, rel=1e-3)
    lost = rng.random(there.shape[:2]) < 0.1  # and filled
    assert [one.marker for one in found_in(there, walk.fps, ~lost)] == [7]
    lost[:, 7] = True
    assert found_in(there, walk.fps, ~lost) == ()


def test_skin_that_moves_by_two_centimetres_is_left_alone():
    walk, positions = body()
    assert found_in(slid(positions, walk.fps, 7, 0.02, 2.0), walk.fps) == ()


def test_few_markers_and_few_frames_tell_nothing():
    walk, positions = body()
    assert found_in(positions[:5], walk.fps) == ()
    assert found_in(slid(positions, walk.fps, 1, 0.1, 2.0)[:, : FEWEST - 1], walk.fps) == ()
    assert found_in(np.full((200, 20, 3), np.nan), 30.0) == ()


@pytest.mark.slow
def test_the_repair_names_it_and_leaves_it():
    walk, positions = body()
    spoilt = walk.with_positions(slid(positions, walk.fps, 7, 0.06, 2.0))
    for repair in (repair_without_model(spoilt, "adaptive"), markers_model().repair(spoilt)):
        said = [one for one in repair.warnings if "may have slid" in one]
        assert len(said) == 1
        assert said[0].startswith(walk.names[7])
    assert not any("slid" in one for one in repair_without_model(walk.with_positions(positions), "adaptive").warnings)
