"""Swaps of which nothing tells which part is wrong: nothing is changed for them, and what is repaired goes back."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin, Repaired
from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.layout import own_layout
from motionmend.denoise.channels.recording import to_channels
from motionmend.denoise.labels.relabelling import at_first_sight
from motionmend.denoise.labels.undecided import but_for_undecided, undecided
from motionmend.samples import clip, markers

WALK = markers(clip("walk", seconds=2.0, fps=60.0, seed=3))
LEG = [name for name in ("THI", "KNE", "ANK", "HEE", "TOE") if f"L{name}" in WALK.names]


def untouched(recording):
    shape = recording.positions.shape[:2]
    marked = np.broadcast_to(np.arange(shape[1], dtype=np.float32), shape)  # what belongs to a marker bears its number
    return Repaired(recording, np.full(shape, Origin.MEASURED), marked, np.ones(shape), "none")


def exchanged(recording, names, first, stop):
    """The recording with the labels of left and right exchanged from `first` to before `stop`."""
    places = recording.positions.copy()
    for name in names:
        pair = [recording.names.index(side + name) for side in "LR"]
        places[first:stop, pair] = places[first:stop, pair[::-1]]
    return recording.with_positions(places)


def seen_in(recording):
    return at_first_sight(recording, to_channels(recording, own_layout(recording)))


@pytest.mark.parametrize(("names", "first", "stop"), [(["THI"], 0, 74), (["THI"], 20, 100), (LEG, 46, 120)])
def test_what_belongs_together_is_together_for_the_repair_and_apart_after_it(names, first, stop):
    swapped = exchanged(WALK, names, first, stop)
    seen = []
    outcome = but_for_undecided(lambda one: seen.append(one) or untouched(one), swapped)
    steps = np.linalg.norm(np.diff(seen[0].positions, axis=0), axis=2)
    assert steps.max() < 0.1 < np.linalg.norm(np.diff(swapped.positions, axis=0), axis=2).max()
    np.testing.assert_array_equal(outcome.recording.positions, swapped.positions)
    # what was told of a marker goes with it to the label under which it was recorded
    steps_told = np.abs(np.diff(outcome.std, axis=0)).max(axis=0) > 0
    assert {WALK.names[m] for m in np.flatnonzero(steps_told)} == {side + name for name in names for side in "LR"}
    assert len([said for said in outcome.warnings if "were not exchanged" in said]) == len(names)


def test_a_swap_that_is_only_declared_is_not_altered_where_it_leaps():
    swapped = exchanged(WALK, ["THI"], 20, 100)  # the 40 of each that are right were replaced: 0.36 m off
    outcome = repair_without_model(swapped)
    assert any("LTHI, RTHI" in said and "were not exchanged" in said for said in outcome.warnings)
    assert np.abs(outcome.recording.positions - swapped.positions).max() < 0.005
    assert (outcome.origin == Origin.MEASURED).mean() > 0.999


def test_labels_that_are_right_and_swaps_that_are_put_right_are_not_undecided():
    assert undecided(seen_in(WALK)) == ()
    assert undecided(seen_in(exchanged(WALK, ["THI"], 40, 60))) == ()
