"""Other readings, of front and back and of left and right, weighed in each frame, and taken when they are right."""

from dataclasses import replace

import numpy as np

from ...arrays import Floats
from ...bodies.performer import Pose
from ...numerics.least_squares import Solution
from ..frame.evidence import Evidence
from ..limbs.certainty import shown_and_denied, trust_of
from ..limbs.mend import mend_limbs
from ..limbs.other_poses import Coarse, disagreement
from ..measure.girth import Girth
from ..model import TrackerModel
from ..settings import TrackSettings
from ..state import Begun, Facing, Sides, TrackState
from ..terms.objective import PAUSE, terms_of
from ..terms.solve import solve_pose
from .facing import along, doubted, walked, weighed
from .left_right import PAIRS, of_pair, sides_weighed
from .pair import Follow

STEPS = 6  # of Gauss-Newton for the other reading: it is begun where it was a few frames ago, and goes on in the next


def faced(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    evidence: Evidence,
    coarse: Coarse,
    solution: Solution[Pose],
    wrong: float,
    elapsed: float,
    ways: list[Pose] | None,
    *,
    busy: bool = False,
) -> tuple[TrackState, Solution[Pose], float, bool]:
    """Front and back, and left and right, weighed in one more frame.

    Parameters
    ----------
    state : its pose is still that of the frame before. solution, wrong : of this frame.
    elapsed : s, since then.
    ways : the readings between which a search of this frame decided; None = it was not searched.
    busy : limbs or the body were searched for in this frame: a look at the other reading may wait for the next.

    Returns
    -------
    State, solution and share of what is followed from here, and whether that faces the other way.
    """
    assert state.pose is not None
    pose, last = solution.state, state.pose
    if ways is not None:
        other = ways[1] if len(ways) > 1 else None
        new = not np.isfinite(state.wrong)
        facing = doubted(state.performer, pose, other, new=new)
        return replace(state, facing=facing, sides=Sides()), solution, wrong, False

    def begin(twin: TrackState, expected: Pose) -> Begun:
        twin = replace(twin, pose=expected, facing=Facing(), sides=Sides(), hypothesis=None)
        terms = terms_of(model, settings, twin, evidence, expected)
        found = solve_pose(twin.performer, evidence, terms, expected, settings, STEPS)
        share = disagreement(twin.performer, found.state, coarse)
        return Begun(twin, evidence, coarse, terms, expected, found, share)

    follow = Follow(begin, lambda begun: _finished(model, settings, begun))
    facing, asked = state.facing, state.facing.question is not None
    speed = 0.0
    if 0.0 < elapsed < PAUSE:
        speed = along(pose, (pose.translation - last.translation) / elapsed)
        facing = walked(facing, speed, elapsed)
    facing, taken = weighed(facing, state, pose, wrong, speed, model.database.search, follow, busy=busy)
    state = replace(state, facing=facing)
    if taken is None:
        if not asked and facing.question is None:  # of one thing at a time
            sides, taken = sides_weighed(
                state.sides, state, pose, wrong, elapsed, model.database.search, follow, busy=busy
            )
            state = replace(state, sides=sides)
        if taken is not None:
            solution, wrong = taken
            before = of_pair(last, solution.state, PAIRS[state.sides.asked])  # they did not move there
            state = replace(state, pose=before)
        return state, solution, wrong, False
    solution, wrong = taken
    girth = None if state.girth is None else Girth(state.girth.base)  # what was learned was the other one's
    body = state.performer if girth is None else girth.base
    state = replace(state, pose=solution.state, performer=body, girth=girth, wrong=wrong, sides=Sides())
    return state, solution, wrong, True


def _finished(model: TrackerModel, settings: TrackSettings, begun: Begun) -> tuple[Solution[Pose], Floats, float]:
    """The pose with its limbs looked for, its trust (28,), and the share of pixels that it explains wrongly."""
    twin, evidence, coarse = begun.state, begun.evidence, begun.coarse
    found, share, *_ = mend_limbs(
        model, settings, twin, evidence, coarse, begun.terms, begun.expected, begun.solution, begun.wrong
    )
    shown, _ = shown_and_denied(twin.performer, found.state, coarse, evidence.weight)
    return found, trust_of(shown)[0], share
