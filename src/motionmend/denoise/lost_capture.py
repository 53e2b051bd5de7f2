"""What capture lost and wrote all the same: frozen frames, and joints that fell to 0. It is repaired as if missing."""

from collections.abc import Callable
from dataclasses import replace

from ..arrays import Bools, runs
from ..bodies.motion import Markers, Recording, Repaired
from .dropped import dropped
from .frozen import frozen, held_ends
from .frozen_alone import frozen_alone
from .held import named, recorded_but_lost, without

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
    return recorded_but_lost(repair(without(recording, lost)), lost, said)


def _frames(samples: Bools) -> str:
    """The stretches of frames that have any of these samples (T, C), the first of them."""
    stretches = runs(samples.any(axis=1))
    told = [f"{start} to {stop - 1}" if stop - start > 1 else f"{start}" for start, stop in stretches[:SAID]]
    one = len(stretches) == 1 and stretches[0][1] - stretches[0][0] == 1
    return f"frame{'' if one else 's'} {', '.join(told)}{', ...' if len(stretches) > SAID else ''}"
