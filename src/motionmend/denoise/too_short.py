"""Takes of so few frames that nothing tells noise from motion: what was measured stays."""

from dataclasses import replace

import numpy as np

from ..bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..bodies.skeleton import ROTATION
from ..errors import counted

FEWEST_FRAMES = 4  # third differences of which tell noise from motion
GUESS, GUESS_PLACE = np.radians(2.0), 0.02  # rad and m; how far a sample may be off of which nothing is told


def as_recorded(recording: Recording, outcome: Repaired[Recording]) -> Repaired[Recording]:
    """The repair with what was measured as it was recorded, and deviations that are said to be a guess.

    Parameters
    ----------
    recording : as it was.
    outcome : its repair, which tells what is missing.
    """
    present = recording.present
    if isinstance(recording, Motion):
        assert isinstance(outcome.recording, Motion)
        guess = np.where(recording.skeleton.dof_kind == ROTATION, GUESS, GUESS_PLACE)
        kept = recording.with_q(np.where(present, recording.q, outcome.recording.q))
    else:
        assert isinstance(recording, Markers)
        assert isinstance(outcome.recording, Markers)
        guess = np.full(len(recording.names), GUESS_PLACE)
        places = np.where(present[..., None], recording.positions, outcome.recording.positions)
        kept = outcome.recording.with_positions(places)
    few = f"{counted(recording.frames, 'frame')} {'tells' if recording.frames == 1 else 'tell'}"
    said = (
        f"{few} too little of noise and outliers: what was measured is kept, and "
        f"deviations of {np.degrees(GUESS):.0f} degrees or {100.0 * GUESS_PLACE:.0f} cm at least are a guess"
    )
    return replace(
        outcome,
        recording=kept,
        origin=np.where(present, Origin.MEASURED, outcome.origin).astype(np.uint8),
        std=np.fmax(outcome.std, guess.astype(np.float32)) * np.where(outcome.origin < Origin.LEFT_OPEN, 1.0, np.nan),
        weights=np.where(present, 1.0, outcome.weights).astype(np.float32),
        warnings=(*outcome.warnings, said),
        noise=None,
    )
