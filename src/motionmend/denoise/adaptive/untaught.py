"""Channels that no clip has taught: repaired by what they show themselves, beside those that a library knows."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...arrays import Bytes, Ints, Singles
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..channels.layout import Layout, names_of
from ..outcome import left_as_recorded, left_open, not_known


def with_untaught(
    recording: Recording,
    outcome: Repaired[Recording],
    layout: Layout,
    repair: Callable[[Recording, Ints], Repaired[Recording]],
) -> Repaired[Recording]:
    """The repair by a library, with the channels that it does not know repaired as well.

    Parameters
    ----------
    recording : as it was.
    outcome : of the library; what its layout does not know is as recorded.
    layout : what the library knows.
    repair : of a recording of which no clip has taught anything, and the channels that are asked for. What the library
        replaced it sees replaced, what it believed as recorded: of one recording all channels are about as noisy.
    """
    taught = set(layout.names)
    unknown = np.array([c for c, name in enumerate(names_of(recording)) if name not in taught], dtype=np.int64)
    if not len(unknown):
        return outcome
    alone = repair(_replaced(recording, outcome), unknown)
    noise = None if outcome.noise is None else outcome.noise.copy()
    if noise is not None and alone.noise is not None:
        noise[unknown] = alone.noise[unknown]
    origin: Bytes = outcome.origin.copy()
    std: Singles = outcome.std.copy()
    weights: Singles = outcome.weights.copy()
    origin[:, unknown] = alone.origin[:, unknown]
    std[:, unknown] = alone.std[:, unknown]
    weights[:, unknown] = alone.weights[:, unknown]
    before = {left_as_recorded(recording, unknown), *left_open(outcome.origin)}
    said = [warning for warning in outcome.warnings if warning not in before]
    said += [not_known(recording, unknown, "repaired by what they show themselves"), *left_open(origin)]
    opened = left_open(alone.origin)
    said += [warning for warning in alone.warnings if warning not in opened]
    return replace(
        outcome,
        recording=_with_channels(outcome.recording, alone.recording, unknown),
        origin=origin,
        std=std,
        weights=weights,
        warnings=tuple(said),
        noise=noise,
    )


def _replaced(recording: Recording, outcome: Repaired[Recording]) -> Recording:
    """The recording with all that is not as measured as the repair has it."""
    kept = outcome.origin == Origin.MEASURED
    if isinstance(recording, Motion):
        assert isinstance(outcome.recording, Motion)
        return recording.with_q(np.where(kept, recording.q, outcome.recording.q))
    assert isinstance(recording, Markers)
    assert isinstance(outcome.recording, Markers)
    return recording.with_positions(np.where(kept[..., None], recording.positions, outcome.recording.positions))


def _with_channels(recording: Recording, other: Recording, channels: Ints) -> Recording:
    """The recording with these channels or markers of another."""
    if isinstance(recording, Motion):
        assert isinstance(other, Motion)
        q = recording.q.copy()
        q[:, channels] = other.q[:, channels]
        return recording.with_q(q)
    assert isinstance(recording, Markers)
    assert isinstance(other, Markers)
    positions = recording.positions.copy()
    positions[:, channels] = other.positions[:, channels]
    return recording.with_positions(positions)
