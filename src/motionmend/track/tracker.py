"""Following one body, frame by frame: a state goes in with a frame, the next state and an estimate come out."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Singles, frozen
from ..bodies.camera import DepthFrame
from ..bodies.performer import DOFS, Performer, Pose, landmarks
from ..bodies.surface import intrinsics
from ..errors import UsageError
from .frame.evidence import evidence_of
from .frame.observation import Observation
from .limbs.certainty import astray, bare_of, certainty_of, shown_and_denied, trust_of
from .limbs.mend import mend_limbs
from .limbs.offers import MUCH, offers_tried
from .limbs.other_poses import coarse_of, disagreement, left_over
from .limbs.pieces import CLAIMED, claimed
from .limbs.rescue import rescued
from .lost import UNPROVEN, is_lost, is_unproven
from .measure.girth import FRAMES, Girth, learned
from .misread import held, misread, odds_misread
from .model import TrackerModel
from .person.fineness import evened
from .person.foreground import Scene, scene_of, told_again
from .person.pixels import person_of
from .readings.facing import lies
from .readings.hypotheses import contested
from .readings.pair import either
from .readings.second import faced
from .settings import TrackSettings
from .stages import Stages
from .starting.afresh import Afresh, watched
from .starting.look import look_for_body, taken_up
from .state import EVERY, Fit, Sight, TrackState
from .terms.objective import PAUSE, expected_pose, fitted
from .terms.smooth import difference

__all__ = ["Estimate", "start", "step"]

FLAGS = ("tracked", "held", "lost", "recovered", "revised", "empty")
BODY = 0.25  # share of pixels usually explained wrongly, up to which they are surely a body's: furniture's are 0.3
PROBATION = 1.0  # s, in which it has to prove itself; what is usual gives way meanwhile
RESCUE = 1.25  # times the usual share of pixels explained wrongly, above which other poses of the body are tried
DOUBTFUL = 1.15  # times the same, above which a pose may be wrong


@final
@dataclass(frozen=True, eq=False)
class Estimate:
    """What one frame gave.

    Attributes
    ----------
    pose : None while nobody was ever found. landmarks : (16, 3) m in camera axes, NaN then.
    std : (16,) m, standard deviation of each joint (one coordinate); half of how far apart two readings of front and
        back have it at least, until one of them is refuted.
    settled : (16,) m, the deviation if this reading is the right one; None where nobody is.
    flags : of `FLAGS`; `held` joints are in `held`, and only `hindsight` says `revised`.
    held : (16,) True where nothing of the limb is seen and the prior holds it.
    costs, inliers : of each term. wrong : share of the person's pixels explained wrongly.
    converged, iterations : of Gauss-Newton. covariance : (34, 34) m² and rad².
    restarts : how many limbs or bodies were found anew.
    seconds : of each stage.
    """

    pose: Pose | None
    landmarks: Floats
    std: Floats
    flags: tuple[str, ...]
    held: Bools
    costs: Mapping[str, float] = field(default_factory=dict)
    inliers: Mapping[str, int] = field(default_factory=dict)
    wrong: float = float("nan")
    converged: bool = False
    iterations: int = 0
    covariance: Floats | None = None
    restarts: int = 0
    settled: Floats | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True, eq=False)
class _Search:
    """What looking for limbs, and for the whole body from where it is, came to.

    Attributes
    ----------
    fit : the best one. restarts : how many limbs were found anew.
    busy : this frame was searched for something. unclaimed : a piece of the person has nothing of the body near it.
    doubt : (16,) m, about each joint.
    """

    fit: Fit
    restarts: int = 0
    busy: bool = False
    unclaimed: bool = False
    doubt: Floats = field(default_factory=lambda: frozen(np.zeros(16)))


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
    return TrackState(body, room, pose, lost=pose is None, girth=Girth(body) if settings.girth else None)


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
        return _nobody(replace(state, searched=EVERY, looked=EVERY), elapsed, ("empty",), clock)
    sight = Sight(model, settings, seen, state.evidence, coarse_of(state.evidence))
    first, waits, recovered = state.pose is None, state.looked < EVERY, False
    state = replace(state, looked=state.looked + 1)
    ways: list[Pose] | None = None
    if state.pose is None or state.lost:
        # Between two looks a lost body is looked for where it was: a look takes as long as many frames.
        found = state.pose
        if not waits:
            ways = look_for_body(sight, state)
            found = ways[0] if ways else None
            state = replace(state, searched=0, looked=1)
        clock.lap("detect")
        if found is None:
            return _nobody(state, elapsed, ("lost",), clock)
        recovered = not (first or waits)
        state = replace(state, pose=found, velocity=frozen(np.zeros(DOFS)), trust=frozen(np.ones(DOFS - 6)))
        elapsed = 0.0
    fit = fitted(sight, state, expected_pose(state, settings, elapsed, sight.coarse), clock=clock)
    search = _limbs_searched(sight, fit, elapsed, clock) if settings.search else _Search(fit)
    fit, restarts = search.fit, search.restarts
    searches = settings.search and model.detector is not None
    if searches and is_lost(fit.state.wrong, fit.wrong) and not (recovered or waits):
        ways = look_for_body(sight, fit.state)
        fit = replace(fit, state=replace(fit.state, looked=1))
        if ways and disagreement(fit.state.performer, ways[0], sight.coarse) < 0.8 * fit.wrong:
            fresh = replace(fit.state, pose=ways[0], velocity=frozen(np.zeros(DOFS)))
            fit, recovered = replace(fitted(sight, fresh, ways[0]), state=fit.state), True
        clock.lap("detect")
    afresh = fit.state.afresh
    if afresh is not None and afresh.due:
        anew = None
        if afresh.doubted and not (recovered or is_lost(fit.state.wrong, fit.wrong)):
            ways = look_for_body(sight, replace(fit.state, pose=None))
            anew = taken_up(sight, fit, ways)
        fit = replace(fit, state=replace(fit.state, afresh=afresh.later if afresh.doubted else None))
        if anew is not None:
            fit, elapsed, recovered = anew, 0.0, True
        clock.lap("detect")
    if settings.search and not is_lost(fit.state.wrong, fit.wrong):
        mended = fit.solution
        asked = (ways or []) if recovered or first else None
        fit, turned_about = faced(sight, fit, elapsed, asked, busy=search.busy)
        if turned_about:
            elapsed, recovered = 0.0, True  # it did not move there
        else:
            restarts += fit.solution is not mended
        clock.lap("facing")
    if searches and first:
        fit = replace(fit, state=replace(fit.state, afresh=Afresh()))
    return _tracked(sight, fit, replace(search, restarts=restarts), elapsed, recovered, clock)


def _seen(settings: TrackSettings, state: TrackState, frame: DepthFrame) -> tuple[TrackState, Observation, float]:
    """The state with what is seen of room and person, without evidence where that is nobody; and s since the last."""
    scene = scene_of(frame) if state.scene is None else told_again(state.scene, frame)
    last = None if state.pose is None else state.pose.translation
    person, scene = person_of(scene, frame, last, settings.median)
    elapsed = frame.time - state.time if np.isfinite(state.time) else 0.0
    seen = Observation(frame.camera, person.depth, person.free, frame.time, _tones(frame, settings), person.rim)
    evidence = evidence_of(seen, settings) if person.found else None
    observation = None if evidence is None else seen
    return replace(state, scene=scene, time=frame.time, evidence=evidence, observation=observation), seen, elapsed


def _limbs_searched(sight: Sight, fit: Fit, elapsed: float, clock: Stages) -> _Search:
    """Limbs that the frame shows elsewhere, and other poses of the whole where that explains little."""
    state, coarse = fit.state, sight.coarse
    # Where the detector sees limbs elsewhere, that is this frame's search; the library's poses wait for the next.
    # What is usual drifts while a limb is lost; a piece of the person with no limb in it stays one.
    left = left_over(state.performer, fit.pose, coarse)
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
            fit, restarts = claimed(sight, fit, left)
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
    fit = replace(fit, state=replace(fit.state, searched=0 if asks else state.searched + 1))
    return _Search(fit, restarts, busy, unclaimed, doubt)


def _tracked(
    sight: Sight, fit: Fit, search: _Search, elapsed: float, recovered: bool, clock: Stages
) -> tuple[TrackState, Estimate]:
    """The next state and the estimate, after a frame in which the body was followed, or lost while it was."""
    settings, seen, evidence, coarse = sight.settings, sight.seen, sight.evidence, sight.coarse
    state, solution, wrong = fit.state, fit.solution, fit.wrong
    assert state.pose is not None
    performer, pose = state.performer, solution.state
    shown, denied, unknown = shown_and_denied(performer, pose, coarse, evidence.weight)
    trust, visible = trust_of(shown)
    odds = odds_misread(sight.model.database.search, pose, wrong, trust)
    past, bare = (float("nan"), np.full(len(shown), np.nan)) if recovered else (state.misread, state.bare)
    mean = held(past, odds, elapsed)
    bare = bare_of(bare, shown, denied, unknown, elapsed)
    doubt = np.hypot(search.doubt, astray(shown, denied, bare, wrong, state.wrong))
    doubt = np.sqrt(doubt**2 + either(state.sides.question, performer, pose) ** 2 + misread(mean) ** 2)
    hidden = np.where(visible, 0.0, state.hidden + elapsed)
    covariance, std = certainty_of(performer, solution, hidden, doubt, wrong)
    # Not who is seen for the first time, unless they lie.
    anew = recovered or (state.lost and (bool(np.isfinite(state.wrong)) or lies(pose)))
    found = 0.0 if anew else state.found + elapsed
    refuted = settings.search and is_lost(state.wrong, wrong)
    lost = refuted or (settings.search and found < PROBATION and is_unproven(state.wrong, pose, wrong))
    velocity = np.zeros(DOFS)
    if 0.0 < elapsed < PAUSE:
        velocity = difference(pose, state.pose) / elapsed
        velocity[6:] *= np.minimum(1.0, 0.2 + trust)  # what is not seen is not known to go on moving
    before = None
    if "color" in settings.terms and seen.intensity is not None:
        from ..bodies.performer import bone_frames

        images = seen.intensity, seen.depth
        before = bone_frames(performer, pose), *images, intrinsics(seen.camera)
    girth = state.girth
    # A pose that was just found, or fits worse than usual, says little of widths.
    sure = elapsed > 0.0 and not (lost or recovered or search.restarts or wrong > DOUBTFUL * state.wrong + 0.01)
    if girth is not None and girth.frames < FRAMES and sure:
        girth = learned(girth, performer, pose, evidence, coarse, settings)
        performer = girth.performer
        clock.lap("girth")
    afresh = None if lost or state.afresh is None else watched(state.afresh, elapsed, odds)
    # A pose that fits worse than usual says little of what is usual, nor does the first one if it fits badly.
    share = 0.1 if wrong < 1.2 * state.wrong and not search.unclaimed else 0.02
    running = min(wrong, UNPROVEN) if not np.isfinite(state.wrong) else (1.0 - share) * state.wrong + share * wrong
    flags = ("lost",) if lost else ("tracked", *(("recovered",) if recovered or search.restarts else ()))
    flags += ("held",) if not visible.all() else ()
    assert state.scene is not None
    vouched = not lost and (state.scene.vouched or running < BODY)
    scene = replace(state.scene, vouched=vouched, stirred=0.0 if lost else state.scene.stirred)
    after = replace(
        state,
        scene=scene,
        performer=performer,
        girth=girth,
        afresh=afresh,
        pose=pose,
        velocity=frozen(velocity),
        trust=frozen(trust),
        hidden=frozen(hidden),
        lost=lost,
        found=found,
        wrong=state.wrong if refuted else running,
        misread=mean,
        bare=frozen(bare),
        hypothesis=None if lost or recovered else state.hypothesis,
        before=before,
    )
    std = np.maximum(std, 0.10) if lost else std
    unsure = np.maximum(std, either(state.facing.question, performer, pose))
    clock.lap("certainty")
    return after, Estimate(
        pose,
        landmarks(performer, pose),
        unsure,
        flags,
        ~visible,
        solution.system.costs,
        solution.system.inliers,
        wrong,
        solution.converged,
        solution.iterations,
        covariance,
        search.restarts + recovered,
        std,
        clock.seconds,
    )


def _nobody(state: TrackState, elapsed: float, flags: tuple[str, ...], clock: Stages) -> tuple[TrackState, Estimate]:
    """The last pose is kept; its joints may be anywhere within reach by now."""
    hidden = state.hidden + elapsed
    after = replace(state, hidden=frozen(hidden), lost=True, velocity=frozen(np.zeros(DOFS)), before=None)
    place = np.full((16, 3), np.nan) if state.pose is None else landmarks(state.performer, state.pose)
    std = np.full(16, np.nan) if state.pose is None else 0.15 + 0.5 * hidden
    return after, Estimate(state.pose, place, std, flags, np.ones(16, bool), seconds=clock.seconds)


def _tones(frame: DepthFrame, settings: TrackSettings) -> Singles | None:
    if frame.color is None or "color" not in settings.terms:
        return None
    return np.asarray(frame.color @ np.array([0.299, 0.587, 0.114], np.float32), np.float32)  # ITU-R BT.601
