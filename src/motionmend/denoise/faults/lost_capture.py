"""What capture lost and wrote all the same: frozen frames, and joints that fell to 0. It is repaired as if missing."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...arrays import Bools, Floats, runs
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ...bodies.skeleton import ROTATION, wrapped
from ..outcome import LEFT_OPEN, left_open
from .dropped import dropped
from .frozen import frozen, held_ends
from .frozen_alone import frozen_alone
from .held import named, recorded_but_lost, without
from .stuck_joint import stuck_joints

SAID = 6  # stretches that a warning names at most


def but_for_lost_capture(
    repair: Callable[[Recording], Repaired[Recording]], recording: Recording
) -> Repaired[Recording]:
    """Repair a recording with what capture lost taken as missing.

    Parameters
    ----------
    repair : of a whole recording.
    recording : motion or markers.

    Returns
    -------
    Lost samples were recorded, so that they are repaired, or left open, and said. Frames at either end that repeat each
    other are said, too.
    """
    fallen = dropped(recording)
    still = frozen(without(recording, fallen) if fallen.any() else recording)
    if isinstance(recording, Markers):
        still |= frozen_alone(recording, still)
    else:
        still |= stuck_joints(recording, still)
    lost = fallen | still
    said: list[str] = [
        f"the {which} {frames} frames repeat each other to the last digit: a pose that was held, or capture that {what}"
        for which, what, frames in zip(
            ("first", "last"), ("had not begun", "had ended"), held_ends(recording), strict=True
        )
        if frames
    ]
    if not lost.any():
        outcome: Repaired[Recording] = repair(recording)
        return replace(outcome, warnings=(*said, *outcome.warnings))
    if still.any():
        said.append(
            f"{int(still.sum())} samples were frozen and taken as missing, {_frames(still)}: they repeat each other to "
            f"the last digit, and then leap to where the motion goes on: {named(recording, still)}"
        )
    if fallen.any():
        said.append(
            f"{int(fallen.sum())} samples fell to exactly 0 and were taken as missing, {_frames(fallen)}: their joints "
            f"leap there and back: {named(recording, fallen)}"
        )
    outcome = recorded_but_lost(repair(without(recording, lost)), lost, said)
    return kept_where_open(outcome, recording, still, lost) if isinstance(recording, Motion) else outcome


def kept_where_open(outcome: Repaired[Motion], recording: Motion, still: Bools, lost: Bools) -> Repaired[Motion]:
    """The repair with what was frozen as it was recorded where nothing else supports a value: a pose says more than
    none. It is as unsure as its channel strays in half the time.

    Parameters
    ----------
    outcome : of the recording without what was lost.
    still : (T, D) samples that were frozen.
    lost : (T, D) these, and all others that were taken as missing.
    """
    open_ = still & (outcome.origin == Origin.LEFT_OPEN)
    if not open_.any():
        return outcome
    q, origin, std = outcome.recording.q.copy(), outcome.origin.copy(), outcome.std.copy()
    q[open_], origin[open_] = recording.q[open_], Origin.MEASURED
    moving, turns = np.where(lost, np.nan, recording.q), recording.skeleton.dof_kind == ROTATION
    for channel in np.flatnonzero(open_.any(axis=0)):
        for start, stop in runs(open_[:, channel]):
            std[start:stop, channel] = _strays(moving[:, channel], (stop - start + 1) // 2, bool(turns[channel]))
    said = (
        f"{int(open_.sum())} of the frozen samples were left as recorded, {_frames(open_)}: nothing near says where "
        "the motion was"
    )
    kept = tuple(warning for warning in outcome.warnings if not warning.endswith(LEFT_OPEN))
    return replace(
        outcome,
        recording=outcome.recording.with_q(q),
        origin=origin,
        std=std,
        weights=np.where(open_, np.float32(1.0), outcome.weights),
        warnings=(*kept, said, *left_open(origin)),
    )


def _strays(values: Floats, ahead: int, turns: bool) -> float:
    """Root mean square by which values (T,) change in so many frames, or from their middle if none are so far apart;
    angles (rad) the shorter way round."""
    changes = values[ahead:] - values[:-ahead]
    if not np.isfinite(changes).any():
        changes = values - np.nanmedian(values)
    changes = changes[np.isfinite(changes)]
    if turns:
        changes = wrapped(changes)
    return float(np.sqrt(np.square(changes).mean()))


def _frames(samples: Bools) -> str:
    """The stretches of frames that have any of these samples (T, C), the first of them."""
    stretches = runs(samples.any(axis=1))
    told = [f"{start} to {stop - 1}" if stop - start > 1 else f"{start}" for start, stop in stretches[:SAID]]
    one = len(stretches) == 1 and stretches[0][1] - stretches[0][0] == 1
    return f"frame{'' if one else 's'} {', '.join(told)}{', ...' if len(stretches) > SAID else ''}"
