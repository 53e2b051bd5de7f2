"""The other reading of front and back carried along with the one that is followed, and taken when it is right."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Floats
from ..bodies.performer import Pose
from ..numerics.least_squares import Solution
from .certainty import shown_and_denied, trust_of
from .evidence import Evidence
from .facing import along, doubted, walked, weighed
from .girth import Girth
from .limbs import Coarse, disagreement
from .mend_limbs import mend_limbs
from .model import TrackerModel
from .objective import PAUSE, terms_of
from .settings import TrackSettings
from .solve import solve_pose

if TYPE_CHECKING:
    from .tracker import TrackState


def faced(
    model: TrackerModel,
    settings: TrackSettings,
    state: "TrackState",
    evidence: Evidence,
    coarse: Coarse,
    solution: Solution[Pose],
    wrong: float,
    elapsed: float,
    ways: list[Pose] | None,
) -> tuple["TrackState", Solution[Pose], float, bool]:
    """Front and back weighed in one more frame: what is followed from here, and whether that is the other reading.

    Parameters
    ----------
    state : its pose is still that of the frame before. solution, wrong : of this frame.
    elapsed : s, since then.
    ways : the readings between which a search of this frame decided; None = it was not searched.
    """
    assert state.pose is not None
    pose = solution.state
    if ways is not None:
        other = ways[1] if len(ways) > 1 else None
        new = not np.isfinite(state.wrong)
        return replace(state, facing=doubted(state.performer, pose, other, new=new)), solution, wrong, False

    def follow(twin: "TrackState", expected: Pose) -> tuple[Solution[Pose], Floats, float]:
        twin = replace(twin, pose=expected)
        terms = terms_of(model, settings, twin, evidence, expected)
        found = solve_pose(twin.performer, evidence, terms, expected, settings)
        share = disagreement(twin.performer, found.state, coarse)
        found, share, *_ = mend_limbs(model, settings, twin, evidence, coarse, terms, expected, found, share)
        shown, _ = shown_and_denied(twin.performer, found.state, coarse, evidence.weight)
        return found, trust_of(shown)[0], share

    facing = state.facing
    speed = 0.0
    if 0.0 < elapsed < PAUSE:
        speed = along(pose, (pose.translation - state.pose.translation) / elapsed)
        facing = walked(facing, speed, elapsed)
    facing, taken = weighed(facing, state, pose, wrong, speed, model.database.search, follow)
    state = replace(state, facing=facing)
    if taken is None:
        return state, solution, wrong, False
    solution, wrong = taken
    girth = None if state.girth is None else Girth(state.girth.base)  # what was learned was the other one's
    body = state.performer if girth is None else girth.base
    state = replace(state, pose=solution.state, performer=body, girth=girth, wrong=wrong)
    return state, solution, wrong, True
