"""What is filled so far from sure that its user should hear of it, even where no limit was asked for."""

import numpy as np

from ...arrays import Bools
from ...bodies.motion import Markers, Motion, Origin, Repaired
from ...bodies.skeleton import ROTATION
from ...errors import few
from ..channels.joints import CENTIMETRES, DEGREES

ANGLE, PLACE = 10.0, 5.0  # degrees and cm of deviation, beyond which a sample is hardly known
MUCH = 0.01  # of what is filled: less is a matter for whoever reads deviations


def hardly_known(outcome: Repaired[Motion] | Repaired[Markers]) -> tuple[str, ...]:
    """A sentence that says how much of what is filled is far from sure, where, and how far; none where hardly any is.

    Joint angles, but for the root's places, and markers between the first and the last time they are seen: what is
    made up beyond, or of who is never seen, is said by whoever does it.

    Parameters
    ----------
    outcome : deviations in rad for joint angles, m for markers.
    """
    recording, filled = outcome.recording, np.asarray(outcome.origin == Origin.FILLED)
    seen: Bools = np.asarray(outcome.origin <= Origin.REPAIRED)
    if isinstance(recording, Motion):
        asked = seen.any(axis=0) & (recording.skeleton.dof_kind == ROTATION)
        unit, scale, limit = "degrees", DEGREES, ANGLE
    else:
        asked = np.logical_or.accumulate(seen, axis=0) & np.logical_or.accumulate(seen[::-1], axis=0)[::-1]
        unit, scale, limit = "cm", CENTIMETRES, PLACE
    filled &= asked
    unsure = filled & (scale * outcome.std > limit)
    if unsure.sum() <= MUCH * filled.sum():
        return ()
    count, names = unsure.sum(axis=0), recording.channels
    most = [f"{names[c]} ({count[c]})" for c in np.argsort(-count, kind="stable") if count[c]]
    return (
        f"{int(unsure.sum())} of {int(filled.sum())} filled samples are less sure than {limit:g} {unit}, "
        f"up to {scale * float(np.quantile(outcome.std[unsure], 0.95)):.2g}: {few(most)}; "
        "a limit (--max-std) leaves such open",
    )
