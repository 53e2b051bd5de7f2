"""Swaps of which nothing tells which part bears the wrong labels: repaired as one, written as recorded.

The markers leap where such a swap begins and ends. A repair takes that for a fault of one part and draws it to where
the other has the marker, which is another marker's place: with the labels exchanged for the repair nothing leaps.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...arrays import Ints
from ...bodies.motion import Markers, Repaired
from ..channels.layout import own_layout
from ..channels.recording import to_channels
from .relabelling import AT_FIRST_SIGHT, at_first_sight, swaps_told
from .swaps import Swap


def undecided(seen: tuple[Swap, ...]) -> tuple[Swap, ...]:
    """Of the swaps that are seen those beyond doubt of which a part may be wrong or all the rest: of two markers, and
    these alone.

    Where a marker changes labels with several, what leaps in one of these swaps may be another's leap.
    """
    pairs = {frozenset(swap.markers) for swap in seen}
    shared = Counter(marker for pair in pairs for marker in pair)
    return tuple(
        swap
        for swap in seen
        if not swap.put_right and swap.log_odds >= AT_FIRST_SIGHT and all(shared[m] == 1 for m in swap.markers)
    )


def but_for_undecided(
    repair: Callable[[Markers], Repaired[Markers]],
    recording: Markers,
    orderly: Callable[[Markers], Repaired[Markers]] | None = None,
) -> Repaired[Markers]:
    """A repair of a recording whose labels no library tells apart: undecided swaps are told, and stay as recorded.

    Parameters
    ----------
    repair : of a recording.
    recording : T frames of M markers.
    orderly : the same of one in which no swap at all is seen; None = `repair`.
    """
    seen = at_first_sight(recording, to_channels(recording, own_layout(recording)))
    swaps = undecided(seen)
    if not swaps:
        return repair(recording) if seen or orderly is None else orderly(recording)
    columns = _exchanged(recording, swaps)
    frames = np.arange(recording.frames)[:, None]
    outcome = repair(recording.with_positions(recording.positions[frames, columns]))
    told = swaps_told(swaps, recording, to_channels(recording, own_layout(recording)), taught=False)
    return replace(
        outcome,
        recording=outcome.recording.with_positions(outcome.recording.positions[frames, columns]),
        origin=outcome.origin[frames, columns],
        std=outcome.std[frames, columns],
        weights=outcome.weights[frames, columns],
        warnings=(*told, *outcome.warnings),
    )


def _exchanged(recording: Markers, swaps: tuple[Swap, ...]) -> Ints:
    """(T, M) the marker under whose label each is recorded; as pairs are exchanged, also the way back."""
    columns = np.tile(np.arange(recording.positions.shape[1]), (recording.frames, 1))
    for swap in swaps:
        frames = slice(swap.first, swap.last + 1)
        columns[frames, list(swap.markers)] = columns[frames, list(swap.markers[::-1])]
    return columns
