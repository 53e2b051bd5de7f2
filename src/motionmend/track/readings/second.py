"""Other readings, of front and back and of left and right, weighed in each frame, and taken when they are right."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Floats
from ...bodies.performer import Performer, Pose
from ..limbs.certainty import shown_and_denied, trust_of
from ..limbs.mend import mend_limbs
from ..measure.girth import Girth
from ..state import Facing, Fit, Sides, Sight, TrackState
from ..terms.objective import PAUSE, fitted
from .facing import along, doubted, known_of, walked, weighed
from .feet import feet_against
from .left_right import PAIRS, of_pair, sides_weighed
from .pair import Follow

STEPS = 6  # of Gauss-Newton for the other reading: it is begun where it was a few frames ago, and goes on in the next


def faced(
    sight: Sight, fit: Fit, elapsed: float, ways: Sequence[Pose] | None, *, busy: bool = False
) -> tuple[Fit, bool]:
    """Front and back, and left and right, weighed in one more frame.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    elapsed : s since the frame before.
    ways : the readings between which a search of this frame decided; None = it was not searched.
    busy : limbs or the body were searched for in this frame: a look at the other reading may wait for the next.

    Returns
    -------
    The fit of what is followed from here, and whether that faces the other way.
    """
    state, pose, last = fit.state, fit.pose, fit.state.pose
    assert last is not None
    if ways is not None:
        other = ways[1] if len(ways) > 1 else None
        new = not np.isfinite(state.wrong)
        known = 0.0 if new else known_of(state.facing, last, pose, float(state.hidden.min()))
        facing = doubted(state.performer, pose, other, new=new, known=known)
        return replace(fit, state=replace(state, facing=facing, sides=Sides())), False

    def begin(twin: TrackState, expected: Pose) -> Fit:
        twin = replace(twin, pose=expected, facing=Facing(), sides=Sides(), hypothesis=None)
        return fitted(sight, twin, expected, STEPS, elapsed=elapsed)

    follow, search = Follow(sight, begin, _finished, _feet), sight.model.database.search
    facing, asked = state.facing, state.facing.question is not None
    speed = 0.0
    if 0.0 < elapsed < PAUSE:
        speed = along(pose, (pose.translation - last.translation) / elapsed)
        facing = walked(facing, speed, elapsed)
    facing, taken = weighed(facing, state, pose, fit.wrong, speed, search, follow, busy=busy)
    state = replace(state, facing=facing)
    if taken is not None:
        girth = None if state.girth is None else Girth(state.girth.base)  # what was learned was the other one's
        body = state.performer if girth is None else girth.base
        state = replace(state, pose=taken.pose, performer=body, girth=girth, wrong=taken.wrong, sides=Sides())
        return replace(fit, state=state, solution=taken.solution, wrong=taken.wrong), True
    if not asked and facing.question is None:  # of one thing at a time
        sides, taken = sides_weighed(state.sides, state, pose, fit.wrong, elapsed, search, follow, busy=busy)
        state = replace(state, sides=sides)
    if taken is not None:
        before = of_pair(last, taken.pose, PAIRS[state.sides.asked])  # they did not move there
        fit, state = replace(fit, solution=taken.solution, wrong=taken.wrong), replace(state, pose=before)
    return replace(fit, state=state), False


def _finished(sight: Sight, begun: Fit) -> tuple[Fit, Floats]:
    """The fit with its limbs looked for, and how well it shows each joint coordinate (28,)."""
    found, *_ = mend_limbs(sight, begun)
    shown, *_ = shown_and_denied(begun.state.performer, found.pose, sight.coarse, sight.evidence.weight)
    return found, trust_of(shown)[0]


def _feet(sight: Sight, performer: Performer, pose: Pose, other: Pose) -> float:
    return feet_against(performer, pose, other, sight.coarse)
