"""The whole body looked for in one frame: where the detector sees it, where it was, and lying."""

from dataclasses import replace

import numpy as np

from ...arrays import frozen
from ...bodies.camera import DepthFrame
from ...bodies.performer import DOFS, Pose
from ..limbs.judge import JUDGED, judge
from ..limbs.rescue import moved_to, turned
from ..lost import LOST
from ..measure.girth import Girth
from ..readings.facing import FEET, faces_otherwise, unlikeliness
from ..readings.feet import feet_against
from ..readings.pair import IMAGE
from ..state import Facing, Fit, Sight, TrackState
from ..terms.objective import fitted
from .afresh import better

UNSETTLED = 0.5  # of what feet tell counts of one frame's search: where they are is not settled there


def look_for_body(sight: Sight, state: TrackState) -> list[Pose]:
    """The pose that explains the frame best, of those the detector proposes and the last one; none = no body.

    The best of those that face the other way comes second, if there is one.

    Parameters
    ----------
    sight : the frame.
    state : after the frame before.
    """
    from ..detect.joints import Detection, detect, detected_lying
    from .first_pose import Candidate, candidates, lying
    from .settle import settled_readings

    model, performer, coarse = sight.model, state.performer, sight.coarse
    few = sight.seen.as_fine_as(JUDGED)
    tried = []
    if state.pose is not None:
        last = (state.pose, *turned(moved_to(performer, state.pose, sight.evidence, coarse), 8))
        tried += [Candidate(pose, judge(performer, pose, few).cost, "last") for pose in last]
    detection = None
    if model.detector is not None:
        shown = DepthFrame(sight.seen.camera, sight.seen.depth, None, sight.seen.time)
        detection = detect(model.detector, shown, furniture=state.furniture)
        tried += candidates(performer, detection, few, model.examples)

    def refine(pose: Pose) -> tuple[Pose, float]:
        fit = fitted(sight, replace(state, pose=pose, before=None, trust=frozen(np.ones(DOFS - 6))), pose)
        return fit.pose, fit.wrong

    def settled(tried: list[Candidate], detection: Detection | None) -> list[Candidate]:
        tried = sorted(tried, key=lambda one: one.cost)
        return settled_readings(performer, tried, few, coarse, model.limb_shapes, refine, detection)

    ways = settled(tried, detection)
    if model.detector is not None and (laid := lying(performer, few)):
        # Whoever looks so may be upright all the same, the legs hidden, say: each search keeps the best of its own.
        sideways = detected_lying(model.detector, shown)
        laid += [way for one in sideways for way in candidates(performer, one, few, model.examples)]
        ways += settled(laid, max(sideways, key=lambda one: float(one.confidence.sum()), default=None))
        ways.sort(key=lambda way: way.cost)
    if not ways or ways[0].cost > 1.5 * LOST:
        return []
    gone = float(state.hidden.min())

    told = [unlikeliness(model.database.search, way.pose, way.cost, state.pose, gone) for way in ways]
    order = np.argsort(told, kind="stable")
    best = ways[order[0]].pose
    other = next((k for k in order[1:] if faces_otherwise(best, ways[k].pose)), None)
    if other is None:
        return [best]
    # Which of the two the search names first is what is followed, and what the other has to be better than.
    facing = ways[other].pose
    feet = UNSETTLED * FEET / IMAGE * feet_against(performer, best, facing, coarse)
    return [best, facing] if told[order[0]] + feet <= told[other] else [facing, best]


def taken_up(sight: Sight, fit: Fit, ways: list[Pose]) -> Fit | None:
    """The fit of a search's best pose, if that is clearly better than the one that is followed.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    ways : what `look_for_body` found.
    """
    if not ways:
        return None
    state = fit.state
    fresh = replace(state, pose=ways[0], velocity=frozen(np.zeros(DOFS)), trust=frozen(np.ones(DOFS - 6)))
    found = fitted(sight, fresh, ways[0])
    beside, facing = 0.0, state.facing
    if faces_otherwise(fit.pose, found.pose):
        facing = Facing(odds=0.0)  # what was told of it led there
        beside = UNSETTLED * FEET * feet_against(state.performer, fit.pose, found.pose, sight.coarse)
    if not better(sight.model.database.search, fit.pose, fit.wrong, found.pose, found.wrong, beside):
        return None
    # What was usual, and what was learned of widths, was the other pose's.
    girth = None if state.girth is None else Girth(state.girth.base)
    body = state.performer if girth is None else girth.base
    fresh = replace(fresh, performer=body, girth=girth, wrong=found.wrong, hypothesis=None, afresh=None, facing=facing)
    return replace(found, state=fresh)
