"""A rest pose before a recording is no motion: it is kept as it is, and what follows is repaired without it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...bodies.motion import Motion, Origin, Recording, Repaired
from ...bodies.put_before import rest_frames


def but_for_rest_pose(repair: Callable[[Recording], Repaired[Recording]], recording: Recording) -> Repaired[Recording]:
    """Repair a recording, but for a rest pose put before it.

    Parameters
    ----------
    repair : of a whole recording.
    recording : motion or markers; of markers nobody can tell.

    Returns
    -------
    All frames; those of a rest pose are measured or left open, as sure as the samples after them.
    """
    if not isinstance(recording, Motion) or not (rested := rest_frames(recording)):
        return repair(recording)
    return _with_first(recording, repair(recording.with_q(recording.q[rested:])), rested)


def _with_first(motion: Motion, outcome: Repaired[Motion], rested: int) -> Repaired[Motion]:
    """What the repair made of all frames but the first ones, after those as they were."""
    there = motion.present[:rested]
    which = "frame 0 is" if rested == 1 else f"frames 0 to {rested - 1} are"
    said = f"{which} a rest pose put before the recording: kept as it is, the rest repaired without it"
    return replace(
        outcome,
        recording=motion.with_q(np.concatenate([motion.q[:rested], outcome.recording.q])),
        origin=np.concatenate([np.where(there, Origin.MEASURED, Origin.LEFT_OPEN).astype(np.uint8), outcome.origin]),
        std=np.concatenate([np.where(there, outcome.std[:1], np.nan), outcome.std]),
        weights=np.concatenate([there.astype(np.float32), outcome.weights]),
        warnings=(*outcome.warnings, said),
    )
