"""A recording seen again from its end, stretch by stretch."""

import tracemalloc
from typing import Any

import numpy as np
import pytest
from sensed_people import fitted, recording, sensed, truth

from motionmend.correct import hindsight, recordings


def long_recording(times: int):
    """Somebody who walks to and fro, an arm lost now and then."""
    there = sensed(truth("walk", 5), 5)
    positions = np.concatenate([there, there[::-1]] * times)
    positions[np.arange(len(positions)) % 90 > 70, 5:8] = np.nan
    return recording(positions)


@pytest.mark.slow
def test_stretches_are_joined_as_if_there_were_none(monkeypatch: pytest.MonkeyPatch) -> None:
    given = long_recording(1)
    whole = fitted().correct(given)
    for stretch in (1, 7, len(given.times) - 1, len(given.times)):
        monkeypatch.setattr(hindsight, "STRETCH", stretch)
        parts = fitted().correct(given)
        np.testing.assert_array_equal(parts.positions, whole.positions)
        np.testing.assert_array_equal(parts.std, whole.std)


@pytest.mark.slow
def test_what_is_known_of_the_factors_is_not_kept_of_all_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """It was a quarter of all memory with this model's thirteen factors, and more than half with usual ones' 24.

    In a recording of 4800 frames; of one with less than a third of them, a quarter of a stretch is as much.
    """
    assert hindsight.STRETCH < 4800 / 4
    monkeypatch.setattr(hindsight, "STRETCH", hindsight.STRETCH // 4)
    highest: list[int] = []
    kept: list[int] = []

    def watched(*given: Any) -> Any:
        before = tracemalloc.get_traced_memory()[0]
        highest.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.reset_peak()
        found = hindsight.placed_again(*given)
        kept.append(tracemalloc.get_traced_memory()[1] - before)
        return found

    monkeypatch.setattr(recordings, "placed_again", watched)
    given = long_recording(12)
    tracemalloc.start()
    fitted().correct(given)
    peak = max(*highest, tracemalloc.get_traced_memory()[1])
    tracemalloc.stop()
    assert len(given.times) > 4 * hindsight.STRETCH
    assert peak < 22_000 * len(given.times)
    assert max(kept) < 6_000 * len(given.times)
