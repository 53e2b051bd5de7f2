"""Markers that fall off are found with when; those that stay, however the body moves, are not."""

from functools import cache

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.faults.fallen import FEWEST, falls
from motionmend.samples import markers
from performers import FPS, clips, truth

GRAVITY = 9.81


def fallen(positions, fps, marker, first):
    """A marker that falls to the floor from a frame on and lies there."""
    result = positions.copy()
    since = np.arange(len(positions) - first) / fps
    height = positions[first, marker, 2]
    result[first:, marker] = positions[first, marker]
    result[first:, marker, 2] = np.maximum(height - 0.5 * GRAVITY * since**2, 0.01)
    return result


def body(kind="walk", seed=0, noise=0.001):
    taken = markers(truth(kind, seed=5, seconds=6.0))
    return taken, taken.positions + noise * np.random.default_rng(seed).standard_normal(taken.positions.shape)


@pytest.mark.parametrize("kind", ["walk", "run", "jump", "reach", "turn"])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_nobody_falls_who_stays(kind, noise):
    taken, positions = body(kind, noise=noise)
    assert falls(positions, taken.fps) == ()


@pytest.mark.parametrize("marker", [0, 7, 12, 20])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_who_falls_is_found_with_when(marker, share):
    walk, positions = body()
    first = round(share * walk.frames)
    found = falls(fallen(positions, walk.fps, marker, first), walk.fps)
    assert [one.marker for one in found] == [marker]
    assert -0.4 < (found[0].first - first) / walk.fps < 0.2
    assert found[0].away > 0.1


def test_it_is_found_among_outliers_and_gaps_and_wherever_the_body_is(rng):
    walk, positions = body()
    there = fallen(positions, walk.fps, 7, walk.frames // 2)
    shown = rng.random(there.shape[:2])
    there[shown < 0.05] += rng.normal(0.0, 0.3, (np.count_nonzero(shown < 0.05), 3))
    there[shown > 0.9] = np.nan
    turned = there @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + np.array([5.0, 1.0, -3.0])
    once, again = falls(there, walk.fps), falls(turned, walk.fps)
    assert [one.marker for one in once] == [7]
    assert [(one.marker, one.first) for one in again] == [(7, once[0].first)]


def test_labels_that_are_swapped_to_the_end_are_no_falls():
    walk, positions = body()
    left, right = (next(m for m, name in enumerate(walk.names) if name.endswith(side)) for side in ("LWRA", "RWRA"))
    swapped = positions.copy()
    swapped[walk.frames // 2 :, [left, right]] = positions[walk.frames // 2 :, [right, left]]
    assert falls(swapped, walk.fps) == ()


def test_few_markers_and_few_frames_tell_nothing():
    walk, positions = body()
    there = fallen(positions, walk.fps, 1, walk.frames // 2)
    assert falls(there[:5], walk.fps) == ()
    assert falls(there[:, :FEWEST], walk.fps) == ()
    assert falls(np.full((200, 20, 3), np.nan), 30.0) == ()


def halved(recording):
    """Every other marker."""
    return Markers(recording.names[::2], recording.positions[:, ::2], recording.fps, up=recording.up)


@cache
def halved_model():
    return Denoiser(window=20, fps=FPS).fit([halved(markers(motion)) for motion in clips()])


@pytest.mark.slow
def test_the_repair_takes_it_for_missing_and_says_so():
    walk, positions = body()
    walk, positions = halved(walk), positions[:, ::2]
    first = walk.frames // 2
    spoilt = walk.with_positions(fallen(positions, walk.fps, 7, first))
    for repair in (repair_without_model(spoilt, "adaptive"), halved_model().repair(spoilt)):
        said = [one for one in repair.warnings if "fell off" in one]
        assert len(said) == 1
        assert said[0].startswith(walk.names[7])
        off = np.linalg.norm(repair.recording.positions[:, 7] - walk.positions[:, 7], axis=1)
        assert np.linalg.norm(spoilt.positions[-30:, 7] - walk.positions[-30:, 7], axis=1).mean() > 0.3
        assert off.mean() < 0.03
        assert (repair.origin[first + 10 :, 7] == Origin.REPAIRED).all()  # recorded, but not there
        assert (repair.origin[: first // 2, 7] == Origin.MEASURED).all()
        assert (repair.std[first + 30 :, 7] > repair.std[: first // 2, 7].mean()).all()
