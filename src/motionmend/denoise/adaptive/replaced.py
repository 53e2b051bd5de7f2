"""What a repair has made up or replaced so much of that it has to be said."""

import numpy as np

from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ...bodies.skeleton import ROTATION
from ...errors import few
from ..channels.joints import CENTIMETRES, DEGREES
from ..faults.held import SAID

HARDLY, FEWEST_REJECTED = 1 / 3, 10  # of a channel's samples, and how many, that are said to be replaced


def never_seen(outcome: Repaired[Recording]) -> tuple[str, ...]:
    """A sentence that names joints or markers without any sample, and how far off they may be; none without such."""
    recording: Motion | Markers = outcome.recording
    made_up = np.flatnonzero((outcome.origin == Origin.FILLED).all(axis=0))
    if isinstance(recording, Motion):
        made_up = made_up[recording.skeleton.dof_kind[made_up] == ROTATION]
        names, unit = [recording.skeleton.names[j] for j in recording.skeleton.dof_joint[made_up]], "degrees"
        scale = DEGREES
    else:
        names, unit, scale = [recording.names[m] for m in made_up], "cm", CENTIMETRES
    off: dict[str, float] = {}
    for name, channel in zip(names, made_up, strict=True):
        off[name] = max(off.get(name, 0.0), scale * float(outcome.std[:, channel].mean()))
    said = few([f"{name} ({away:.2g} {unit})" for name, away in off.items()])
    return (f"never seen, and made up by what the library's people do, off by about: {said}",) if said else ()


def hardly_believed(outcome: Repaired[Recording]) -> tuple[str, ...]:
    """A sentence that names the channels of which little is left as it was measured; none where there are none."""
    rejected = (outcome.origin == Origin.REPAIRED) & (outcome.weights == 0.0)
    count, measured = rejected.sum(axis=0), (outcome.origin <= Origin.REPAIRED).sum(axis=0)
    most = np.argsort(-count, kind="stable")
    most = most[(count > HARDLY * measured)[most] & (count[most] >= FEWEST_REJECTED)]
    if not len(most):
        return ()
    names = outcome.recording.channels
    said = ", ".join(f"{names[c]} ({count[c]} of {measured[c]})" for c in most[:SAID])
    return (f"much of what was measured is taken for wrong and replaced: {said}{', ...' if len(most) > SAID else ''}",)
