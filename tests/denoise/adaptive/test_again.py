"""A recording repaired again without a few samples: what the first repair went by serves, and little is done twice."""

from collections import Counter

import numpy as np
import pytest

from motionmend.denoise import repair_without_model
from motionmend.denoise.adaptive import beliefs, rounds
from motionmend.denoise.adaptive import recording as mending
from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.faults.contradicted import Contradicted
from motionmend.denoise.faults.held import without
from motionmend.denoise.library.local_prior import Prior
from motionmend.samples import markers
from performers import every_other, truth

NOISE = 0.0005  # m


def _walk():
    """A walk, the same in noise with a gap of two markers, and samples beside one of these that are off by 2 cm."""
    clean = every_other(markers(truth("walk", 9, 1.5, 100.0)))
    positions = clean.positions + NOISE * np.random.default_rng(3).standard_normal(clean.positions.shape)
    positions[60:90, [2, 5]] = np.nan
    off = np.zeros(positions.shape[:2], dtype=bool)
    off[90:94, 5] = True
    positions[off] += 0.02
    return clean, clean.with_positions(positions), off


def _counted(monkeypatch, module, *names):
    calls = Counter()

    def counting(name, done):
        def count(*args, **options):
            calls[name] += 1
            return done(*args, **options)

        return count

    for name in names:
        monkeypatch.setattr(module, name, counting(name, getattr(module, name)))
    return calls


def _errors(repaired, clean, where):
    return np.linalg.norm(repaired.recording.positions - clean.positions, axis=2)[where]


@pytest.mark.slow
def test_what_strays_costs_no_second_repair(monkeypatch):
    clean, bad, off = _walk()
    whole = mending._mended_once(without(bad, off), mending._of_itself(bad))
    monkeypatch.setattr(mending, "contradicted", lambda *_: Contradicted(off, np.zeros_like(off)))
    calls = _counted(monkeypatch, mending, "mend_channels", "with_gaps_filled", "right_at_first_sight", "swaps_seen")
    again = repair_without_model(bad)
    assert calls == {"mend_channels": 3, "with_gaps_filled": 1, "swaps_seen": 1}  # not 4, 2, 2, and 2 at first sight
    gone = ~bad.present | off
    for where in (gone, ~gone):
        new, anew = (np.sqrt(np.square(_errors(one, clean, where)).mean()) for one in (again, whole))
        assert new < 1.03 * anew
    difference = np.linalg.norm(again.recording.positions - whole.recording.positions, axis=2)
    assert difference[~gone].max() < NOISE
    assert np.median(np.abs(again.std / whole.std - 1.0)) < 0.03


@pytest.mark.slow
def test_where_nothing_strays_gaps_are_filled_as_ever(monkeypatch):
    _, bad, off = _walk()
    sound = without(bad, off)
    known = mending._of_itself(sound)
    whole = mending._mended_once(sound, known)
    calls = _counted(monkeypatch, mending, "mend_channels", "with_gaps_filled")
    again = mending._brought_back(sound, known)
    assert calls == {"mend_channels": 2, "with_gaps_filled": 1}
    np.testing.assert_array_equal(again.recording.positions, whole.recording.positions)
    np.testing.assert_array_equal(again.std, whole.std)


def test_samples_tell_of_their_noise_once(monkeypatch):
    _, bad, _ = _walk()
    calls = _counted(monkeypatch, beliefs, "loudness", "rattles")
    values = 100.0 * bad.positions.reshape(bad.frames, -1)[:80, :9]
    prior = Prior(np.diag(np.full(9, 0.01)), None)
    first = mend_channels(values, prior, bad.fps, hearing=True)
    again = mend_channels(values, prior, bad.fps, heard=first.heard)
    assert calls == {"loudness": 1, "rattles": 1}
    np.testing.assert_array_equal(again.found.values, first.found.values)
    np.testing.assert_array_equal(again.found.std, first.found.std)


def test_a_repair_that_goes_on_takes_one_round(monkeypatch):
    _, bad, _ = _walk()
    values = 100.0 * bad.positions.reshape(bad.frames, -1)[:80, :9]
    prior = Prior(np.diag(np.full(9, 0.01)), None)
    first = mend_channels(values, prior, bad.fps, hearing=True, resumed=True)
    calls = _counted(monkeypatch, rounds, "likeliest_histories")
    again = mend_channels(values, prior, bad.fps, heard=first.heard)
    assert calls == {"likeliest_histories": 1}
    seen = np.isfinite(values)
    np.testing.assert_allclose(again.found.values[seen], first.found.values[seen], atol=50.0 * NOISE)
