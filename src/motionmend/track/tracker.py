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
from ..numerics.least_squares import Solution
from ..numerics.neighbors import Neighbors
from .frame.evidence import Evidence, evidence_of
from .frame.observation import Observation
from .limbs.certainty import astray, certainty_of, shown_and_denied, trust_of
from .limbs.mend import mend_limbs
from .limbs.offers import MUCH, offers_tried
from .limbs.other_poses import Coarse, coarse_of, disagreement, left_over
from .limbs.pieces import CLAIMED, claimed
from .limbs.rescue import moved_to, rescued, turned
from .lost import LOST, UNPROVEN, is_lost, is_unproven
from .measure.girth import FRAMES, Girth, learned
from .model import TrackerModel
from .person.fineness import evened
from .person.foreground import Scene, scene_of, told_again
from .person.pixels import person_of
from .readings.facing import faces_otherwise, lies, unlikeliness
from .readings.hypotheses import contested
from .readings.pair import either
from .readings.second import faced
from .settings import TrackSettings
from .stages import Stages
from .starting.afresh import Afresh, better, watched
from .state import EVERY, TrackState
from .terms.contract import Term
from .terms.objective import PAUSE, expected_pose, terms_of
from .terms.smooth import difference
from .terms.solve import solve_pose

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
    frame = evened(frame)
    scene = scene_of(frame) if state.scene is None else told_again(state.scene, frame)
    last = None if state.pose is None else state.pose.translation
    person, scene = person_of(scene, frame, last, settings.median)
    elapsed = frame.time - state.time if np.isfinite(state.time) else 0.0
    state = replace(state, scene=scene, time=frame.time)
    observation = Observation(frame.camera, person.depth, person.free, frame.time, _tones(frame, settings), person.rim)
    evidence = evidence_of(observation, settings) if person.found else None
    state = replace(state, evidence=evidence, observation=None if evidence is None else observation)
    clock.lap("foreground")
    if evidence is None:
        return _nobody(replace(state, searched=EVERY, looked=EVERY), elapsed, ("empty",), clock)
    coarse = coarse_of(evidence)
    first, recovered = state.pose is None, False
    ways: list[Pose] = []
    waits = state.looked < EVERY
    state = replace(state, looked=state.looked + 1)
    if state.pose is None or state.lost:
        # Between two looks a lost body is looked for where it was: a look takes as long as many frames.
        if not waits:
            ways = _found(model, settings, state, observation, evidence, coarse)
            state = replace(state, searched=0, looked=1)
        clock.lap("detect")
        if not (ways or (waits and state.pose is not None)):
            return _nobody(state, elapsed, ("lost",), clock)
        recovered = state.pose is not None and not waits
        found = state.pose if waits else ways[0]
        assert found is not None
        state = replace(state, pose=found, velocity=frozen(np.zeros(DOFS)), trust=frozen(np.ones(DOFS - 6)))
        elapsed = 0.0
    assert state.pose is not None
    expected = expected_pose(state, settings, elapsed, coarse)
    terms = terms_of(model, settings, state, evidence, expected)
    clock.lap("prior")
    solution = solve_pose(state.performer, evidence, terms, expected, settings)
    clock.lap("solve")
    restarts, hypothesis, offered, busy = 0, None, False, False
    doubt, wrong = np.zeros(16), disagreement(state.performer, solution.state, coarse)
    # Where the detector sees limbs elsewhere, that is this frame's search; the library's poses wait for the next.
    # What is usual drifts while a limb is lost; a piece of the person with no limb in it stays one.
    left = left_over(state.performer, solution.state, coarse) if settings.search else None
    unclaimed = left is not None and left.area > MUCH
    doubtful = unclaimed or wrong > DOUBTFUL * state.wrong + 0.01
    asks = model.detector is not None and state.searched >= EVERY and doubtful
    if settings.search and asks:
        solution, wrong, restarts, offered = offers_tried(
            model, settings, state, observation, evidence, coarse, terms, solution, wrong
        )
        busy = True
        clock.lap("offers")
    if left is not None and not offered:
        solution, wrong, restarts, doubt, hypothesis = mend_limbs(
            model, settings, state, evidence, coarse, terms, expected, solution, wrong, unclaimed
        )
        busy |= bool(restarts) or hypothesis is not None
        clock.lap("limbs")
        if left.area > CLAIMED and not restarts:
            solution, wrong, restarts = claimed(settings, state, evidence, coarse, terms, solution, wrong, left)
            state = replace(state, hypothesis=None) if restarts else state  # it left the piece over, too
            busy = True
            clock.lap("pieces")
        if wrong > RESCUE * state.wrong + 0.03:
            solution, wrong = rescued(model, settings, state, evidence, coarse, terms, solution, wrong)
            busy = True
            clock.lap("rescue")
    if settings.search:
        mended = solution
        state, terms, solution, wrong = contested(
            model, settings, state, evidence, coarse, terms, mended, wrong, elapsed, hypothesis
        )
        restarts += solution is not mended
        clock.lap("hypothesis")
    state = replace(state, searched=0 if asks else state.searched + 1)
    if is_lost(state.wrong, wrong) and settings.search and model.detector is not None and not (recovered or waits):
        ways = _found(model, settings, state, observation, evidence, coarse)
        state = replace(state, looked=1)
        if ways and disagreement(state.performer, ways[0], coarse) < 0.8 * wrong:
            found = ways[0]
            fresh = replace(state, pose=found, velocity=frozen(np.zeros(DOFS)))
            terms = terms_of(model, settings, fresh, evidence, found)
            solution = solve_pose(state.performer, evidence, terms, found, settings)
            wrong, recovered = disagreement(state.performer, solution.state, coarse), True
        clock.lap("detect")
    if state.afresh is not None and state.afresh.due:
        anew = None
        if state.afresh.doubted and not (recovered or is_lost(state.wrong, wrong)):
            ways = _found(model, settings, replace(state, pose=None), observation, evidence, coarse)
            anew = _taken_up(model, settings, state, evidence, coarse, solution, wrong, ways)
        state = replace(state, afresh=state.afresh.later if state.afresh.doubted else None)
        if anew is not None:
            state, terms, solution, wrong = anew
            elapsed, recovered = 0.0, True
        clock.lap("detect")
    if settings.search and not is_lost(state.wrong, wrong):
        mended = solution
        state, solution, wrong, turned_about = faced(
            model,
            settings,
            state,
            evidence,
            coarse,
            mended,
            wrong,
            elapsed,
            ways if recovered or first else None,
            busy=busy,
        )
        if turned_about:
            elapsed, recovered = 0.0, True  # it did not move there
        else:
            restarts += solution is not mended
        clock.lap("facing")
    if settings.search and first and model.detector is not None:
        state = replace(state, afresh=Afresh())
    return _tracked(
        model.database.search,
        settings,
        state,
        observation,
        evidence,
        coarse,
        solution,
        wrong,
        elapsed,
        recovered,
        restarts,
        doubt,
        unclaimed,
        clock,
    )


def _found(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    observation: Observation,
    evidence: Evidence,
    coarse: Coarse,
) -> list[Pose]:
    """The pose that explains the frame best, of those the detector proposes and the last one; none = no body.

    The best of those that face the other way comes second, if there is one.
    """
    from .detect.joints import Detection, detect, detected_lying
    from .limbs.judge import JUDGED, judge
    from .starting.first_pose import Candidate, candidates, lying
    from .starting.settle import settled_readings

    few = observation.as_fine_as(JUDGED)
    tried = []
    if state.pose is not None:
        last = (state.pose, *turned(moved_to(state.performer, state.pose, evidence, coarse), 8))
        tried += [Candidate(pose, judge(state.performer, pose, few).cost, "last") for pose in last]
    detection = None
    if model.detector is not None:
        shown = DepthFrame(observation.camera, observation.depth, None, observation.time)
        detection = detect(model.detector, shown)
        tried += candidates(state.performer, detection, few, model.examples)

    def refine(pose: Pose) -> tuple[Pose, float]:
        trial = replace(state, pose=pose, before=None, trust=frozen(np.ones(DOFS - 6)))
        terms = terms_of(model, settings, trial, evidence, pose)
        solution = solve_pose(state.performer, evidence, terms, pose, settings)
        return solution.state, disagreement(state.performer, solution.state, coarse)

    def settled(tried: list[Candidate], detection: Detection | None) -> list[Candidate]:
        tried = sorted(tried, key=lambda one: one.cost)
        return settled_readings(state.performer, tried, few, coarse, model.limb_shapes, refine, detection)

    ways = settled(tried, detection)
    if model.detector is not None and (laid := lying(state.performer, few)):
        # Whoever looks so may be upright all the same, the legs hidden, say: each search keeps the best of its own.
        sideways = detected_lying(model.detector, shown)
        laid += [way for one in sideways for way in candidates(state.performer, one, few, model.examples)]
        ways += settled(laid, max(sideways, key=lambda one: float(one.confidence.sum()), default=None))
        ways.sort(key=lambda way: way.cost)
    if not ways or ways[0].cost > 1.5 * LOST:
        return []
    gone = float(state.hidden.min())
    ways.sort(key=lambda way: unlikeliness(model.database.search, way.pose, way.cost, state.pose, gone))
    best = ways[0].pose
    return [best, *[way.pose for way in ways[1:] if faces_otherwise(best, way.pose)][:1]]


def _taken_up(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    evidence: Evidence,
    coarse: Coarse,
    solution: Solution[Pose],
    wrong: float,
    ways: list[Pose],
) -> tuple[TrackState, list[Term], Solution[Pose], float] | None:
    """State, terms, solution and share explained wrongly of a search's best pose, if that is clearly better."""
    if not ways:
        return None
    fresh = replace(state, pose=ways[0], velocity=frozen(np.zeros(DOFS)), trust=frozen(np.ones(DOFS - 6)))
    terms = terms_of(model, settings, fresh, evidence, ways[0])
    found = solve_pose(state.performer, evidence, terms, ways[0], settings)
    share = disagreement(state.performer, found.state, coarse)
    if not better(model.database.search, solution.state, wrong, found.state, share):
        return None
    # What was usual, and what was learned of widths, was the other pose's.
    girth = None if state.girth is None else Girth(state.girth.base)
    body = state.performer if girth is None else girth.base
    return replace(fresh, performer=body, girth=girth, wrong=share, hypothesis=None, afresh=None), terms, found, share


def _tracked(
    search: Neighbors,
    settings: TrackSettings,
    state: TrackState,
    observation: Observation,
    evidence: Evidence,
    coarse: Coarse,
    solution: Solution[Pose],
    wrong: float,
    elapsed: float,
    recovered: bool,
    restarts: int,
    doubt: Floats,
    unclaimed: bool,
    clock: Stages,
) -> tuple[TrackState, Estimate]:
    assert state.pose is not None
    performer, pose = state.performer, solution.state
    shown, denied = shown_and_denied(performer, pose, coarse, evidence.weight)
    trust, seen = trust_of(shown)
    doubt = np.hypot(doubt, astray(shown, denied, wrong, state.wrong))
    doubt = np.hypot(doubt, either(state.sides.question, performer, pose))
    hidden = np.where(seen, 0.0, state.hidden + elapsed)
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
    if "color" in settings.terms and observation.intensity is not None:
        from ..bodies.performer import bone_frames

        images = observation.intensity, observation.depth
        before = bone_frames(performer, pose), *images, intrinsics(observation.camera)
    girth = state.girth
    # A pose that was just found, or fits worse than usual, says little of widths.
    sure = elapsed > 0.0 and not (lost or recovered or restarts or wrong > DOUBTFUL * state.wrong + 0.01)
    if girth is not None and girth.frames < FRAMES and sure:
        girth = learned(girth, performer, pose, evidence, coarse, settings)
        performer = girth.performer
        clock.lap("girth")
    afresh = None if lost or state.afresh is None else watched(state.afresh, elapsed, search, pose, wrong, trust)
    # A pose that fits worse than usual says little of what is usual, nor does the first one if it fits badly.
    share = 0.1 if wrong < 1.2 * state.wrong and not unclaimed else 0.02
    running = min(wrong, UNPROVEN) if not np.isfinite(state.wrong) else (1.0 - share) * state.wrong + share * wrong
    flags = ("lost",) if lost else ("tracked", *(("recovered",) if recovered or restarts else ()))
    flags += ("held",) if not seen.all() else ()
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
        ~seen,
        solution.system.costs,
        solution.system.inliers,
        wrong,
        solution.converged,
        solution.iterations,
        covariance,
        restarts + recovered,
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
