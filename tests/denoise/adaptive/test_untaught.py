"""Markers that no clip has taught, under one another's labels and under those of markers that a library knows."""

import numpy as np
import pytest

from motionmend import repair_without_model
from motionmend.bodies.motion import Markers
from motionmend.denoise import Denoiser
from motionmend.io import read
from motionmend.samples import markers
from performers import every_other, half_the_markers_model, truth

SWAPPED = slice(30, 60)
RWRA = 10


def _with_props(*places):
    """Half of the walk's markers and more at places (T, 3) m beside the first one, each in a millimetre of noise."""
    clean = every_other(markers(truth("walk"))).at_frames(slice(0, 90))
    props = [clean.positions[:, [0]] + place for place in places]
    positions = np.concatenate([clean.positions, *props], axis=1)
    positions += np.random.default_rng(0).normal(0, 0.001, positions.shape)
    return Markers((*clean.names, *(f"PROP{n + 1}" for n in range(len(places)))), positions, clean.fps, up=clean.up)


def _swapped(recording, one, other):
    positions = recording.positions.copy()
    positions[SWAPPED, [[one], [other]]] = positions[SWAPPED, [[other], [one]]]
    return recording.with_positions(positions)


@pytest.mark.slow
def test_swapped_labels_of_unknown_markers_are_put_right_and_said():
    right = _with_props([0.3, 0.0, 0.0], [0.0, 0.0, 0.4])
    repaired = half_the_markers_model().repair(_swapped(right, -2, -1))
    assert np.linalg.norm(repaired.recording.positions - right.positions, axis=2)[:, -2:].max() < 0.02
    assert any("PROP1, PROP2: labels were swapped in frames 30 to 59" in warning for warning in repaired.warnings)


@pytest.mark.slow
def test_of_a_known_and_an_unknown_marker_that_changed_places_neither_is_lost():
    """Only one of them the library believes: were that put right alone both would be in one place."""
    right = _with_props([0.3, 0.0, 0.0])
    repaired = half_the_markers_model().repair(_swapped(right, RWRA, -1))
    assert np.linalg.norm(repaired.recording.positions - right.positions, axis=2).max() < 0.04
    assert any("leapt away" in warning and "RWRA, PROP1" in warning for warning in repaired.warnings)


def _part(data, name, first, last):
    """Some frames of a real recording, by the markers' bare names."""
    whole = read(data / "mocap" / "c3d" / f"{name}.c3d")
    names = [n.rpartition(":")[2] for n in whole.names]
    return Markers(names, whole.positions[first:last], whole.fps, up=whole.up)


@pytest.mark.slow
def test_gaps_of_known_markers_are_filled_from_those_that_the_library_does_not_know_too(data):
    clean, model = (
        _part(data, "sfu_0005_SideSkip001", 0, 150),
        Denoiser().fit([_part(data, "hdm05_bd_01-02_01_120", 0, 600)]),
    )
    rng = np.random.default_rng(5)
    positions = clean.positions + rng.normal(0, 0.003, clean.positions.shape)
    gone = np.zeros(clean.present.shape, dtype=bool)
    for name in [n for n in clean.names if n in model.layout.names][::3]:
        start = rng.integers(10, 100)
        gone[start : start + rng.integers(20, 40), clean.names.index(name)] = True
    positions[gone] = np.nan
    gappy = clean.with_positions(positions)
    filled, alone = model.repair(gappy), repair_without_model(gappy, "adaptive")

    def error(outcome):
        return np.sqrt(np.mean(np.square(outcome.recording.positions - clean.positions)[gone & clean.present]))

    assert error(filled) < 1.3 * error(alone)
