"""Following one body, frame by frame: a state goes in with a frame, the next state and an estimate come out."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ..arrays import Singles, frozen
from ..bodies.camera import DepthFrame
from ..bodies.performer import DOFS, LANDMARKS, Performer, Pose
from ..errors import UsageError
from .frame.evidence import evidence_of
from .frame.observation import Observation
from .limbs.mend import mend_limbs
from .limbs.offers import MUCH, offers_tried
from .limbs.other_poses import coarse_of, disagreement, left_over
from .limbs.pieces import CLAIMED, claimed, in_doubt, laid_in
from .limbs.rescue import rescued
from .lost import is_lost
from .measure.girth import Girth
from .model import TrackerModel
from .outcome import DOUBTFUL, Estimate, Searched, followed, nobody
from .person.fineness import evened
from .person.foreground import Scene, scene_of, told_again
from .person.moved_camera import camera_followed
from .person.pixels import person_of
from .readings.facing import faces_otherwise, turned_about
from .readings.hypotheses import contested
from .readings.second import faced
from .settings import TrackSettings
from .stages import Stages
from .starting.afresh import Afresh
from .starting.look import look_for_body, taken_up
from .state import EVERY, Fit, Sight, TrackState
from .terms.objective import expected_pose, fitted

NEVER = 3.0  # s; a joint that was not seen yet is no surer than one that was last seen so long ago
RESCUE = 1.25  # times the usual share of pixels explained wrongly, above which other poses of the body are tried


@final
@dataclass(frozen=True, eq=False)
class _Body:
    """The body in a frame, while it is made out.

    Attributes
    ----------
    fit : the best one so far. elapsed : s since the pose that it moved from; 0 where it was found anew.
    recovered : whether it was. ways : poses that the last look for it gave; None where nobody looked.
    restarts : how many limbs were found anew.
    """

    fit: Fit
    elapsed: float
    recovered: bool
    ways: list[Pose] | None
    restarts: int


def start(
    model: TrackerModel,
    settings: TrackSettings,
    frame: DepthFrame,
    performer: Performer | None = None,
    pose: Pose | None = None,
    scene: Scene | None = None,
) -> TrackState:
    """The state before frame 0, which `step` is then called with.

    Parameters
    ----------
    model, settings : as for `step`.
    frame : frame 0.
    performer : the person's lengths; an average adult when not given.
    pose : of frame 0; the detector finds it when not given.
    scene : the room, if it was seen empty (`foreground.empty_scene`) or its furniture was told (`standing`).

    Raises
    ------
    UsageError
        When there is neither a pose nor a detector.
    """
    from ..bodies import anatomy

    if pose is None and model.detector is None:
        raise UsageError("a start pose was wanted: this model was fitted without a detector")
    room = scene_of(evened(frame)) if scene is None else scene
    room = room if pose is None else replace(room, vouched=True)  # who is pointed at is the person
    body = anatomy.average() if performer is None else performer
    # Of who is found behind a desk nobody has ever seen the legs.
    hidden = frozen(np.full(len(LANDMARKS), 0.0 if pose is not None else NEVER))
    girth = Girth(body) if settings.girth else None
    return TrackState(body, room, pose, hidden=hidden, lost=pose is None, girth=girth)


def step(
    model: TrackerModel, settings: TrackSettings, state: TrackState, frame: DepthFrame
) -> tuple[TrackState, Estimate]:
    """Follow the body into one more frame (section 3.6).

    Parameters
    ----------
    model : pose library and detector.
    settings : terms and weights (`settings_of`).
    state : what `start` or the last `step` gave.
    frame : the next one, of the same camera.

    Returns
    -------
    The next state, and the estimate of this frame. In a frame with nobody in it the last pose is kept, the joints'
    standard deviations grow, and the flags say `empty`; where the body is not found they say `lost`.
    """
    clock = Stages()
    state, seen, elapsed = _seen(settings, state, evened(frame))
    clock.lap("foreground")
    if state.evidence is None:
        return nobody(replace(state, searched=EVERY, looked=EVERY), elapsed, ("empty",), clock)
    sight = Sight(model, settings, seen, state.evidence, coarse_of(state.evidence))
    first, waits = state.pose is None, state.looked < EVERY
    state = replace(state, looked=state.looked + 1)
    ways, recovered = None, False
    if state.pose is None or state.lost:
        state, ways, found = _placed(sight, state, waits=waits)
        clock.lap("detect")
        if not found:
            return nobody(state, elapsed, ("lost",), clock)
        elapsed, recovered = 0.0, not (first or waits)
    expected = expected_pose(state, settings, elapsed, sight.coarse)
    fit = fitted(sight, state, expected, clock=clock, elapsed=elapsed)
    searched = _limbs_searched(sight, fit, elapsed, clock) if settings.search else Searched(fit)
    body = _Body(searched.fit, elapsed, recovered, ways, searched.restarts)
    searches = settings.search and model.detector is not None
    if searches and not (recovered or waits):
        body = _found_again(sight, body, clock)
    body = _looked_at_afresh(sight, body, clock)
    if settings.search:
        body = _faced(sight, body, clock, first=first, busy=searched.busy)
    fit = body.fit
    if searches and first:
        fit = replace(fit, state=replace(fit.state, afresh=Afresh()))
    return followed(sight, fit, replace(searched, restarts=body.restarts), body.elapsed, body.recovered, clock)


def _seen(settings: TrackSettings, state: TrackState, frame: DepthFrame) -> tuple[TrackState, Observation, float]:
    """The state with what is seen of room and person, without evidence where that is nobody; and s since the last."""
    scene = scene_of(frame) if state.scene is None else told_again(state.scene, frame)
    scene = camera_followed(scene, frame)
    last = None if state.pose is None else state.pose.translation
    person, scene = person_of(scene, frame, last, settings.median)
    elapsed = max(frame.time - state.time, 0.0) if np.isfinite(state.time) else 0.0  # a recording may be wound back
    seen = Observation(frame.camera, person.depth, person.free, frame.time, _tones(frame, settings), person.rim)
    evidence = evidence_of(seen, settings) if person.found else None
    observation = None if evidence is None else seen
    return replace(state, scene=scene, time=frame.time, evidence=evidence, observation=observation), seen, elapsed


def _placed(sight: Sight, state: TrackState, *, waits: bool) -> tuple[TrackState, list[Pose] | None, bool]:
    """A body that is lost, or was never seen, looked for: the state with it in place at rest, the poses that the look
    gave, None if there was none, and whether it is anywhere.

    Between two looks a lost body is looked for where it was: a look takes as long as many frames.
    """
    ways, pose = None, state.pose
    if not waits:
        ways = look_for_body(sight, state)
        pose = ways[0] if ways else None
        state = replace(state, searched=0, looked=1)
    if pose is None:
        return state, ways, False
    still, trusted = frozen(np.zeros(DOFS)), frozen(np.ones(DOFS - 6))
    facing = state.facing
    if state.pose is not None and faces_otherwise(state.pose, pose):
        facing = turned_about(facing)
    return replace(state, pose=pose, velocity=still, trust=trusted, facing=facing), ways, True


def _limbs_searched(sight: Sight, fit: Fit, elapsed: float, clock: Stages) -> Searched:
    """Limbs that the frame shows elsewhere, and other poses of the whole where that explains little."""
    state, coarse = fit.state, sight.coarse
    # Where the detector sees limbs elsewhere, that is this frame's search; the library's poses wait for the next.
    # What is usual drifts while a limb is lost; a piece of the person with no limb in it stays one.
    left, began = left_over(state.performer, fit.pose, coarse), fit.solution
    ways = laid_in(state.performer, fit.pose, coarse, left)
    unclaimed = left.area > MUCH
    asks = sight.model.detector is not None and state.searched >= EVERY
    asks = asks and (unclaimed or fit.wrong > DOUBTFUL * state.wrong + 0.01)
    restarts, hypothesis, offered, busy, doubt = 0, None, False, asks, np.zeros(16)
    if asks:
        fit, restarts, offered = offers_tried(sight, fit)
        clock.lap("offers")
    if not offered:
        fit, restarts, doubt, hypothesis = mend_limbs(sight, fit, unclaimed)
        busy |= bool(restarts) or hypothesis is not None
        clock.lap("limbs")
        if left.area > CLAIMED and not restarts:
            fit, restarts = claimed(sight, fit, left, ways)
            if restarts:
                fit = replace(fit, state=replace(fit.state, hypothesis=None))  # it left the piece over, too
            busy = True
            clock.lap("pieces")
        if fit.wrong > RESCUE * state.wrong + 0.03:
            fit = rescued(sight, fit)
            busy = True
            clock.lap("rescue")
    mended = fit.solution
    fit = contested(sight, fit, elapsed, hypothesis)
    restarts += fit.solution is not mended
    clock.lap("hypothesis")
    if fit.solution is not began:
        ways = laid_in(state.performer, fit.pose, coarse, left_over(state.performer, fit.pose, coarse))
    doubt = np.hypot(doubt, in_doubt(state.performer, fit.pose, fit.wrong, ways))
    fit = replace(fit, state=replace(fit.state, searched=0 if asks else state.searched + 1))
    return Searched(fit, restarts, busy, unclaimed, doubt)


def _found_again(sight: Sight, body: _Body, clock: Stages) -> _Body:
    """A body that its pose explains no longer, looked for in the whole image."""
    fit = body.fit
    if not is_lost(fit.state.wrong, fit.wrong):
        return body
    ways = look_for_body(sight, fit.state)
    body = replace(body, ways=ways, fit=replace(fit, state=replace(fit.state, looked=1)))
    if ways and disagreement(fit.state.performer, ways[0], sight.coarse) < 0.8 * fit.wrong:
        fresh = replace(body.fit.state, pose=ways[0], velocity=frozen(np.zeros(DOFS)))
        anew = replace(fitted(sight, fresh, ways[0]), state=body.fit.state)
        body = replace(body, fit=anew, recovered=True)
    clock.lap("detect")
    return body


def _looked_at_afresh(sight: Sight, body: _Body, clock: Stages) -> _Body:
    """A body that may well be followed wrongly ever since it was found, looked for anew when it is time."""
    fit = body.fit
    afresh = fit.state.afresh
    if afresh is None or not afresh.due:
        return body
    ways, anew = body.ways, None
    if afresh.doubted and not (body.recovered or is_lost(fit.state.wrong, fit.wrong)):
        ways = look_for_body(sight, replace(fit.state, pose=None))
        anew = taken_up(sight, fit, ways)
    fit = replace(fit, state=replace(fit.state, afresh=afresh.later if afresh.doubted else None))
    clock.lap("detect")
    if anew is not None:
        return replace(body, fit=anew, elapsed=0.0, recovered=True, ways=ways)
    return replace(body, fit=fit, ways=ways)


def _faced(sight: Sight, body: _Body, clock: Stages, *, first: bool, busy: bool) -> _Body:
    """The body as of the likelier of two readings, front or back, left or right."""
    if is_lost(body.fit.state.wrong, body.fit.wrong):
        return body
    asked = (body.ways or []) if body.recovered or first else None
    fit, otherwise = faced(sight, body.fit, body.elapsed, asked, busy=busy)
    clock.lap("facing")
    if otherwise:
        return replace(body, fit=fit, elapsed=0.0, recovered=True)  # it did not move there
    return replace(body, fit=fit, restarts=body.restarts + (fit.solution is not body.fit.solution))


def _tones(frame: DepthFrame, settings: TrackSettings) -> Singles | None:
    if frame.color is None or "color" not in settings.terms:
        return None
    return np.asarray(frame.color @ np.array([0.299, 0.587, 0.114], np.float32), np.float32)  # ITU-R BT.601
